#include "analysis/reduce.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "analysis/audit.hpp"
#include "core/units.hpp"
#include "model/frames.hpp"
#include "support/meshes.hpp"
#include "support/models.hpp"

namespace vrda::analysis::two_sided_test {

constexpr double rounding_mm = 1e-9;
constexpr double apart_mm = 30.0, step_mm = 1.0;  // of the boxes: along z, and the lateral one higher
constexpr double face_mm = 10.0;                  // lower face of the block above the rotation centre

/// A wide block whose lower face rotates with the attitude, over two boxes of 2 mm, one per compartment.
/// By symmetry both boxes first touch with the same corner, so the gaps are equal if the face contains the
/// direction from one box to the other.
store::MotionModel block_over_boxes(const std::string& side, double spine_varus_deg)
{
  test::ModelPlan plan;
  plan.side = side;
  plan.rotation_centre_mm = {20, 50, -30};
  plan.flexion_deg = {0, 5, 10};
  plan.varus_deg = {-4, 0, 4};
  plan.motion = [](double, double) { return store::PoseCoordinates{0, 0, 0, 0}; };
  store::MotionModel model = test::model_of(plan);
  const double lateral = side == "left" ? -1.0 : 1.0;
  const Eigen::Vector3d to_lateral = 0.5 * Eigen::Vector3d(0, step_mm, lateral * apart_mm);
  model.reference.contact.mesh = test::box(plan.rotation_centre_mm + Eigen::Vector3d(0, 30, 0), {90, 40, 90});
  model.moving.contact.mesh = test::box(plan.rotation_centre_mm - to_lateral, {2, 2, 2});
  const auto n_medial = static_cast<std::size_t>(model.moving.contact.mesh.triangles.rows());
  append(model.moving.contact.mesh, test::box(plan.rotation_centre_mm + to_lateral, {2, 2, 2}));
  model.compartment_of_triangle.assign(n_medial, store::code_of(Compartment::medial));
  model.compartment_of_triangle.resize(2 * n_medial, store::code_of(Compartment::lateral));
  model.has_compartments = true;
  model.method = "equilibrium";
  store::FreeSpine& spine = model.equilibrium.emplace().spine;
  spine.status.assign(3, status_stable);
  spine.varus_deg.assign(3, spine_varus_deg);
  for (std::vector<double>* zero : {&spine.tx_mm, &spine.ty_mm, &spine.tz_mm, &spine.theta_deg})
    zero->assign(3, 0.0);
  model.contact_resolution_mm = 10.0;
  return model;
}

Eigen::Vector3d face_normal(double flexion_deg, double varus_deg)
{
  return reference_rotation({rad_from_deg(flexion_deg), rad_from_deg(varus_deg)}) * Eigen::Vector3d::UnitY();
}

// In the solver frame lateral is +Z for either side.
double balance(double flexion_deg, double varus_deg)
{
  return face_normal(flexion_deg, varus_deg).dot(Eigen::Vector3d(0, step_mm, apart_mm));
}

TEST(TwoSided, BothGapsCloseAtTheVarusOfTheClosedForm)
{
  for (const char* side : {"right", "left"}) {
    const store::MotionModel model = block_over_boxes(side, 0.0);
    const std::optional<store::TwoSided> found = analysis::two_sided(model, {}, 1);
    ASSERT_TRUE(found);
    for (std::size_t i = 0; i < found->flexion_deg.size(); ++i) {
      ASSERT_EQ(found->contact[i], store::code_of(store::TwoSidedContact::both)) << i;
      EXPECT_NEAR(balance(found->flexion_deg[i], found->varus_deg[i]), 0.0, rounding_mm);
      EXPECT_NEAR(found->gap_mm[0][i], contact_margin_mm, rounding_mm);
      EXPECT_NEAR(found->gap_mm[1][i], contact_margin_mm, rounding_mm);
      // The first corner of the lateral box to reach the face.
      const Eigen::Vector3d n = face_normal(found->flexion_deg[i], found->varus_deg[i]);
      const Eigen::Vector3d centre = 0.5 * Eigen::Vector3d(0, step_mm, apart_mm);
      const double height_mm = (face_mm - n.dot(centre) - n.cwiseAbs().sum()) / n.y();
      EXPECT_NEAR(found->ty_mm[i], height_mm - contact_margin_mm, rounding_mm);
    }
  }
}

TEST(TwoSided, ItsAxisContainsTheFlexionsOfTheModelAtMostAQuarterOfADegreeApart)
{
  const store::MotionModel model = block_over_boxes("right", 0.0);
  const store::TwoSided found = analysis::two_sided(model, {}, 1).value();
  for (const double flexion_deg : model.flexion_deg)
    EXPECT_TRUE(std::ranges::find(found.flexion_deg, flexion_deg) != found.flexion_deg.end()) << flexion_deg;
  for (std::size_t i = 1; i < found.flexion_deg.size(); ++i)
    EXPECT_LE(found.flexion_deg[i] - found.flexion_deg[i - 1], 0.25);
}

TEST(TwoSided, ALiftOffOfTheRawEquilibriumIsKept)
{
  store::MotionModel model = block_over_boxes("right", 0.0);
  model.contact_resolution_mm = 0.01;
  const store::TwoSided found = analysis::two_sided(model, {}, 1).value();
  for (std::size_t i = 0; i < found.flexion_deg.size(); ++i) {
    EXPECT_EQ(found.contact[i], store::code_of(store::TwoSidedContact::lateral));
    EXPECT_NEAR(found.gap_mm[1][i], contact_margin_mm, rounding_mm);
  }
  EXPECT_NEAR(found.gap_mm[0].front(), step_mm + contact_margin_mm, rounding_mm);
  EXPECT_NEAR(found.varus_deg.front(), 0.0, rounding_mm);
}

TEST(TwoSided, FlexionsBeyondTheRawSpineHaveNoPose)
{
  store::MotionModel model = block_over_boxes("right", 0.0);
  model.equilibrium->spine.status.back() = static_cast<std::int8_t>(StepStatus::iteration_limit);
  const store::TwoSided found = analysis::two_sided(model, {.degree = 1}, 1).value();
  for (std::size_t i = 0; i < found.flexion_deg.size(); ++i)
    EXPECT_EQ(found.contact[i] == store::code_of(store::TwoSidedContact::no_pose),
              found.flexion_deg[i] > 5.0);
}

TEST(TwoSided, ThreadsDoNotChangeABit)
{
  const store::MotionModel model = block_over_boxes("right", 0.5);
  const store::TwoSided one = analysis::two_sided(model, {}, 1).value(),
                        three = analysis::two_sided(model, {}, 3).value();
  EXPECT_EQ(one.varus_deg, three.varus_deg);
  EXPECT_EQ(one.ty_mm, three.ty_mm);
}

TEST(TwoSided, ReducedItKeepsItsOwnVarus)
{
  store::MotionModel model = block_over_boxes("right", 0.0);
  model.two_sided = analysis::two_sided(model, {}, 1);
  const store::ZeroVarus z = reduce(model, "two_sided");
  ASSERT_GT(n_reduced_flexions(z), 0);
  for (std::size_t i = 0; i < model.flexion_deg.size(); ++i) {
    const std::vector<double>& axis = model.two_sided->flexion_deg;
    const auto k =
        static_cast<std::size_t>(std::find(axis.begin(), axis.end(), model.flexion_deg[i]) - axis.begin());
    ASSERT_LT(k, axis.size());
    EXPECT_NEAR(z.varus_deg[i], model.two_sided->varus_deg[k], rounding_mm);
    EXPECT_NEAR(z.clinical[JointCoordinate::varus][i], z.varus_deg[i], rounding_mm);
    EXPECT_EQ(z.source[i], static_cast<std::int8_t>(store::ZeroVarusSource::interpolated));
    EXPECT_TRUE(std::isnan(z.varus_first_deg[i]));
  }
}

TEST(TwoSided, TheAuditMeasuresEachSide)
{
  store::MotionModel model = block_over_boxes("right", 0.0);
  model.two_sided = analysis::two_sided(model, {}, 1);
  const store::AuditSet two_sided = audit(model, "two_sided", 4, 2);
  EXPECT_EQ(two_sided.flexion_deg.size(), 4 * (model.two_sided->flexion_deg.size() - 1) + 1);
  EXPECT_LT(two_sided.compartment_gap_mm[0].abs().maxCoeff(), 1e-4);
  EXPECT_LT(two_sided.compartment_gap_mm[1].abs().maxCoeff(), 1e-4);
  // At flexion 0 and varus 0 the raw pose of height 0 leaves the medial box `step_mm` more than the lateral
  // one.
  const store::AuditSet raw = audit(model, "raw", 1, 1);
  EXPECT_NEAR(raw.compartment_gap_mm[1](0, 1), face_mm - 1.0 - 0.5 * step_mm, rounding_mm);
  EXPECT_NEAR(raw.compartment_gap_mm[0](0, 1), face_mm - 1.0 + 0.5 * step_mm, rounding_mm);
}

}  // namespace vrda::analysis::two_sided_test
