// The player's poses equal those of the pipeline, for every set at every attitude of the grid.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <map>

#include "app/scenes.hpp"
#include "core/units.hpp"
#include "store/motion.hpp"
#include "store/motion_model.hpp"
#include "support/scratch.hpp"

namespace vrda::player_poses_test {

// mm and matrix elements: products of three rotations on coordinates of some hundreds have errors of 1e-12.
// This is the player's specified accuracy.
constexpr double promised = 1e-9;

struct Variant {
  const char* name;
  std::vector<std::string> sets;  ///< --set
};

/// The generic knee with ligaments on a coarse grid.
store::MotionModel solved(const Variant& variant)
{
  std::vector<std::string> sets = variant.sets;
  sets.insert(sets.end(), {"solver.equilibrium.restarts=0", "grid.flexion.step=15", "smooth.degrees=[1, 3]",
                           "smooth.recontact=true"});
  return test::solved(VRDA_SOURCE_DIR "/jobs/knee-generic.toml", sets);
}

/// Computed by the formulas of the frames from the stored numbers.
Pose pose_from(const store::MotionModel& model, Eigen::Index row, double varus_deg,
               const store::PoseCoordinates& numbers_deg)
{
  const Side side = model.side == "left" ? Side::left : Side::right;
  const SolverFrame frame{side, model.rotation_centre_mm, model.push.delta.row(row).transpose()};
  const Attitude attitude{rad_from_deg(model.flexion_deg[static_cast<std::size_t>(row)]),
                          rad_from_deg(varus_deg)};
  const Eigen::Vector3d shift_mm(numbers_deg[0], numbers_deg[1], numbers_deg[2]);
  return X_reference_moving(frame, attitude,
                            {solver_translation_mm(frame, shift_mm), rad_from_deg(numbers_deg[3])});
}

double difference(const Pose& a, const Pose& b)
{
  return (a.matrix() - b.matrix()).cwiseAbs().maxCoeff();
}

struct Cell {
  Eigen::Index row, column;
  std::size_t index(const store::MotionModel& model) const
  {
    return static_cast<std::size_t>(row * model.status.cols() + column);
  }
};

std::vector<Cell> cells(const store::MotionModel& model)
{
  std::vector<Cell> all;
  for (Eigen::Index i = 0; i < model.status.rows(); ++i)
    for (Eigen::Index j = 0; j < model.status.cols(); ++j) all.push_back({i, j});
  return all;
}

store::JointPose shown(const store::Motion& motion, const store::MotionModel& model, const Cell& cell)
{
  return motion.at({rad_from_deg(model.flexion_deg[static_cast<std::size_t>(cell.row)]),
                    rad_from_deg(model.varus_deg[static_cast<std::size_t>(cell.column)])});
}

/// Number of compared poses.
int expect_raw(const store::MotionModel& model)
{
  const store::Motion motion(model, "raw");
  int n = 0;
  for (const Cell& cell : cells(model)) {
    const bool is_stable = model.status(cell.row, cell.column) == status_stable;
    const store::JointPose pose = shown(motion, model, cell);
    EXPECT_EQ(pose.status == store::PoseStatus::solved, is_stable);
    if (!is_stable) continue;
    ++n;
    EXPECT_LT(
        difference(pose.X_reference_moving, store::pose_in(model.X_reference_moving, cell.index(model))),
        promised);
  }
  return n;
}

/// The stored smoothed values of a set at a cell: x, y, z, theta and, with a fifth surface, varus.
std::vector<double> stored(const store::SmoothedSet& set, const Cell& cell)
{
  std::vector<double> numbers;
  for (const store::SmoothedSurface& surface : set.surfaces)
    numbers.push_back(surface.values(cell.row, cell.column));
  return numbers;
}

int expect_smoothed(const store::MotionModel& model, const store::SmoothedSet& set, bool is_recontacted)
{
  const store::Motion motion(model,
                             "degree_" + std::to_string(set.degree) + (is_recontacted ? "_recontacted" : ""));
  int n = 0;
  for (const Cell& cell : cells(model)) {
    const std::vector<double> numbers = stored(set, cell);
    store::PoseCoordinates wanted{numbers[0], numbers[1], numbers[2], numbers[3]};
    const double varus_deg =
        numbers.size() == 5 ? numbers[4] : model.varus_deg[static_cast<std::size_t>(cell.column)];
    const double travel_mm = is_recontacted ? (*set.recontact_mm)(cell.row, cell.column) : 0.0;
    const store::JointPose pose = shown(motion, model, cell);
    EXPECT_EQ(pose.status == store::PoseStatus::solved, !std::isnan(travel_mm));
    if (std::isnan(travel_mm)) continue;
    for (int axis = 0; axis < 3; ++axis)
      wanted[static_cast<std::size_t>(axis)] += travel_mm * model.push.delta(cell.row, axis);
    ++n;
    EXPECT_LT(difference(pose.X_reference_moving, pose_from(model, cell.row, varus_deg, wanted)), promised);
  }
  return n;
}

int expect_zero_varus(const store::MotionModel& model)
{
  const store::Motion motion(model, "zero_varus");
  int n = 0;
  for (Eigen::Index i = 0; i < model.status.rows(); ++i) {
    const auto row = static_cast<std::size_t>(i);
    const bool has_pose =
        model.zero_varus->source[row] != static_cast<std::int8_t>(store::ZeroVarusSource::none);
    const store::JointPose pose = motion.at({rad_from_deg(model.flexion_deg[row]), 0.0});
    EXPECT_EQ(pose.status == store::PoseStatus::solved, has_pose);
    if (!has_pose) continue;
    ++n;
    EXPECT_LT(difference(pose.X_reference_moving, store::pose_in(model.zero_varus->X_reference_moving, row)),
              promised);
    EXPECT_NEAR(deg_from_rad(pose.attitude.varus_rad), model.zero_varus->varus_deg[row], promised);
  }
  return n;
}

TEST(PlayerPoses, AreThePipelinesAtEveryAttitudeOfEverySet)
{
  const Variant variants[] = {
      {"oblique Delta", {"grid.varus.step=5", "push.delta=[0.1, 0.98, 0.05]"}},
      {"left, Delta that turns",
       {"grid.varus.step=5", "side=left",
        "push.delta={ flexion_deg = [0, 90], value = [[0, 1, 0], [0.2, 1, 0.1]] }"}},
      {"left, free varus", {"grid.varus=free", "side=left"}},
  };
  for (const Variant& variant : variants) {
    SCOPED_TRACE(variant.name);
    const store::MotionModel model = solved(variant);
    const int half = static_cast<int>(model.status.size()) / 2;
    EXPECT_GT(expect_raw(model), half);
    ASSERT_EQ(model.smoothed.size(), 2u);
    for (const store::SmoothedSet& set : model.smoothed) {
      EXPECT_EQ(set.surfaces.size(), model.varus_deg.size() == 1 ? 5u : 4u);
      EXPECT_EQ(expect_smoothed(model, set, false), model.status.size());
      ASSERT_TRUE(set.recontact_mm.has_value());
      EXPECT_GT(expect_smoothed(model, set, true), half);
    }
    ASSERT_TRUE(model.zero_varus.has_value());
    EXPECT_GT(expect_zero_varus(model), 3);
  }
}

}  // namespace vrda::player_poses_test
