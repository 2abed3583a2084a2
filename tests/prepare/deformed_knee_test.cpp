// A template's own knee, deformed, as a subject whose attachments are known; real knees.
#include <gmock/gmock.h>
#include <cstdlib>
#include <map>
#include <random>

#include "core/units.hpp"
#include "geometry/knee_fit.hpp"
#include "model/coordinates.hpp"
#include "prepare/knee_landmarks.hpp"
#include "prepare/template_joint.hpp"
#include "prepare/transfer.hpp"
#include "solve/case_solver.hpp"
#include "support/real_knees.hpp"

namespace vrda::deformed_knee_test {

// A scale an axis within 12 %, and waves of 1 mm. Seed 0 changes nothing.
struct Deformation {
  explicit Deformation(unsigned seed)
  {
    if (seed == 0) return;
    amplitude_mm = 1.0;
    std::mt19937 random(seed);
    const auto uniform = [&](double low, double high) {
      return low + (high - low) * static_cast<double>(random()) / 4294967296.0;
    };
    for (Eigen::Index k = 0; k < 3; ++k) {
      scale[k] = uniform(0.88, 1.12);
      for (Eigen::Index i = 0; i < 3; ++i) wave_per_mm(k, i) = uniform(-0.1, 0.1);
      phase[k] = uniform(0.0, 2.0 * pi);
    }
  }

  Eigen::Vector3d operator()(const Eigen::Vector3d& p_mm) const
  {
    return scale.cwiseProduct(p_mm) +
           amplitude_mm * ((wave_per_mm * p_mm + phase).array().sin() / std::sqrt(3.0)).matrix();
  }

  Mesh operator()(Mesh mesh) const
  {
    for (Eigen::Index v = 0; v < mesh.vertices_mm.rows(); ++v)
      mesh.vertices_mm.row(v) = (*this)(Eigen::Vector3d(mesh.vertices_mm.row(v))).transpose();
    mesh.normals = vertex_normals(mesh);
    return mesh;
  }

  geometry::BoneSurfaces operator()(const geometry::BoneSurfaces& bone) const
  {
    return {(*this)(bone.bone), (*this)(bone.cartilage)};
  }

