// The screening of eight pairs of triangles against the exact kernel.
#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <cstring>
#include <random>
#include <utility>
#include <vector>

#include "geometry/gap_blocks.hpp"
#include "geometry/gap_kernel.hpp"
#include "geometry/instruction_set.hpp"
#include "geometry/rounded_kernel.hpp"

namespace vrda::gap_pair_lanes_test {

using geometry::Corners;

const geometry::BlockFunctions& functions_of(geometry::InstructionSet set)
{
  switch (set) {
    case geometry::InstructionSet::avx512:
      return geometry::block_functions_avx512;
    case geometry::InstructionSet::avx2:
      return geometry::block_functions_avx2;
    case geometry::InstructionSet::baseline:
      break;
  }
  return geometry::block_functions_baseline;
}

// Bits of the candidates within the limit, as of PlacedPairs::candidates.
unsigned candidates_within(const Corners& r, const Corners& m, double limit_mm)
{
  unsigned bits = 0;
  visit_contact_candidates(geometry::gap_face(r), geometry::gap_face(m),
                           [&](const geometry::ContactCandidate& at) {
                             const unsigned bit = at.kind == geometry::ContactKind::moving_vertex ? at.moving
                                                  : at.kind == geometry::ContactKind::reference_vertex
                                                      ? 3 + at.reference
                                                      : 6 + 3 * at.reference + at.moving;
                             if (at.travel_mm <= limit_mm) bits |= 1U << bit;
                           });
  return bits;
}

// Triangles of 0.01 to 30 mm, some narrow or steep, with common vertices and edges now and then.
struct RandomPairs {
  std::mt19937_64 random{5};
  std::uniform_real_distribution<double> unit{-1.0, 1.0};

  Corners triangle(double size_mm)
  {
    const double height = unit(random) < 0.3 ? 1e-4 : (unit(random) < 0.3 ? 100.0 : 1.0);
    Corners t;
    for (Eigen::Vector3d& p : t)
      p = size_mm * Eigen::Vector3d(unit(random), height * unit(random), unit(random));
    if (unit(random) < -0.6) t[2] = 0.5 * (t[0] + t[1]) + 1e-5 * t[2];
    return t;
  }

