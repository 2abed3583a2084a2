#include "proximity/gap_query.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "core/units.hpp"
#include "proximity/directional_gap.hpp"
#include "support/meshes.hpp"

namespace vrda {
namespace {

// Heights of some 30 mm, each a sum of a few products that a sliver's slope may amplify a hundredfold.
constexpr double rounding_mm = 1e-11;

double brute_force_mm(const Mesh& reference, const Attitude& attitude, const Mesh& moving,
                      const MovingPose& pose)
{
  const TreeMesh there = turned(make_tree_mesh(reference), attitude);
  const Placement place(pose);
  double least = std::numeric_limits<double>::infinity();
  for (Eigen::Index r = 0; r < reference.triangles.rows(); ++r) {
    for (Eigen::Index m = 0; m < moving.triangles.rows(); ++m) {
      least = std::min(least,
                       pair_travel_mm(corners(there.mesh, r), place(corners(moving, m)), GapKind::from_afar));
    }
  }
  return least;
}

class Random {
 public:
  explicit Random(unsigned seed) : engine_(seed) {}
  double unit() { return distribution_(engine_); }
  MovingPose pose(double across_mm, double depth_mm)
  {
    return {{across_mm * unit(), depth_mm + 3 * unit(), across_mm * unit()}, 3 * unit()};
  }
  Attitude attitude() { return {unit(), 0.2 * unit()}; }

  Mesh soup(int n_triangles, double size_mm)
  {
    Mesh mesh;
    mesh.vertices_mm.resize(3 * n_triangles, 3);
    mesh.triangles.resize(n_triangles, 3);
    for (int t = 0; t < n_triangles; ++t) {
      const Eigen::RowVector3d centre(10 * unit(), 3 * unit(), 10 * unit());
      for (int k = 0; k < 3; ++k) {
        mesh.vertices_mm.row(3 * t + k) = centre + size_mm * Eigen::RowVector3d(unit(), unit(), unit());
        mesh.triangles(t, k) = 3 * t + k;
      }
    }
    return mesh;
  }

