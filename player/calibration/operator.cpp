#include "calibration/operator.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <map>

#include "bench/rigid_body.hpp"
#include "calibration/bench_poses.hpp"
#include "calibration/distortion_fit.hpp"
#include "calibration/eyepoint_fit.hpp"
#include "calibration/parts.hpp"
#include "calibration/statistics.hpp"
#include "core/text.hpp"
#include "core/units.hpp"

namespace vrda::calibration {
namespace {

constexpr std::int64_t frame_ns = 16'666'667;
/// Offset of the encoder before it is zeroed.
constexpr double stage_offset_mm = 37.0;

/// FNV-1a; makes noise depend on the task only, not on earlier tasks.
std::uint64_t number_of(const std::string& text)
{
  std::uint64_t hash = 14695981039346656037ULL;
  for (const char c : text) hash = (hash ^ static_cast<unsigned char>(c)) * 1099511628211ULL;
  return hash;
}

void press(CalibrationSession& session, view::Key key, bool has_shift = false, bool has_control = false)
{
  session.take(view::KeyPress{key, has_shift, has_control});
}

/// Presses for 1, 10 or 100 steps, whichever does not overshoot.
void press_towards(CalibrationSession& session, view::Key key, long long n_steps)
{
  press(session, key, n_steps >= 10 && n_steps < 100, n_steps >= 100);
}

void select_dial(CalibrationSession& session, std::size_t k)
{
  const std::size_t n = session.values().size();
  for (std::size_t step = 0; step < n && session.selected_dial() != k; ++step)
    press(session, view::Key::down);
  check(session.selected_dial() == k, "the down key must select every dial in turn");
}

/// Presses keys until dial `k` is within half a step of `wanted`, or at the limit of its range. Whether a key
/// was needed.
bool set_dial(CalibrationSession& session, const Task& task, std::size_t k, double wanted)
{
  const bool is_selected = task.dials.size() > 2;
  if (is_selected) select_dial(session, k);
  view::Key up = is_selected || k == 0 ? view::Key::right : view::Key::up,
            down = is_selected || k == 0 ? view::Key::left : view::Key::down;
  const double step = task.dials[k].step;
  constexpr int most_presses = 1000;
  for (int n = 0; n < most_presses; ++n) {
    const double before = session.values()[k];
    const long long n_steps = std::llround((wanted - before) / step);
    if (n_steps == 0) return n > 0;
    press_towards(session, n_steps > 0 ? up : down, std::llabs(n_steps));
    const double moved = session.values()[k] - before;
    if (moved == 0.0) return true;
    // For crosses the up key decreases y.
    if ((moved > 0.0) != (n_steps > 0)) std::swap(up, down);
  }
  throw InternalError("a dial must reach the required value");
}

/// A step and back: a dial that is right as it is must be touched, or the reading is refused.
void touch_dial(CalibrationSession& session, const Task& task, std::size_t k)
{
  const double wanted = session.values()[k];
  const double step = task.dials[k].step;
  set_dial(session, task, k, wanted + step <= task.dials[k].maximum ? wanted + step : wanted - step);
  set_dial(session, task, k, wanted);
}

std::string key_of(const CalibrationSession& session)
{
  return std::string(bench::name_of(session.progress().part)) + "/" + session.task()->name;
}

/// The current task, and with what it is done.
struct TaskContext {
  const Task& task;
  CalibrationPart part;
  const Calibration& found;  ///< found so far, used for drawing
  const BenchFile& bench;
  const VirtualTruth& truth;
  const VirtualNoise& noise;
  RandomSequence& draws;
};

Eigen::Vector2d off_px(const TaskContext& context)
{
  const double x = context.draws.normal(), y = context.draws.normal();
  return context.noise.alignment_px * Eigen::Vector2d(x, y);
}

std::vector<double> scan(const TaskContext& context)
{
  const VirtualTruth::Edges& edges = context.truth.edges_px[context.task.is_right ? 1 : 0];
  const auto edge = static_cast<calibration::Edge>(context.task.index);
  const double border_px = edge == calibration::Edge::left    ? edges.left
                           : edge == calibration::Edge::right ? edges.right
                           : edge == calibration::Edge::top   ? edges.top
                                                              : edges.bottom;
  const bool is_last = edge == calibration::Edge::right || edge == calibration::Edge::bottom;
  return {scan_reading(border_px + context.noise.alignment_px * context.draws.normal(), is_last)};
}

std::vector<double> node(const TaskContext& context)
{
  const Eigen::Vector2d at =
      drawn_node_px(context.truth, context.task.is_right, context.task.node) + off_px(context);
  return {at.x(), at.y()};
}

std::vector<double> sides(const TaskContext& context)
{
  const RectangleSides rectangle =
      rectangle_sides(context.bench, context.truth, static_cast<std::size_t>(context.task.index));
  SideLine line;
  line.drawing = view::side_of(context.found.eyes, context.task.is_right);
  line.row_px = line.drawing.sight_px.y();
  std::vector<double> values;
  for (const double x_mm : {rectangle.left_table_mm, rectangle.right_table_mm}) {
    values.push_back(side_value(line, context.truth, context.task.is_right, {x_mm, rectangle.z_table_mm},
                                context.noise.alignment_px * context.draws.normal()));
  }
  return values;
}

/// Fits the eight grid parameters to all nodes, each with alignment noise.
std::vector<double> whole_grid(const TaskContext& context)
{
  std::vector<calibration::GridMark> marks;
  for (int row = 0; row < context.bench.calibration.grid_rows; ++row) {
    for (int column = 0; column < context.bench.calibration.grid_columns; ++column) {
      const Eigen::Vector2d at(column - 0.5 * (context.bench.calibration.grid_columns - 1),
                               row - 0.5 * (context.bench.calibration.grid_rows - 1));
      marks.push_back({at, drawn_node_px(context.truth, context.task.is_right, at) + off_px(context)});
    }
  }
  const view::Eye& drawing = view::side_of(context.found.eyes, context.task.is_right);
  constexpr double held = 1e-6;
  const calibration::DistortionFit fit =
      calibration::fit_distortion(marks, drawing, {drawing.pixel_aspect, held}, "grid", "virtual bench");
  return {fit.distortion.k1,
          fit.distortion.k2,
          fit.distortion.centre_px.x(),
          fit.distortion.centre_px.y(),
          fit.grid.origin_px.x(),
          fit.grid.origin_px.y(),
          fit.grid.spacing_px,
          fit.grid.turn_rad / rad_from_deg(1.0)};
}

std::vector<double> bullseye(const TaskContext& context)
{
  const BenchPoses standing = bullseye_poses(context.bench, context.truth, context.task.index);
  const Eigen::Vector2d seen =
      view::shown_px(view::side_of(context.truth.calibration.eyes, context.task.is_right),
                     standing.X_tracker_eyes.inverse() * standing.X_tracker_tool.translation());
  const Eigen::Vector2d value = cross_value(view::side_of(context.found.eyes, context.task.is_right),
                                            context.truth, context.task.is_right, seen, off_px(context));
  return {value.x(), value.y()};
}

/// Places the model on the leg to within alignment context.noise of marks 100 mm around, at 800 mm.
std::vector<double> place(const TaskContext& context)
{
  constexpr double distance_mm = 800.0, distance_px = 880.0, about_mm = 100.0;
  const BodyRole role = calibration::role_of(context.part);
  const double noise_mm = context.noise.alignment_px * distance_mm / distance_px;
  Pose X = bench::pose_of(context.truth.calibration.X_body_model[static_cast<std::size_t>(role)]);
  X.translation() += noise_mm * context.draws.normal_vector();
  X.linear() = bench::rotation_of(noise_mm / about_mm * context.draws.normal_vector()) * X.linear();
  const bench::PoseParameters six = bench::pose_parameters_of(X);
  std::vector<double> values(six.shift_mm.begin(), six.shift_mm.end());
  for (const double turn_rad : six.turn_rad) values.push_back(turn_rad / rad_from_deg(1.0));
  return values;
}

double size_of_screen(const TaskContext& context)
{
  return context.truth.screen_mm[context.task.is_right ? 1 : 0][context.task.index] +
         context.noise.ruler_mm * context.draws.normal();
}

double number_of_person(const TaskContext& context)
{
  enum { pupils, left_arm, right_arm, image };
  const view::EyePair& eyes = context.truth.calibration.eyes;
  switch (context.task.index) {
    case pupils:
      return eyes.right.position_head_mm.x() - eyes.left.position_head_mm.x() +
             context.noise.pupillometer_mm * context.draws.normal();
    case left_arm:
      return -eyes.left.position_head_mm.x();
    case right_arm:
      return eyes.right.position_head_mm.x();
    default:
      check(context.task.index == image, "unknown number of the person part");
      return context.truth.calibration.image_distance_mm;
  }
}

/// Reading of a ruler, tape or pupillometer; nullopt if the task requires no number.
std::optional<double> simulated_reading(const TaskContext& context)
{
  if (context.task.kind != TaskKind::number) return std::nullopt;
  if (context.part == CalibrationPart::viewport) return size_of_screen(context);
  if (context.part != CalibrationPart::subject) return number_of_person(context);
  const bench::CalibrationLandmarks& pair =
      context.bench.calibration.landmarks.at(static_cast<std::size_t>(context.task.index));
  return context.truth.calibration.subject_scale * pair.model_mm +
         context.noise.landmark_mm * context.draws.normal();
}

/// Dial values at which everything appears aligned, in the order and units of the dials; empty if the task
/// has none.
std::vector<double> dial_values(const TaskContext& context)
{
  switch (context.task.kind) {
    case TaskKind::scan_line:
      return scan(context);
    case TaskKind::point:
      return node(context);
    case TaskKind::rectangle_sides:
      return sides(context);
    case TaskKind::grid:
      return whole_grid(context);
    case TaskKind::number:
      return {simulated_reading(context).value()};
    case TaskKind::bullseye:
      return bullseye(context);
    case TaskKind::model_pose:
      return place(context);
    case TaskKind::sweep:
    case TaskKind::bend:
    case TaskKind::hold:
    case TaskKind::stop:
    case TaskKind::depth_check:
      break;
  }
  return {};
}

/// Of the nodes drawn by the dials from where the true grid needs them.
double grid_deviation_px(const TaskContext& context, std::span<const double> v)
{
  view::Distortion dialled = view::side_of(context.found.eyes, context.task.is_right).distortion;
  const double aspect = view::side_of(context.found.eyes, context.task.is_right).pixel_aspect;
  dialled.k1 = v[0];
  dialled.k2 = v[1];
  dialled.centre_px = {v[2], v[3]};
  const calibration::GridPose grid{{v[4], v[5]}, v[6], rad_from_deg(v[7])};
  double sum_sq = 0.0;
  int n = 0;
  for (int row = 0; row < context.bench.calibration.grid_rows; ++row) {
    for (int column = 0; column < context.bench.calibration.grid_columns; ++column, ++n) {
      const Eigen::Vector2d at(column - 0.5 * (context.bench.calibration.grid_columns - 1),
                               row - 0.5 * (context.bench.calibration.grid_rows - 1));
      sum_sq += (view::drawn_px(dialled, calibration::shown_px(grid, aspect, at)) -
                 drawn_node_px(context.truth, context.task.is_right, at))
                    .squaredNorm();
    }
  }
  return std::sqrt(sum_sq / n);
}

double model_deviation_mm(const TaskContext& context, std::span<const double> v)
{
  const Pose X = bench::pose_of(
      bench::PoseParameters{{v[0], v[1], v[2]}, Eigen::Vector3d(v[3], v[4], v[5]) * rad_from_deg(1.0)});
  const BodyRole role = calibration::role_of(context.part);
  const Pose X_true = bench::pose_of(context.truth.calibration.X_body_model[static_cast<std::size_t>(role)]);
  const std::vector<CalibrationPoint>& points =
      calibration::points_of(context.part, context.bench.calibration);
  double sum_sq = 0.0;
  for (const CalibrationPoint& point : points) {
    const Eigen::Vector3d p_mm = context.truth.calibration.subject_scale * point.p_model_mm;
    sum_sq += (X * p_mm - X_true * p_mm).squaredNorm();
  }
  return std::sqrt(sum_sq / static_cast<double>(points.size()));
}

/// A reading names the first visible column or row, or the last one, whose far side is the border.
double scan_deviation_px(const TaskContext& context, double value)
{
  const VirtualTruth::Edges& e = context.truth.edges_px[context.task.is_right ? 1 : 0];
  const std::array<double, calibration::n_edges> borders{e.left, e.right, e.top, e.bottom};
  const auto edge = static_cast<calibration::Edge>(context.task.index);
  const bool is_last = edge == calibration::Edge::right || edge == calibration::Edge::bottom;
  return std::abs(value + (is_last ? 1.0 : 0.0) - borders.at(static_cast<std::size_t>(edge)));
}

}  // namespace

/// Index of the current task's noise; differs when the task is repeated.
std::uint64_t VirtualOperator::draws_index(const CalibrationSession& session) const
{
  const std::string key = key_of(session);
  const auto done = n_done_.find(key);
  return number_of(key + "/" + std::to_string(done == n_done_.end() ? 0 : done->second));
}

RandomSequence VirtualOperator::hand(const CalibrationSession& session) const
{
  return {truth_.seed, bench::RandomPurpose::virtual_hand, draws_index(session)};
}

BenchPoses VirtualOperator::standing(const CalibrationSession& session) const
{
  const int n = std::max(2, session.task()->n_samples);
  return poses(session, std::min(1.0, static_cast<double>(session.progress().n_samples) / (n - 1)));
}

BenchPoses VirtualOperator::poses(const CalibrationSession& session, double way) const
{
  const Task& task = *session.task();
  if (task.kind == TaskKind::bullseye) return bullseye_poses(bench_, truth_, task.index);
  if (task.kind == TaskKind::bend) return bend_poses(truth_, task.index, way);
  if (task.kind == TaskKind::hold) {
    const CalibrationPart part = session.progress().part;
    TouchedPoint touched;
    touched.role = calibration::role_of(part);
    touched.index = task.index;
    touched.p_model_mm =
        calibration::points_of(part, bench_.calibration).at(static_cast<std::size_t>(task.index)).p_model_mm;
    touched.off_mm = noise_.touch_mm * hand(session).normal_vector();
    return touch_poses(truth_, touched);
  }
  if (task.kind != TaskKind::sweep) return resting_poses(truth_);
  if (task.tool == bench_.calibration.probe) return pivot_poses(truth_, way);
  return task.name == "x rail" ? x_rail_poses(truth_, way) : z_rail_poses(truth_, way);
}

std::vector<bench::Sample> VirtualOperator::samples(const CalibrationSession& session,
                                                    const BenchPoses& poses, std::uint64_t frame) const
{
  FrameFacts facts;
  facts.time_ns = time_ns_;
  facts.noise = noise_;
  facts.tool = session.task()->tool;
  facts.is_stage_zeroed = is_stage_zeroed_;
  facts.stage_offset_mm = facts.is_stage_zeroed ? 0.0 : stage_offset_mm;
  RandomSequence draws(truth_.seed, bench::RandomPurpose::virtual_tracker, draws_index(session) + frame);
  return tracker_frame(bench_, truth_, poses, facts, draws);
}

void VirtualOperator::send_frame(CalibrationSession& session, const BenchPoses& poses)
{
  for (const bench::Sample& sample : samples(session, poses, n_frames_)) session.take(sample);
  time_ns_ += frame_ns;
  ++n_frames_;
}

void VirtualOperator::handle_zeroing(CalibrationSession& session)
{
  if (session.take_zero_request()) is_stage_zeroed_ = true;
}

/// In a resumed session with a restarted board: moves the stage to its stop and presses Z. Resets the frame
/// count, so that the task's noise_ equals that of an uninterrupted session.
void VirtualOperator::zero_stage(CalibrationSession& session)
{
  if (session.task()->kind != TaskKind::bullseye || !calibration::has_stage(bench_) || is_stage_zeroed_)
    return;
  send_frame(session, resting_poses(truth_));
  press(session, vrda::view::key_of('Z'));
  handle_zeroing(session);
  n_frames_ = 0;
}

void VirtualOperator::take_samples(CalibrationSession& session)
{
  const std::uint64_t most_frames = 10 * static_cast<std::uint64_t>(session.task()->n_samples) + 100;
  while (session.progress().is_sampling && n_frames_ < most_frames) send_frame(session, standing(session));
  check(!session.progress().is_sampling, "a task must end after the required samples");
}

void VirtualOperator::do_task(CalibrationSession& session)
{
  check(session.task() != nullptr, "do_task needs a current task");
  const Task task = *session.task();
  const std::string key = key_of(session);
  constexpr int most_refusals = 20;
  if (n_done_[key] > most_refusals) {
    throw InputError({bench_.path, key,
                      "more than " + std::to_string(most_refusals) + " refusals: " +
                          (session.progress().messages.empty() ? "" : session.progress().messages.front()),
                      "marks that the calibration accepts"});
  }
  n_frames_ = 0;
  zero_stage(session);
  RandomSequence draws = hand(session);
  const TaskContext context{task, session.progress().part, session.calibration(), bench_, truth_, noise_,
                            draws};
  const std::vector<double> wanted = dial_values(context);
  std::size_t n_moved = 0;
  for (std::size_t k = 0; k < wanted.size(); ++k) {
    const bool is_moved = set_dial(session, task, k, wanted[k]);
    if (!is_moved && task.kind == TaskKind::rectangle_sides) touch_dial(session, task, k);
    n_moved += is_moved ? 1 : 0;
  }
  if (!wanted.empty() && n_moved == 0) touch_dial(session, task, 0);
  const bool wants_samples = task.n_samples > 0;
  if (wants_samples || task.kind == TaskKind::stop) send_frame(session, standing(session));
  press(session, view::Key::enter);
  if (wants_samples) take_samples(session);
  handle_zeroing(session);
  ++n_done_[key];
  if (session.progress().has_error) ++n_refusals_;
}

void VirtualOperator::send_samples(CalibrationSession& session)
{
  handle_zeroing(session);
  const Task* task = session.task();
  if (task == nullptr || (task->n_samples == 0 && task->kind != TaskKind::stop)) return;
  if (session.progress().n_samples == 0 && !session.progress().is_sampling) n_frames_ = 0;
  send_frame(session, standing(session));
}

std::optional<double> VirtualOperator::reading(const CalibrationSession& session) const
{
  if (session.task() == nullptr) return std::nullopt;
  RandomSequence draws = hand(session);
  return simulated_reading(
      {*session.task(), session.progress().part, session.calibration(), bench_, truth_, noise_, draws});
}

std::vector<double> VirtualOperator::aligned_values(const CalibrationSession& session) const
{
  RandomSequence draws = hand(session);
  return dial_values(
      {*session.task(), session.progress().part, session.calibration(), bench_, truth_, noise_, draws});
}

std::optional<VirtualOperator::Deviation> VirtualOperator::deviation(const CalibrationSession& session) const
{
  if (session.task() == nullptr || session.task()->dials.empty()) return std::nullopt;
  constexpr VirtualNoise none{0, 0, 0, 0, 0, 0, 0, 0, 0};
  RandomSequence draws = hand(session);
  const TaskContext context{
      *session.task(), session.progress().part, session.calibration(), bench_, truth_, none, draws};
  const std::span<const double> values = session.values();
  if (context.task.kind == TaskKind::scan_line) return Deviation{scan_deviation_px(context, values[0]), "px"};
  if (context.task.kind == TaskKind::grid) return Deviation{grid_deviation_px(context, values), "px"};
  if (context.task.kind == TaskKind::model_pose) return Deviation{model_deviation_mm(context, values), "mm"};
  const std::vector<double> wanted = dial_values(context);
  // Of a cross the distance, of two lines the larger one.
  const bool is_cross = context.task.kind == TaskKind::point || context.task.kind == TaskKind::bullseye;
  double value = 0.0;
  for (std::size_t k = 0; k < wanted.size(); ++k) {
    const double off = std::abs(values[k] - wanted[k]);
    value = is_cross ? std::hypot(value, off) : std::max(value, off);
  }
  return Deviation{value, context.task.dials.front().unit};
}

}  // namespace vrda::calibration
