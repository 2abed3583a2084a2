// Minimum travels: against brute force, and invariances.
// Each rule of gap_query.hpp on a scene with a closed form.
// The screening of eight pairs of triangles against the exact kernel.
#include <gtest/gtest.h>

#include <bit>
#include <cmath>
#include <cstring>
#include <random>
#include <utility>
#include <vector>

#include "geometry/gap_blocks.hpp"
#include "geometry/gap_kernel.hpp"
#include "geometry/gap_query.hpp"
#include "geometry/gap_scenes.hpp"
#include "geometry/rounded_kernel.hpp"
#include "support/directional_gap.hpp"
#include "support/meshes.hpp"

namespace vrda::gap_query_test {

using test::GapBodies;
using test::GapRandom;

// Heights of some 30 mm, each a sum of a few products; a sliver's slope may amplify errors a hundredfold.
constexpr double rounding_mm = 1e-11;

double travel_of(const Mesh& reference, const Mesh& moving, const MovingPose& pose,
                 const Attitude& attitude = {})
{
  geometry::GapQuery query{geometry::GapTree(reference), geometry::GapTree(moving)};
  query.set_attitude(attitude);
  return query.travel_mm(pose);
}

// Infinities compare equal.
void expect_same(double a, double b, double tolerance)
{
  EXPECT_EQ(std::isfinite(a), std::isfinite(b));
  EXPECT_NEAR(std::isfinite(a) ? a : 0.0, std::isfinite(b) ? b : 0.0, tolerance);
}

void expect_every_pair(const GapBodies& bodies, double tolerance_mm, GapRandom& random, int& n_finite,
                       int& n_infinite)
{
  const geometry::GapTree reference(bodies.reference), moving(bodies.moving);
  geometry::GapQuery warm(reference, moving);
  for (int k = 0; k < 20; ++k) {
    const Attitude attitude = random.attitude();
    const MovingPose pose = random.pose(15, bodies.depth_mm);
    warm.set_attitude(attitude);
    const double travel = warm.travel_mm(pose);
    geometry::GapQuery cold(reference, moving);
    cold.set_attitude(attitude);
    EXPECT_EQ(travel, cold.travel_mm(pose));
    EXPECT_EQ(test::bits_of(warm.features(pose, 0.1)), test::bits_of(cold.features(pose, 0.1)));
    expect_same(travel, test::dense_gap_mm(bodies, attitude, pose), tolerance_mm);
    ++(std::isfinite(travel) ? n_finite : n_infinite);
  }
}

TEST(GapQuery, AgreesWithEveryPairOfTrianglesWhateverTheEarlierQueries)
{
  GapRandom random(11);
  int n_finite = 0, n_infinite = 0;
  for (const GapBodies& bodies : test::gap_bodies(random)) {
    expect_every_pair(bodies, rounding_mm, random, n_finite, n_infinite);
    // Travels of rounded pairs are roots.
    expect_every_pair(test::rounded(bodies), 1e-9 * std::abs(bodies.depth_mm), random, n_finite, n_infinite);
  }
  EXPECT_GT(n_finite, 120);
  EXPECT_GT(n_infinite, 10);
}

TEST(GapQuery, FarFromTheOriginTheFloatBoundsStillHold)
{
  GapRandom random(14);
  int n_finite = 0;
  for (GapBodies& bodies : test::gap_bodies(random)) {
    // The reference rotates about a distant origin; the moving object follows.
    const Eigen::RowVector3d far(40, -600, 75);
    bodies.reference.vertices_mm.rowwise() += far;
    bodies.moving.vertices_mm.rowwise() -= 2 * far;
    geometry::GapQuery query{geometry::GapTree(bodies.reference), geometry::GapTree(bodies.moving)};
    for (int k = 0; k < 10; ++k) {
      const Attitude attitude{0.1 * random.unit(), 0.1 * random.unit()};
      MovingPose pose = random.pose(3, bodies.depth_mm - 5);
      pose.theta_rad = 0.01 * random.unit();
      pose.translation_mm +=
          reference_rotation(attitude) * far.transpose() + rotation_y(pose.theta_rad) * (2 * far).transpose();
      query.set_attitude(attitude);
      const double travel = query.travel_mm(pose);
      // Twenty times the coordinates.
      expect_same(travel, test::dense_gap_mm(bodies, attitude, pose), 20 * rounding_mm);
      n_finite += std::isfinite(travel) ? 1 : 0;
    }
  }
  EXPECT_GT(n_finite, 40);
}

TEST(GapQuery, EveryInstructionSetGivesTheSameBits)
{
  const std::vector<geometry::InstructionSet> sets = geometry::instruction_sets();
  const geometry::InstructionSet before = geometry::instruction_set();
  std::vector<std::vector<double>> answers;
  for (const geometry::InstructionSet set : sets) {
    geometry::set_instruction_set(set);
    GapRandom random(15);
    std::vector<double> all;
    std::vector<GapBodies> every = test::gap_bodies(random);
    for (std::size_t n = every.size(); n-- > 0;) every.push_back(test::rounded(every[n]));
    for (const GapBodies& bodies : every) {
      geometry::GapQuery query{geometry::GapTree(bodies.reference), geometry::GapTree(bodies.moving)};
      for (int k = 0; k < 100; ++k) {
        query.set_attitude(random.attitude());
        const MovingPose pose = random.pose(10, bodies.depth_mm);
        const std::vector<double> bits = test::bits_of(query.features(pose, 0.2));
        all.insert(all.end(), bits.begin(), bits.end());
        all.push_back(query.next_contact(pose).travel_mm);
      }
    }
    answers.push_back(all);
  }
  geometry::set_instruction_set(before);
  EXPECT_GT(answers.front().size(), 10000U);
  for (const std::vector<double>& other : answers) EXPECT_EQ(answers.front(), other);
}

TEST(GapQuery, NumberingChangesNothing)
{
  GapRandom random(16);
  int n_finite = 0;
  for (const GapBodies& bodies : test::gap_bodies(random)) {
    geometry::GapQuery query{geometry::GapTree(bodies.reference), geometry::GapTree(bodies.moving)};
    geometry::GapQuery other{geometry::GapTree(random.renumbered(bodies.reference)),
                             geometry::GapTree(random.renumbered(bodies.moving))};
    for (int k = 0; k < 20; ++k) {
      const Attitude attitude = random.attitude();
      const MovingPose pose = random.pose(10, bodies.depth_mm);
      query.set_attitude(attitude);
      other.set_attitude(attitude);
      const double travel = query.travel_mm(pose);
      expect_same(travel, other.travel_mm(pose), rounding_mm);
      EXPECT_EQ(query.features(pose, 0.1).features.size(), other.features(pose, 0.1).features.size());
      n_finite += std::isfinite(travel) ? 1 : 0;
    }
  }
  EXPECT_GT(n_finite, 60);
}

TEST(GapQuery, TurningAndShiftingTheWholeSceneChangesNothing)
{
  GapRandom random(17);
  int n_finite = 0;
  for (const GapBodies& bodies : test::gap_bodies(random)) {
    for (int k = 0; k < 10; ++k) {
      const MovingPose pose = random.pose(8, bodies.depth_mm);
      const double angle = 3 * random.unit();
      const Eigen::Vector3d shift(20 * random.unit(), 20 * random.unit(), 20 * random.unit());
      Pose X = Pose::Identity();
      X.linear() = rotation_y(angle);
      X.translation() = shift;
      const MovingPose moved{X * pose.translation_mm, pose.theta_rad + angle};
      const double travel = travel_of(bodies.reference, bodies.moving, pose);
      expect_same(travel, travel_of(transformed(bodies.reference, X), bodies.moving, moved), rounding_mm);
      n_finite += std::isfinite(travel) ? 1 : 0;
    }
  }
  EXPECT_GT(n_finite, 30);
}

TEST(GapQuery, MoreTrianglesNeverGiveMoreRoom)
{
  GapRandom random(18);
  int n_less = 0, n_same = 0;
  for (const GapBodies& bodies : test::gap_bodies(random)) {
    const std::vector<std::int32_t> some = [&] {
      std::vector<std::int32_t> rows;
      for (std::int32_t t = 0; t < bodies.reference.triangles.rows(); t += 2) rows.push_back(t);
      return rows;
    }();
    geometry::GapQuery all{geometry::GapTree(bodies.reference), geometry::GapTree(bodies.moving)};
    geometry::GapQuery part{geometry::GapTree(bodies.reference, some), geometry::GapTree(bodies.moving)};
    for (int k = 0; k < 20; ++k) {
      const MovingPose pose = random.pose(8, bodies.depth_mm);
      const double travel = all.travel_mm(pose), travel_of_part = part.travel_mm(pose);
      EXPECT_LE(travel, travel_of_part);
      n_less += travel < travel_of_part ? 1 : 0;
      n_same += travel == travel_of_part ? 1 : 0;
    }
  }
  EXPECT_GT(n_less, 10);
  EXPECT_GT(n_same, 10);
}

TEST(GapQuery, TravelFallsOneForOneAndGoesNegative)
{
  const Mesh upper = test::box({0, 10, 0}, {4, 4, 4}), lower = test::box({0, 0, 0}, {2, 2, 2});
  for (const double y : {-30.0, 0.0, 7.0, 7.5, 12.0}) {
    // Top of the moving box at y + 1, underside of the reference at 8.
    EXPECT_NEAR(travel_of(upper, lower, {{0.3, y, -0.2}, 0.4}), 7.0 - y, rounding_mm);
  }
}

TEST(GapQuery, TouchHasTheBitsOfThePlainWalkFromAnywhere)
{
  GapRandom random(19);
  int n_free = 0, n_infinite = 0, n_inside = 0;
  std::vector<GapBodies> every = test::gap_bodies(random);
  every.push_back(test::rounded(every.front()));
  every.push_back(test::rounded(every[1]));
  for (const GapBodies& bodies : every) {
    const geometry::TreeMesh reference = geometry::make_tree_mesh(bodies.reference),
                             moving = geometry::make_tree_mesh(bodies.moving);
    geometry::GapQuery query{geometry::GapTree(bodies.reference), geometry::GapTree(bodies.moving)};
    for (int k = 0; k < 60; ++k) {
      const Attitude attitude = random.attitude();
      // From well below to well above, and sideways beyond the rim.
      MovingPose pose = random.pose(14, bodies.depth_mm);
      pose.translation_mm.y() += 25 * (1 + random.unit());
      query.set_attitude(attitude);
      const geometry::Gap plain = test::directional_gap(geometry::rotated_reference(reference, attitude),
                                                        moving.mesh, moving.tree, pose);
      const geometry::Gap found = query.next_contact(pose);
      EXPECT_EQ(found.travel_mm, plain.travel_mm);
      EXPECT_EQ(found.pair, plain.pair);
      n_infinite += std::isfinite(plain.travel_mm) ? 0 : 1;
      n_inside += std::isfinite(plain.travel_mm) && query.travel_mm(pose) < 0.0 ? 1 : 0;
      n_free += std::isfinite(plain.travel_mm) && query.travel_mm(pose) >= 0.0 ? 1 : 0;
    }
  }
  EXPECT_GT(n_free, 30);
  EXPECT_GT(n_inside, 30);
  EXPECT_GT(n_infinite, 30);
}

TEST(GapQuery, NothingFacesAnEmptyTree)
{
  const Mesh ball = test::ball(5);
  const std::vector<std::int32_t> none;
  geometry::GapQuery query{geometry::GapTree(ball), geometry::GapTree(ball, none)};
  query.set_attitude({0.3, 0.1});
  EXPECT_TRUE(std::isinf(query.travel_mm({})));
  EXPECT_TRUE(query.features({}, 1.0).features.empty());
  EXPECT_TRUE(std::isinf(geometry::GapQuery(geometry::GapTree(), geometry::GapTree(ball)).travel_mm({})));
  EXPECT_TRUE(geometry::GapTree().is_empty());
  EXPECT_TRUE(geometry::GapTree(ball, none).is_empty());
  EXPECT_FALSE(geometry::GapTree(ball).is_empty());
  EXPECT_EQ(query.n_queries(), 2);
}

constexpr double exact_mm = 1e-12;

Mesh triangles(const std::vector<Eigen::RowVector3d>& vertices, const std::vector<Eigen::RowVector3i>& rows)
{
  Mesh mesh;
  mesh.vertices_mm.resize(static_cast<Eigen::Index>(vertices.size()), 3);
  for (std::size_t v = 0; v < vertices.size(); ++v)
    mesh.vertices_mm.row(static_cast<Eigen::Index>(v)) = vertices[v];
  mesh.triangles.resize(static_cast<Eigen::Index>(rows.size()), 3);
  for (std::size_t t = 0; t < rows.size(); ++t) mesh.triangles.row(static_cast<Eigen::Index>(t)) = rows[t];
  return mesh;
}

Mesh flipped(Mesh mesh)
{
  mesh.triangles.col(1).swap(mesh.triangles.col(2));
  return mesh;
}

// Two faces directed down with a common edge along X at y = height: a ridge, or a valley if rise < 0.
Mesh down_fold(double height, double rise)
{
  return triangles({{-4, height, 0}, {4, height, 0}, {0, height + rise, 4}, {0, height + rise, -4}},
                   {{0, 1, 2}, {1, 0, 3}});
}

// Two faces directed up with a common edge along Z at y = 0.
Mesh up_fold(double rise)
{
  return triangles({{0, 0, -4}, {0, 0, 4}, {4, -rise, 0}, {-4, -rise, 0}}, {{0, 1, 2}, {1, 0, 3}});
}

geometry::GapResult answer_of(const Mesh& reference, const Mesh& moving, const MovingPose& pose,
                              double band_mm)
{
  geometry::GapQuery query{geometry::GapTree(reference), geometry::GapTree(moving)};
  return query.features(pose, band_mm);
}

TEST(GapRules, RidgeOverRidgeIsOneCrossingFromEitherSide)
{
  const geometry::GapResult answer = answer_of(down_fold(5, 2), up_fold(2), {}, 0.1);
  ASSERT_EQ(answer.features.size(), 1U) << "found through four pairs of triangles";
  EXPECT_NEAR(answer.travel_mm, 5.0, exact_mm);
  EXPECT_EQ(answer.pair, (geometry::TrianglePair{0, 0}));
  EXPECT_LT((answer.features[0].point_mm - Eigen::Vector3d::Zero()).norm(), exact_mm);
  EXPECT_LT((answer.features[0].normal + Eigen::Vector3d::UnitY()).norm(), exact_mm);
}

TEST(GapRules, ReflexAndFlatEdgesGiveNoCrossing)
{
  // A valley over a ridge: the first contact is at the valley's rim, at its corners over the ridge's faces.
  const geometry::GapResult valley = answer_of(down_fold(5, -1), up_fold(2), {}, 10.0);
  EXPECT_LT(valley.travel_mm, 5.0);
  for (const geometry::GapFeature& feature : valley.features) {
    EXPECT_GT(feature.point_mm.cwiseAbs().maxCoeff(), 0.1) << "the crossing in the middle is never first";
  }
  // Coplanar neighbours: crossings of diagonals inside flat sheets are not features.
  const Mesh above = flipped(test::sheet(4, 4));
  const MovingPose pose{{0.21, -3, 0.13}, 0.2};
  const geometry::GapResult flat = answer_of(above, test::sheet(20, 3), pose, 1e-9);
  EXPECT_EQ(flat.features.size(), 25U) << "the upper sheet's vertices; no convex edge is below its edges";
  for (const geometry::GapFeature& feature : flat.features) EXPECT_NEAR(feature.travel_mm, 3.0, exact_mm);
}

TEST(GapRules, AVertexOverASharedEdgeGivesEachFaceItsNormalAndACoplanarOneOnce)
{
  // The tip of a pyramid under a ridge, under a flat diagonal, and under a corner of four faces.
  const Mesh tip = triangles({{0, 0, 0}, {1, -2, 0}, {0, -2, 1}, {-1, -2, 0}, {0, -2, -1}},
                             {{0, 2, 1}, {0, 3, 2}, {0, 4, 3}, {0, 1, 4}});
  EXPECT_EQ(answer_of(down_fold(5, 2), tip, {{1.0, 0, 0}, 0}, 1e-9).features.size(), 4U)
      << "both faces, and the two edges of the tip that leave across the ridge";
  const Mesh flat = flipped(test::sheet(4, 2));
  EXPECT_EQ(answer_of(flat, tip, {{0.5, -3, 0.5}, 0}, 1e-9).features.size(), 1U);
  EXPECT_EQ(answer_of(flat, tip, {{0.0, -3, 0.0}, 0}, 1e-9).features.size(), 5U)
      << "a vertex of the sheet right above: four faces below it, and the sheet itself once";
  const Mesh corner = triangles({{0, 5, 0}, {4, 7, 0}, {0, 7, 4}, {-4, 7, 0}, {0, 7, -4}},
                                {{0, 1, 2}, {0, 2, 3}, {0, 3, 4}, {0, 4, 1}});
  const geometry::GapResult tips = answer_of(corner, tip, {}, 1e-9);
  EXPECT_NEAR(tips.travel_mm, 5.0, exact_mm);
  EXPECT_GE(tips.features.size(), 8U) << "four faces above, four below, and edges that cross at the tips";
}

TEST(GapRules, BackFacesCannotBeMet)
{
  const Mesh up = test::sheet(4, 2), down = flipped(up);
  const MovingPose below{{0, -3, 0}, 0};
  EXPECT_NEAR(answer_of(down, up, below, 0).travel_mm, 3.0, exact_mm);
  EXPECT_TRUE(std::isinf(answer_of(up, up, below, 0).travel_mm)) << "back face of the reference";
  EXPECT_TRUE(std::isinf(answer_of(down, down, below, 0).travel_mm)) << "back face of the moving object";
}

TEST(GapRules, VerticalFacesTakePartByTheEdgesTheyShare)
{
  // A box's walls are vertical; contact with its lower rim is through the floor's edges.
  const Mesh box = test::box({0, 5, 0}, {2, 4, 2});
  // A roof edge along Z that is beside the rim at x = 1.5; the roof falls to both sides.
  const geometry::GapResult rim = answer_of(box, up_fold(2), {{1.5, 0, 0}, 0}, 1e-9);
  // The roof at x = 1 is 0.5 * 2 / 4 below its ridge; the box's floor is at 3.
  EXPECT_NEAR(rim.travel_mm, 3.25, exact_mm);
  // A single vertical sheet faces neither way.
  const Mesh wall = triangles({{-2, 4, 0}, {2, 4, 0}, {0, 8, 0}}, {{0, 1, 2}});
  EXPECT_TRUE(std::isinf(answer_of(wall, test::box({0, 0, 0}, {1, 2, 1}), {}, 0).travel_mm));
  // Nor does a face tilted by less than 1e-6; one tilted by more does.
  const auto tilted = [](double tilt) {
    return triangles({{-2, 4, 0}, {2, 4, 0}, {0, 8, 4 * tilt}}, {{0, 1, 2}});
  };
  EXPECT_TRUE(std::isinf(answer_of(tilted(0.9e-6), test::sheet(4, 1), {}, 0).travel_mm));
  EXPECT_NEAR(answer_of(tilted(1.1e-6), test::sheet(4, 1), {}, 0).travel_mm, 4.0, 1e-6);
}

TEST(GapRules, ProjectionsThatOnlyGrazeMeet)
{
  const Mesh box = test::box({0, 5, 0}, {2, 2, 2}), other = test::box({0, 0, 0}, {2, 2, 2});
  // Side by side with a common line, a common corner, and 1e-9 mm apart.
  EXPECT_NEAR(answer_of(box, other, {{2, 0, 0.5}, 0}, 0).travel_mm, 3.0, exact_mm);
  EXPECT_NEAR(answer_of(box, other, {{2, 0, 2}, 0}, 0).travel_mm, 3.0, exact_mm);
  EXPECT_TRUE(std::isinf(answer_of(box, other, {{2 + 1e-9, 0, 0}, 0}, 0).travel_mm));
}

TEST(GapRules, NearlyParallelEdgesAreMeasuredAtOnePoint)
{
  // Rising ridges along X and nearly along X with a constant distance of 5 mm.
  for (const double sine : {1e-4, 1e-7, 1e-9, 1e-11, 1e-13, 0.0}) {
    SCOPED_TRACE(sine);
    const Mesh upper = triangles({{-4, 1, 0}, {4, 9, 0}, {0, 7, 4}, {0, 7, -4}}, {{0, 1, 2}, {1, 0, 3}});
    const Mesh lower =
        triangles({{-3, -3, -3 * sine}, {3, 3, 3 * sine}, {0, -3, 3}, {0, -3, -3}}, {{0, 2, 1}, {1, 3, 0}});
    EXPECT_NEAR(answer_of(upper, lower, {}, 0).travel_mm, 5.0, 10 * exact_mm);
  }
}

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

}  // namespace vrda::gap_query_test
