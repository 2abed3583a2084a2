// Compliant contact: the elastic foundation against closed forms, its derivatives, its invariances, and the
// steps solved with it.
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstdio>
#include <random>

#include "contact/contacts.hpp"
#include "core/units.hpp"
#include "geometry/level_set.hpp"
#include "solve/compliant_contact.hpp"
#include "solve/pins.hpp"

namespace vrda::compliant_contact_test {

constexpr double stiffness = 2.0;  // N/mm3
constexpr double push_n = 20.0;
// The binomial filter of the moving heights has this variance along each axis: it lowers a sphere's top by
// the variance over the radius. The distance field does so to fourth order only.
constexpr double height_variance_mm2 = 0.5 * geometry::surface_passes;

EquilibriumOptions compliant_options()
{
  EquilibriumOptions options;
  options.contact_stiffness_n_per_mm3 = stiffness;
  return options;
}

Mesh moved(Mesh mesh, const Eigen::Vector3d& by_mm)
{
  return transformed(mesh, Pose(Eigen::Translation3d(by_mm)));
}

Mesh sphere(double radius_mm, int n_edges = 40)
{
  return geometry::ellipsoid_mesh({radius_mm, radius_mm, radius_mm}, n_edges);
}

// Depth of facets of edge e below the sphere: their circumscribed circle has the radius e / sqrt(3).
double facet_mm(double radius_mm, int n_edges = 40)
{
  const double edge_mm = 1.107 * radius_mm / n_edges;
  return edge_mm * edge_mm / (6.0 * radius_mm);
}

struct Scene {
  Scene(const Mesh& reference, const Mesh& moving, const std::vector<std::int32_t>& component = {})
      : joint(test::joint_of(reference, moving)),
        surfaces(joint, component),
        scale(solve::rotation_scale_of(moving))
  {
  }

  solve::Foundation at(const MovingPose& pose, const Attitude& attitude = {}) const
  {
    const solve::Configuration c = solve::configuration_at(pose, attitude.varus_rad, scale);
    return solve::foundation_at({surfaces, c, scale, attitude.flexion_rad}, stiffness);
  }