  double amplitude_mm = 0.0;
  Eigen::Vector3d scale = Eigen::Vector3d::Ones(), phase = Eigen::Vector3d::Zero();
  Eigen::Matrix3d wave_per_mm = Eigen::Matrix3d::Zero();
};

geometry::BoneSurfaces in_frame(const geometry::BoneSurfaces& bone, const Pose& X_scan_bone)
{
  const Pose X = X_scan_bone.inverse();
  return {transformed(bone.bone, X), transformed(bone.cartilage, X)};
}

prepare::TemplateJoint template_named(const std::string& name)
{
  if (name == "generic") return prepare::generic_template();
  return prepare::template_of(
      job::load_case((test::source_directory() / ("jobs/knee-" + name + ".toml")).string(),
                     {test::data_directory()->string(), {}}));
}

// Free varus at 0, 5, ... 90 degrees, along a spine in steps of 1 degree.
std::vector<ClinicalCoordinates> solved_motion(job::Case joint)
{
  joint.grid = {{}, {0.0}};
  joint.path_flexion_deg.clear();
  for (int k = 0; k <= 90; ++k) {
    joint.path_flexion_deg.push_back(k);
    if (k % 5 == 0) joint.grid.flexion_deg.push_back(k);
  }
  joint.is_varus_free = true;
  joint.push.assign(joint.grid.flexion_deg.size(), joint.push.front());
  joint.path_push.assign(joint.path_flexion_deg.size(), joint.push.front());
  joint.spine = {0, 0.0};
  constexpr int n_threads = 1;
  solve::CaseSolver solver(joint, n_threads);
  const solve::SweepResult result = solve::sweep(
      solve::plan_of(joint), [&](const solve::StepTask& task) { return solver(task); }, {}, n_threads);
  std::vector<ClinicalCoordinates> motion;
  for (const StepRecord& cell : result.cells) {
    if (cell.status != StepStatus::stable) continue;
    const double flexion_rad =
        rad_from_deg(joint.grid.flexion_deg[static_cast<std::size_t>(cell.key.flexion)]);
    motion.push_back(
        clinical_coordinates(X_reference_moving(joint.frame, {flexion_rad, cell.varus_rad}, cell.pose),
                             joint.frame.side, joint.frame.rotation_centre_mm));
  }
  return motion;
}

constexpr std::size_t n_flexions = 19;

double rms_difference(const std::vector<ClinicalCoordinates>& a, const std::vector<ClinicalCoordinates>& b,
                      double ClinicalCoordinates::*quantity)
{
  double sum = 0.0;
  for (std::size_t i = 0; i < a.size(); ++i) sum += std::pow(a[i].*quantity - b[i].*quantity, 2);
  return std::sqrt(sum / static_cast<double>(a.size()));
}

class DeformedKnee : public testing::TestWithParam<const char*> {
 protected:
  void SetUp() override
  {
    if (GetParam() != std::string("generic")) VRDA_REQUIRE_REAL_KNEES();
  }
};

// $VRDA_DEFORMED_SEED: another deformation; scripts/prepare_trials tries 20.
TEST_P(DeformedKnee, ItsAttachmentsAreFoundAndItMovesAsWithItsOwnLigaments)
{
  const char* given = std::getenv("VRDA_DEFORMED_SEED");
  const Deformation deform(given == nullptr ? 1 : static_cast<unsigned>(std::stoul(given)));
  const prepare::TemplateJoint joint = template_named(GetParam());
  const geometry::KneeSurfaces scan{deform(joint.knee.surfaces.femur), deform(joint.knee.surfaces.tibia)};
  const geometry::KneeFit fit = fit_knee(scan, joint.knee);
  ASSERT_EQ(fit.side, Side::right);
  const prepare::SubjectBones bones{
      {in_frame(scan.femur, fit.X_scan_femur), in_frame(scan.tibia, fit.X_scan_tibia)},
      transformed(deform(joint.fibula), fit.X_scan_tibia.inverse())};

  // The knee with its own ligaments, in the axes and the pose of the template.
  job::Case own = joint.joint;
  own.reference.contact.mesh = deform(own.reference.contact.mesh);
  own.moving.contact.mesh = deform(own.moving.contact.mesh);
  own.frame.rotation_centre_mm = deform(joint.knee.origin_mm);
  job::Case subject = own;
  subject.reference.contact.mesh = transformed(own.reference.contact.mesh, fit.X_scan_femur.inverse());
  subject.moving.contact.mesh = transformed(own.moving.contact.mesh, fit.X_scan_tibia.inverse());
  subject.frame.rotation_centre_mm.setZero();
  subject.ligaments = prepare::transferred_ligaments(joint, fit, bones).ligaments;

  double sum_mm = 0.0;
  std::vector<model::Fibre>& fibres = own.ligaments.fibres;
  for (std::size_t i = 0; i < fibres.size(); ++i) {
    const model::Fibre& transferred = subject.ligaments.fibres[i];
    fibres[i].reference_mm = deform(fibres[i].reference_mm);
    fibres[i].moving_mm = deform(fibres[i].moving_mm);
    sum_mm += (fit.X_scan_femur * transferred.reference_mm - fibres[i].reference_mm).norm() +
              (fit.X_scan_tibia * transferred.moving_mm - fibres[i].moving_mm).norm();
  }
  own.ligaments.wraps = subject.ligaments.wraps;
  for (model::Wrap& wrap : own.ligaments.wraps)
    wrap.X_body_wrap =
        (wrap.body == BodyIndex::reference ? fit.X_scan_femur : fit.X_scan_tibia) * wrap.X_body_wrap;

  const double attachments_mm = sum_mm / (2.0 * static_cast<double>(fibres.size()));
  EXPECT_LT(attachments_mm, 2.0);
  RecordProperty("attachments_mm", std::to_string(attachments_mm));

  constexpr int n_threads = 1;
  prepare::SlackLengths(own, joint.joint, n_threads).set();
  const prepare::SlackResult slack = prepare::SlackLengths(subject, joint.joint, n_threads).set();
  EXPECT_EQ(slack.loads.n_solved, slack.loads.n_flexions);
  const std::vector<ClinicalCoordinates> expected = solved_motion(own), found = solved_motion(subject);
  RecordProperty("n_solved", static_cast<int>(found.size()));
  ASSERT_EQ(expected.size(), n_flexions);
  ASSERT_EQ(found.size(), n_flexions);

  const double internal_deg =
      deg_from_rad(rms_difference(found, expected, &ClinicalCoordinates::internal_rotation_rad));
  const double varus_deg = deg_from_rad(rms_difference(found, expected, &ClinicalCoordinates::varus_rad));
  const double anterior_mm = rms_difference(found, expected, &ClinicalCoordinates::anterior_mm);
  EXPECT_LT(internal_deg, 6.0);
  EXPECT_LT(anterior_mm, 1.5);
  RecordProperty("internal_deg", std::to_string(internal_deg));
  RecordProperty("varus_deg", std::to_string(varus_deg));
  RecordProperty("anterior_mm", std::to_string(anterior_mm));
}

INSTANTIATE_TEST_SUITE_P(Templates, DeformedKnee, testing::Values("generic", "jam-smith2019-ligaments"));

using geometry::KneeFit, geometry::KneeSurfaces;

job::Case load_knee(const std::string& name)
{
  return job::load_case((test::source_directory() / ("jobs/knee-" + name + ".toml")).string(),
                        {test::data_directory()->string(), {}});
}

KneeSurfaces moved(KneeSurfaces knee, const Pose& X, double unit_mm)
{
  for (Mesh* mesh : {&knee.femur.bone, &knee.femur.cartilage, &knee.tibia.bone, &knee.tibia.cartilage}) {
    *mesh = transformed(*mesh, X);
    mesh->vertices_mm /= unit_mm;
  }
  return knee;
}

double degrees_between(const Pose& a, const Pose& b)
{
  return deg_from_rad((a.linear() - b.linear()).norm() / std::sqrt(2.0));
}

void expect_near(const Pose& a, const Pose& b, double most_deg, double most_mm)
{
  EXPECT_LT(degrees_between(a, b), most_deg);
  EXPECT_LT((a.translation() - b.translation()).norm(), most_mm);
}

const geometry::TemplateKnee& reference()
{
  static const geometry::TemplateKnee knee = prepare::template_of(load_knee("jam-smith2019-ligaments")).knee;
  return knee;
}

/// A real knee as scanned and its fit to the reference, made once for all tests.
struct RealKnee {
  explicit RealKnee(const std::string& name) : RealKnee(load_knee(name)) {}
  explicit RealKnee(const job::Case& knee)
      : surfaces{prepare::surfaces_of(knee.reference), prepare::surfaces_of(knee.moving)},
        fit(fit_knee(surfaces, reference()))
  {
  }

