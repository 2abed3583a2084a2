/// Motion models made by code.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "store/motion.hpp"
#include "store/motion_model.hpp"

namespace vrda::test {

/// x, y, z (mm, world W) and theta (degrees) of the moving object at an attitude in degrees.
using ModelMotion = std::function<store::PoseCoordinates(double flexion_deg, double varus_deg)>;

struct ModelPlan {
  std::string side = "right";
  std::vector<double> flexion_deg{0, 15, 30, 45, 60, 75, 90};
  std::vector<double> varus_deg{-4, -2, 0, 2, 4};
  Eigen::Vector3d rotation_centre_mm{0, 0, 0};
  Eigen::Vector3d delta{0, 1, 0};
  ModelMotion motion;                                                ///< all zero when empty
  std::function<Eigen::Vector3d(double flexion_deg)> turning_delta;  ///< unit; empty: `delta` throughout
  std::function<double(double flexion_deg)> free_varus_deg;          ///< for one varus; empty: it was given
};

/// Marks one cell as solved at this pose, in contact on both sides; its flexion, varus and Delta are the
/// model's.
void solve_cell(store::MotionModel& model, Eigen::Index flexion, Eigen::Index varus,
                const store::PoseCoordinates& numbers);

/// The surface's polynomial at every cell of the model.
store::GridD grid_values(const store::MotionModel& model, const store::SmoothedSet& set,
                         const store::SmoothedSurface& surface);

/// Every cell solved and the spine on the middle varus; with bodies it can be written and read back.
store::MotionModel model_of(const ModelPlan& plan);

/// A sequence of frames over time_s: frame i is row order[i] of a grid with the single varus 0.
store::MotionModel frames_of(const store::MotionModel& column, const std::vector<std::size_t>& order,
                             const std::vector<double>& keys);

/// Flexion 0 to 30 by 10, varus -1 to 1, with bodies; the cell at 10 degrees, varus 1 is unsolved. The set
/// "degree_1" has theta that grows with flexion.
store::MotionModel small_model();

/// Frames at 0, 0.5, 1 and 2 s with flexion 20, 0, 30, 10, and bodies.
store::MotionModel small_sequence();

/// Marks one cell as ended with no_contact, its numbers NaN.
void unsolve(store::MotionModel& model, Eigen::Index flexion, Eigen::Index varus);

/// Adds a body that follows the joint, a box about `centre_mm`, with the coordinates of each cell (rad, mm;
/// model/coordinates.hpp) given by its angles. Its BodyIndex is the next free one; `of` is an earlier one.
void add_follower(store::MotionModel& model, BodyIndex of, const Eigen::Vector3d& centre_mm,
                  const std::function<JointCoordinates(double flexion_deg, double varus_deg)>& coordinates);

/// Adds the set "degree_N" with coefficients of P_i(u) P_j(v) given by `coefficient(i, j)` for each of
/// x, y, z (mm) and theta (degrees), i + j <= degree.
void add_smoothed(store::MotionModel& model, int degree,
                  const std::function<store::PoseCoordinates(int, int)>& coefficient);

/// A joint for pictures: a ball of 20 mm radius (reference, bone) on a box (moving, bone) with a
/// translucent plate (moving, meniscus) between them.
void add_bodies(store::MotionModel& model);

}  // namespace vrda::test
