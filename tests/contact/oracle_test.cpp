// Our collision answers compared with FCL, an independent library with its own trees and triangle tests.
// Distances and closest points by Bullet compared with the closed forms, on all pairs of triangles near
// contact.
#include <fcl/geometry/bvh/BVH_model.h>
#include <fcl/narrowphase/collision.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <limits>
#include <map>
#include <memory>
#include <vector>

#include "contact/contacts.hpp"
#include "contact/scenes.hpp"
#include "contact/triangles.hpp"
#include "support/meshes.hpp"
#include "support/real_knees.hpp"
#include "support/triangle_distance.hpp"

namespace vrda::oracle_test {

using test::Zone;

// A disagreement counts only beyond this distance from contact.
constexpr long double touching_mm = 1e-9L;
constexpr int n_touches_a_scene = 250;
constexpr int n_touches_an_attitude = 5;

// Boxes further apart than this are irrelevant at nanometre scale.
constexpr double near_mm = 1e-6;

struct Boxed {
  geometry::Corners corner;
  std::array<geometry::Extent, 3> box;
};

bool are_near(const std::array<geometry::Extent, 3>& a, const std::array<geometry::Extent, 3>& b)
{
  for (std::size_t k = 0; k < 3; ++k) {
    if (a[k].least - b[k].most > near_mm || b[k].least - a[k].most > near_mm) return false;
  }
  return true;
}

Boxed boxed(const geometry::Corners& t)
{
  return {t, {geometry::extent(t, 0), geometry::extent(t, 1), geometry::extent(t, 2)}};
}

std::vector<Boxed> all_boxed(const Mesh& mesh, const geometry::Placement& place)
{
  std::vector<Boxed> result;
  for (Eigen::Index t = 0; t < mesh.triangles.rows(); ++t) result.push_back(boxed(place(corners(mesh, t))));
  return result;
}

std::array<geometry::Extent, 3> whole_box(const std::vector<Boxed>& all)
{
  std::array<geometry::Extent, 3> whole = all.front().box;
  for (const Boxed& one : all) {
    for (std::size_t k = 0; k < 3; ++k) {
      whole[k].least = std::min(whole[k].least, one.box[k].least);
      whole[k].most = std::max(whole[k].most, one.box[k].most);
    }
  }
  return whole;
}

// Standard triangle tests in 80-bit arithmetic, over the pairs found by our trees.
bool textbook_collides(const geometry::TreeMesh& reference, const geometry::TreeMesh& moving,
                       const MovingPose& pose)
{
  const geometry::Placement place(pose);
  return geometry::visit_close_pairs(
      reference.tree, moving.tree, geometry::Placement(pose), 0.0, [&](const geometry::TrianglePair& pair) {
        const Boxed r = boxed(corners(reference.mesh, pair.reference));
        const Boxed m = boxed(place(corners(moving.mesh, pair.moving)));
        return are_near(r.box, m.box) && test::fine_triangle_distance_mm(r.corner, m.corner) <= 0.0L;
      });
}

struct ThirdMeasure {
  bool is_overlapping = false;
  /// Distance of the nearest pair, or depth of the deepest; infinite if no pair is within a micrometre.
  long double from_touch_mm = 0.0L;
};

// Decides between different answers: over every pair of triangles, without a tree. Cost: seconds for a real
// knee.
ThirdMeasure reference_measure(const Mesh& reference, const Mesh& moving, const MovingPose& pose)
{
  const std::vector<Boxed> fixed = all_boxed(reference, geometry::Placement({}));
  const std::vector<Boxed> placed = all_boxed(moving, geometry::Placement(pose));
  const std::array<geometry::Extent, 3> fixed_box = whole_box(fixed);
  ThirdMeasure result{false, std::numeric_limits<long double>::infinity()};
  for (const Boxed& m : placed) {
    if (!are_near(m.box, fixed_box)) continue;
    for (const Boxed& r : fixed) {
      if (!are_near(m.box, r.box)) continue;
      const long double distance_mm = test::fine_triangle_distance_mm(r.corner, m.corner);
      if (distance_mm > 0.0L) {
        if (!result.is_overlapping) result.from_touch_mm = std::min(result.from_touch_mm, distance_mm);
        continue;
      }
      const long double depth_mm = test::fine_triangle_depth_mm(r.corner, m.corner);
      result.from_touch_mm = result.is_overlapping ? std::max(result.from_touch_mm, depth_mm) : depth_mm;
      result.is_overlapping = true;
    }
  }
  return result;
}

class ByFcl {
 public:
  ByFcl(const Mesh& reference, const Mesh& moving) : reference_(model(reference)), moving_(model(moving)) {}

