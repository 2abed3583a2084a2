#include "validation/scene_case.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <nlohmann/json.hpp>

namespace vrda::test {

double Draw::uniform(double from, double to)
{
  // 53 bits; the standard library's distributions differ between implementations.
  return from + (to - from) * static_cast<double>(bits_() >> 11) * 0x1p-53;
}

double Draw::log_uniform(double from, double to)
{
  return std::exp(uniform(std::log(from), std::log(to)));
}

int Draw::whole(int from, int to)
{
  return from + static_cast<int>(bits_() % static_cast<std::uint64_t>(to - from + 1));
}

double Draw::sign()
{
  return (bits_() & 1U) != 0 ? 1.0 : -1.0;
}

Scene scene_of(const geometry::ShapeRequest& request)
{
  geometry::Shape shape = geometry::generate_shape(request);
  return {std::move(shape.reference.front().mesh), std::move(shape.moving.front().mesh)};
}

Solved solve(const Scene& scene, const SearchOptions& options, const MovingPose& seed)
{
  Solved solved;
  const solve::Joint joint = solve::make_joint({scene.reference, {}}, {scene.moving, {}}, {});
  solved.record = solve::find_stable_pose(joint, {}, seed, options,
                                          [&](const SearchMove& move) { ++solved.moves[move.kind]; });
  return solved;
}

Eigen::Vector3d placed(const Solved& solved, const Eigen::Vector3d& p_moving_mm)
{
  return pose_of(solved.record.pose) * p_moving_mm;
}

int n_tested(int n)
{
  return std::getenv("VRDA_VALIDATION") != nullptr ? n : (n + 3) / 4;
}

bool Tally::add(double measured)
{
  ++cases;
  const bool holds = measured <= allowed;
  if (!holds) ++failures;
  if (!(measured <= worst)) worst = measured;
  return holds;
}

void report(const Tally& tally)
{
  std::cout << tally.scene << ": " << tally.claim << "\n  seed " << tally.seed << ", " << tally.cases
            << " cases, worst " << tally.measure << " " << tally.worst << " (allowed " << tally.allowed
            << "), " << tally.failures << " failures";
  for (const auto& [name, n] : tally.outcomes) std::cout << ", " << name << " " << n;
  std::cout << std::endl;
  if (const char* folder = std::getenv("VRDA_VALIDATION")) {
    const auto* test = testing::UnitTest::GetInstance()->current_test_info();
    std::ofstream file(std::filesystem::path(folder) / (std::string(test->name()) + ".jsonl"), std::ios::app);
    file << nlohmann::json{{"test", test->name()}, {"scene", tally.scene},
                           {"claim", tally.claim}, {"measure", tally.measure},
                           {"seed", tally.seed},   {"allowed", tally.allowed},
                           {"cases", tally.cases}, {"failures", tally.failures},
                           {"worst", tally.worst}, {"outcomes", tally.outcomes}}
         << '\n';
    EXPECT_TRUE(file.good());
  }
  EXPECT_EQ(tally.failures, 0);
  EXPECT_GT(tally.cases, 0);
}

}  // namespace vrda::test
