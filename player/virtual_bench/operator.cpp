#include "virtual_bench/operator.hpp"

#include <cmath>
#include <cstdlib>
#include <map>

#include "calibration/distortion_fit.hpp"
#include "calibration/viewport_fit.hpp"
#include "calibration_tasks/parts.hpp"
#include "core/error.hpp"
#include "core/units.hpp"
#include "tracking/screw.hpp"
#include "virtual_bench/alignment.hpp"
#include "virtual_bench/bench_poses.hpp"

namespace vrda::virtual_bench {
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

void press(calibration_tasks::CalibrationSession& session, navigation::Key key, bool has_shift = false,
           bool has_control = false)
{
  session.take(navigation::KeyPress{key, has_shift, has_control});
}

/// Presses for 1, 10 or 100 steps, whichever does not overshoot.
void press_towards(calibration_tasks::CalibrationSession& session, navigation::Key key, long long n_steps)
{
  press(session, key, n_steps >= 10 && n_steps < 100, n_steps >= 100);
}

void select_dial(calibration_tasks::CalibrationSession& session, std::size_t k)
{
  const std::size_t n = session.values().size();
  for (std::size_t step = 0; step < n && session.selected_dial() != k; ++step)
    press(session, navigation::Key::down);
  check(session.selected_dial() == k, "the down key must select every dial in turn");
}

/// Presses keys until dial `k` is within half a step of `wanted`, or at the limit of its range.
void set_dial(calibration_tasks::CalibrationSession& session, const calibration_tasks::Task& task,
              std::size_t k, double wanted)
{
  const bool is_selected = task.dials.size() > 2;
  if (is_selected) select_dial(session, k);
  navigation::Key up = is_selected || k == 0 ? navigation::Key::right : navigation::Key::up,
                  down = is_selected || k == 0 ? navigation::Key::left : navigation::Key::down;
  const double step = task.dials[k].step;
  constexpr int most_presses = 1000;
  for (int n = 0; n < most_presses; ++n) {
    const double before = session.values()[k];
    const long long n_steps = std::llround((wanted - before) / step);
    if (n_steps == 0) return;
    press_towards(session, n_steps > 0 ? up : down, std::llabs(n_steps));
    const double moved = session.values()[k] - before;
    if (moved == 0.0) return;
    // For crosses the up key decreases y.
    if ((moved > 0.0) != (n_steps > 0)) std::swap(up, down);
  }
  check(false, "a dial must reach the required value");
}

}  // namespace

struct VirtualOperator::Inner {
  bench_files::BenchFile bench;
  VirtualTruth truth;
  VirtualNoise noise;
  std::map<std::string, int> n_done;  ///< by part and task
  int n_refusals = 0;
  std::uint64_t n_frames = 0;  ///< of the current task
  std::int64_t time_ns = 0;
  bool is_stage_zeroed = false;

  static std::string key_of(const calibration_tasks::CalibrationSession& session)
  {
    return std::string(bench_files::name_of(session.progress().part)) + "/" + session.task()->name;
  }
  /// Index of the current task's noise; differs when the task is repeated.
  std::uint64_t draws_index(const calibration_tasks::CalibrationSession& session) const
  {
    const std::string key = key_of(session);
    const auto done = n_done.find(key);
    return number_of(key + "/" + std::to_string(done == n_done.end() ? 0 : done->second));
  }
  simulation::RandomSequence hand(const calibration_tasks::CalibrationSession& session) const
  {
    return {truth.seed, simulation::RandomPurpose::virtual_hand, draws_index(session)};
  }

  BenchPoses standing(const calibration_tasks::CalibrationSession& session) const;
  void send_frame(calibration_tasks::CalibrationSession& session, const BenchPoses& poses);
  void handle_zeroing(calibration_tasks::CalibrationSession& session);
  void zero_stage(calibration_tasks::CalibrationSession& session);
  void take_samples(calibration_tasks::CalibrationSession& session);
};

