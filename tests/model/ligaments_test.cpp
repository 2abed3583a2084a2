#include <gtest/gtest.h>

#include <random>

#include "core/text.hpp"
#include "model/ligaments.hpp"

namespace vrda::ligaments_test {

/// A pose with its attitude, moved along the five coordinates.
struct Place {
  Attitude attitude;
  MovingPose pose;

  Place moved(Eigen::Index coordinate, double by) const
  {
    Place out = *this;
    if (coordinate < about_y) out.pose.translation_mm[coordinate] += by;
    if (coordinate == about_y) out.pose.theta_rad += by;
    if (coordinate == about_varus) out.attitude.varus_rad += by;
    return out;
  }
};

/// Steps where truncation and rounding of doubles are in balance for lengths of tens of mm.
double difference_step(Eigen::Index coordinate)
{
  return coordinate < about_y ? 1e-4 : 2e-6;
}

Potential energy_at(const model::Ligaments& ligaments, const Place& place)
{
  return model::ligament_energy(ligaments, place.attitude, place.pose);
}

/// Gradient from energies, second derivatives from gradients.
Potential energy_by_differences(const model::Ligaments& ligaments, const Place& place)
{
  Potential out = energy_at(ligaments, place);
  for (Eigen::Index i = 0; i < n_coordinates; ++i) {
    const double h = difference_step(i);
    const Potential ahead = energy_at(ligaments, place.moved(i, h));
    const Potential behind = energy_at(ligaments, place.moved(i, -h));
    out.gradient[i] = (ahead.energy_nmm - behind.energy_nmm) / (2.0 * h);
    out.hessian.col(i) = (ahead.gradient - behind.gradient) / (2.0 * h);
  }
  return out;
}

constexpr double rounding = 1e-12;  // relative, of a few operations on doubles

model::Ligaments one_fibre(double stiffness_n, double slack_length_mm)
{
  model::Ligaments ligaments;
  ligaments.fibres = {{"a", "a", {0, 0, 0}, {0, 0, 0}, stiffness_n, slack_length_mm, -1}};
  return ligaments;
}

// Straight fibres of a joint's size, from slack to well beyond the toe.
model::Ligaments random_fibres(int n, std::uint64_t seed)
{
  std::mt19937_64 random(seed);
  const auto uniform = [&](double from, double to) {
    return from + (to - from) * static_cast<double>(random() >> 11U) * 0x1p-53;
  };
  const auto point = [&](double y_mm) {
    return Eigen::Vector3d(uniform(-30, 30), y_mm + uniform(-10, 10), uniform(-40, 40));
  };
  model::Ligaments ligaments;
  for (int i = 0; i < n; ++i) {
    model::Fibre fibre{"f" + std::to_string(i), "f", point(5), point(-25), uniform(100, 3000), 1.0, -1};
    fibre.slack_length_mm = (fibre.moving_mm - fibre.reference_mm).norm() * uniform(0.85, 1.05);
    ligaments.fibres.push_back(fibre);
  }
  return ligaments;
}

const Place bent{{0.6, -0.08}, {{1.5, -2.0, 0.7}, 0.15}};

TEST(Tension, FollowsTheLawOfBlankevoort)
{
  // k e^2 / (2 et) up to et = 0.06, then k (e - et / 2)
  struct Row {
    double strain, force_n, stiffness_n;
  };
  for (const Row row :
       {Row{-0.1, 0, 0}, Row{0, 0, 0}, Row{0.03, 15, 1000}, Row{0.06, 60, 2000}, Row{0.1, 140, 2000}}) {
    SCOPED_TRACE(row.strain);
    const model::Tension tension = model::tension_of(row.strain, 2000, 0.06);
    EXPECT_NEAR(tension.force_n, row.force_n, 140 * rounding);
    EXPECT_NEAR(tension.stiffness_n, row.stiffness_n, 2000 * rounding);
  }
}

TEST(Tension, EnergyIsTheIntegralOfTheForce)
{
  // Simpson's rule is exact for the square of the toe and for the line after it.
  const auto integral = [](double from, double to) {
    const double middle = 0.5 * (from + to);
    return (to - from) / 6 *
           (model::tension_of(from, 800, 0.06).force_n + 4 * model::tension_of(middle, 800, 0.06).force_n +
            model::tension_of(to, 800, 0.06).force_n);
  };
  EXPECT_NEAR(model::tension_of(0.05, 800, 0.06).energy_n, integral(0, 0.05), rounding);
  EXPECT_NEAR(model::tension_of(0.2, 800, 0.06).energy_n, integral(0, 0.06) + integral(0.06, 0.2),
              10 * rounding);
  EXPECT_EQ(model::tension_of(-0.01, 800, 0.06).energy_n, 0.0);
}

TEST(LigamentEnergy, OfOneStretchedFibreIsThatOfASpring)
{
  const model::Ligaments ligaments = one_fibre(2000, 20);
  // 25 mm along y: strain 0.25
  const MovingPose pose{{0, -25, 0}, 0};
  const Potential potential = model::ligament_energy(ligaments, {}, pose);
  const double force_n = 2000 * (0.25 - 0.03);
  EXPECT_NEAR(potential.gradient[along_y], -force_n, force_n * rounding);
  EXPECT_NEAR(potential.hessian(along_y, along_y), 2000.0 / 20, 100 * rounding);
  // Across itself a taut fibre is stiff as force over length.
  EXPECT_NEAR(potential.hessian(along_x, along_x), force_n / 25, 100 * rounding);
  // k l0 (e^2/2 - e et/2 + et^2/6)
  const double energy_nmm = 2000 * 20 * (0.25 * 0.25 / 2 - 0.25 * 0.03 + 0.06 * 0.06 / 6);
  EXPECT_NEAR(potential.energy_nmm, energy_nmm, energy_nmm * rounding);
}

TEST(LigamentEnergy, OfSlackFibresIsNothing)
{
  const Potential potential = model::ligament_energy(one_fibre(2000, 26), {}, {{0, -25, 0}, 0});
  EXPECT_EQ(potential.energy_nmm, 0.0);
  EXPECT_EQ(potential.gradient, Vector5d(Vector5d::Zero()));
  EXPECT_EQ(potential.hessian, Matrix5d(Matrix5d::Zero()));
}

TEST(LigamentEnergy, IsTheSumOfTheStates)
{
  const model::Ligaments ligaments = random_fibres(40, 1);
  double energy_nmm = 0.0;
  int n_slack = 0, n_toe = 0, n_linear = 0;
  for (const model::FibreState& state : model::fibre_states(ligaments, bent.attitude, bent.pose)) {
    energy_nmm += state.energy_nmm;
    n_slack += state.strain <= 0.0;
    n_toe += state.strain > 0.0 && state.strain < 0.06;
    n_linear += state.strain > 0.06;
  }
  EXPECT_GE(std::min({n_slack, n_toe, n_linear}), 4);
  EXPECT_NEAR(energy_at(ligaments, bent).energy_nmm, energy_nmm, energy_nmm * rounding);
}

TEST(LigamentEnergy, DerivativesMatchDifferences)
{
  const model::Ligaments ligaments = random_fibres(40, 2);
  const Potential exact = energy_at(ligaments, bent);
  const Potential measured = energy_by_differences(ligaments, bent);
  // Rounding of the energy (1e-16 of 1e4 N mm over steps of 1e-4 mm or 2e-6 rad) and squares of the steps.
  for (Eigen::Index i = 0; i < n_coordinates; ++i) {
    const double unit = i < about_y ? 1.0 : 50.0;  // mm a radian
    EXPECT_NEAR(exact.gradient[i], measured.gradient[i], 1e-6 * unit);
    for (Eigen::Index j = 0; j < n_coordinates; ++j) {
      SCOPED_TRACE(std::to_string(i) + " " + std::to_string(j));
      EXPECT_NEAR(exact.hessian(i, j), measured.hessian(i, j), 1e-5 * unit * (j < about_y ? 1.0 : 50.0));
    }
  }
  EXPECT_EQ(exact.hessian, Matrix5d(exact.hessian.transpose()));
}

// A fibre each round a cylinder on the reference, the same on the moving object, and ellipsoids on both.
model::Ligaments wrapped_fibres()
{
  Pose X_tilted = Pose::Identity();
  X_tilted.linear() = rotation_x(0.3) * rotation_y(-0.2) * rotation_z(0.4);
  X_tilted.translation() << 2, -3, 1;
  model::Ligaments ligaments;
  ligaments.wraps = {{"a", model::WrapShape::cylinder, BodyIndex::reference, X_tilted, {18, 18, 50}},
                     {"b", model::WrapShape::cylinder, BodyIndex::moving, X_tilted, {12, 12, 50}},
                     {"c", model::WrapShape::ellipsoid, BodyIndex::reference, X_tilted, {25, 14, 12}},
                     {"d", model::WrapShape::ellipsoid, BodyIndex::moving, X_tilted, {30, 18, 12}}};
  ligaments.fibres = {{"a", "a", {-12, 20, 5}, {-10, -29, 12}, 1200, 46, 0},
                      {"b", "b", {-6, 25, 5}, {-5, -22, -8}, 900, 46, 1},
                      {"c", "c", {3, 21, -9}, {6, -30, -8}, 1500, 48, 2},
                      {"d", "d", {4, 30, -8}, {6, -41, -9}, 700, 67, 3}};
  return ligaments;
}

const Place wrapped_at{{0.25, -0.06}, {{1.5, -2.0, 0.7}, 0.1}};

TEST(WrappedFibres, AllTouchAndAreTaut)
{
  for (const model::FibreState& state :
       model::fibre_states(wrapped_fibres(), wrapped_at.attitude, wrapped_at.pose)) {
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
    const Potential exact = energy_at(one, wrapped_at);
    const Potential measured = energy_by_differences(one, wrapped_at);
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
  const Potential a = energy_at(model::solver_ligaments(right, right_frame), wrapped_at);
  const Potential b = energy_at(model::solver_ligaments(left, left_frame), wrapped_at);
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
    wrap.body = wrap.body == BodyIndex::moving ? BodyIndex::reference : BodyIndex::moving;
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
  const model::JointPlacement placement = model::joint_placement(wrapped_at.attitude, wrapped_at.pose);
  for (const model::Fibre& fibre : ligaments.fibres) {
    SCOPED_TRACE(fibre.name);
    const model::FibrePath path = model::fibre_path(fibre, ligaments.wraps, placement);
    std::vector<Eigen::Vector3d> points_mm(202);
    const model::SampledFibre way = model::sample_fibre_path(fibre, ligaments.wraps, placement, points_mm);
    ASSERT_TRUE(way.is_wrapped);
    EXPECT_EQ(way.length_mm, path.length_mm);
    const bool is_on_moving = path.end_body == BodyIndex::reference;
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

}  // namespace vrda::ligaments_test