 private:
  std::mt19937_64 engine_;
  std::uniform_real_distribution<double> distribution_{-1, 1};
};

struct Bodies {
  Mesh reference, moving;
};

// Convex on convex, a bumpy pair with reflex edges, and two soups.
std::vector<Bodies> all_bodies(Random& random)
{
  Mesh bumps = test::ball(10, 14, 22), dents = test::ball(8, 13, 20);
  for (Eigen::Index v = 0; v < bumps.vertices_mm.rows(); ++v) {
    bumps.vertices_mm.row(v) *= 1.0 + 0.1 * random.unit();
  }
  for (Eigen::Index v = 0; v < dents.vertices_mm.rows(); ++v) {
    dents.vertices_mm.row(v) *= 1.0 + 0.1 * random.unit();
  }
  return {{test::ball(10, 10, 16), test::ball(7, 9, 14)},
          {bumps, dents},
          {test::box({0, 0, 0}, {12, 4, 12}), test::box({0, 0, 0}, {5, 5, 5})},
          {random.soup(60, 3), random.soup(50, 4)}};
}

TEST(GapQuery, AgreesWithBruteForceWhateverWasAskedBefore)
{
  Random random(11);
  int n_finite = 0, n_infinite = 0;
  for (const Bodies& bodies : all_bodies(random)) {
    const GapTree reference(bodies.reference), moving(bodies.moving);
    GapQuery warm(reference, moving);
    for (int k = 0; k < 25; ++k) {
      const Attitude attitude = random.attitude();
      const MovingPose pose = random.pose(14, -15);
      warm.set_attitude(attitude);
      const double travel = warm.travel_mm(pose);
      GapQuery cold(reference, moving);
      cold.set_attitude(attitude);
      EXPECT_EQ(travel, cold.travel_mm(pose));
      const double expected = brute_force_mm(bodies.reference, attitude, bodies.moving, pose);
      EXPECT_EQ(std::isfinite(travel), std::isfinite(expected));
      EXPECT_NEAR(std::isfinite(travel) ? travel : 0.0, std::isfinite(expected) ? expected : 0.0,
                  rounding_mm);
      n_finite += std::isfinite(expected) ? 1 : 0;
      n_infinite += std::isfinite(expected) ? 0 : 1;
    }
  }
  EXPECT_GT(n_finite, 50);
  EXPECT_GT(n_infinite, 5);
}

TEST(GapQuery, FeaturesReachTheLeastTravelAndKeepTheBand)
{
  Random random(12);
  std::size_t n_features = 0;
  for (const Bodies& bodies : all_bodies(random)) {
    GapQuery query{GapTree(bodies.reference), GapTree(bodies.moving)};
    for (int k = 0; k < 25; ++k) {
      query.set_attitude(random.attitude());
      const MovingPose pose = random.pose(4, -25);
      const double travel = query.travel_mm(pose);
      const GapAnswer& answer = query.features(pose, 0.5);
      ASSERT_FALSE(answer.features.empty());
      EXPECT_EQ(answer.travel_mm, travel);
      EXPECT_EQ(answer.features.front().travel_mm, travel);
      EXPECT_EQ(answer.features.front().triangles, answer.pair);
      for (const GapFeature& feature : answer.features) {
        EXPECT_LE(feature.travel_mm, travel + 0.5);
        EXPECT_LT(feature.normal.y(), 0.0);
        EXPECT_NEAR(feature.normal.norm(), 1.0, 1e-14);
      }
      n_features += answer.features.size();
    }
  }
  EXPECT_GT(n_features, 200U);
}

// Travel of the feature nearest in kind after a small change, by differences of the whole query.
Vector5d gradient_by_differences(GapQuery& query, const Attitude& attitude, const MovingPose& pose,
                                 double step)
{
  Vector5d gradient;
  for (Eigen::Index k = 0; k < n_coordinates; ++k) {
    double side[2];
    for (const int sign : {0, 1}) {
      const double change = sign == 0 ? -step : step;
      Attitude there = attitude;
      MovingPose moved = pose;
      if (k < 3) moved.translation_mm[k] += change;
      if (k == about_y) moved.theta_rad += change;
      if (k == about_varus) there.varus_rad += change;
      query.set_attitude(there);
      side[sign] = query.travel_mm(moved);
    }
    gradient[k] = (side[1] - side[0]) / (2 * step);
  }
  return gradient;
}

TEST(GapQuery, GradientMatchesDifferencesAwayFromKinks)
{
  Random random(13);
  int n_checked = 0, n_kinks = 0;
  const double step = 1e-6;
  for (const Bodies& bodies : all_bodies(random)) {
    GapQuery query{GapTree(bodies.reference), GapTree(bodies.moving)};
    for (int k = 0; k < 40; ++k) {
      const Attitude attitude = random.attitude();
      const MovingPose pose = random.pose(4, -25);
      query.set_attitude(attitude);
      // Lever arms reach 30 mm: within the band nothing else can become the least over these steps.
      const GapAnswer& answer = query.features(pose, 100 * step);
      const bool is_smooth = answer.features.size() == 1;
      (is_smooth ? n_checked : n_kinks) += 1;
      const GapFeature feature = answer.features.front();
      const Vector5d expected = travel_gradient(feature, pose);
      EXPECT_NEAR(expected[along_y], -1.0, 1e-14);
      const Vector5d measured = is_smooth ? gradient_by_differences(query, attitude, pose, step) : expected;
      // Rounding over the step, and the curvature of a turn of 1e-6 rad over 30 mm, each on slopes up to 100.
      EXPECT_LT((measured - expected).cwiseAbs().maxCoeff(), 1e-5 * (1.0 + expected.cwiseAbs().maxCoeff()));
    }
  }
  EXPECT_GT(n_checked, 80);
  EXPECT_GT(n_kinks, 0);
}

}  // namespace
}  // namespace vrda
