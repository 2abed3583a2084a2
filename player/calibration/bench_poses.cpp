#include "calibration/bench_poses.hpp"

#include <cmath>

#include "bench/rigid_body.hpp"
#include "core/units.hpp"
#include "view/eye.hpp"

namespace vrda::calibration {

BenchPoses resting_poses(const VirtualTruth& truth, double stage_mm, const Pose& X_eyes_moved)
{
  BenchPoses poses;
  poses.stage_mm = stage_mm;
  poses.X_tracker_eyes = X_tracker_eyes(truth.calibration, stage_mm) * X_eyes_moved;
  poses.X_tracker_headbody =
      poses.X_tracker_eyes * bench::pose_of(truth.calibration.X_headbody_eyes).inverse();
  return poses;
}

void put_tip_at(const VirtualTruth& truth, const Eigen::Vector3d& tip_tracker_mm, const Eigen::Matrix3d& R,
                BenchPoses& poses)
{
  poses.X_tracker_tool.linear() = R;
  poses.X_tracker_tool.translation() = tip_tracker_mm - R * truth.tip_probe_mm;
}

Pose X_tracker_eyes(const Calibration& calibration, double stage_mm)
{
  Pose X_table_eyes = bench::pose_of(calibration.X_table_eyes);
  X_table_eyes.translation() += stage_mm * calibration.stage_direction_table;
  return bench::pose_of(calibration.X_tracker_table) * X_table_eyes;
}

const Pose& X_tracker_body(const VirtualTruth& truth, BodyRole role)
{
  return role == BodyRole::tibia  ? truth.X_tracker_shank
         : role == BodyRole::head ? truth.X_tracker_headbody
                                  : truth.X_tracker_leg;
}

Pose X_body_model(const Calibration& calibration, BodyRole role)
{
  return bench::pose_of(calibration.X_body_model[static_cast<std::size_t>(role)]);
}

/// Random numbers of where a hand puts something, by `kind` and `index`.
RandomSequence draws_of_hand(const VirtualTruth& truth, std::uint64_t kind, int index)
{
  constexpr std::uint64_t first = 2000, most_indices = 1000;
  return {truth.seed, bench::RandomPurpose::virtual_bench,
          first + kind * most_indices + static_cast<std::uint64_t>(index)};
}

Eigen::Vector3d even_vector(RandomSequence& draws, double most)
{
  const double x = draws.uniform(), y = draws.uniform(), z = draws.uniform();
  return most * (2.0 * Eigen::Vector3d(x, y, z) - Eigen::Vector3d::Ones());
}

Eigen::Vector2d alignment_off_px(const TaskContext& context)
{
  const double x = context.draws.normal(), y = context.draws.normal();
  return context.noise.alignment_px * Eigen::Vector2d(x, y);
}

namespace {

/// True pose of a tool; nullopt if unused.
std::optional<Pose> true_tool_pose(const BenchFile& bench, const VirtualTruth& truth, const BenchPoses& poses,
                                   const std::string& used, const std::string& tool)
{
  if (tool == used && !poses.X_tracker_shank) return poses.X_tracker_tool;
  for (std::size_t k = 0; k < bench::n_body_roles; ++k) {
    if (!bench.bodies[k]) continue;
    const bench::BodySettings& body = *bench.bodies[k];
    const auto role = static_cast<BodyRole>(k);
    const Pose X = role == BodyRole::head    ? poses.X_tracker_headbody
                   : role == BodyRole::tibia ? poses.X_tracker_shank.value_or(truth.X_tracker_shank)
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
                                         const BenchPoses& poses, const FrameFacts& facts,
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
        std::lround((poses.stage_mm + facts.stage_offset_mm) / bench.stage_mm_per_count));
    samples.push_back(sample);
  }
  sample.kind = bench::SampleKind::tool_pose;
  sample.count = 0;
  for (std::size_t k = 0; k < bench.tracker->tools.size(); ++k) {
    const std::optional<Pose> X = true_tool_pose(bench, truth, poses, facts.tool, bench.tracker->tools[k]);
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

std::vector<DrawnLine> seen_lines(std::span<const DrawnLine> drawn, const VirtualTruth& truth)
{
  std::vector<DrawnLine> seen;
  for (const DrawnLine& line : drawn) {
    const view::Distortion& optics = view::side_of(truth.calibration.eyes, line.is_right).distortion;
    const VirtualTruth::Edges& edges = truth.edges_px[line.is_right ? 1 : 0];
    for (Points2d& piece : pieces_within(with_points_between(line.points_px),
                                         {{edges.left, edges.top}, {edges.right, edges.bottom}})) {
      for (Eigen::Vector2d& point : piece) point = view::shown_px(optics, point);
      DrawnLine& part = seen.emplace_back(line);
      part.points_px = std::move(piece);
      part.is_smooth = true;  // a scan line's whole pixels are bent by the optics like the edge
    }
  }
  return seen;
}

}  // namespace vrda::calibration
