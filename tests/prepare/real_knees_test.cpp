#include "support/real_knees.hpp"

#include <gmock/gmock.h>

#include "core/units.hpp"
#include "geometry/knee_fit.hpp"
#include "prepare/template_joint.hpp"

namespace vrda::prepare_real_knees_test {

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

// One orientation of each knee, by both templates.
TEST(PrepareRealKnees, UnitSideAndFramesAreFoundInAnyOrientation)
{
  VRDA_REQUIRE_REAL_KNEES();
  const geometry::TemplateKnee reference = prepare::template_of(load_knee("jam-smith2019-ligaments")).knee;
  const geometry::TemplateKnee generic = prepare::generic_template().knee;
  Pose X = Pose::Identity();
  X.linear() = Eigen::Quaterniond(1, -2, 3, 1).normalized().toRotationMatrix();
  X.translation() = Eigen::Vector3d(310, -200, 40);
  for (const auto& [name, side, unit_mm] :
       {std::tuple("jam-smith2019", Side::right, 10.0), std::tuple("pymskt-dess", Side::right, 1000.0),
        std::tuple("vhf-left", Side::left, 1.0), std::tuple("vhf-right", Side::right, 10.0)}) {
    SCOPED_TRACE(name);
    const job::Case knee = load_knee(name);
    const KneeSurfaces surfaces{prepare::surfaces_of(knee.reference), prepare::surfaces_of(knee.moving)};
    const KneeFit fit = fit_knee(surfaces, reference);
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
  const geometry::TemplateKnee reference = prepare::template_of(load_knee("jam-smith2019-ligaments")).knee;
  const job::Case knee = load_knee("vhf-left");
  const KneeSurfaces surfaces{prepare::surfaces_of(knee.reference), prepare::surfaces_of(knee.moving)};
  Pose X = Pose::Identity();
  X.linear() = Eigen::Quaterniond(2, 1, -1, 3).normalized().toRotationMatrix();
  X.translation() = Eigen::Vector3d(-130, 250, 400);
  const KneeFit fit = fit_knee(surfaces, reference), other = fit_knee(moved(surfaces, X, 1.0), reference);
  expect_near(X * fit.X_scan_femur, other.X_scan_femur, 0.1, 0.1);
  expect_near(X * fit.X_scan_tibia, other.X_scan_tibia, 0.1, 0.1);
}

// As one, the bones of these knees are refused at 90 degrees.
TEST(PrepareRealKnees, AFlexedScanGivesTheFramesOfTheOther)
{
  VRDA_REQUIRE_REAL_KNEES();
  const geometry::TemplateKnee reference = prepare::template_of(load_knee("jam-smith2019-ligaments")).knee;
  for (const char* name : {"vhf-left", "vhf-right"}) {
    SCOPED_TRACE(name);
    const job::Case knee = load_knee(name);
    KneeSurfaces surfaces{prepare::surfaces_of(knee.reference), prepare::surfaces_of(knee.moving)};
    const KneeFit straight = fit_knee(surfaces, reference);
    Pose X_femur_flexed = Pose::Identity();
    X_femur_flexed.linear() = rotation_z(rad_from_deg(90.0));
    const Pose X = straight.X_scan_femur * X_femur_flexed * straight.X_scan_femur.inverse();
    surfaces.femur.cartilage = transformed(surfaces.femur.cartilage, X);
    const KneeFit fit = fit_knee(surfaces, reference);
    EXPECT_THAT(geometry::rejection_reasons(fit, surfaces), testing::IsEmpty());
    expect_near(X * straight.X_scan_femur, fit.X_scan_femur, 0.5, 0.5);
    expect_near(straight.X_scan_tibia, fit.X_scan_tibia, 0.5, 0.5);
    EXPECT_NEAR(fit.scanned.flexion_rad, straight.scanned.flexion_rad + rad_from_deg(90.0),
                rad_from_deg(2.0));
  }
}

}  // namespace vrda::prepare_real_knees_test
