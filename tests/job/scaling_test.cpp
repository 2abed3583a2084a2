// [scaling] of a job: which lengths are scaled, and whether the steps are kept.
#include <gmock/gmock.h>
#include "job/component_loader.hpp"

#include <cmath>

#include "job/job.hpp"
#include "job/job_parts.hpp"
#include "job/ligament_files.hpp"
#include "job/mesh_text.hpp"
#include "support/meshes.hpp"
#include "support/refusal.hpp"
#include "support/scratch.hpp"

namespace vrda::scaling_test {

using test::refuses;
using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

const Eigen::Vector3d centre_mm(3, -2, 5);
const std::string head =
    "joint = \"other\"\n[frame]\norigin = [3, -2, 5]\n"
    "[push]\npoint_mm = [1, 2, 3]\n";
const std::string fibres = R"([[ligaments.fibre]]
name = "given"
reference_mm = [10, 40, 0]
moving_mm = [10, 0, 0]
stiffness_n = 100
slack_length_mm = 36
[[ligaments.fibre]]
name = "strained"
reference_mm = [10, 40, 30]
moving_mm = [10, 0, 0]
stiffness_n = 100
reference_strain = 0.25
)";

// A box above a ball, with a landmark table and wraps.
struct Folder : test::JobFolder {
  explicit Folder(const std::string& tail = "", const std::string& extra_head = "")
      : JobFolder(test::small_job(head + extra_head, tail), test::box({0, 40, 0}, {60, 20, 80}),
                  test::ball(20))
  {
    scratch.write("marks.csv", "name,ax,ay,az,bx,by,bz,subject_mm\na,0,0,0,80,0,0,100\nb,0,0,0,0,4,3,6.25\n");
    scratch.write("wraps.json",
                  R"([{"name":"W","type":"WrapEllipsoid","body":"moving","xyz_body_rotation":"0 0 0",)"
                  R"("translation":"1 2 3","dimensions":"9 8 7","unit":"mm"}])");
  }
};

// Rounding of coordinates up to 100 mm in a few operations.
constexpr double rounding_mm = 1e-12;

Points scaled(const Points& points_mm, const Eigen::Vector3d& factor)
{
  Points out = points_mm;
  for (Eigen::Index i = 0; i < out.rows(); ++i) {
    const Eigen::Vector3d p_mm = points_mm.row(i);
    out.row(i) = (centre_mm + factor.asDiagonal() * (p_mm - centre_mm)).transpose();
  }
  return out;
}

// Bodies, start and push point of `got` are those of `plain` times `factor`.
void expect_scaled(const job::Case& got, const job::Case& plain, const Eigen::Vector3d& factor)
{
  EXPECT_EQ(got.frame.rotation_centre_mm, centre_mm);
  for (const auto body : {&job::Case::reference, &job::Case::moving}) {
    const Points wanted_mm = scaled((plain.*body).contact.mesh.vertices_mm, factor);
    EXPECT_LT(((got.*body).contact.mesh.vertices_mm - wanted_mm).cwiseAbs().maxCoeff(), rounding_mm);
    EXPECT_EQ((got.*body).contact.mesh.triangles, (plain.*body).contact.mesh.triangles);
  }
  EXPECT_LT((got.initial.translation_mm - factor.asDiagonal() * plain.initial.translation_mm).norm(),
            rounding_mm);
  EXPECT_LT((got.push_point_mm - factor.asDiagonal() * plain.push_point_mm).norm(), rounding_mm);
  EXPECT_EQ(got.initial.theta_rad, plain.initial.theta_rad);
  ASSERT_EQ(got.survey.size(), 2U);
  for (std::size_t i = 0; i < 2; ++i) {
    const Eigen::Vector3d low_mm = plain.survey[i].box.min_mm - centre_mm;
    EXPECT_LT((got.survey[i].box.min_mm - centre_mm - factor.asDiagonal() * low_mm).norm(), rounding_mm);
    EXPECT_NEAR(got.survey[i].volume_mm3, factor.prod() * plain.survey[i].volume_mm3,
                1e-12 * plain.survey[i].volume_mm3);
  }
}

