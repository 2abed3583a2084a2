#include "virtual_bench/operator.hpp"

#include <cmath>
#include <cstdlib>
#include <map>

#include "calibration/distortion_fit.hpp"
#include "calibration/viewport_fit.hpp"
#include "core/error.hpp"
#include "core/units.hpp"
#include "guide/parts.hpp"
#include "tracking/screw.hpp"
#include "virtual_bench/alignment.hpp"
#include "virtual_bench/standing.hpp"

namespace vrda {
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

void press(GuideSession& session, Key key, bool has_shift = false, bool has_control = false)
{
  session.take(KeyPress{key, has_shift, has_control});
}

/// Presses for 1, 10 or 100 steps, whichever does not overshoot.
void press_towards(GuideSession& session, Key key, long long n_steps)
{
  press(session, key, n_steps >= 10 && n_steps < 100, n_steps >= 100);
}

void select_dial(GuideSession& session, std::size_t k)
{
  const std::size_t n = session.values().size();
  for (std::size_t step = 0; step < n && session.selected_dial() != k; ++step) press(session, Key::down);
  check(session.selected_dial() == k, "the down key must select every dial in turn");
}

/// Presses keys until dial `k` is within half a step of `wanted`, or at the limit of its range.
void set_dial(GuideSession& session, const Task& task, std::size_t k, double wanted)
{
  const bool is_selected = task.dials.size() > 2;
  if (is_selected) select_dial(session, k);
  Key up = is_selected || k == 0 ? Key::right : Key::up, down = is_selected || k == 0 ? Key::left : Key::down;
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
  BenchFile bench;
  VirtualTruth truth;
  VirtualNoise noise;
  std::map<std::string, int> n_done;  ///< by part and task
  int n_refusals = 0;
  std::uint64_t n_frames = 0;  ///< of the current task
  std::int64_t time_ns = 0;
  bool is_stage_zeroed = false;

  static std::string key_of(const GuideSession& session)
  {
    return std::string(name_of(session.progress().part)) + "/" + session.task()->name;
  }
  /// Index of the current task's noise; differs when the task is repeated.
  std::uint64_t draws_index(const GuideSession& session) const
  {
    const std::string key = key_of(session);
    const auto done = n_done.find(key);
    return number_of(key + "/" + std::to_string(done == n_done.end() ? 0 : done->second));
  }
  Draws hand(const GuideSession& session) const
  {
    return {truth.seed, DrawFor::virtual_hand, draws_index(session)};
  }

  Standing standing(const GuideSession& session) const;
  void send_frame(GuideSession& session, const Standing& poses);
  void handle_zeroing(GuideSession& session);
  void zero_stage(GuideSession& session);
  void take_samples(GuideSession& session);
};

Standing VirtualOperator::Inner::standing(const GuideSession& session) const
{
  const Task& task = *session.task();
  const int n = std::max(2, task.n_samples);
  const double way = std::min(1.0, static_cast<double>(session.progress().n_samples) / (n - 1));
  if (task.kind == TaskKind::bullseye) return at_bullseye(bench, truth, task.index);
  if (task.kind == TaskKind::hold) {
    const CalibrationPart part = session.progress().part;
    const bool is_tibia = part == CalibrationPart::tibia;
    const std::vector<CalibrationPoint>& points =
        is_tibia ? bench.calibration.tibia_points : bench.calibration.points;
    Touched touched;
    touched.role = is_tibia                         ? BodyRole::tibia
                   : part == CalibrationPart::femur ? BodyRole::femur
                                                    : BodyRole::leg;
    touched.index = task.index;
    touched.p_model_mm = points.at(static_cast<std::size_t>(task.index)).p_model_mm;
    touched.off_mm = noise.touch_mm * hand(session).normal_vector();
    return touching(truth, touched);
  }
  if (task.kind != TaskKind::sweep) return at_rest(truth);
  if (task.tool == bench.calibration.probe) return pivoting(truth, way);
  return task.name == "x rail" ? on_x_rail(truth, way) : on_z_rail(truth, way);
}

void VirtualOperator::Inner::send_frame(GuideSession& session, const Standing& poses)
{
  FrameFacts facts;
  facts.time_ns = time_ns;
  facts.noise = noise;
  facts.tool = session.task()->tool;
  facts.is_stage_zeroed = is_stage_zeroed;
  facts.stage_offset_mm = facts.is_stage_zeroed ? 0.0 : stage_offset_mm;
  Draws draws(truth.seed, DrawFor::virtual_tracker, draws_index(session) + n_frames);
  for (const Sample& sample : tracker_frame(bench, truth, poses, facts, draws)) session.take(sample);
  time_ns += frame_ns;
  ++n_frames;
}

void VirtualOperator::Inner::handle_zeroing(GuideSession& session)
{
  if (session.zeroes_stage()) is_stage_zeroed = true;
}

/// In a resumed session with a restarted board: moves the stage to its stop and presses Z. Resets the frame
/// count, so that the task's noise equals that of an uninterrupted session.
void VirtualOperator::Inner::zero_stage(GuideSession& session)
{
  if (session.task()->kind != TaskKind::bullseye || !has_stage(bench) || is_stage_zeroed) return;
  send_frame(session, at_rest(truth));
  press(session, vrda::key_of('Z'));
  handle_zeroing(session);
  n_frames = 0;
}

void VirtualOperator::Inner::take_samples(GuideSession& session)
{
  const std::uint64_t most_frames = 10 * static_cast<std::uint64_t>(session.task()->n_samples) + 100;
  while (session.progress().is_taking && n_frames < most_frames) send_frame(session, standing(session));
  check(!session.progress().is_taking, "a task must end after the required samples");
}

VirtualOperator::VirtualOperator(const BenchFile& bench, const VirtualTruth& truth, const VirtualNoise& noise)
    : inner_(std::make_unique<Inner>())
{
  inner_->bench = bench;
  inner_->truth = truth;
  inner_->noise = noise;
}

VirtualOperator::~VirtualOperator() = default;

void VirtualOperator::do_task(GuideSession& session)
{
  check(session.task() != nullptr, "do_task needs a current task");
  const Task task = *session.task();
  const std::string key = Inner::key_of(session);
  constexpr int most_refusals = 20;
  if (inner_->n_done[key] > most_refusals) {
    throw InputError({inner_->bench.path, key,
                      "more than " + std::to_string(most_refusals) + " refusals: " +
                          (session.progress().words.empty() ? "" : session.progress().words.front()),
                      "marks that the guide accepts"});
  }
  inner_->n_frames = 0;
  inner_->zero_stage(session);
  Draws hand = inner_->hand(session);
  const AskedFor asked{task, session.progress().part, session.calibration()};
  const std::vector<double> wanted = dial_values(asked, inner_->bench, inner_->truth, inner_->noise, hand);
  for (std::size_t k = 0; k < wanted.size(); ++k) set_dial(session, task, k, wanted[k]);
  const bool wants_samples = task.n_samples > 0;
  if (wants_samples || task.kind == TaskKind::stop) inner_->send_frame(session, inner_->standing(session));
  press(session, Key::enter);
  if (wants_samples) inner_->take_samples(session);
  inner_->handle_zeroing(session);
  ++inner_->n_done[key];
  if (session.progress().is_refused) ++inner_->n_refusals;
}

int VirtualOperator::n_refusals() const
{
  return inner_->n_refusals;
}

void VirtualOperator::send_samples(GuideSession& session)
{
  inner_->handle_zeroing(session);
  const Task* task = session.task();
  if (task == nullptr || (task->n_samples == 0 && task->kind != TaskKind::stop)) return;
  if (session.progress().n_samples == 0 && !session.progress().is_taking) inner_->n_frames = 0;
  inner_->send_frame(session, inner_->standing(session));
}

std::optional<double> VirtualOperator::reading(const GuideSession& session) const
{
  if (session.task() == nullptr) return std::nullopt;
  Draws hand = inner_->hand(session);
  return number_read({*session.task(), session.progress().part, session.calibration()}, inner_->bench,
                     inner_->truth, inner_->noise, hand);
}

namespace {

Eigen::Vector2d off_px(const VirtualNoise& noise, Draws& draws)
{
  const double x = draws.normal(), y = draws.normal();
  return noise.alignment_px * Eigen::Vector2d(x, y);
}

std::vector<double> scan(const AskedFor& asked, const VirtualTruth& truth, const VirtualNoise& noise,
                         Draws& draws)
{
  const VirtualTruth::Edges& edges = truth.edges_px[asked.task.is_right ? 1 : 0];
  const auto edge = static_cast<Edge>(asked.task.index);
  const double border_px = edge == Edge::left    ? edges.left
                           : edge == Edge::right ? edges.right
                           : edge == Edge::top   ? edges.top
                                                 : edges.bottom;
  const bool is_last = edge == Edge::right || edge == Edge::bottom;
  return {scan_reading(border_px + noise.alignment_px * draws.normal(), is_last)};
}

std::vector<double> node(const AskedFor& asked, const VirtualTruth& truth, const VirtualNoise& noise,
                         Draws& draws)
{
  const Eigen::Vector2d at =
      drawn_node_px(truth, asked.task.is_right, asked.task.node) + off_px(noise, draws);
  return {at.x(), at.y()};
}

std::vector<double> sides(const AskedFor& asked, const BenchFile& bench, const VirtualTruth& truth,
                          const VirtualNoise& noise, Draws& draws)
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
std::vector<double> whole_grid(const AskedFor& asked, const BenchFile& bench, const VirtualTruth& truth,
                               const VirtualNoise& noise, Draws& draws)
{
  std::vector<GridMark> marks;
  for (int row = 0; row < bench.calibration.grid_rows; ++row) {
    for (int column = 0; column < bench.calibration.grid_columns; ++column) {
      const Eigen::Vector2d at(column - 0.5 * (bench.calibration.grid_columns - 1),
                               row - 0.5 * (bench.calibration.grid_rows - 1));
      marks.push_back({at, drawn_node_px(truth, asked.task.is_right, at) + off_px(noise, draws)});
    }
  }
  const Eye& drawing = eye_of(asked.found.eyes, asked.task.is_right);
  constexpr double held = 1e-6;
  const DistortionFit fit =
      fit_distortion(marks, drawing, {drawing.pixel_aspect, held}, "grid", "virtual bench");
  return {fit.distortion.k1,
          fit.distortion.k2,
          fit.distortion.centre_px.x(),
          fit.distortion.centre_px.y(),
          fit.grid.at_px.x(),
          fit.grid.at_px.y(),
          fit.grid.spacing_px,
          fit.grid.turn_rad / rad_from_deg(1.0)};
}

std::vector<double> bullseye(const AskedFor& asked, const BenchFile& bench, const VirtualTruth& truth,
                             const VirtualNoise& noise, Draws& draws)
{
  const Standing standing = at_bullseye(bench, truth, asked.task.index);
  const Eigen::Vector2d seen =
      shown_px(eye_of(truth.calibration.eyes, asked.task.is_right),
               standing.X_tracker_eyes.inverse() * standing.X_tracker_tool.translation());
  const Eigen::Vector2d value = cross_value(eye_of(asked.found.eyes, asked.task.is_right), truth,
                                            asked.task.is_right, seen, off_px(noise, draws));
  return {value.x(), value.y()};
}

/// Places the model on the leg to within alignment noise of marks 100 mm around, at 800 mm.
std::vector<double> place(const AskedFor& asked, const VirtualTruth& truth, const VirtualNoise& noise,
                          Draws& draws)
{
  constexpr double distance_mm = 800.0, distance_px = 880.0, about_mm = 100.0;
  const BodyRole role = asked.part == CalibrationPart::leg     ? BodyRole::leg
                        : asked.part == CalibrationPart::femur ? BodyRole::femur
                                                               : BodyRole::tibia;
  const double noise_mm = noise.alignment_px * distance_mm / distance_px;
  Pose X = pose_of(truth.calibration.X_body_model[static_cast<std::size_t>(role)]);
  X.translation() += noise_mm * draws.normal_vector();
  X.linear() = rotation_of(noise_mm / about_mm * draws.normal_vector()) * X.linear();
  const SixNumbers six = six_numbers_of(X);
  std::vector<double> values(six.shift_mm.begin(), six.shift_mm.end());
  for (const double turn_rad : six.turn_rad) values.push_back(turn_rad / rad_from_deg(1.0));
  return values;
}

double size_of_screen(const AskedFor& asked, const VirtualTruth& truth, const VirtualNoise& noise,
                      Draws& draws)
{
  return truth.screen_mm[asked.task.is_right ? 1 : 0][asked.task.index] + noise.ruler_mm * draws.normal();
}

double number_of_person(const AskedFor& asked, const VirtualTruth& truth, const VirtualNoise& noise,
                        Draws& draws)
{
  enum Asked { pupils, left_arm, right_arm, image };
  const EyePair& eyes = truth.calibration.eyes;
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

std::optional<double> number_read(const AskedFor& asked, const BenchFile& bench, const VirtualTruth& truth,
                                  const VirtualNoise& noise, Draws& draws)
{
  if (asked.task.kind != TaskKind::number) return std::nullopt;
  if (asked.part == CalibrationPart::viewport) return size_of_screen(asked, truth, noise, draws);
  if (asked.part != CalibrationPart::subject) return number_of_person(asked, truth, noise, draws);
  const CalibrationLandmarks& pair =
      bench.calibration.landmarks.at(static_cast<std::size_t>(asked.task.index));
  return truth.calibration.subject_scale * pair.model_mm + noise.landmark_mm * draws.normal();
}

std::vector<double> dial_values(const AskedFor& asked, const BenchFile& bench, const VirtualTruth& truth,
                                const VirtualNoise& noise, Draws& draws)
{
  switch (asked.task.kind) {
    case TaskKind::scan_line:
      return scan(asked, truth, noise, draws);
    case TaskKind::point:
      return node(asked, truth, noise, draws);
    case TaskKind::sides:
      return sides(asked, bench, truth, noise, draws);
    case TaskKind::grid:
      return whole_grid(asked, bench, truth, noise, draws);
    case TaskKind::number:
      return {number_read(asked, bench, truth, noise, draws).value()};
    case TaskKind::bullseye:
      return bullseye(asked, bench, truth, noise, draws);
    case TaskKind::place:
      return place(asked, truth, noise, draws);
    case TaskKind::sweep:
    case TaskKind::hold:
    case TaskKind::stop:
    case TaskKind::look:
      break;
  }
  return {};
}

}  // namespace vrda