  std::pair<Corners, Corners> pair()
  {
    const double size_mm = std::exp(4.0 * unit(random) - 0.6);
    Corners r = triangle(size_mm), m = triangle(size_mm);
    if (unit(random) < -0.5) m[0] = r[1];
    if (unit(random) < -0.5) m[1] = r[2];
    return {r, m};
  }
};

void put(const std::pair<Corners, Corners>& pair, double offset_mm, int lane, geometry::PairBatch& batch)
{
  const auto& [r, m] = pair;
  for (int c = 0; c < 9; ++c) {
    batch.reference[c][lane] = r[static_cast<std::size_t>(c / 3)][c % 3];
    batch.moving[c][lane] = m[static_cast<std::size_t>(c / 3)][c % 3];
  }
  batch.least_projected[0][lane] = geometry::least_screened_area(r);
  batch.least_projected[1][lane] = geometry::least_screened_area(m);
  batch.offset_mm[lane] = offset_mm;
}

constexpr geometry::PairPlacement still{{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}, 1, 0, 0, 0, 0};

TEST(PairScreen, KeepsEveryCandidateOfTheKernelAndFewOthers)
{
  RandomPairs pairs;
  int n_touching = 0, n_kept = 0, n_candidates = 0, n_pairs = 0;
  for (int k = 0; k < 20000; ++k) {
    geometry::PairBatch batch{};
    unsigned touching[8];
    const double limit_mm = pairs.unit(pairs.random);
    for (int i = 0; i < 8; ++i) {
      const auto pair = pairs.pair();
      put(pair, 0.0, i, batch);
      touching[i] = candidates_within(pair.first, pair.second, limit_mm);
    }
    geometry::PlacedPairs placed{};
    const unsigned kept = geometry::block_functions_baseline.screen_pairs(batch, still, limit_mm, placed);
    for (int i = 0; i < 8; ++i) {
      const auto candidates = static_cast<unsigned>(placed.candidates[i]);
      ASSERT_EQ(touching[i] & ~candidates, 0U) << k << ' ' << i;
      ASSERT_EQ((kept >> i & 1U) != 0, candidates != 0);
      n_touching += touching[i] != 0 ? 1 : 0;
      n_kept += candidates != 0 ? 1 : 0;
      // Narrow and steep triangles keep all.
      n_candidates += candidates != geometry::all_candidates ? std::popcount(candidates & ~touching[i]) : 0;
      ++n_pairs;
    }
    for (const geometry::InstructionSet set : geometry::instruction_sets()) {
      geometry::PlacedPairs again{};
      ASSERT_EQ(functions_of(set).screen_pairs(batch, still, limit_mm, again), kept);
      ASSERT_EQ(std::memcmp(&again, &placed, sizeof placed), 0);
    }
  }
  EXPECT_GT(n_touching, n_pairs / 10);
  EXPECT_LT(n_touching, n_pairs / 2);
  // A third of the triangles here is narrow or steep, and never rejected.
  EXPECT_LT(n_kept - n_touching, n_pairs / 2);
  // A common corner is an end of up to four pairs of edges, which are kept.
  EXPECT_LT(n_candidates, n_pairs / 10);
}

TEST(PairScreen, PlacesPairsAsTheKernelDoes)
{
  RandomPairs pairs;
  const Attitude attitude{0.7, -0.1};
  MovingPose pose;
  pose.theta_rad = 0.3;
  pose.translation_mm = Eigen::Vector3d(1.5, -20.25, 3.125);
  const Eigen::Matrix3d R = reference_rotation(attitude);
  const SinCos turn = sin_cos(pose.theta_rad);
  geometry::PairPlacement at{{}, turn.cos, turn.sin, 1.5, -20.25, 3.125};
  for (int i = 0; i < 3; ++i) {
    for (int k = 0; k < 3; ++k) at.R[i][k] = R(i, k);
  }
  const geometry::Placement place(pose);
  geometry::PairBatch batch{};
  std::vector<std::pair<Corners, Corners>> all;
  for (int i = 0; i < 8; ++i) {
    all.push_back(pairs.pair());
    put(all.back(), 0.0, i, batch);
  }
  for (const geometry::InstructionSet set : geometry::instruction_sets()) {
    geometry::PlacedPairs placed{};
    functions_of(set).screen_pairs(batch, at, 1.0, placed);
    for (int i = 0; i < 8; ++i) {
      for (int c = 0; c < 9; ++c) {
        const auto corner = static_cast<std::size_t>(c / 3);
        const Eigen::Vector3d& p = all[static_cast<std::size_t>(i)].first[corner];
        // In the order of the kernel.
        const double turned = R(c % 3, 0) * p.x() + R(c % 3, 1) * p.y() + R(c % 3, 2) * p.z();
        EXPECT_EQ(placed.reference[c][i], turned);
        EXPECT_EQ(placed.moving[c][i], place(all[static_cast<std::size_t>(i)].second[corner])[c % 3]);
      }
    }
  }
}

// Of points of a grid on both triangles: not below the distance.
double sampled_distance_mm(const Corners& r, const Corners& m)
{
  constexpr int n = 8;
  std::vector<Eigen::Vector3d> on_r, on_m;
  for (int i = 0; i <= n; ++i) {
    for (int k = 0; k <= n - i; ++k) {
      const double a = i / double{n}, b = k / double{n}, c = 1.0 - a - b;
      on_r.push_back(a * r[0] + b * r[1] + c * r[2]);
      on_m.push_back(a * m[0] + b * m[1] + c * m[2]);
    }
  }
  double least_mm = geometry::gap_rules::infinity;
  for (const Eigen::Vector3d& p : on_r) {
    for (const Eigen::Vector3d& q : on_m) least_mm = std::min(least_mm, (p - q).norm());
  }
  return least_mm;
}

TEST(ApartScreen, KeepsEveryPairWithinTheBandAndFewOthers)
{
  RandomPairs pairs;
  int n_close = 0, n_kept = 0, n_pairs = 0;
  for (int k = 0; k < 500; ++k) {
    geometry::PairBatch batch{};
    double distance_mm[8];
    for (int i = 0; i < 8; ++i) {
      const auto pair = pairs.pair();
      put(pair, 0.1 * i, i, batch);
      distance_mm[i] = sampled_distance_mm(pair.first, pair.second) - 0.1 * i;
    }
    const geometry::ApartLimits limits{0.2, 0.0, false};
    const unsigned kept = geometry::block_functions_baseline.screen_apart(batch, still, limits);
    for (int i = 0; i < 8; ++i) {
      const bool is_kept = (kept >> i & 1U) != 0, is_close = distance_mm[i] <= 0.2;
      ASSERT_TRUE(is_kept || !is_close) << k << ' ' << i << ' ' << distance_mm[i];
      n_close += is_close ? 1 : 0;
      n_kept += is_kept ? 1 : 0;
      ++n_pairs;
    }
    for (const geometry::InstructionSet set : geometry::instruction_sets())
      ASSERT_EQ(functions_of(set).screen_apart(batch, still, limits), kept);
  }
  EXPECT_GT(n_close, n_pairs / 20);
  // Random pairs intersect or have a distance that the samples miss; few others are kept.
  EXPECT_LT(n_kept - n_close, n_pairs / 4);
}

TEST(ApartScreen, KeepsEveryRoundedPairThatTouchesWithinTheTravel)
{
  RandomPairs pairs;
  int n_touching = 0, n_kept = 0, n_pairs = 0;
  for (int k = 0; k < 5000; ++k) {
    geometry::PairBatch batch{};
    double travel_mm[8];
    for (int i = 0; i < 8; ++i) {
      const auto pair = pairs.pair();
      put(pair, 0.05 + 0.1 * i, i, batch);
      travel_mm[i] = geometry::rounded_passage(pair.first, pair.second, 0.05 + 0.1 * i).enter_mm;
    }
    const double limit_mm = pairs.unit(pairs.random);
    const unsigned kept =
        geometry::block_functions_baseline.screen_apart(batch, still, {0.0, limit_mm, true});
    for (int i = 0; i < 8; ++i) {
      const bool is_kept = (kept >> i & 1U) != 0, is_touching = travel_mm[i] <= limit_mm;
      ASSERT_TRUE(is_kept || !is_touching) << k << ' ' << i << ' ' << travel_mm[i] - limit_mm;
      n_touching += is_touching ? 1 : 0;
      n_kept += is_kept ? 1 : 0;
      ++n_pairs;
    }
  }
  EXPECT_GT(n_touching, n_pairs / 10);
  EXPECT_LT(n_kept - n_touching, n_pairs / 4);
}

}  // namespace vrda::gap_pair_lanes_test