TEST(Scaling, AnEvenFactorOfAJointHeldByContactKeepsTheSteps)
{
  const Folder folder;
  const job::Case plain = folder.load(), solved = folder.load({"scaling.factor=1.25"});
  ASSERT_TRUE(solved.scaling);
  EXPECT_TRUE(solved.scaling->keeps_steps);
  EXPECT_EQ(solved.scaling->factor, Eigen::Vector3d::Constant(1.25));
  EXPECT_EQ(solved.steps_scale, 1.25);
  EXPECT_EQ(solved.steps_job_text, plain.resolved_job) << "the same steps whatever the size";
  EXPECT_THAT(solved.resolved_job, HasSubstr("[scaling]\nfactor = 1.25\n"));
  EXPECT_EQ(solved.moving.contact.mesh.vertices_mm, plain.moving.contact.mesh.vertices_mm);
  const job::Case subject = job::scaled_to_subject(solved);
  expect_scaled(subject, plain, Eigen::Vector3d::Constant(1.25));
  EXPECT_EQ(subject.steps_scale, 1.0);
  EXPECT_NEAR(subject.survey[1].mean_edge_mm, 1.25 * plain.survey[1].mean_edge_mm, rounding_mm);
  EXPECT_NEAR(subject.survey[1].area_mm2, 1.25 * 1.25 * plain.survey[1].area_mm2, 1e-12 * 5000);
  EXPECT_NEAR(subject.equilibrium.contact_resolution_mm, 0.0125, rounding_mm);
  EXPECT_NEAR(subject.search.translation_resolution_mm, 0.125, rounding_mm);
  EXPECT_NEAR(subject.search.approach_step_mm, 6.25, rounding_mm);
}

TEST(Scaling, WhatElseHoldsTheJointMakesItANewRun)
{
  struct Row {
    std::string tail;
    std::vector<std::string> overrides;
    std::string because;
  };
  const std::vector<Row> rows{
      {fibres, {}, "ligaments"},
      {"", {"push.moment_nmm=100"}, "a moment"},
      {"", {"push.moment_nmm={flexion_deg=[0,90],value=[0,5]}"}, "a moment"},
      {"", {"push.varus_moment_nmm=-100"}, "a moment"},
  };
  for (const Row& row : rows) {
    SCOPED_TRACE(row.because);
    const Folder folder(row.tail);
    std::vector<std::string> overrides = row.overrides;
    const job::Case plain = folder.load(overrides);
    overrides.emplace_back("scaling.factor=1.25");
    const job::Case rerun = folder.load(overrides);
    EXPECT_FALSE(rerun.scaling.value().keeps_steps);
    EXPECT_THAT(rerun.rerun_reason, HasSubstr(row.because));
    EXPECT_EQ(rerun.steps_scale, 1.0);
    EXPECT_EQ(rerun.steps_job_text, rerun.resolved_job);
    expect_scaled(rerun, plain, Eigen::Vector3d::Constant(1.25));
    EXPECT_EQ(rerun.equilibrium.contact_resolution_mm, plain.equilibrium.contact_resolution_mm);
  }
}

TEST(Scaling, FibresKeepTheirStrainAtThePoseOfTheMeshes)
{
  const Folder folder(fibres);
  const model::Ligaments plain = folder.load().ligaments;
  const std::vector<model::FibreState> before = model::fibre_states(plain, {}, {});
  for (const char* factor : {"scaling.factor=1.25", "scaling.factor=[1.25,0.8,1.1]"}) {
    SCOPED_TRACE(factor);
    const model::Ligaments now = folder.load({factor}).ligaments;
    const std::vector<model::FibreState> after = model::fibre_states(now, {}, {});
    for (std::size_t k = 0; k < 2; ++k) {
      EXPECT_NE(after[k].length_mm, before[k].length_mm);
      EXPECT_NEAR(after[k].strain, before[k].strain, 1e-14);
      EXPECT_EQ(now.fibres[k].stiffness_n, plain.fibres[k].stiffness_n);
      // At equal strain the energy is proportional to the slack length.
      EXPECT_NEAR(after[k].energy_nmm * plain.fibres[k].slack_length_mm,
                  before[k].energy_nmm * now.fibres[k].slack_length_mm, 1e-9);
    }
  }
}

