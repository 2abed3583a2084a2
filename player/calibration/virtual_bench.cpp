#include "calibration/virtual_bench.hpp"

#include <algorithm>
#include <cmath>

#include "bench/rigid_body.hpp"
#include "core/units.hpp"
#include "view/eye.hpp"

namespace vrda::calibration {

/// Text of virtual_bench.toml, of which CMake makes a source.
const char* virtual_bench_toml();

namespace {

/// Groups of random numbers, so that a change in one does not affect the others.
enum class Group : std::uint64_t {
  left_display,
  right_display,
  person,
  table,
  rails,
  leg,
  head,
  probe,
  joint
};

RandomSequence draws_for(std::uint64_t seed, Group group)
{
  return {seed, bench::RandomPurpose::virtual_bench, static_cast<std::uint64_t>(group)};
}

double between(RandomSequence& draws, double least, double most)
{
  return least + (most - least) * draws.uniform();
}

Eigen::Vector3d vector_within(RandomSequence& draws, double most)
{
  const double x = between(draws, -most, most), y = between(draws, -most, most),
               z = between(draws, -most, most);
  return {x, y, z};
}

/// Random pose, rotated by up to `most_deg` about each axis in turn.
Pose any_pose(RandomSequence& draws, double most_deg, const Eigen::Vector3d& about_mm, double most_mm)
{
  bench::PoseParameters six;
  six.turn_rad = vector_within(draws, rad_from_deg(most_deg));
  six.shift_mm = about_mm + vector_within(draws, most_mm);
  return bench::pose_of(six);
}

view::ShownBox drawn_edges(RandomSequence& draws, const view::Viewport& window)
{
  // Inside the window's borders by 2 to 6 % of its size, drawn per border.
  const auto share = [&](double size) { return between(draws, 0.02, 0.06) * size; };
  view::ShownBox edges;
  edges.low_px.x() = window.x + share(window.width);
  edges.high_px.x() = window.x + window.width - share(window.width);
  edges.low_px.y() = window.y + share(window.height);
  edges.high_px.y() = window.y + window.height - share(window.height);
  return edges;
}

/// One eye's display and optics.
void add_display(const BenchFile& bench, bool is_right, VirtualTruth& truth)
{
  const std::size_t k = is_right ? 1 : 0;
  RandomSequence draws = draws_for(truth.seed, is_right ? Group::right_display : Group::left_display);
  view::Eye& eye = view::side_of(truth.calibration.eyes, is_right);
  eye.window = view::side_of(bench.display.windows, is_right);
  const view::ShownBox edges = truth.edges_px[k] = drawn_edges(draws, eye.window);
  eye.visible = nearest_pixels(edges);
  eye.pixel_aspect = between(draws, 0.97, 1.03);
  const double pixel_mm = between(draws, 95.0, 105.0) / eye.window.width;
  const Eigen::Vector2d size_px = edges.high_px - edges.low_px;
  truth.screen_mm[k] = pixel_mm * Eigen::Vector2d(size_px.x(), size_px.y() * eye.pixel_aspect);
  const Eigen::Vector2d middle = 0.5 * (edges.low_px + edges.high_px);
  const auto off = [&](double sd_px) -> Eigen::Vector2d {
    const double x = draws.normal(), y = draws.normal();
    return {sd_px * x, sd_px * y};
  };
  eye.sight_px = middle + off(bench.calibration.sight_sd_px);
  eye.distance_px = between(draws, 840.0, 920.0);
  eye.distortion.k1 = between(draws, 0.06, 0.15);
  eye.distortion.k2 = between(draws, 0.0, 0.02);
  constexpr double centre_sd_px = 3.0;
  eye.distortion.centre_px = middle + off(centre_sd_px);
  eye.distortion.unit_px = 0.5 * eye.window.width;
  eye.distortion.pixel_aspect = eye.pixel_aspect;
  constexpr double grid_off_px = 4.0;
  truth.grids[k].origin_px = eye.sight_px + off(grid_off_px);
  truth.grids[k].turn_rad = rad_from_deg(0.5) * draws.normal();
}

/// Grid spacing: the largest multiple of 5 mm that fits the area visible to both eyes.
void add_grid(const BenchFile& bench, VirtualTruth& truth)
{
  const CalibrationSettings& settings = bench.calibration;
  constexpr double filled = 0.9, usual_distance_px = 880.0, step_mm = 5.0;
  double spacing_px = usual_distance_px;
  for (const view::Eye* eye : {&truth.calibration.eyes.left, &truth.calibration.eyes.right}) {
    spacing_px = std::min({spacing_px, filled * eye->visible.width / std::max(1, settings.grid_columns - 1),
                           filled * eye->visible.height / std::max(1, settings.grid_rows - 1)});
  }
  const double spacing_mm = spacing_px * truth.grid_depth_mm / usual_distance_px;
  truth.grid_spacing_mm = std::max(1.0, std::floor(spacing_mm / step_mm)) * step_mm;
  truth.grids[0].spacing_px =
      truth.calibration.eyes.left.distance_px * truth.grid_spacing_mm / truth.grid_depth_mm;
  truth.grids[1].spacing_px =
      truth.calibration.eyes.right.distance_px * truth.grid_spacing_mm / truth.grid_depth_mm;
}

void add_person(const BenchFile& bench, VirtualTruth& truth)
{
  RandomSequence draws = draws_for(truth.seed, Group::person);
  Calibration& c = truth.calibration;
  const double ipd_mm = between(draws, 58.0, 70.0);
  constexpr double depth_apart_sd_mm = 2.0;
  const double depth_apart_mm = depth_apart_sd_mm * draws.normal();
  const double height_apart_mm = bench.calibration.eye_height_sd_mm * draws.normal();
  c.eyes.left.position_head_mm = 0.5 * Eigen::Vector3d(-ipd_mm, height_apart_mm, depth_apart_mm);
  c.eyes.right.position_head_mm = -c.eyes.left.position_head_mm;
  c.subject_scale = between(draws, 0.93, 1.07);
  // With the stage at its stop the head is left of the centre; a tracked head is near the centre.
  const double x_mm = bench.head == HeadKind::stage ? -140.0 : 0.0;
  Pose X_table_eyes = Pose::Identity();
  X_table_eyes.linear() = bench::rotation_of(bench.calibration.alignment_sd_rad * draws.normal_vector());
  X_table_eyes.translation() = Eigen::Vector3d(x_mm, 250.0, 750.0) + 10.0 * draws.normal_vector();
  c.X_table_eyes = bench::pose_parameters_of(X_table_eyes);
  truth.reference_plane_table_mm = X_table_eyes.translation().z() - between(draws, 590.0, 610.0);
}

void add_table(VirtualTruth& truth)
{
  // A tracker two and a half metres away, above the table and to one side.
  RandomSequence draws = draws_for(truth.seed, Group::table);
  truth.calibration.X_tracker_table =
      bench::pose_parameters_of(any_pose(draws, 40.0, {0.0, 0.0, -2500.0}, 200.0));
  RandomSequence rails = draws_for(truth.seed, Group::rails);
  const double off_square_rad = rad_from_deg(0.3) * rails.normal();
  truth.z_rail_table = Eigen::Vector3d(0.0, 0.0, std::sqrt(1.0 - off_square_rad * off_square_rad)) +
                       off_square_rad * Eigen::Vector3d::UnitX();
  truth.z_rail_above_mm = between(rails, 5.0, 30.0);
}

void add_leg(const BenchFile& bench, VirtualTruth& truth)
{
  RandomSequence draws = draws_for(truth.seed, Group::leg);
  Calibration& c = truth.calibration;
  // Anterior (X) towards the viewer, proximal (Y) up, about 800 mm in front of the eyes.
  Pose X_table_model = Pose::Identity();
  Eigen::Matrix3d facing;
  facing << 0, 0, -1, 0, 1, 0, 1, 0, 0;
  X_table_model.linear() = bench::rotation_of(vector_within(draws, rad_from_deg(20.0))) * facing;
  X_table_model.translation() =
      Eigen::Vector3d(0.0, c.X_table_eyes.shift_mm.y(), c.X_table_eyes.shift_mm.z() - 800.0) +
      vector_within(draws, 20.0);
  for (const BodyRole role : {BodyRole::leg, BodyRole::femur, BodyRole::tibia}) {
    const double y_mm = role == BodyRole::tibia ? 120.0 : -120.0;
    c.X_body_model[role] = bench::pose_parameters_of(any_pose(draws, 60.0, {-60.0, y_mm, 0.0}, 30.0));
  }
  const Pose X_tracker_model = bench::pose_of(c.X_tracker_table) * X_table_model;
  const auto body_at = [&](BodyRole role) -> Pose {
    return X_tracker_model * X_body_model(c, role).inverse();
  };
  truth.X_tracker_leg = body_at(bench.leg == LegKind::rigid ? BodyRole::leg : BodyRole::femur);
  truth.X_tracker_shank = body_at(BodyRole::tibia);
}

void add_tracked_things(VirtualTruth& truth)
{
  Calibration& c = truth.calibration;
  RandomSequence head = draws_for(truth.seed, Group::head);
  // The body is mounted above and in front of the eyes.
  const Pose X_headbody_eyes = any_pose(head, 30.0, {0.0, -80.0, 60.0}, 30.0);
  c.X_headbody_eyes = bench::pose_parameters_of(X_headbody_eyes);
  truth.X_tracker_headbody =
      bench::pose_of(c.X_tracker_table) * bench::pose_of(c.X_table_eyes) * X_headbody_eyes.inverse();
  RandomSequence probe = draws_for(truth.seed, Group::probe);
  truth.tip_probe_mm = Eigen::Vector3d(0.0, 0.0, -100.0) + vector_within(probe, 15.0);
}

}  // namespace

VirtualTruth virtual_truth(const BenchFile& bench, std::uint64_t seed)
{
  VirtualTruth truth;
  truth.seed = seed;
  truth.calibration = bench::nominal_calibration(bench);
  add_display(bench, false, truth);
  add_display(bench, true, truth);
  add_grid(bench, truth);
  add_person(bench, truth);
  add_table(truth);
  add_leg(bench, truth);
  add_tracked_things(truth);
  return truth;
}

VirtualJoint virtual_joint(const VirtualTruth& truth, const JointCurve& curve, const VirtualNoise& noise)
{
  // A coordinate has a third of the square; half of it in the offset, so that the variance is the same
  // everywhere.
  const double share = std::sqrt(1.0 / 6.0);
  RandomSequence draws = draws_for(truth.seed, Group::joint);
  VirtualJoint joint;
  joint.curve = scaled(curve, truth.calibration.subject_scale);
  for (VirtualJoint::Coordinates* part : {&joint.offset, &joint.by_cosine, &joint.by_sine})
    *part << share * noise.model_mm * draws.normal_vector(),
        share * rad_from_deg(noise.model_deg) * draws.normal_vector();
  return joint;
}

Pose VirtualJoint::X_femur_tibia(double flexion_rad) const
{
  constexpr double waves = 2.0;  // half a wave in 90 degrees
  const SinCos phase = sin_cos(waves * flexion_rad);
  const Coordinates off = offset + phase.cos * by_cosine + phase.sin * by_sine;
  Pose X_deviation = Pose::Identity();
  X_deviation.linear() = bench::rotation_of(off.tail<3>());
  // About the joint's centre.
  X_deviation.translation() = off.head<3>() + curve.centre_mm - X_deviation.linear() * curve.centre_mm;
  return curve.at(flexion_rad) * X_deviation;
}

const std::string& virtual_bench_text(HeadKind head)
{
  static const std::string on_a_stage = virtual_bench_toml(), tracked = [] {
    std::string text = on_a_stage;
    const auto replace = [&](const std::string& from, const std::string& to) {
      text.replace(text.find(from), from.size(), to);
    };
    replace("head = \"stage\"\n\n[board]\nport = \"/tmp/vrda-virtual-board\"\n", "head = \"tracker\"\n");
    replace("tool = \"leg\"\n", "tool = \"leg\"\n\n[body.head]\ntool = \"head\"\n");
    return text;
  }();
  return head == HeadKind::stage ? on_a_stage : tracked;
}

// Where things are, and the samples of it.

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
  return bench::pose_of(calibration.X_body_model[role]);
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
  for (const BodyRole role : bench::body_roles) {
    if (!bench.bodies[role]) continue;
    const bench::BodySettings& body = *bench.bodies[role];
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
  Eigen::Matrix<double, 6, 1> off;
  off << noise.tracker_mm * draws.normal_vector(), rad_from_deg(noise.tracker_deg) * draws.normal_vector();
  return bench::moved(X, off);
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
    const view::ShownBox& edges = truth.edges_px[line.is_right ? 1 : 0];
    for (Points2d& piece : pieces_within(with_points_between(line.points_px), edges)) {
      for (Eigen::Vector2d& point : piece) point = view::shown_px(optics, point);
      DrawnLine& part = seen.emplace_back(line);
      part.points_px = std::move(piece);
      part.is_smooth = true;  // a scan line's whole pixels are bent by the optics like the edge
    }
  }
  return seen;
}

}  // namespace vrda::calibration