  void turn(const Attitude& attitude) { reference_.setRotation(reference_rotation(attitude)); }
  void place(const MovingPose& pose) { moving_.setTransform(fcl::Transform3d(pose_of(pose).matrix())); }

  bool collides() const { return count(reference_, moving_) > 0; }
  bool collides_exchanged() const { return count(moving_, reference_) > 0; }

 private:
  static std::shared_ptr<fcl::CollisionGeometryd> model(const Mesh& mesh)
  {
    auto result = std::make_shared<fcl::BVHModel<fcl::OBBRSSd>>();
    result->beginModel();
    for (Eigen::Index t = 0; t < mesh.triangles.rows(); ++t) {
      const auto [a, b, c] = corners(mesh, t);
      result->addTriangle(a, b, c);
    }
    result->endModel();
    return result;
  }

  static std::size_t count(const fcl::CollisionObjectd& a, const fcl::CollisionObjectd& b)
  {
    const fcl::CollisionRequestd request;
    fcl::CollisionResultd result;
    return fcl::collide(&a, &b, request, result);
  }

  fcl::CollisionObjectd reference_, moving_;
};

// The pose of the reference relative to the moving object.
MovingPose exchanged(const MovingPose& pose)
{
  const MovingPose back{Eigen::Vector3d::Zero(), -pose.theta_rad};
  return {-geometry::Placement(back)(pose.translation_mm), -pose.theta_rad};
}

struct Answers {
  bool ours = false;
  bool exchanged = false;
  bool fcl = false;
  bool fcl_exchanged = false;
  bool textbook = false;