  solve::Joint joint;
  solve::CompliantSurfaces surfaces;
  solve::RotationScale scale;
};

// Energy and force over the depth; `tolerance_mm` bounds the error of the overlap, so that energies, which
// grow with its cube, may differ by 3 and forces by 2 times its share of the depth.
void expect_foundation(const Scene& scene, double depth_mm, double energy_nmm, double force_n,
                       double tolerance_mm)
{
  SCOPED_TRACE(depth_mm);
  const solve::Foundation found = scene.at({{0, depth_mm, 0}, 0});
  EXPECT_NEAR(found.potential.energy_nmm, energy_nmm, 3 * tolerance_mm / depth_mm * energy_nmm);
  EXPECT_NEAR(found.potential.gradient(along_y), force_n, 2 * tolerance_mm / depth_mm * force_n);
  // By symmetry nothing pushes aside.
  EXPECT_NEAR(found.potential.gradient(along_x), 0.0, 1e-3 * force_n);
  EXPECT_NEAR(found.potential.gradient(along_z), 0.0, 1e-3 * force_n);
}

TEST(CompliantContact, APlanePressedIntoASphere)
{
  // Overlap R - s at distance s from the centre; s ds = r dr.
  constexpr double R = 20;
  const Scene scene(moved(sphere(R), {0, R, 0}), test::box({0, -5, 0}, {60, 10, 60}));
  for (const double d : {0.5, 1.0, 2.0}) {
    expect_foundation(scene, d, pi * stiffness * (R * d * d * d / 3 - d * d * d * d / 4),
                      pi * stiffness * (R * d * d - d * d * d), 2 * facet_mm(R) + 0.004);
    EXPECT_NEAR(scene.at({{0, d, 0}, 0}).deepest_mm, d, 2 * facet_mm(R) + 0.004);
  }
}

TEST(CompliantContact, ASpherePressedIntoAPlane)
{
  // A cap of height d: the area is 2 pi R per height. The box is thick, since the distance has a crease
  // halfway through it, which the filter feels 5 mm away.
  constexpr double R = 20;
  const Scene scene(test::box({0, 20, 0}, {60, 40, 60}), moved(sphere(R), {0, -R, 0}));
  for (const double depth : {0.7, 1.2, 2.0}) {
    const double d = depth - height_variance_mm2 / R;
    const solve::Foundation found = scene.at({{0, depth, 0}, 0});
    EXPECT_NEAR(found.potential.energy_nmm, pi * stiffness * R * d * d * d / 3,
                0.03 * found.potential.energy_nmm);
    EXPECT_NEAR(found.potential.gradient(along_y), pi * stiffness * R * d * d,
                0.02 * found.potential.gradient(along_y));
  }
}

TEST(CompliantContact, TwoBalls)
{
  // The area of the moving sphere between distances s and s + ds from the other centre is 2 pi r s ds / D.
  constexpr double R = 25, r = 18;
  const Scene scene(moved(sphere(R), {0, R, 0}), moved(sphere(r), {0, -r, 0}));
  for (const double depth : {0.7, 1.2, 2.0}) {
    const double d = depth - height_variance_mm2 / r, D = R + r - d;
    const double moment = R * d * d * d / 3 - d * d * d * d / 4;
    const solve::Foundation found = scene.at({{0, depth, 0}, 0});
    const double energy_nmm = pi * stiffness * r / D * moment;
    const double force_n = pi * stiffness * r * ((R * d * d - d * d * d) / D + moment / (D * D));
    EXPECT_NEAR(found.potential.energy_nmm, energy_nmm, 0.03 * energy_nmm) << depth;
    EXPECT_NEAR(found.potential.gradient(along_y), force_n, 0.02 * force_n) << depth;
  }
  EXPECT_EQ(scene.at({{0, -0.5, 0}, 0}).potential.energy_nmm, 0.0);
}

// Offsets of both objects are one thickness: of a larger sphere, since its distance is measured along its
// radii.
TEST(CompliantContact, OffsetsAddToTheOverlap)
{
  constexpr double R = 20, of_reference_mm = 0.3, of_moving_mm = 0.4,
                   grown_mm = R + of_reference_mm + of_moving_mm;
  Mesh reference = moved(sphere(R), {0, R, 0}), moving = test::box({0, -5, 0}, {60, 10, 60});
  reference.offset_mm.assign(static_cast<std::size_t>(reference.triangles.rows()), of_reference_mm);
  moving.offset_mm.assign(static_cast<std::size_t>(moving.triangles.rows()), of_moving_mm);
  const Scene scene(reference, moving);
  const double d = 1.2;
  const Potential found = scene.at({{0, d - of_reference_mm - of_moving_mm, 0}, 0}).potential;
  const double tolerance_mm = 2 * facet_mm(R) + 0.004;
  const double energy_nmm = pi * stiffness * (grown_mm * d * d * d / 3 - d * d * d * d / 4);
  EXPECT_NEAR(found.energy_nmm, energy_nmm, 3 * tolerance_mm / d * energy_nmm);
  const double force_n = pi * stiffness * (grown_mm * d * d - d * d * d);
  EXPECT_NEAR(found.gradient(along_y), force_n, 2 * tolerance_mm / d * force_n);
}

Mesh reversed(Mesh mesh)
{
  mesh.triangles.col(1).swap(mesh.triangles.col(2));
  return mesh;
}

// A layer of cartilage, alone or on its bone, resists as a solid does.
TEST(CompliantContact, ALayerIsAsDeepAsASolid)
{
  constexpr double R = 20, layer_mm = 2.0, depth_mm = 1.5;
  const Mesh plate = test::box({0, -5 - R, 0}, {60, 10, 60});
  Mesh layer = sphere(R);
  append(layer, reversed(sphere(R - layer_mm)));
  Mesh on_bone = sphere(R - layer_mm);
  std::vector<std::int32_t> component(static_cast<std::size_t>(on_bone.triangles.rows()), 0);
  append(on_bone, layer);
  component.resize(static_cast<std::size_t>(on_bone.triangles.rows()), 1);
  const MovingPose pose{{0, depth_mm, 0}, 0};
  const double energy_nmm = Scene(sphere(R), plate).at(pose).potential.energy_nmm;
  EXPECT_NEAR(Scene(layer, plate).at(pose).potential.energy_nmm, energy_nmm, 1e-3 * energy_nmm);
  EXPECT_NEAR(Scene(on_bone, plate, component).at(pose).potential.energy_nmm, energy_nmm, 1e-3 * energy_nmm);
}

const Mesh upper = moved(geometry::ellipsoid_mesh({30, 12, 18}, 30), {2, 12, -3});
const Mesh lower = moved(geometry::ellipsoid_mesh({16, 9, 25}, 30), {-1, -9, 2});

TEST(CompliantContact, DerivativesMatchDifferences)
{
  const Scene scene(upper, lower);
  std::mt19937_64 random(3);
  std::uniform_real_distribution<double> unit(-1, 1);
  constexpr double h = 1e-5;
  for (int k = 0; k < 10; ++k) {
    const double flexion_rad = 0.3 * unit(random);
    const solve::Configuration at{{unit(random), 1.5, unit(random)}, 0.3 * unit(random), 0.05 * unit(random)};
    const auto value = [&](Eigen::Index c, double step) {
      solve::Configuration moved = at;
      if (c < 3) moved.pivot_mm(c) += step;
      if (c == about_y) moved.theta_rad += step;
      if (c == about_varus) moved.varus_rad += step;
      return solve::foundation_at({scene.surfaces, moved, scene.scale, flexion_rad}, stiffness).potential;
    };
    const Potential u = value(0, 0.0);
    ASSERT_GT(u.energy_nmm, 1.0);
    for (Eigen::Index c = 0; c < n_coordinates; ++c) {
      const Potential up = value(c, h), down = value(c, -h);
      EXPECT_NEAR((up.energy_nmm - down.energy_nmm) / (2 * h), u.gradient(c), 1e-5 * (1 + u.gradient.norm()));
      EXPECT_LE(((up.gradient - down.gradient) / (2 * h) - u.hessian.col(c)).norm(), 1e-4 * u.hessian.norm());
    }
  }
}

// The nearest triangle spreads from node to node in an order that depends on the axes: where two triangles
// are about as near, a few nodes take the other one.
constexpr double order_share = 1e-7;

Potential mirrored(Potential u)
{
  Vector5d sign;
  sign << 1, 1, -1, -1, -1;
  u.gradient = sign.cwiseProduct(u.gradient).eval();
  u.hessian = (sign.asDiagonal() * u.hessian * sign.asDiagonal()).eval();
  return u;
}

TEST(CompliantContact, MirroredObjectsMirrorTheResult)
{
  const Scene scene(upper, lower), other(mirrored_z(upper), mirrored_z(lower));
  const Potential u = scene.at({{0.3, 1.4, -0.7}, 0.2}, {0.2, 0.03}).potential;
  const Potential v = mirrored(other.at({{0.3, 1.4, 0.7}, -0.2}, {0.2, -0.03}).potential);
  EXPECT_NEAR(u.energy_nmm, v.energy_nmm, order_share * u.energy_nmm);
  EXPECT_LE((u.gradient - v.gradient).norm(), order_share * u.gradient.norm());
  EXPECT_LE((u.hessian - v.hessian).norm(), order_share * u.hessian.norm());
}

TEST(CompliantContact, TurnedObjectsKeepTheEnergy)
{
  // A quarter turn maps the grids onto each other; another angle only the surfaces.
  const Scene scene(upper, lower);
  const MovingPose pose{{0.3, 1.4, -0.7}, 0.2};
  const double energy_nmm = scene.at(pose).potential.energy_nmm;
  for (const auto& [turn_rad, tolerance] : {std::pair{pi / 2, order_share}, std::pair{0.4, 5e-3}}) {
    Pose X = Pose::Identity();
    X.linear() = rotation_y(turn_rad);
    X.translation() = Eigen::Vector3d(4, 2, -3);
    const Scene turned(transformed(upper, X), transformed(lower, X));
    // X pose X^-1 of points.
    const Pose there = X * pose_of(pose) * X.inverse();
    const double found_nmm = turned.at({there.translation(), pose.theta_rad}).potential.energy_nmm;
    EXPECT_NEAR(found_nmm, energy_nmm, tolerance * energy_nmm);
  }
}

// Steps.

Mesh dish(double radius_mm)
{
  return test::ceiling(60, 60, [&](double x, double z) {
    return std::sqrt(radius_mm * radius_mm - x * x - z * z) - radius_mm;
  });
}

StepRecord solved(const solve::Joint& joint, const Loads& loads, const EquilibriumOptions& options,
                  const MovingPose& seed = {{3, -10, 2}, 0.1})
{
  const model::Ligaments none;
  return solve::EquilibriumSolver(joint, none, options).solve({{}, seed, loads, false});
}

Loads aside(double force_n)
{
  Loads loads;
  loads.force_n = {force_n, push_n, 0.0};
  return loads;
}

bool overlaps(const solve::Joint& joint, const StepRecord& r, double flexion_rad = 0.0)
{
  contact::NarrowPhase narrow_phase;
  return contact::find_collision(
             geometry::rotated_reference(joint.reference.tree_mesh, {flexion_rad, r.varus_rad}),
             joint.moving.tree_mesh, r.pose, narrow_phase)
      .has_value();
}

TEST(CompliantEquilibrium, ABallInADishIsBelowItsCentreAlongTheForce)
{
  // The pressure is symmetric about the line of centres, so that the resultant is along it.
  constexpr double R = 45, r = 12;
  const solve::Joint joint = test::joint_of(dish(R), moved(sphere(r), {0, -r, 0}));
  for (const double force_n : {0.0, 2.0, 5.0}) {
    SCOPED_TRACE(force_n);
    const StepRecord record = solved(joint, aside(force_n), compliant_options());
    ASSERT_EQ(record.status, StepStatus::stable);
    EXPECT_LE(record.balance.residual_n, 1e-6 * push_n);
    // Centres are R - r + overlap apart; the overlap of some 0.2 mm changes x by less than a hundredth.
    const double sine = force_n / std::hypot(force_n, push_n);
    EXPECT_NEAR(record.pose.translation_mm.x(), (R - r) * sine, 0.02 * R * sine + 0.02);
    EXPECT_NEAR(record.pose.translation_mm.z(), 0.0, 0.02);
    EXPECT_FALSE(record.theta_determined);
    EXPECT_FALSE(overlaps(joint, record));
    EXPECT_LE(record.balance.worst_gap_mm, 1e-4);
    EXPECT_GE(record.balance.worst_gap_mm, 0.0);
    Eigen::Vector3d sum_n = Eigen::Vector3d::Zero();
    for (const ContactForce& force : record.balance.forces) sum_n += test::force_of(force);
    EXPECT_LE((sum_n + Eigen::Vector3d(force_n, push_n, 0)).norm(), 1e-5 * push_n);
  }
}

// Two balls under two bowls, held by fibres.
struct BallKnee {
  solve::Joint joint = test::joint_of(test::ceiling(80, 80,
                                                    [](double x, double z) {
                                                      const double side = std::abs(z) - 20;
                                                      return -(x * x + side * side) / 80;
                                                    }),
                                      balls());
  model::Ligaments ligaments = test::MinimalKnee().ligaments;

