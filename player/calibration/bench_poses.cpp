#include "calibration/bench_poses.hpp"

#include <cmath>

#include "bench/rigid_body.hpp"
#include "bench/simulation.hpp"
#include "calibration/statistics.hpp"
#include "calibration/task.hpp"
#include "core/text.hpp"
#include "core/units.hpp"

namespace vrda::calibration {
namespace {

constexpr double sweep_mm = 300.0;

Eigen::Vector3d even_vector(RandomSequence& draws, double most)
{
  const double x = draws.uniform(), y = draws.uniform(), z = draws.uniform();
  return most * (2.0 * Eigen::Vector3d(x, y, z) - Eigen::Vector3d::Ones());
}

/// Random numbers of where a hand puts something, by `kind` and `index`.
RandomSequence draws_of_hand(const VirtualTruth& truth, std::uint64_t kind, int index)
{
  constexpr std::uint64_t first = 2000, most_indices = 1000;
  return {truth.seed, bench::RandomPurpose::virtual_bench,
          first + kind * most_indices + static_cast<std::uint64_t>(index)};
}

void put_on_table(const VirtualTruth& truth, const Eigen::Vector3d& p_table_mm, BenchPoses& standing)
{
  standing.X_tracker_tool = bench::pose_of(truth.calibration.X_tracker_table);
  standing.X_tracker_tool.translation() = standing.X_tracker_tool * p_table_mm;
}

void put_tip_at(const VirtualTruth& truth, const Eigen::Vector3d& tip_tracker_mm, const Eigen::Matrix3d& R,
                BenchPoses& standing)
{
  standing.X_tracker_tool.linear() = R;
  standing.X_tracker_tool.translation() = tip_tracker_mm - R * truth.tip_probe_mm;
}

void put_head(const VirtualTruth& truth, const Pose& X_eyes_moved, double stage_mm, BenchPoses& standing)
{
  standing.stage_mm = stage_mm;
  standing.X_tracker_eyes = X_tracker_eyes(truth.calibration, stage_mm) * X_eyes_moved;
  standing.X_tracker_headbody =
      standing.X_tracker_eyes * bench::pose_of(truth.calibration.X_headbody_eyes).inverse();
}

}  // namespace

BenchPoses resting_poses(const VirtualTruth& truth)
{
  BenchPoses standing;
  put_head(truth, Pose::Identity(), 0.0, standing);
  return standing;
}

BenchPoses x_rail_poses(const VirtualTruth& truth, double way)
{
  BenchPoses standing;
  put_head(truth, Pose::Identity(), sweep_mm * way, standing);
  put_on_table(truth, {sweep_mm * (way - 0.5), 0.0, 0.0}, standing);
  return standing;
}

BenchPoses z_rail_poses(const VirtualTruth& truth, double way)
{
  BenchPoses standing = resting_poses(truth);
  put_on_table(truth,
               Eigen::Vector3d(0.0, truth.z_rail_above_mm, 0.0) + sweep_mm * (way - 0.5) * truth.z_rail_table,
               standing);
  return standing;
}

BenchPoses pivot_poses(const VirtualTruth& truth, double way)
{
  // Inclination of 20 degrees in all directions: a range of 40 degrees about x and about y.
  constexpr double turns = 3.0, lean_deg = 20.0;
  const SinCos round = sin_cos(2.0 * pi * turns * way);
  const Eigen::Vector3d lean_rad = rad_from_deg(lean_deg) * Eigen::Vector3d(round.cos, round.sin, 0.0);
  BenchPoses standing = resting_poses(truth);
  const Pose X_tracker_table = bench::pose_of(truth.calibration.X_tracker_table);
  put_tip_at(truth, X_tracker_table * Eigen::Vector3d(100.0, 0.0, 100.0),
             X_tracker_table.linear() * bench::rotation_of(lean_rad), standing);
  return standing;
}

BenchPoses bullseye_poses(const BenchFile& bench, const VirtualTruth& truth, int index)
{
  RandomSequence draws = draws_of_hand(truth, 0, index);
  const Eigen::Vector3d place = calibration::requested_marker_position(index).cast<double>();
  const double depth_mm = 750.0 + 200.0 * place.z() + 40.0 * (draws.uniform() - 0.5);
  const view::Eye& eye = truth.calibration.eyes.left;
  const Eigen::Vector2d tangent =
      Eigen::Vector2d(0.25 * eye.visible.width, 0.3 * eye.visible.height) / eye.distance_px;
  const Eigen::Vector3d p_eyes_mm(place.x() * tangent.x() * depth_mm, place.y() * tangent.y() * depth_mm,
                                  -depth_mm);
  BenchPoses standing;
  Pose X_eyes_moved = Pose::Identity();
  double stage_mm = 0.0;
  if (bench.head == HeadKind::stage) {
    stage_mm = 60.0 + 160.0 * draws.uniform();
  } else {
    X_eyes_moved.linear() = bench::rotation_of(even_vector(draws, rad_from_deg(8.0)));
    X_eyes_moved.translation() = even_vector(draws, 40.0);
  }
  put_head(truth, X_eyes_moved, stage_mm, standing);
  standing.X_tracker_tool.translation() = standing.X_tracker_eyes * (p_eyes_mm + even_vector(draws, 10.0));
  return standing;
}

BenchPoses touch_poses(const VirtualTruth& truth, const TouchedPoint& touched)
{
  RandomSequence draws = draws_of_hand(truth, 1 + static_cast<std::uint64_t>(touched.role), touched.index);
  constexpr double lean_deg = 40.0;
  const Pose X_body_model =
      bench::pose_of(truth.calibration.X_body_model[static_cast<std::size_t>(touched.role)]);
  const Eigen::Vector3d tip_mm = X_tracker_body(truth, touched.role) * X_body_model *
                                     (truth.calibration.subject_scale * touched.p_model_mm) +
                                 touched.off_mm;
  BenchPoses standing = resting_poses(truth);
  put_tip_at(truth, tip_mm, bench::rotation_of(even_vector(draws, rad_from_deg(lean_deg))), standing);
  return standing;
}

BenchPoses bend_poses(const VirtualTruth& truth, int index, double way)
{
  check(truth.joint.has_value(), "a virtual leg bends by the motion of a model");
  constexpr double least_share = 0.94;
  RandomSequence draws = draws_of_hand(truth, 1 + bench::n_body_roles, index);
  const VirtualJoint& joint = *truth.joint;
  const double share = least_share + (1.0 - least_share) * draws.uniform();
  const double bent = 0.5 * share * (1.0 - sin_cos(2.0 * pi * way).cos);
  const double flexion_rad = joint.curve.first_rad + bent * (joint.curve.last_rad() - joint.curve.first_rad);
  const auto model_of = [&](BodyRole role) {
    return bench::pose_of(truth.calibration.X_body_model[static_cast<std::size_t>(role)]);
  };
  BenchPoses standing = resting_poses(truth);
  standing.X_tracker_shank = truth.X_tracker_leg * model_of(BodyRole::femur) *
                             joint.X_femur_tibia(flexion_rad) * model_of(BodyRole::tibia).inverse();
  return standing;
}

const Pose& X_tracker_body(const VirtualTruth& truth, BodyRole role)
{
  return role == BodyRole::tibia  ? truth.X_tracker_shank
         : role == BodyRole::head ? truth.X_tracker_headbody
                                  : truth.X_tracker_leg;
}

namespace {

/// True pose of a tool; nullopt if unused.
std::optional<Pose> true_tool_pose(const BenchFile& bench, const VirtualTruth& truth,
                                   const BenchPoses& standing, const std::string& used,
                                   const std::string& tool)
{
  if (tool == used && !standing.X_tracker_shank) return standing.X_tracker_tool;
  for (std::size_t k = 0; k < bench::n_body_roles; ++k) {
    if (!bench.bodies[k]) continue;
    const bench::BodySettings& body = *bench.bodies[k];
    const auto role = static_cast<BodyRole>(k);
    const Pose X = role == BodyRole::head    ? standing.X_tracker_headbody
                   : role == BodyRole::tibia ? standing.X_tracker_shank.value_or(truth.X_tracker_shank)
                                             : X_tracker_body(truth, role);
    if (tool == body.tool) return X;
    for (std::size_t m = 0; m < body.markers.size(); ++m) {
      if (tool != body.markers[m]) continue;
      Pose marker = X;
      marker.translation() = X * body.markers_body_mm[m];
      return marker;
    }
  }
  return std::nullopt;
}

}  // namespace

Pose measured(const Pose& X, const VirtualNoise& noise, RandomSequence& draws)
{
  Pose seen = X;
  seen.translation() += noise.tracker_mm * draws.normal_vector();
  seen.linear() = bench::rotation_of(rad_from_deg(noise.tracker_deg) * draws.normal_vector()) * X.linear();
  return seen;
}

std::vector<bench::Sample> tracker_frame(const BenchFile& bench, const VirtualTruth& truth,
                                         const BenchPoses& standing, const FrameFacts& facts,
                                         RandomSequence& draws)
{
  std::vector<bench::Sample> samples;
  bench::Sample sample;
  sample.arrival_ns = sample.device_ns = facts.time_ns;
  if (bench.board && bench.board->has_stage) {
    sample.kind = bench::SampleKind::stage;
    sample.source = static_cast<std::uint16_t>(bench::DeviceId::board);
    sample.state = facts.is_stage_zeroed ? bench::stage_zeroed : 0;
    sample.count = static_cast<std::int32_t>(
        std::lround((standing.stage_mm + facts.stage_offset_mm) / bench.stage_mm_per_count));
    samples.push_back(sample);
  }
  sample.kind = bench::SampleKind::tool_pose;
  sample.count = 0;
  for (std::size_t k = 0; k < bench.tracker->tools.size(); ++k) {
    const std::optional<Pose> X = true_tool_pose(bench, truth, standing, facts.tool, bench.tracker->tools[k]);
    sample.source = static_cast<std::uint16_t>(k);
    sample.state =
        static_cast<std::uint8_t>(X ? bench::ToolVisibility::seen : bench::ToolVisibility::missing);
    // Drawn for hidden tools too, so that hiding one does not change the others.
    const Pose seen = measured(X.value_or(Pose::Identity()), facts.noise, draws);
    sample.tool_pose = X ? bench::place_of(seen) : bench::ToolPose{};
    samples.push_back(sample);
  }
  return samples;
}

}  // namespace vrda::calibration