BenchPoses VirtualOperator::Inner::standing(const calibration_tasks::CalibrationSession& session) const
{
  const calibration_tasks::Task& task = *session.task();
  const int n = std::max(2, task.n_samples);
  const double way = std::min(1.0, static_cast<double>(session.progress().n_samples) / (n - 1));
  if (task.kind == calibration_tasks::TaskKind::bullseye) return bullseye_poses(bench, truth, task.index);
  if (task.kind == calibration_tasks::TaskKind::hold) {
    const bench_files::CalibrationPart part = session.progress().part;
    const bool is_tibia = part == bench_files::CalibrationPart::tibia;
    const std::vector<bench_files::CalibrationPoint>& points =
        is_tibia ? bench.calibration.tibia_points : bench.calibration.points;
    TouchedPoint touched;
    touched.role = is_tibia                                      ? bench_files::BodyRole::tibia
                   : part == bench_files::CalibrationPart::femur ? bench_files::BodyRole::femur
                                                                 : bench_files::BodyRole::leg;
    touched.index = task.index;
    touched.p_model_mm = points.at(static_cast<std::size_t>(task.index)).p_model_mm;
    touched.off_mm = noise.touch_mm * hand(session).normal_vector();
    return touch_poses(truth, touched);
  }
  if (task.kind != calibration_tasks::TaskKind::sweep) return resting_poses(truth);
  if (task.tool == bench.calibration.probe) return pivot_poses(truth, way);
  return task.name == "x rail" ? x_rail_poses(truth, way) : z_rail_poses(truth, way);
}

void VirtualOperator::Inner::send_frame(calibration_tasks::CalibrationSession& session,
                                        const BenchPoses& poses)
{
  FrameFacts facts;
  facts.time_ns = time_ns;
  facts.noise = noise;
  facts.tool = session.task()->tool;
  facts.is_stage_zeroed = is_stage_zeroed;
  facts.stage_offset_mm = facts.is_stage_zeroed ? 0.0 : stage_offset_mm;
  simulation::RandomSequence draws(truth.seed, simulation::RandomPurpose::virtual_tracker,
                                   draws_index(session) + n_frames);
  for (const devices::Sample& sample : tracker_frame(bench, truth, poses, facts, draws)) session.take(sample);
  time_ns += frame_ns;
  ++n_frames;
}

void VirtualOperator::Inner::handle_zeroing(calibration_tasks::CalibrationSession& session)
{
  if (session.take_zero_request()) is_stage_zeroed = true;
}

/// In a resumed session with a restarted board: moves the stage to its stop and presses Z. Resets the frame
/// count, so that the task's noise equals that of an uninterrupted session.
void VirtualOperator::Inner::zero_stage(calibration_tasks::CalibrationSession& session)
{
  if (session.task()->kind != calibration_tasks::TaskKind::bullseye || !calibration_tasks::has_stage(bench) ||
      is_stage_zeroed)
    return;
  send_frame(session, resting_poses(truth));
  press(session, vrda::navigation::key_of('Z'));
  handle_zeroing(session);
  n_frames = 0;
}

void VirtualOperator::Inner::take_samples(calibration_tasks::CalibrationSession& session)
{
  const std::uint64_t most_frames = 10 * static_cast<std::uint64_t>(session.task()->n_samples) + 100;
  while (session.progress().is_sampling && n_frames < most_frames) send_frame(session, standing(session));
  check(!session.progress().is_sampling, "a task must end after the required samples");
}

VirtualOperator::VirtualOperator(const bench_files::BenchFile& bench, const VirtualTruth& truth,
                                 const VirtualNoise& noise)
    : inner_(std::make_unique<Inner>())
{
  inner_->bench = bench;
  inner_->truth = truth;
  inner_->noise = noise;
}

VirtualOperator::~VirtualOperator() = default;

void VirtualOperator::do_task(calibration_tasks::CalibrationSession& session)
{
  check(session.task() != nullptr, "do_task needs a current task");
  const calibration_tasks::Task task = *session.task();
  const std::string key = Inner::key_of(session);
  constexpr int most_refusals = 20;
  if (inner_->n_done[key] > most_refusals) {
    throw InputError({inner_->bench.path, key,
                      "more than " + std::to_string(most_refusals) + " refusals: " +
                          (session.progress().messages.empty() ? "" : session.progress().messages.front()),
                      "marks that the guide accepts"});
  }
  inner_->n_frames = 0;
  inner_->zero_stage(session);
  simulation::RandomSequence hand = inner_->hand(session);
  const TaskContext asked{task, session.progress().part, session.calibration()};
  const std::vector<double> wanted = dial_values(asked, inner_->bench, inner_->truth, inner_->noise, hand);
  for (std::size_t k = 0; k < wanted.size(); ++k) set_dial(session, task, k, wanted[k]);
  const bool wants_samples = task.n_samples > 0;
  if (wants_samples || task.kind == calibration_tasks::TaskKind::stop)
    inner_->send_frame(session, inner_->standing(session));
  press(session, navigation::Key::enter);
  if (wants_samples) inner_->take_samples(session);
  inner_->handle_zeroing(session);
  ++inner_->n_done[key];
  if (session.progress().has_error) ++inner_->n_refusals;
}

