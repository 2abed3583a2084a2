// [scaling] of a job: which lengths are scaled, and whether the steps are kept.
#include "job/scaling.hpp"

#include <gmock/gmock.h>

#include <array>

#include "job/job.hpp"
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

TEST(Scaling, none)
{
  const job::Case plain = Folder().load();
  EXPECT_FALSE(plain.scaling);
  EXPECT_EQ(plain.steps_scale, 1.0);
  EXPECT_EQ(plain.steps_job_text, plain.resolved_job);
  EXPECT_THAT(plain.resolved_job, testing::Not(HasSubstr("scaling")));
}

TEST(Scaling, even_factor)
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

TEST(Scaling, factor_of_one)
{
  const Folder folder(fibres);
  const job::Case plain = folder.load();
  for (const char* one : {"scaling.factor=1", "scaling.factor=[1,1.0,1]", "scaling={}"}) {
    SCOPED_TRACE(one);
    const job::Case subject = job::scaled_to_subject(folder.load({one}));
    EXPECT_TRUE(subject.scaling.value().keeps_steps);
    EXPECT_EQ(subject.steps_job_text, plain.resolved_job);
    EXPECT_EQ(subject.moving.contact.mesh.vertices_mm, plain.moving.contact.mesh.vertices_mm);
    EXPECT_EQ(subject.initial.translation_mm, plain.initial.translation_mm);
    EXPECT_EQ(subject.ligaments.fibres[1].slack_length_mm, plain.ligaments.fibres[1].slack_length_mm);
  }
}

TEST(Scaling, new_run)
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

TEST(Scaling, kept_steps)
{
  EXPECT_TRUE(Folder()
                  .load({"scaling.factor=1.25", "push.force_n=300", "push.lateral_force_n=[5,-5]"})
                  .scaling->keeps_steps);
  const job::Case search =
      Folder(fibres).load({"scaling.factor=1.25", "solver.method=stability-search", "push.moment_nmm=100"});
  EXPECT_TRUE(search.scaling->keeps_steps);
  EXPECT_NEAR(job::scaled_to_subject(search).ligaments.fibres[0].slack_length_mm, 45.0, rounding_mm);
}

TEST(Scaling, fibres)
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

TEST(Scaling, wraps)
{
  const Folder folder(fibres + "[ligaments]\nwraps = \"wraps.json\"\n");
  const model::Wrap wrap = folder.load({"scaling.factor=2"}).ligaments.wraps.at(0);
  EXPECT_LT((wrap.X_body_wrap.translation() - (2 * Eigen::Vector3d(1, 2, 3) - centre_mm)).norm(),
            rounding_mm);
  EXPECT_EQ(wrap.radii_mm, Eigen::Vector3d(18, 16, 14));
  for (const char* found : {"[1, 1, 1.1]", "\"W\""})
    EXPECT_THAT(folder.refused({"scaling.factor=[1,1,1.1]"}), refuses({"--set", "scaling.factor", found}));
}

TEST(Scaling, uneven_factors)
{
  const Folder folder;
  const job::Case plain = folder.load(), rerun = folder.load({"scaling.factor=[1.2,1,0.9]"});
  EXPECT_FALSE(rerun.scaling->keeps_steps);
  EXPECT_THAT(rerun.rerun_reason, HasSubstr("factors differ"));
  expect_scaled(rerun, plain, {1.2, 1, 0.9});
}

TEST(Scaling, normals)
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

TEST(Scaling, coinciding_attachments)
{
  const Folder folder(
      "[[ligaments.fibre]]\nname = \"short\"\nreference_mm = [0, 20, 0]\nmoving_mm = [0, 20, 0]\n"
      "stiffness_n = 1\nslack_length_mm = 5\n");
  EXPECT_EQ(folder.load({"scaling.factor=2"}).ligaments.fibres[0].slack_length_mm, 10.0);
  EXPECT_THAT(folder.refused({"scaling.factor=[1,1,2]"}),
              refuses({.field = "scaling.factor", .found = "\"short\""}));
}

TEST(Scaling, landmarks)
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

TEST(Scaling, misfit)
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

TEST(Scaling, WhatMakesNoFactorIsRefused)
{
  const Folder folder("", "[scaling]\nfactor = 1.1\n");
  EXPECT_THAT(folder.refused({"scaling.landmarks=marks.csv"}),
              refuses({.field = "scaling", .found = "both"}));
  for (const char* wrong : {"0.09", "10.5", "-1", "[1, 1]", "\"large\""})
    for (const char* limit : {"0.1", "10"})
      EXPECT_THAT(folder.refused({std::string("scaling.factor=") + wrong}),
                  refuses({"", "scaling.factor", wrong, limit}));
  EXPECT_THAT(folder.refused({"scaling.factor=[1,1,0]"}), refuses({"", "scaling.factor.2", "0", "0.1"}));
  const Folder plain;
  EXPECT_EQ(plain.refused({"scaling.landmarks=none.csv"}).field, "scaling.landmarks");
  EXPECT_THAT(plain.refused({"scaling.landmark=marks.csv"}),
              refuses({.field = "scaling.landmark", .wanted = "\"scaling.landmarks\""}));
  EXPECT_THAT(plain.refused({"scaling.landmarks=marks.csv", "frame.unit=m"}),
              refuses({"marks.csv", "", "0.00125", "frame.unit = \"m\""}));
}

TEST(Scaling, left_joint)
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

}  // namespace vrda::scaling_test
