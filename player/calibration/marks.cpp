#include "calibration/marks.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>

#include "bench/devices.hpp"
#include "calibration/eyepoint_fit.hpp"
#include "calibration/solve_part.hpp"
#include "core/text.hpp"
#include "core/units.hpp"
#include "show/session.hpp"

namespace vrda::calibration {
namespace {

/// Row lengths of a task kind.
struct RowShape {
  std::size_t first = 0;         ///< length of the first row
  std::vector<std::size_t> all;  ///< allowed lengths of the other rows
};

const RowShape& shape_of(TaskKind kind)
{
  using enum TaskKind;
  static const std::map<TaskKind, RowShape> shapes{
      {scan_line, {1, {}}},       {number, {1, {}}},  {stop, {1, {}}},          {point, {2, {}}},
      {rectangle_sides, {4, {}}}, {grid, {8, {}}},    {model_pose, {6, {}}},    {depth_check, {0, {}}},
      {sweep, {0, {7, 8}}},       {hold, {14, {14}}}, {bullseye, {3, {3, 10}}}, {bend, {14, {14}}}};
  return shapes.at(kind);
}

bool is_of_shape(const CalibrationMark& mark, TaskKind kind)
{
  const RowShape& shape = shape_of(kind);
  if (mark.rows.empty() || (shape.all.empty() && mark.rows.size() != 1)) return false;
  for (std::size_t k = 0; k < mark.rows.size(); ++k) {
    const std::size_t n = mark.rows[k].size();
    const bool is_first = k == 0 && kind != TaskKind::sweep;
    if (is_first ? n != shape.first : std::ranges::find(shape.all, n) == shape.all.end()) return false;
  }
  // A bull's-eye has the cross in row 0, then at least one sample.
  return kind != TaskKind::bullseye || mark.rows.size() > 1;
}

std::ptrdiff_t index_of_task(const std::vector<Task>& tasks, const std::string& name)
{
  const auto found = std::ranges::find(tasks, name, &Task::name);
  return found - tasks.begin();
}

}  // namespace

const CalibrationMark* find_mark(const CalibrationRecord& record, const std::string& task)
{
  const auto found = std::ranges::find(record.marks, task, &CalibrationMark::task);
  return found == record.marks.end() ? nullptr : &*found;
}

std::size_t next_task(const std::vector<Task>& tasks, const CalibrationRecord& record)
{
  std::size_t at = 0;
  while (at < tasks.size() && find_mark(record, tasks[at].name) != nullptr) ++at;
  return at;
}

void insert_mark(CalibrationRecord& record, const std::vector<Task>& tasks, CalibrationMark mark)
{
  std::erase_if(record.marks, [&](const CalibrationMark& m) { return m.task == mark.task; });
  const std::ptrdiff_t at = index_of_task(tasks, mark.task);
  const auto later = std::ranges::find_if(
      record.marks, [&](const CalibrationMark& m) { return index_of_task(tasks, m.task) > at; });
  record.marks.insert(later, std::move(mark));
}

void require_task_marks(const CalibrationRecord& record, const std::vector<Task>& tasks,
                        const std::string& place, const std::string& path)
{
  for (const CalibrationMark& mark : record.marks) {
    const auto at = static_cast<std::size_t>(index_of_task(tasks, mark.task));
    if (at == tasks.size()) {
      throw InputError({path, place, "a mark of '" + mark.task + "', which is not a task of the bench file",
                        "marks of its tasks; if [calibration] has changed, repeat the part with --anew"});
    }
    if (!is_of_shape(mark, tasks[at].kind)) {
      throw InputError({path, place, "rows of '" + mark.task + "' with a wrong number of values",
                        "rows as in schemas/calibration.md; repeat the part with --anew"});
    }
  }
}

Pose sampled_pose(std::span<const double> row, std::size_t at)
{
  bench::ToolPose place;
  std::copy_n(row.begin() + static_cast<std::ptrdiff_t>(at), 3, place.position_mm);
  std::copy_n(row.begin() + static_cast<std::ptrdiff_t>(at) + 3, 4, place.rotation);
  return bench::pose_of(place);
}

Eigen::Vector3d sampled_position(std::span<const double> row)
{
  return {row[0], row[1], row[2]};
}

namespace {

void put_aspect(view::Eye& eye, double aspect)
{
  eye.pixel_aspect = eye.distortion.pixel_aspect = aspect;
}

void put_viewport(view::Eye& eye, const std::string& name, const bench::Estimate& found)
{
  const auto edge = [&](const char* which) { return value_in(found, name + ".edge_" + which); };
  const Eigen::Vector2d low(edge("left"), edge("top")), high(edge("right"), edge("bottom"));
  const auto whole = [](double x) { return static_cast<int>(std::lround(x)); };
  eye.visible = {whole(low.x()), whole(low.y()), whole(high.x()) - whole(low.x()),
                 whole(high.y()) - whole(low.y())};
  put_aspect(eye, value_in(found, name + ".pixel_aspect"));
  eye.sight_px = 0.5 * (low + high);
  if (eye.distortion.k1 == 0.0 && eye.distortion.k2 == 0.0) eye.distortion.centre_px = eye.sight_px;
}

void put_distortion(view::Eye& eye, const std::string& name, const bench::Estimate& found)
{
  const auto value = [&](const char* which) { return value_in(found, name + which); };
  eye.distortion.k1 = value(".k1");
  eye.distortion.k2 = value(".k2");
  eye.distortion.centre_px = {value(".centre_x"), value(".centre_y")};
  eye.distortion.unit_px = 0.5 * eye.window.width;
  put_aspect(eye, value(".pixel_aspect"));
}

void put_eyepoints(view::EyePair& eyes, const bench::Estimate& found)
{
  eyes.left.distance_px = value_in(found, "left.distance");
  eyes.right.distance_px = value_in(found, "right.distance");
  // The origin of the head frame stays at the midpoint; the eye with the larger depth is further back.
  const double apart_mm = value_in(found, "left.depth") - value_in(found, "right.depth");
  eyes.left.position_head_mm.z() = 0.5 * apart_mm;
  eyes.right.position_head_mm.z() = -0.5 * apart_mm;
}

}  // namespace

const char* side_name(bool is_right)
{
  return is_right ? "right" : "left";
}

std::vector<std::string> distortion_names(bool is_right)
{
  std::vector<std::string> names = bench::shared_estimate_names(CalibrationPart::distortion);
  std::erase_if(names, [&](const std::string& name) { return !name.starts_with(side_name(is_right)); });
  return names;
}

double value_in(const bench::Estimate& estimate, const std::string& name)
{
  const Eigen::Index k = bench::index_of(estimate, name);
  check(k >= 0, "an estimate has the numbers of its part");
  return estimate.values[k];
}

Pose pose_in(const bench::Estimate& estimate, const std::string& name)
{
  Eigen::Matrix<double, 6, 1> six;
  Eigen::Index k = 0;
  for (const std::string& number : bench::pose_number_names(name)) six[k++] = value_in(estimate, number);
  return bench::pose_of(bench::PoseParameters{six.head<3>(), six.tail<3>() * rad_from_deg(1.0)});
}

void apply_estimate(view::EyePair& eyes, CalibrationPart part, const bench::Estimate& found)
{
  for (const bool is_right : {false, true}) {
    view::Eye& eye = view::side_of(eyes, is_right);
    if (part == CalibrationPart::viewport) put_viewport(eye, side_name(is_right), found);
    if (part == CalibrationPart::distortion) put_distortion(eye, side_name(is_right), found);
  }
  if (part == CalibrationPart::eyepoints) put_eyepoints(eyes, found);
  if (part == CalibrationPart::ipd) view::set_ipd(eyes, value_in(found, "ipd"));
}

view::EyePair eyes_before(CalibrationPart part, const PartInput& in)
{
  view::EyePair eyes = bench::nominal_calibration(in.bench).eyes;
  for (const CalibrationPart earlier : {CalibrationPart::viewport, CalibrationPart::distortion,
                                        CalibrationPart::eyepoints, CalibrationPart::ipd}) {
    const bench::Estimate* estimate = find_estimate(in.begun, earlier);
    if (earlier < part && estimate != nullptr) apply_estimate(eyes, earlier, *estimate);
  }
  return eyes;
}

const CalibrationRecord* find_record(const Calibration& calibration, CalibrationPart part)
{
  const auto found = calibration.records.find(part);
  return found == calibration.records.end() ? nullptr : &found->second;
}

const bench::Estimate* find_estimate(const Calibration& calibration, CalibrationPart part)
{
  const CalibrationRecord* record = find_record(calibration, part);
  return record == nullptr || !record->estimate ? nullptr : &*record->estimate;
}

const bench::Estimate& estimate_of(CalibrationPart part, const PartInput& in)
{
  if (const bench::Estimate* found = find_estimate(in.begun, part)) return *found;
  throw InputError(
      {in.path, bench::name_of(part), "no estimate", "a finished part, because others depend on it"});
}

Eigen::MatrixXd prior_covariance(const bench::Estimate& estimate, const std::vector<std::string>& names)
{
  const auto n = static_cast<Eigen::Index>(names.size());
  Eigen::MatrixXd covariance(n, n);
  for (Eigen::Index i = 0; i < n; ++i) {
    for (Eigen::Index j = 0; j < n; ++j) {
      const Eigen::Index a = bench::index_of(estimate, names[static_cast<std::size_t>(i)]);
      const Eigen::Index b = bench::index_of(estimate, names[static_cast<std::size_t>(j)]);
      check(a >= 0 && b >= 0, "an estimate has the numbers of its part");
      covariance(i, j) = estimate.covariance(a, b);
    }
  }
  const double t_ratio = bench::t_95(estimate.dof) / bench::t_95(std::numeric_limits<double>::infinity());
  return t_ratio * t_ratio * covariance;
}

namespace {

bool is_first(calibration::Edge edge)
{
  return edge == calibration::Edge::left || edge == calibration::Edge::top;
}

/// The edges are in pairs: left and right, top and bottom.
calibration::Edge opposite(calibration::Edge edge)
{
  return static_cast<calibration::Edge>(static_cast<int>(edge) ^ 1);
}

struct ScannedLine {
  std::string task;
  double at_px = 0.0;
};

/// Marked scans of an edge, for the eye of `task`.
std::vector<ScannedLine> scans_of(calibration::Edge edge, const Task& task, const std::vector<Task>& tasks,
                                  const CalibrationRecord& record)
{
  std::vector<ScannedLine> scans;
  for (const Task& t : tasks) {
    if (t.kind != TaskKind::scan_line || t.is_right != task.is_right || t.index != static_cast<int>(edge))
      continue;
    if (const CalibrationMark* mark = find_mark(record, t.name)) scans.push_back({t.name, mark->rows[0][0]});
  }
  return scans;
}

}  // namespace

void require_edge_order(const std::vector<Task>& tasks, const CalibrationRecord& record, std::size_t done,
                        const std::string& path)
{
  const Task& last = tasks[done];
  if (last.kind != TaskKind::scan_line) return;
  const auto edge = static_cast<calibration::Edge>(last.index);
  const double at_px = find_mark(record, last.name)->rows[0][0];
  std::vector<ScannedLine> scans = scans_of(opposite(edge), last, tasks, record);
  const bool is_crossed = std::ranges::any_of(scans, [&](const ScannedLine& other) {
    return is_first(edge) ? at_px >= other.at_px : at_px <= other.at_px;
  });
  if (!is_crossed) return;
  std::vector<std::string> rejected;
  for (const ScannedLine& scan : scans) rejected.push_back(scan.task);
  for (const ScannedLine& scan : scans_of(edge, last, tasks, record)) rejected.push_back(scan.task);
  throw PartRefusal({path, bench::name_of(CalibrationPart::viewport),
                     "crossed edges of the " + eye_text(last.is_right) + ": " + calibration::name_of(edge) +
                         " beyond " + calibration::name_of(opposite(edge)),
                     "left before right and top before bottom; scan both edges again"},
                    std::move(rejected));
}

std::string screen_message(const InputError& error)
{
  const InputError::Facts& facts = error.facts();
  return (facts.field.empty() ? "" : facts.field + ": ") + "found " + facts.found + ", wanted " +
         facts.wanted;
}

namespace {

std::string with_unit(double value, const std::string& unit)
{
  return show::rounded_text(value, 2) + (unit.empty() ? "" : " " + unit);
}

std::string thing_of(TaskKind kind)
{
  switch (kind) {
    case TaskKind::scan_line:
      return "line";
    case TaskKind::rectangle_sides:
      return "lines";
    case TaskKind::point:
    case TaskKind::bullseye:
      return "cross";
    case TaskKind::grid:
      return "grid";
    case TaskKind::model_pose:
      return "model";
    default:
      return "number";
  }
}

/// Where the tool of a static measurement was, in the body's frame; empty for other kinds.
std::vector<Eigen::Vector3d> places_of(const Task& task, const CalibrationMark& mark)
{
  if (task.kind == TaskKind::bullseye) return marker_positions(mark);
  std::vector<Eigen::Vector3d> places;
  if (task.kind != TaskKind::hold) return places;
  for (const std::vector<double>& row : mark.rows)
    places.push_back(sampled_pose(row, 7).inverse() * sampled_position(row));
  return places;
}

}  // namespace

std::string untouched_text(const Task& task, const std::vector<bool>& touched)
{
  if (task.dials.empty() || task.is_start_valid) return {};
  const bool is_done = task.kind == TaskKind::rectangle_sides ? std::ranges::all_of(touched, std::identity())
                                                              : std::ranges::any_of(touched, std::identity());
  if (is_done) return {};
  const bool is_part = std::ranges::any_of(touched, std::identity());
  const std::string thing = is_part ? "other line" : thing_of(task.kind);
  const bool is_plural = !is_part && task.kind == TaskKind::rectangle_sides;
  return "Not taken: the " + thing + (is_plural ? " were" : " was") +
         " not touched. Follow the instruction above, then press Enter. If the " + thing +
         (is_plural ? " are right where they are, move each" : " is right where it is, move it") +
         " by a step and back first.";
}

std::string implausible_text(const Task& task, std::span<const double> values)
{
  for (std::size_t k = 0; k < task.dials.size(); ++k) {
    const Dial& dial = task.dials[k];
    if (values[k] >= dial.least_plausible && values[k] <= dial.most_plausible) continue;
    return "Not taken: " + dial.name + " " + with_unit(values[k], dial.unit) +
           " is implausible, expected is " + with_unit(dial.least_plausible, "") + " to " +
           with_unit(dial.most_plausible, dial.unit) +
           ". Read again and correct it. If it is right, press Enter again.";
  }
  return {};
}

std::string same_place_text(const std::vector<Task>& tasks, const CalibrationRecord& record, const Task& task,
                            const CalibrationMark& mark)
{
  constexpr double same_mm = 1.0;  // above the noise of a mean, below the distance of two points
  const std::vector<Eigen::Vector3d> places = places_of(task, mark);
  if (places.empty()) return {};
  const Eigen::Vector3d p_mm = mean_position(places).p_mm;
  for (const Task& other : tasks) {
    // Both eyes look at one marker position.
    const CalibrationMark* const done = other.index == task.index ? nullptr : find_mark(record, other.name);
    if (done == nullptr || (mean_position(places_of(other, *done)).p_mm - p_mm).norm() > same_mm) continue;
    return "Not taken: " + task.tool + " is where it was for \"" + other.name +
           "\". Move it as the instruction above says, then press Enter.";
  }
  return {};
}

std::string unexpected_text(const std::vector<Task>& tasks, const CalibrationRecord& record,
                            const bench::Estimate& estimate, const Calibration& nominal)
{
  const std::string again =
      ". The readings agree with each other, so they must be measured again: check the instrument, its unit "
      "and what is measured. The same readings are then accepted.";
  for (const Task& task : tasks) {
    const CalibrationMark* const mark = find_mark(record, task.name);
    const bool has_reading = task.kind == TaskKind::scan_line || task.kind == TaskKind::number;
    if (!has_reading || mark == nullptr || implausible_text(task, mark->rows[0]).empty()) continue;
    return task.name + ": " + with_unit(mark->rows[0][0], task.dials[0].unit) + " is far from the expected " +
           with_unit(task.dials[0].least_plausible, "") + " to " +
           with_unit(task.dials[0].most_plausible, task.dials[0].unit) + again;
  }
  struct Expected {
    const char* name;
    double least, most;
  };
  const double eye_px = nominal.eyes.left.distance_px, image_mm = nominal.image_distance_mm;
  // Adults are 0.75 to 1.3 times as large as a reference body; displays and rectangles are built near their
  // nominal sizes, and square pixels are usual.
  const std::array<Expected, 8> expected{{{"subject.scale", 0.75, 1.35},
                                          {"ipd", 45.0, 80.0},
                                          {"left.distance", 0.5 * eye_px, 2.0 * eye_px},
                                          {"right.distance", 0.5 * eye_px, 2.0 * eye_px},
                                          {"left.depth", 0.3 * image_mm, 3.0 * image_mm},
                                          {"right.depth", 0.3 * image_mm, 3.0 * image_mm},
                                          {"left.pixel_aspect", 0.7, 1.4},
                                          {"right.pixel_aspect", 0.7, 1.4}}};
  for (const Expected& e : expected) {
    const auto found = std::ranges::find(estimate.names, e.name);
    if (found == estimate.names.end()) continue;
    const auto k = static_cast<std::size_t>(found - estimate.names.begin());
    const double value = estimate.values[static_cast<Eigen::Index>(k)];
    if (value >= e.least && value <= e.most) continue;
    return std::string(e.name) + " " + with_unit(value, estimate.units[k]) + " is far from the expected " +
           with_unit(e.least, "") + " to " + with_unit(e.most, estimate.units[k]) + again;
  }
  return {};
}

}  // namespace vrda::calibration