  KneeSurfaces surfaces;
  KneeFit fit;
};

const RealKnee& real_knee(const std::string& name)
{
  static std::map<std::string, RealKnee> knees;
  return knees.try_emplace(name, name).first->second;
}

// One orientation of each knee, by both templates.
TEST(PrepareRealKnees, UnitSideAndFramesAreFoundInAnyOrientation)
{
  VRDA_REQUIRE_REAL_KNEES();
  const geometry::TemplateKnee generic = prepare::generic_template().knee;
  Pose X = Pose::Identity();
  X.linear() = Eigen::Quaterniond(1, -2, 3, 1).normalized().toRotationMatrix();
  X.translation() = Eigen::Vector3d(310, -200, 40);
  for (const auto& [name, side, unit_mm] :
       {std::tuple("jam-smith2019", Side::right, 10.0), std::tuple("pymskt-dess", Side::right, 1000.0),
        std::tuple("vhf-left", Side::left, 1.0), std::tuple("vhf-right", Side::right, 10.0)}) {
    SCOPED_TRACE(name);
    const auto& [surfaces, fit] = real_knee(name);
    const KneeFit other = fit_knee(moved(surfaces, X, unit_mm), generic);
    EXPECT_DOUBLE_EQ(fit.unit_mm, 1.0);
    EXPECT_DOUBLE_EQ(other.unit_mm, unit_mm);
    EXPECT_EQ(fit.side, side);
    EXPECT_EQ(other.side, side);
    EXPECT_GT(fit.side_margin, 1.05);
    EXPECT_GT(other.side_margin, 1.05);
    // Templates differ like people: the frames agree to some degrees and millimetres.
    expect_near(X * fit.X_scan_femur, other.X_scan_femur, 5.0, 4.0);
    expect_near(X * fit.X_scan_tibia, other.X_scan_tibia, 5.0, 4.0);
    EXPECT_THAT(geometry::rejection_reasons(other, moved(surfaces, X, unit_mm)), testing::IsEmpty());
    EXPECT_THAT(geometry::rejection_reasons(fit, surfaces), testing::IsEmpty());
  }
}

// Of the four, the knee whose fit has the most optima.
TEST(PrepareRealKnees, AMovedKneeGivesTheMovedFrames)
{
  VRDA_REQUIRE_REAL_KNEES();
  const RealKnee& knee = real_knee("vhf-left");
  Pose X = Pose::Identity();
  X.linear() = Eigen::Quaterniond(2, 1, -1, 3).normalized().toRotationMatrix();
  X.translation() = Eigen::Vector3d(-130, 250, 400);
  const KneeFit other = fit_knee(moved(knee.surfaces, X, 1.0), reference());
  expect_near(X * knee.fit.X_scan_femur, other.X_scan_femur, 0.1, 0.1);
  expect_near(X * knee.fit.X_scan_tibia, other.X_scan_tibia, 0.1, 0.1);
}

// As one, the bones of this knee are refused at 90 degrees.
TEST(PrepareRealKnees, AFlexedScanGivesTheFramesOfTheOther)
{
  VRDA_REQUIRE_REAL_KNEES();
  KneeSurfaces surfaces = real_knee("vhf-right").surfaces;
  const KneeFit& straight = real_knee("vhf-right").fit;
  Pose X_femur_flexed = Pose::Identity();
  X_femur_flexed.linear() = rotation_z(rad_from_deg(90.0));
  const Pose X = straight.X_scan_femur * X_femur_flexed * straight.X_scan_femur.inverse();
  surfaces.femur.cartilage = transformed(surfaces.femur.cartilage, X);
  const KneeFit fit = fit_knee(surfaces, reference());
  EXPECT_THAT(geometry::rejection_reasons(fit, surfaces), testing::IsEmpty());
  expect_near(X * straight.X_scan_femur, fit.X_scan_femur, 0.5, 0.5);
  expect_near(straight.X_scan_tibia, fit.X_scan_tibia, 0.5, 0.5);
  EXPECT_NEAR(fit.scanned.flexion_rad, straight.scanned.flexion_rad + rad_from_deg(90.0), rad_from_deg(2.0));
}

}  // namespace vrda::deformed_knee_test
