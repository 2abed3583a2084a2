// Our collision answers compared with FCL, an independent library with its own trees and triangle tests.
#include <fcl/geometry/bvh/BVH_model.h>
#include <fcl/narrowphase/collision.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>

#include "contact/contacts.hpp"
#include "contact/scenes.hpp"
#include "contact/third_measure.hpp"
#include "support/meshes.hpp"
#include "support/real_knees.hpp"

namespace vrda::collision_test {

using test::Zone;

// A disagreement counts only beyond this distance from contact.
constexpr long double touching_mm = 1e-9L;
constexpr int n_touches_a_scene = 250;
constexpr int n_touches_an_attitude = 5;

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
void judge(const Answers& answers, const test::ThirdMeasure& truth, Tally& tally)
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
      answers.textbook = test::textbook_collides(sample.reference, objects.moving, pose);
      ++tally.n_poses;
      ++tally.n_in_zone[zone];
      tally.n_colliding += answers.ours ? 1 : 0;
      tally.n_near += zone == Zone::milli || zone == Zone::micro || zone == Zone::nano ? 1 : 0;
      if (!answers.agree())
        judge(answers, test::reference_measure(sample.reference.mesh, objects.moving.mesh, pose), tally);
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
    const test::ThirdMeasure found = test::reference_measure(above, below, pose);
    EXPECT_EQ(found.is_overlapping, depth_mm > 0.0);
    EXPECT_NEAR(static_cast<double>(found.from_touch_mm), std::abs(depth_mm), 1e-14);
    EXPECT_EQ(test::textbook_collides(geometry::make_tree_mesh(above), geometry::make_tree_mesh(below), pose),
              depth_mm > 0.0);
  }
  EXPECT_TRUE(std::isinf(test::reference_measure(above, below, {{0.3, -1e-3, 0.2}, 0.4}).from_touch_mm));
}

}  // namespace vrda::collision_test