int VirtualOperator::n_refusals() const
{
  return inner_->n_refusals;
}

void VirtualOperator::send_samples(calibration_tasks::CalibrationSession& session)
{
  inner_->handle_zeroing(session);
  const calibration_tasks::Task* task = session.task();
  if (task == nullptr || (task->n_samples == 0 && task->kind != calibration_tasks::TaskKind::stop)) return;
  if (session.progress().n_samples == 0 && !session.progress().is_sampling) inner_->n_frames = 0;
  inner_->send_frame(session, inner_->standing(session));
}

std::optional<double> VirtualOperator::reading(const calibration_tasks::CalibrationSession& session) const
{
  if (session.task() == nullptr) return std::nullopt;
  simulation::RandomSequence hand = inner_->hand(session);
  return simulated_reading({*session.task(), session.progress().part, session.calibration()}, inner_->bench,
                           inner_->truth, inner_->noise, hand);
}

namespace {

Eigen::Vector2d off_px(const VirtualNoise& noise, simulation::RandomSequence& draws)
{
  const double x = draws.normal(), y = draws.normal();
  return noise.alignment_px * Eigen::Vector2d(x, y);
}

std::vector<double> scan(const TaskContext& asked, const VirtualTruth& truth, const VirtualNoise& noise,
                         simulation::RandomSequence& draws)
{
  const VirtualTruth::Edges& edges = truth.edges_px[asked.task.is_right ? 1 : 0];
  const auto edge = static_cast<calibration::Edge>(asked.task.index);
  const double border_px = edge == calibration::Edge::left    ? edges.left
                           : edge == calibration::Edge::right ? edges.right
                           : edge == calibration::Edge::top   ? edges.top
                                                              : edges.bottom;
  const bool is_last = edge == calibration::Edge::right || edge == calibration::Edge::bottom;
  return {scan_reading(border_px + noise.alignment_px * draws.normal(), is_last)};
}

std::vector<double> node(const TaskContext& asked, const VirtualTruth& truth, const VirtualNoise& noise,
                         simulation::RandomSequence& draws)
{
  const Eigen::Vector2d at =
      drawn_node_px(truth, asked.task.is_right, asked.task.node) + off_px(noise, draws);
  return {at.x(), at.y()};
}

std::vector<double> sides(const TaskContext& asked, const bench_files::BenchFile& bench,
                          const VirtualTruth& truth, const VirtualNoise& noise,
                          simulation::RandomSequence& draws)
{
  const RectangleSides rectangle = rectangle_sides(bench, truth, static_cast<std::size_t>(asked.task.index));
  SideLine line;
  line.drawing = eye_of(asked.found.eyes, asked.task.is_right);
  line.row_px = line.drawing.sight_px.y();
  std::vector<double> values;
  for (const double x_mm : {rectangle.left_table_mm, rectangle.right_table_mm}) {
    values.push_back(side_value(line, truth, asked.task.is_right, {x_mm, rectangle.z_table_mm},
                                noise.alignment_px * draws.normal()));
  }
  return values;
}

/// Fits the eight grid parameters to all nodes, each with alignment noise.
std::vector<double> whole_grid(const TaskContext& asked, const bench_files::BenchFile& bench,
                               const VirtualTruth& truth, const VirtualNoise& noise,
                               simulation::RandomSequence& draws)
{
  std::vector<calibration::GridMark> marks;
  for (int row = 0; row < bench.calibration.grid_rows; ++row) {
    for (int column = 0; column < bench.calibration.grid_columns; ++column) {
      const Eigen::Vector2d at(column - 0.5 * (bench.calibration.grid_columns - 1),
                               row - 0.5 * (bench.calibration.grid_rows - 1));
      marks.push_back({at, drawn_node_px(truth, asked.task.is_right, at) + off_px(noise, draws)});
    }
  }
  const optics::Eye& drawing = eye_of(asked.found.eyes, asked.task.is_right);
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

std::vector<double> bullseye(const TaskContext& asked, const bench_files::BenchFile& bench,
                             const VirtualTruth& truth, const VirtualNoise& noise,
                             simulation::RandomSequence& draws)
{
  const BenchPoses standing = bullseye_poses(bench, truth, asked.task.index);
  const Eigen::Vector2d seen =
      optics::shown_px(eye_of(truth.calibration.eyes, asked.task.is_right),
                       standing.X_tracker_eyes.inverse() * standing.X_tracker_tool.translation());
  const Eigen::Vector2d value = cross_value(eye_of(asked.found.eyes, asked.task.is_right), truth,
                                            asked.task.is_right, seen, off_px(noise, draws));
  return {value.x(), value.y()};
}

/// Places the model on the leg to within alignment noise of marks 100 mm around, at 800 mm.
std::vector<double> place(const TaskContext& asked, const VirtualTruth& truth, const VirtualNoise& noise,
                          simulation::RandomSequence& draws)
{
  constexpr double distance_mm = 800.0, distance_px = 880.0, about_mm = 100.0;
  const bench_files::BodyRole role =
      asked.part == bench_files::CalibrationPart::leg     ? bench_files::BodyRole::leg
      : asked.part == bench_files::CalibrationPart::femur ? bench_files::BodyRole::femur
                                                          : bench_files::BodyRole::tibia;
  const double noise_mm = noise.alignment_px * distance_mm / distance_px;
  Pose X = tracking::pose_of(truth.calibration.X_body_model[static_cast<std::size_t>(role)]);
  X.translation() += noise_mm * draws.normal_vector();
  X.linear() = tracking::rotation_of(noise_mm / about_mm * draws.normal_vector()) * X.linear();
  const tracking::PoseParameters six = tracking::pose_parameters_of(X);
  std::vector<double> values(six.shift_mm.begin(), six.shift_mm.end());
  for (const double turn_rad : six.turn_rad) values.push_back(turn_rad / rad_from_deg(1.0));
  return values;
}

double size_of_screen(const TaskContext& asked, const VirtualTruth& truth, const VirtualNoise& noise,
                      simulation::RandomSequence& draws)
{
  return truth.screen_mm[asked.task.is_right ? 1 : 0][asked.task.index] + noise.ruler_mm * draws.normal();
}

double number_of_person(const TaskContext& asked, const VirtualTruth& truth, const VirtualNoise& noise,
                        simulation::RandomSequence& draws)
{
  enum Asked { pupils, left_arm, right_arm, image };
  const optics::EyePair& eyes = truth.calibration.eyes;
  switch (asked.task.index) {
    case pupils:
      return eyes.right.position_head_mm.x() - eyes.left.position_head_mm.x() +
             noise.pupillometer_mm * draws.normal();
    case left_arm:
      return -eyes.left.position_head_mm.x();
    case right_arm:
      return eyes.right.position_head_mm.x();
    default:
      check(asked.task.index == image, "unknown number of the person part");
      return truth.calibration.image_distance_mm;
  }
}

}  // namespace

std::optional<double> simulated_reading(const TaskContext& asked, const bench_files::BenchFile& bench,
                                        const VirtualTruth& truth, const VirtualNoise& noise,
                                        simulation::RandomSequence& draws)
{
  if (asked.task.kind != calibration_tasks::TaskKind::number) return std::nullopt;
  if (asked.part == bench_files::CalibrationPart::viewport) return size_of_screen(asked, truth, noise, draws);
  if (asked.part != bench_files::CalibrationPart::subject)
    return number_of_person(asked, truth, noise, draws);
  const bench_files::CalibrationLandmarks& pair =
      bench.calibration.landmarks.at(static_cast<std::size_t>(asked.task.index));
  return truth.calibration.subject_scale * pair.model_mm + noise.landmark_mm * draws.normal();
}

std::vector<double> dial_values(const TaskContext& asked, const bench_files::BenchFile& bench,
                                const VirtualTruth& truth, const VirtualNoise& noise,
                                simulation::RandomSequence& draws)
{
  switch (asked.task.kind) {
    case calibration_tasks::TaskKind::scan_line:
      return scan(asked, truth, noise, draws);
    case calibration_tasks::TaskKind::point:
      return node(asked, truth, noise, draws);
    case calibration_tasks::TaskKind::rectangle_sides:
      return sides(asked, bench, truth, noise, draws);
    case calibration_tasks::TaskKind::grid:
      return whole_grid(asked, bench, truth, noise, draws);
    case calibration_tasks::TaskKind::number:
      return {simulated_reading(asked, bench, truth, noise, draws).value()};
    case calibration_tasks::TaskKind::bullseye:
      return bullseye(asked, bench, truth, noise, draws);
    case calibration_tasks::TaskKind::model_pose:
      return place(asked, truth, noise, draws);
    case calibration_tasks::TaskKind::sweep:
    case calibration_tasks::TaskKind::hold:
    case calibration_tasks::TaskKind::stop:
    case calibration_tasks::TaskKind::depth_check:
      break;
  }
  return {};
}

}  // namespace vrda::virtual_bench
