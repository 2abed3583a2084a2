#include <gtest/gtest.h>

#include "core/text.hpp"
#include "model/differences.hpp"
#include "model/ligaments.hpp"

namespace vrda::wrapped_fibres_test {

using test::Place;

// A fibre each round a cylinder on the reference, the same on the moving object, and ellipsoids on both.
model::Ligaments wrapped_fibres()
{
  Pose X_tilted = Pose::Identity();
  X_tilted.linear() = rotation_x(0.3) * rotation_y(-0.2) * rotation_z(0.4);
  X_tilted.translation() << 2, -3, 1;
  model::Ligaments ligaments;
  ligaments.wraps = {{"a", model::WrapShape::cylinder, model::WrapBody::reference, X_tilted, {18, 18, 50}},
                     {"b", model::WrapShape::cylinder, model::WrapBody::moving, X_tilted, {12, 12, 50}},
                     {"c", model::WrapShape::ellipsoid, model::WrapBody::reference, X_tilted, {25, 14, 12}},
                     {"d", model::WrapShape::ellipsoid, model::WrapBody::moving, X_tilted, {30, 18, 12}}};
  ligaments.fibres = {{"a", "a", {-12, 20, 5}, {-10, -29, 12}, 1200, 46, 0},
                      {"b", "b", {-6, 25, 5}, {-5, -22, -8}, 900, 46, 1},
                      {"c", "c", {3, 21, -9}, {6, -30, -8}, 1500, 48, 2},
                      {"d", "d", {4, 30, -8}, {6, -41, -9}, 700, 67, 3}};
  return ligaments;
}

const Place bent{{0.25, -0.06}, {{1.5, -2.0, 0.7}, 0.1}};

TEST(WrappedFibres, AllTouchAndAreTaut)
{
  for (const model::FibreState& state : model::fibre_states(wrapped_fibres(), bent.attitude, bent.pose)) {
    EXPECT_TRUE(state.is_wrapped);
    EXPECT_GT(state.force_n, 0.0);
  }
}

TEST(WrappedFibres, DerivativesMatchDifferences)
{
  const model::Ligaments all = wrapped_fibres();
  for (std::size_t k = 0; k < all.fibres.size(); ++k) {
    SCOPED_TRACE(all.fibres[k].name);
    model::Ligaments one = all;
    one.fibres = {all.fibres[k]};
    const Potential exact = test::energy_at(one, bent);
    const Potential measured = test::energy_by_differences(one, bent);
    EXPECT_GT(exact.energy_nmm, 0.0);
    // Lengths are known to 1e-9 mm and pull with up to 300 N over steps of 1e-4 mm or 2e-6 rad.
    for (Eigen::Index i = 0; i < n_coordinates; ++i) {
      const double unit = i < about_y ? 1.0 : 50.0;  // mm a radian
      EXPECT_NEAR(exact.gradient[i], measured.gradient[i], 3e-3 * unit) << i;
      for (Eigen::Index j = 0; j < n_coordinates; ++j) {
        const double other_unit = j < about_y ? 1.0 : 50.0;
        EXPECT_NEAR(exact.hessian(i, j), measured.hessian(i, j), 3e-3 * unit * other_unit) << i << " " << j;
      }
    }
  }
}

TEST(WrappedFibres, MirroredJointGivesTheSameToTheLastBit)
{
  const model::Ligaments right = wrapped_fibres();
  model::Ligaments left = right;
  const Eigen::Vector3d m(1, 1, -1);
  for (model::Fibre& fibre : left.fibres) {
    fibre.reference_mm = m.cwiseProduct(fibre.reference_mm);
    fibre.moving_mm = m.cwiseProduct(fibre.moving_mm);
  }
  for (model::Wrap& wrap : left.wraps) {
    // As a file would give it: the angles about X and Y change sign.
    wrap.X_body_wrap.linear() = rotation_x(-0.3) * rotation_y(0.2) * rotation_z(0.4);
    wrap.X_body_wrap.translation().z() *= -1.0;
  }
  const SolverFrame right_frame{Side::right, {1, 2, 3}, Eigen::Vector3d::UnitY()};
  const SolverFrame left_frame{Side::left, {1, 2, -3}, Eigen::Vector3d::UnitY()};
  const Potential a = test::energy_at(model::solver_ligaments(right, right_frame), bent);
  const Potential b = test::energy_at(model::solver_ligaments(left, left_frame), bent);
  EXPECT_GT(a.energy_nmm, 0.0);
  EXPECT_EQ(a.energy_nmm, b.energy_nmm);
  EXPECT_EQ(a.gradient, b.gradient);
  EXPECT_EQ(a.hessian, b.hessian);
}

TEST(WrappedFibres, KeepTheirLengthsWhenTheJointIsMovedAsAWhole)
{
  // Both objects moved together, as another rotation centre and Delta do at the pose of the meshes.
  const model::Ligaments canonical = wrapped_fibres();
  const SolverFrame frame{Side::right, {40, -7, 12}, Eigen::Vector3d(0.2, 1, 0.4).normalized()};
  const std::vector<model::FibreState> here = model::fibre_states(canonical, {}, {});
  const std::vector<model::FibreState> there =
      model::fibre_states(model::solver_ligaments(canonical, frame), {}, {});
  for (std::size_t i = 0; i < here.size(); ++i) {
    EXPECT_TRUE(here[i].is_wrapped);
    EXPECT_NEAR(here[i].length_mm, there[i].length_mm, 1e-8);
  }
}

TEST(WrappedFibres, SwappedBodiesPullTheOtherWay)
{
  // What a wrap on the moving object does is what the same wrap on the reference does with the roles swapped.
  const model::Ligaments forward = wrapped_fibres();
  model::Ligaments swapped = forward;
  for (model::Fibre& fibre : swapped.fibres) std::swap(fibre.reference_mm, fibre.moving_mm);
  for (model::Wrap& wrap : swapped.wraps) {
    wrap.body = wrap.body == model::WrapBody::moving ? model::WrapBody::reference : model::WrapBody::moving;
  }
  const Eigen::Vector3d t_mm(1.5, -2.0, 0.7);
  const Potential a = model::ligament_energy(forward, {}, {t_mm, 0.0});
  const Potential b = model::ligament_energy(swapped, {}, {-t_mm, 0.0});
  EXPECT_NEAR(a.energy_nmm, b.energy_nmm, 1e-6);
  EXPECT_LT((a.gradient.head<3>() + b.gradient.head<3>()).norm(), 1e-6);
}

double chords_mm(const std::vector<Eigen::Vector3d>& points_mm)
{
  double sum_mm = 0.0;
  for (std::size_t k = 1; k < points_mm.size(); ++k) sum_mm += (points_mm[k] - points_mm[k - 1]).norm();
  return sum_mm;
}

TEST(WrappedFibres, TheWayLiesOnTheSurfaceAndIsAsLongAsThePath)
{
  const model::Ligaments ligaments = wrapped_fibres();
  const model::JointPlacement placement = model::joint_placement(bent.attitude, bent.pose);
  for (const model::Fibre& fibre : ligaments.fibres) {
    SCOPED_TRACE(fibre.name);
    const model::FibrePath path = model::fibre_path(fibre, ligaments.wraps, placement);
    std::vector<Eigen::Vector3d> points_mm(202);
    const model::SampledFibre way = model::sample_fibre_path(fibre, ligaments.wraps, placement, points_mm);
    ASSERT_TRUE(way.is_wrapped);
    EXPECT_EQ(way.length_mm, path.length_mm);
    const bool is_on_moving = path.end_body == model::WrapBody::reference;
    const Eigen::Vector3d& end_mm = is_on_moving ? points_mm.front() : points_mm.back();
    EXPECT_EQ(end_mm, path.end_mm);
    // 199 chords of an arc that turns by at most pi are short by a part of (pi / 199)^2 / 24: 1e-5.
    EXPECT_LE(chords_mm(points_mm), path.length_mm + 1e-8);
    EXPECT_GT(chords_mm(points_mm), path.length_mm * (1.0 - 1.1e-5));
    const model::Wrap& wrap = ligaments.wraps[static_cast<std::size_t>(fibre.wrap)];
    for (std::size_t k = 1; k + 1 < points_mm.size(); ++k) {
      const Eigen::Vector3d p_body_mm =
          is_on_moving
              ? Eigen::Vector3d(placement.R_S_moving.transpose() * (points_mm[k] - placement.t_S_moving_mm))
              : Eigen::Vector3d(placement.R_S_reference.transpose() * points_mm[k]);
      Eigen::Vector3d q = (wrap.X_body_wrap.inverse() * p_body_mm).cwiseQuotient(wrap.radii_mm);
      if (wrap.shape == model::WrapShape::cylinder) q.z() = 0.0;
      EXPECT_NEAR(q.norm(), 1.0, 1e-9);
    }
    // It leaves along the path's last segment.
    const Eigen::Vector3d last_mm = is_on_moving ? Eigen::Vector3d(points_mm[1] - points_mm[0])
                                                 : Eigen::Vector3d(points_mm[201] - points_mm[200]);
    EXPECT_LT((last_mm.normalized() - path.direction).norm(), 1e-7);
  }
}

TEST(WrappedFibres, AStraightWayIsEvenlyDivided)
{
  model::Ligaments ligaments = wrapped_fibres();
  model::Fibre fibre = ligaments.fibres.front();
  fibre.wrap = -1;
  std::vector<Eigen::Vector3d> points_mm(5);
  const model::SampledFibre way = model::sample_fibre_path(fibre, ligaments.wraps, {}, points_mm);
  EXPECT_FALSE(way.is_wrapped);
  EXPECT_EQ(way.length_mm, (fibre.moving_mm - fibre.reference_mm).norm());
  for (std::size_t k = 0; k < 5; ++k) {
    const Eigen::Vector3d expected =
        fibre.reference_mm + static_cast<double>(k) / 4.0 * (fibre.moving_mm - fibre.reference_mm);
    EXPECT_LT((points_mm[k] - expected).norm(), 1e-13);
  }
  points_mm.resize(3);
  EXPECT_THROW(model::sample_fibre_path(fibre, ligaments.wraps, {}, points_mm), InternalError);
}

}  // namespace vrda::wrapped_fibres_test