  bool agree() const { return ours == exchanged && ours == fcl && ours == fcl_exchanged && ours == textbook; }
};

std::ostream& operator<<(std::ostream& out, const Answers& a)
{
  return out << "ours " << a.ours << " exchanged " << a.exchanged << ", FCL's " << a.fcl << " exchanged "
             << a.fcl_exchanged << ", textbook's " << a.textbook;
}

struct Tally {
  int n_poses = 0;
  int n_colliding = 0;
  int n_near = 0;  // within 1e-3 mm of contact
  std::map<Zone, int> n_in_zone;
  int n_disagreeing = 0;
  int n_we_hit = 0;    // and FCL does not
  int n_fcl_hits = 0;  // and we do not
  int n_fcl_wrong = 0;
  int n_textbook_wrong = 0;
  int n_excused = 0;  // we were wrong, within touching_mm of contact
  long double farthest_mm = 0.0L;
};

std::ostream& operator<<(std::ostream& out, const Tally& t)
{
  return out << t.n_poses << " poses: " << t.n_colliding << " collide, " << t.n_poses - t.n_colliding
             << " free, " << t.n_near << " within 1e-3 mm of touching (" << t.n_in_zone.at(Zone::nano)
             << " within 1e-9); " << t.n_disagreeing << " disagree (" << t.n_we_hit << " we hit, "
             << t.n_fcl_hits << " FCL hits), at most " << static_cast<double>(t.farthest_mm)
             << " mm from touching; wrong there: FCL " << t.n_fcl_wrong << ", we " << t.n_excused
             << ", textbook over our tree " << t.n_textbook_wrong;
}

// Appends a JSON line to the folder $VRDA_VALIDATION if set; results/validation.md is made from these.
void write(const Tally& t, const std::string& scene, unsigned seed)
{
  const char* folder = std::getenv("VRDA_VALIDATION");
  if (folder == nullptr) return;
  std::ofstream file(std::filesystem::path(folder) / ("oracle-" + scene + ".jsonl"));
  file << nlohmann::json{{"oracle", scene},
                         {"seed", seed},
                         {"poses", t.n_poses},
                         {"colliding", t.n_colliding},
                         {"near", t.n_near},
                         {"disagreeing", t.n_disagreeing},
                         {"farthest_mm", static_cast<double>(t.farthest_mm)},
                         {"fcl_wrong", t.n_fcl_wrong},
                         {"textbook_wrong", t.n_textbook_wrong},
                         {"we_wrong", t.n_excused}}
       << '\n';
  EXPECT_TRUE(file.good());
}

// Answers differ: the third measure decides. Ours must not be wrong beyond a nanometre from contact.
void judge(const Answers& answers, const ThirdMeasure& truth, Tally& tally)
{
  ++tally.n_disagreeing;
  tally.n_we_hit += answers.ours && !answers.fcl ? 1 : 0;
  tally.n_fcl_hits += answers.fcl && !answers.ours ? 1 : 0;
  tally.farthest_mm = std::max(tally.farthest_mm, truth.from_touch_mm);
  const bool we_are_wrong = answers.ours != truth.is_overlapping || answers.exchanged != truth.is_overlapping;
  EXPECT_TRUE(!we_are_wrong || truth.from_touch_mm <= touching_mm)
      << answers << "; truly " << (truth.is_overlapping ? "overlapping by " : "apart by ")
      << static_cast<double>(truth.from_touch_mm) << " mm";
  tally.n_excused += we_are_wrong ? 1 : 0;
  const bool fcl_is_wrong =
      answers.fcl != truth.is_overlapping || answers.fcl_exchanged != truth.is_overlapping;
  tally.n_fcl_wrong += fcl_is_wrong ? 1 : 0;
  tally.n_textbook_wrong += answers.textbook != truth.is_overlapping ? 1 : 0;
}

Tally tally_of(const test::TwoObjects& objects, unsigned seed)
{
  std::mt19937_64 random(seed);
  contact::NarrowPhase narrow_phase;
  ByFcl fcl(objects.reference.mesh, objects.moving.mesh);
  Tally tally;
  for (int done = 0; done < n_touches_a_scene; done += n_touches_an_attitude) {
    const test::TestAttitude sample = test::random_attitude(objects, n_touches_an_attitude, random);
    fcl.turn(sample.attitude);
    for (const auto& [pose, zone] : sample.poses) {
      fcl.place(pose);
      Answers answers;
      answers.ours =
          contact::find_collision(sample.reference, objects.moving, pose, narrow_phase).has_value();
      answers.exchanged =
          contact::find_collision(objects.moving, sample.reference, exchanged(pose), narrow_phase)
              .has_value();
      answers.fcl = fcl.collides();
      answers.fcl_exchanged = fcl.collides_exchanged();
      answers.textbook = textbook_collides(sample.reference, objects.moving, pose);
      ++tally.n_poses;
      ++tally.n_in_zone[zone];
      tally.n_colliding += answers.ours ? 1 : 0;
      tally.n_near += zone == Zone::milli || zone == Zone::micro || zone == Zone::nano ? 1 : 0;
      if (!answers.agree())
        judge(answers, reference_measure(sample.reference.mesh, objects.moving.mesh, pose), tally);
    }
  }
  return tally;
}

void expect_agreement(const std::string& scene, unsigned seed)
{
  const Tally tally = tally_of(test::two_objects(scene), seed);
  std::cout << scene << ", seed " << seed << ": " << tally << '\n';
  write(tally, scene, seed);
  EXPECT_EQ(tally.n_poses, n_touches_a_scene * test::poses_per_contact);
  EXPECT_GT(tally.n_colliding, tally.n_poses / 5);
  EXPECT_GT(tally.n_poses - tally.n_colliding, tally.n_poses / 5);
  EXPECT_GT(tally.n_near, tally.n_poses / 5);
  for (const auto& [zone, n] : tally.n_in_zone) EXPECT_GE(n, n_touches_a_scene);
  EXPECT_EQ(tally.n_in_zone.size(), 6U);
}

std::string readable(const testing::TestParamInfo<std::string>& scene)
{
  std::string name = scene.param;
  std::replace(name.begin(), name.end(), '-', '_');
  return name;
}

class GeneratedScene : public testing::TestWithParam<std::string> {};
class RealKnee : public testing::TestWithParam<std::string> {};

TEST_P(GeneratedScene, CollidesWhereFclSaysSo)
{
  expect_agreement(GetParam(), 501);
}

TEST_P(RealKnee, CollidesWhereFclSaysSo)
{
  VRDA_REQUIRE_REAL_KNEES();
  expect_agreement(GetParam(), 502);
}

INSTANTIATE_TEST_SUITE_P(Oracle, GeneratedScene, testing::ValuesIn(test::generated_scenes()), readable);
INSTANTIATE_TEST_SUITE_P(Oracle, RealKnee, testing::ValuesIn(test::real_knee_scenes()), readable);

// The decision itself, in closed form.
TEST(ThirdMeasure, MeasuresDepthAndDistanceOfACornerAtAFace)
{
  const Mesh above = test::box({0, 2, 0}, {8, 4, 8});
  Pose corner_up = Pose::Identity();
  corner_up.linear() = shortest_rotation(Eigen::Vector3d(1, 1, 1).normalized(), Eigen::Vector3d::UnitY());
  const Mesh below = transformed(test::box({-1, -1, -1}, {2, 2, 2}), corner_up);  // its corner at the origin
  for (const double depth_mm : {-1e-7, -1e-9, 1e-9, 1e-7, 1e-3}) {
    SCOPED_TRACE(depth_mm);
    const MovingPose pose{{0.3, depth_mm, 0.2}, 0.4};
    const ThirdMeasure found = reference_measure(above, below, pose);
    EXPECT_EQ(found.is_overlapping, depth_mm > 0.0);
    EXPECT_NEAR(static_cast<double>(found.from_touch_mm), std::abs(depth_mm), 1e-14);
    EXPECT_EQ(textbook_collides(geometry::make_tree_mesh(above), geometry::make_tree_mesh(below), pose),
              depth_mm > 0.0);
  }
  EXPECT_TRUE(std::isinf(reference_measure(above, below, {{0.3, -1e-3, 0.2}, 0.4}).from_touch_mm));
}

constexpr double band_mm = 0.2;
constexpr double agreed_mm = 1e-6, nanometre_mm = 1e-9;
constexpr int n_attitudes = 25;
constexpr int n_touches_of_pairs = 2;

struct Pairs {
  int n_compared = 0;
  int n_near = 0;  // within 1e-3 mm, where the moving triangle is backed off
  int n_overlapping = 0;
  double largest_error_mm = 0.0;
};

void compare(const geometry::Corners& r, const geometry::Corners& m, contact::NarrowPhase& narrow_phase,
             Pairs& pairs)
{
  const contact::TriangleDistance found = narrow_phase.measure(r, m);
  EXPECT_EQ(narrow_phase.overlap(r, m), found.is_overlapping);
  const double expected_mm = test::triangle_distance_mm(r, m);
  if (found.is_overlapping || expected_mm <= 0.0) {
    // The two may differ within a nanometre of contact.
    const double apart_mm = found.is_overlapping ? expected_mm : 0.0;
    EXPECT_LT(apart_mm, nanometre_mm);
    EXPECT_TRUE(found.is_overlapping || test::fine_triangle_depth_mm(r, m) < nanometre_mm);
    ++pairs.n_overlapping;
    return;
  }
  pairs.largest_error_mm = std::max(pairs.largest_error_mm, std::abs(found.distance_mm - expected_mm));
  // Two points on the triangles at the smallest distance are closest points, unique or not.
  EXPECT_LT(test::outside_mm(r, found.p_reference_mm), agreed_mm);
  EXPECT_LT(test::outside_mm(m, found.p_moving_mm), agreed_mm);
  EXPECT_NEAR((found.p_moving_mm - found.p_reference_mm).norm(), expected_mm, agreed_mm);
  ++pairs.n_compared;
  pairs.n_near += expected_mm < 1e-3 ? 1 : 0;
}

Pairs compared(const std::string& scene, unsigned seed)
{
  const test::TwoObjects objects = test::two_objects(scene);
  std::mt19937_64 random(seed);
  contact::NarrowPhase narrow_phase;
  Pairs pairs;
  for (int k = 0; k < n_attitudes; ++k) {
    const test::TestAttitude sample = test::random_attitude(objects, n_touches_of_pairs, random);
    for (const auto& [pose, zone] : sample.poses) {
      const geometry::Placement place(pose);
      if (zone == test::Zone::deep || zone == test::Zone::anywhere) continue;
      geometry::visit_close_pairs(
          sample.reference.tree, objects.moving.tree, place, band_mm,
          [&](const geometry::TrianglePair& pair) {
            const geometry::Corners r = corners(sample.reference.mesh, pair.reference),
                                    m = place(corners(objects.moving.mesh, pair.moving));
            if (!contact::is_certainly_separated(r, m, band_mm)) compare(r, m, narrow_phase, pairs);
            return false;
          });
    }
  }
  return pairs;
}

void expect_closest_points(const std::string& scene, unsigned seed)
{
  const Pairs pairs = compared(scene, seed);
  std::cout << scene << ": " << pairs.n_compared << " pairs, " << pairs.n_near << " within 1e-3 mm, "
            << pairs.n_overlapping << " overlapping; largest error " << pairs.largest_error_mm << " mm\n";
  EXPECT_GT(pairs.n_compared, 500);
  EXPECT_GT(pairs.n_near, 50);
  EXPECT_LT(pairs.largest_error_mm, agreed_mm);
}

class RealKneePairs : public testing::TestWithParam<std::string> {};

TEST(ClosestPairs, OfTheGenericKneeAreThoseOfTheClosedForms)
{
  expect_closest_points("GenericKnee", 601);
}

TEST_P(RealKneePairs, AreThoseOfTheClosedForms)
{
  VRDA_REQUIRE_REAL_KNEES();
  expect_closest_points(GetParam(), 602);
}

INSTANTIATE_TEST_SUITE_P(Oracle, RealKneePairs, testing::ValuesIn(test::real_knee_scenes()), readable);

}  // namespace vrda::oracle_test