TEST(Scaling, WrapsGrowEvenlyOrAreRefused)
{
  const Folder folder(fibres + "[ligaments]\nwraps = \"wraps.json\"\n");
  const model::Wrap wrap = folder.load({"scaling.factor=2"}).ligaments.wraps.at(0);
  EXPECT_LT((wrap.X_body_wrap.translation() - (2 * Eigen::Vector3d(1, 2, 3) - centre_mm)).norm(),
            rounding_mm);
  EXPECT_EQ(wrap.radii_mm, Eigen::Vector3d(18, 16, 14));
  for (const char* found : {"[1, 1, 1.1]", "\"W\""})
    EXPECT_THAT(folder.refused({"scaling.factor=[1,1,1.1]"}), refuses({"--set", "scaling.factor", found}));
}

TEST(Scaling, UnevenFactorsChangeTheShape)
{
  const Folder folder;
  const job::Case plain = folder.load(), rerun = folder.load({"scaling.factor=[1.2,1,0.9]"});
  EXPECT_FALSE(rerun.scaling->keeps_steps);
  EXPECT_THAT(rerun.rerun_reason, HasSubstr("factors differ"));
  expect_scaled(rerun, plain, {1.2, 1, 0.9});
}

TEST(Scaling, NormalsOfAFileStayAcrossTheirSurface)
{
  const Folder folder;
  Mesh ball = test::ball(20);
  ball.normals = ball.vertices_mm / 20.0;
  folder.scratch.write("moving.ply", test::ascii_ply(ball, true));
  const std::string file = "moving.component.0.file=moving.ply";
  const Mesh mesh = folder.load({file, "scaling.factor=[1.2,1,0.9]"}).moving.contact.mesh;
  const Mesh even = job::scaled_to_subject(folder.load({file, "scaling.factor=1.2"})).moving.contact.mesh;
  const Mesh plain = folder.load({file}).moving.contact.mesh;
  ASSERT_EQ(mesh.normals.rows(), mesh.vertices_mm.rows());
  EXPECT_EQ(even.normals, plain.normals);
  // A normal stays orthogonal to the image of a tangent t.
  for (Eigen::Index v = 0; v < mesh.normals.rows(); ++v) {
    const Eigen::Vector3d n = plain.normals.row(v), n_now = mesh.normals.row(v);
    const Eigen::Vector3d t = n.unitOrthogonal();
    EXPECT_NEAR(n_now.dot(Eigen::Vector3d(1.2, 1, 0.9).asDiagonal() * t), 0.0, 1e-12);
    EXPECT_NEAR(n_now.norm(), 1.0, 1e-12);
    EXPECT_GT(n_now.dot(n), 0.0);
  }
}

TEST(Scaling, CoincidingAttachmentsHaveNoLengthToFollow)
{
  const Folder folder(
      "[[ligaments.fibre]]\nname = \"short\"\nreference_mm = [0, 20, 0]\nmoving_mm = [0, 20, 0]\n"
      "stiffness_n = 1\nslack_length_mm = 5\n");
  EXPECT_EQ(folder.load({"scaling.factor=2"}).ligaments.fibres[0].slack_length_mm, 10.0);
  EXPECT_THAT(folder.refused({"scaling.factor=[1,1,2]"}),
              refuses({.field = "scaling.factor", .found = "\"short\""}));
}

TEST(Scaling, LandmarksGiveTheFactorAndAreAnInput)
{
  const Folder folder;
  const job::Case solved = folder.load({"scaling.landmarks=marks.csv", "grid.varus=free"});
  ASSERT_TRUE(solved.scaling);
  EXPECT_NEAR(solved.scaling->factor.x(), 1.25, 1e-14);
  EXPECT_THAT(solved.scaling->landmark, ElementsAre("a", "b"));
  EXPECT_THAT(solved.warnings, IsEmpty());
  const job::LoadedInput& input = solved.inputs.back();
  EXPECT_EQ(input.name, "marks.csv");
  EXPECT_EQ(input.sha256, job::sha256_of(test::read_bytes(folder.scratch.path() / "marks.csv")));
  EXPECT_FALSE(input.affects_steps);
  EXPECT_TRUE(folder.load({"scaling.landmarks=marks.csv", "push.moment_nmm=1"}).inputs.back().affects_steps);
  EXPECT_NEAR(folder.load({"scaling.landmarks=marks.csv", "frame.unit=cm"}).scaling->factor.x(), 0.125,
              1e-15);
}