  static Mesh balls()
  {
    Mesh both = moved(sphere(12, 24), {0, -12, 20});
    append(both, moved(sphere(12, 24), {0, -11.6, -20}));
    return both;
  }
  StepRecord solve(const MovingPose& seed, const Loads& loads = {}) const
  {
    return solve::EquilibriumSolver(joint, ligaments, compliant_options())
        .solve({{0.1, 0.0}, seed, loads, true});
  }
};

TEST(CompliantEquilibrium, BothCompartmentsTouchWithoutOverlap)
{
  const BallKnee knee;
  const StepRecord r = knee.solve({{2, -20, 1}, 0.1});
  ASSERT_EQ(r.status, StepStatus::stable);
  EXPECT_LE(r.balance.residual_n, 1e-6 * push_n);
  EXPECT_FALSE(overlaps(knee.joint, r, 0.1));
  EXPECT_TRUE(r.is_in_contact[0] && r.is_in_contact[1]);
  EXPECT_NEAR(r.gap_mm[0], 1e-5, 1e-6);
  EXPECT_NEAR(r.gap_mm[1], 1e-5, 1e-6);
  EXPECT_EQ(r.balance.forces.size(), 2U);
  EXPECT_TRUE(r.theta_determined);
}

TEST(CompliantEquilibrium, StartsNearbyEndAtTheSamePose)
{
  const BallKnee knee;
  const StepRecord r = knee.solve({{2, -20, 1}, 0.1});
  for (const MovingPose& seed :
       {MovingPose{{-1, -30, 0}, 0.0}, MovingPose{{0, 5, 3}, 0.2}, MovingPose{{3, 0, -2}, -0.1}}) {
    const StepRecord other = knee.solve(seed);
    ASSERT_EQ(other.status, StepStatus::stable);
    EXPECT_LE((other.pose.translation_mm - r.pose.translation_mm).norm(), 1e-4);
    EXPECT_NEAR(other.pose.theta_rad, r.pose.theta_rad, 1e-6);
    EXPECT_NEAR(other.varus_rad, r.varus_rad, 1e-6);
  }
}

TEST(CompliantEquilibrium, AStepDoesNotDependOnEarlierSteps)
{
  const BallKnee knee;
  solve::EquilibriumSolver solver(knee.joint, knee.ligaments, compliant_options());
  const solve::EquilibriumSolver::Task a{{0.1, 0.0}, {{2, -20, 1}, 0.1}, {}, true};
  const solve::EquilibriumSolver::Task b{{-0.2, 0.05}, {{-2, -20, 1}, -0.1}, {}, false};
  const StepRecord first = solver.solve(a);
  solver.solve(b);
  const StepRecord again = solver.solve(a);
  EXPECT_EQ(first.pose.translation_mm, again.pose.translation_mm);
  EXPECT_EQ(first.pose.theta_rad, again.pose.theta_rad);
  EXPECT_EQ(first.varus_rad, again.varus_rad);
  EXPECT_EQ(first.balance.energy_nmm, again.balance.energy_nmm);
  EXPECT_EQ(first.queries, again.queries);
}

TEST(CompliantEquilibrium, LoadsThatTurnAreBalancedInTheirFinalDirections)
{
  const BallKnee knee;
  Loads loads;
  loads.applied.push_back({BodyIndex::moving, {3, 2, -1}, {0, 20, 0}, {2, -30, 4}});
  const StepRecord r = knee.solve({{2, -20, 1}, 0.1}, loads);
  ASSERT_EQ(r.status, StepStatus::stable);
  EXPECT_LE(r.balance.residual_n, 1e-5 * push_n);
}

TEST(CompliantEquilibrium, StatusesNameWhatIsWrong)
{
  const solve::Joint joint = test::joint_of(dish(45), moved(sphere(12), {0, -12, 0}));
  EXPECT_EQ(solved(joint, {}, compliant_options(), {{100, -10, 0}, 0}).status, StepStatus::no_contact);
  Loads pull;
  pull.force_n = {0, -20, 0};
  EXPECT_EQ(solved(joint, pull, compliant_options()).status, StepStatus::unbounded);
  EquilibriumOptions thin = compliant_options();
  thin.contact_thickness_mm = 0.1;
  EXPECT_EQ(solved(joint, {}, thin).status, StepStatus::unbounded);
}

// Noise of a surface moves the pose less than with exact contact, which touches its highest points.
TEST(CompliantEquilibrium, NoiseMovesABallInADishLess)
{
  constexpr int n_seeds = 8;
  constexpr double noise_mm = 0.3;
  std::array<double, 2> sum_sq_mm2{};
  for (int seed = 1; seed <= n_seeds; ++seed) {
    std::mt19937_64 random(static_cast<std::uint64_t>(seed));
    std::normal_distribution<double> normal(0.0, noise_mm);
    Mesh ball = moved(sphere(12, 12), {0, -12, 0});
    for (Eigen::Index v = 0; v < ball.vertices_mm.rows(); ++v) {
      for (Eigen::Index k = 0; k < 3; ++k) ball.vertices_mm(v, k) += normal(random);
    }
    const solve::Joint joint = test::joint_of(dish(45), ball);
    for (const bool is_compliant : {false, true}) {
      const StepRecord r =
          solved(joint, {}, is_compliant ? compliant_options() : EquilibriumOptions(), {{0.5, -10, 0.5}, 0});
      ASSERT_EQ(r.status, StepStatus::stable);
      sum_sq_mm2.at(is_compliant ? 1 : 0) += r.pose.translation_mm.x() * r.pose.translation_mm.x() +
                                             r.pose.translation_mm.z() * r.pose.translation_mm.z();
    }
  }
  std::printf("noise of %g mm: RMS displacement %.3f mm exact, %.3f mm compliant\n", noise_mm,
              std::sqrt(sum_sq_mm2[0] / n_seeds), std::sqrt(sum_sq_mm2[1] / n_seeds));
  EXPECT_LT(sum_sq_mm2[1], 0.25 * sum_sq_mm2[0]);
}

}  // namespace vrda::compliant_contact_test