// Every pair of common labels; the subject's points in the other space and in cm.
TEST(Scaling, PointsOfSlicerGiveTheFactor)
{
  const Folder folder;
  const std::string rest = ",0,0,0,1,1,1,0,";
  folder.scratch.write("model.fcsv", "# CoordinateSystem = RAS\n1,0,0,0" + rest + "a\n2,80,0,0" + rest +
                                         "b\n3,0,0,40" + rest + "c\n4,9,9,9" + rest + "other\n");
  folder.scratch.write("subject.mrk.json",
                       R"({"markups": [{"coordinateSystem": "LPS", "coordinateUnits": "cm", "controlPoints": [
                       {"label": "c", "position": [0, 0, 5]}, {"label": "b", "position": [-10, 0, 0]},
                       {"label": "a", "position": [0, 0, 0]}]}]})");
  const job::Case loaded =
      folder.load({"scaling.landmarks=subject.mrk.json", "scaling.model_landmarks=model.fcsv"});
  EXPECT_THAT(loaded.scaling->landmark, ElementsAre("a - b", "a - c", "b - c"));
  EXPECT_NEAR(loaded.scaling->factor.x(), 1.25, 1e-12);  // rounding
  EXPECT_LT(loaded.scaling->residual_rms_mm, 1e-9);
}

TEST(Scaling, LandmarksThatDoNotFitAreDoubted)
{
  const Folder folder;
  const auto warnings = [&](const std::string& rows) {
    folder.scratch.write("marks.csv", "name,ax,ay,az,bx,by,bz,subject_mm\n" + rows);
    return folder.load({"scaling.landmarks=marks.csv", "grid.varus=free"}).warnings;
  };
  // 100 and 100 mm of model against 110 and 90: 10 mm of 100.5 each, 10 %; at 104 and 96 they are 4 %.
  EXPECT_THAT(warnings("wide,0,0,0,100,0,0,110\nlong,0,0,0,0,100,0,90\n"),
              ElementsAre(AllOf(HasSubstr("scaling.landmarks"), HasSubstr("10 mm, 10 % of the distances"),
                                HasSubstr("\"wide\", 10 mm"), HasSubstr("a new run"))));
  EXPECT_THAT(warnings("wide,0,0,0,100,0,0,104\nlong,0,0,0,0,100,0,96\n"), IsEmpty());
  EXPECT_THAT(warnings("wide,0,0,0,100,0,0,104\n"), ElementsAre(HasSubstr("one pair")));
}

TEST(Scaling, ALeftJointIsTheMirroredRightOne)
{
  const Folder folder;
  Mesh left = mirrored_z(folder.load().moving.contact.mesh);
  folder.scratch.write("left.stl", test::binary_stl(left));
  for (const char* factor : {"scaling.factor=1.07", "scaling.factor=[1.07,0.9,1.1]"}) {
    const job::Case right = job::scaled_to_subject(folder.load({"frame.origin=[3,-2,0]", factor}));
    const job::Case mirrored = job::scaled_to_subject(
        folder.load({"frame.origin=[3,-2,0]", "side=left", "moving.component.0.file=left.stl", factor}));
    const Mesh back = mirrored_z(mirrored.moving.contact.mesh);
    EXPECT_EQ(back.vertices_mm, right.moving.contact.mesh.vertices_mm);
  }
}

const std::string header = "name,ax,ay,az,bx,by,bz,subject_mm\n";

std::vector<job::LandmarkPair> read(const std::string& rows)
{
  return job::read_landmarks("marks.csv", header + rows);
}

TEST(Landmarks, ColumnsComeInAnyOrder)
{
  const auto pairs =
      job::read_landmarks("marks.csv",
                          "# epicondyles and more\r\n\r\nsubject_mm, bz,by,bx ,az,ay,ax,name\r\n"
                          "82.5,6,5,4,3,2,1, epicondyles\r\n#\n+1e2,0,0,0,0,-1.5,0,shaft");
  ASSERT_EQ(pairs.size(), 2U);
  EXPECT_EQ(pairs[0].name, "epicondyles");
  EXPECT_EQ(pairs[0].a_native, Eigen::Vector3d(1, 2, 3));
  EXPECT_EQ(pairs[0].b_native, Eigen::Vector3d(4, 5, 6));
  EXPECT_EQ(pairs[0].subject_mm, 82.5);
  EXPECT_EQ(pairs[1].subject_mm, 100.0);
}

// Rounding of sums of a few products.
constexpr double rounding = 1e-14;

TEST(Landmarks, AKnownFactorIsFoundWithNothingLeft)
{
  const Scaling fit =
      job::fit_scaling(read("a,0,0,0,80,0,0,85.6\nb,1,1,1,1,4,5,5.35\nc,0,0,-2,0,0,10,12.84\n"), 1.0);
  EXPECT_NEAR(fit.factor.x(), 1.07, rounding);
  EXPECT_TRUE(is_uniform(fit.factor));
  EXPECT_EQ(fit.model_mm, (std::vector<double>{80, 5, 12}));
  for (const double residual_mm : fit.residual_mm) EXPECT_NEAR(residual_mm, 0.0, 85.6 * rounding);
  EXPECT_NEAR(fit.residual_rms_mm, 0.0, 85.6 * rounding);
  EXPECT_NEAR(fit.standard_error, 0.0, rounding);
}

TEST(Landmarks, ResidualsAndTheirErrorByHand)
{
  // s = (3 x 3.3 + 4 x 4) / (9 + 16) = 25.9 / 25
  const Scaling fit = job::fit_scaling(read("a,0,0,0,3,0,0,3.3\nb,0,0,0,0,4,0,4\n"), 1.0);
  EXPECT_NEAR(fit.factor.x(), 1.036, rounding);
  EXPECT_NEAR(fit.residual_mm.at(0), 0.192, 4 * rounding);
  EXPECT_NEAR(fit.residual_mm.at(1), -0.144, 4 * rounding);
  EXPECT_NEAR(fit.residual_rms_mm, std::sqrt(0.0576 / 2), 4 * rounding);
  EXPECT_NEAR(fit.standard_error, 0.24 / 5, 4 * rounding);
}

TEST(Landmarks, OnePairFitsItselfWithoutAnError)
{
  const Scaling fit = job::fit_scaling(read("a,0,0,0,0,0,50,45\n"), 1.0);
  EXPECT_NEAR(fit.factor.x(), 0.9, rounding);
  EXPECT_TRUE(std::isnan(fit.standard_error));
  EXPECT_NEAR(fit.residual_rms_mm, 0.0, 50 * rounding);
}

TEST(Landmarks, TheFitKeepsItsInvariances)
{
  const Scaling fit =
      job::fit_scaling(read("a,0,0,0,80,0,0,84\nb,0,0,0,0,30,0,33\nc,5,5,5,5,5,45,41\n"), 1.0);
  // Least-squares residuals are orthogonal to the distances of the model.
  double along_sq_mm2 = 0.0;
  for (std::size_t i = 0; i < 3; ++i) along_sq_mm2 += fit.residual_mm[i] * fit.model_mm[i];
  EXPECT_NEAR(along_sq_mm2, 0.0, 84 * 84 * rounding);
  // Swapped ends, a common translation, cm, and another order give the same fit.
  const Scaling other =
      job::fit_scaling(read("c,1,1,5,1,1,1,41\na,9,1,1,1,1,1,84\nb,1,4,1,1,1,1,33\n"), 10.0);
  EXPECT_NEAR(other.factor.x(), fit.factor.x(), rounding);
  EXPECT_NEAR(other.residual_rms_mm, fit.residual_rms_mm, 84 * rounding);
  EXPECT_NEAR(other.standard_error, fit.standard_error, rounding);
  // Twice the subject's distances give twice the factor, residuals and error.
  const Scaling twice =
      job::fit_scaling(read("a,0,0,0,80,0,0,168\nb,0,0,0,0,30,0,66\nc,5,5,5,5,5,45,82\n"), 1.0);
  EXPECT_NEAR(twice.factor.x(), 2 * fit.factor.x(), rounding);
  EXPECT_NEAR(twice.residual_rms_mm, 2 * fit.residual_rms_mm, 168 * rounding);
  EXPECT_NEAR(twice.standard_error, 2 * fit.standard_error, rounding);
}

}  // namespace vrda::scaling_test
