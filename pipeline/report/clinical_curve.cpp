#include "report/clinical_curve.hpp"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <limits>
#include <span>
#include <utility>

#include "analysis/score.hpp"
#include "core/text.hpp"
#include "core/units.hpp"
#include "job/job.hpp"
#include "job/mesh_file.hpp"
#include "model/coordinates.hpp"
#include "store/motion.hpp"
#include "store/solved_cells.hpp"
#include "tables/formats.hpp"

namespace vrda::report {
namespace {

// Tolerance for equal flexions of two files: rounding.
constexpr double same_flexion_deg = 1e-9;

Side side_of(const store::MotionModel& model)
{
  return side_named(model.side);
}

ClinicalCurve empty_curve(const store::MotionModel& model, std::string name)
{
  ClinicalCurve curve;
  curve.name = std::move(name);
  curve.flexion_deg = model.frames ? model.frames->key : model.flexion_deg;
  curve.values.fill(std::vector<double>(model.flexion_deg.size(), nan));
  return curve;
}

/// A model, and the moving point whose translations a curve has.
struct TrackedModel {
  const store::MotionModel& model;
  Eigen::Vector3d point_mm;

  ContinuousCoordinates start() const { return {side_of(model), point_mm}; }
};

/// `along` is that of the rows before.
void set_row(ClinicalCurve& curve, std::size_t row, const Pose& X_reference_moving,
             const store::MotionModel& model, ContinuousCoordinates& along)
{
  const ClinicalCoordinates c = along.next(X_reference_moving);
  const Eigen::Vector3d origin_mm = X_reference_moving.translation();
  if (store::has_turned_axes(model)) curve.flexion_deg[row] = deg_from_rad(c.flexion_rad);
  curve.values_of(Quantity::internal)[row] = deg_from_rad(c.internal_rotation_rad);
  curve.values_of(Quantity::varus)[row] = deg_from_rad(c.varus_rad);
  curve.values_of(Quantity::anterior)[row] = c.anterior_mm;
  curve.values_of(Quantity::proximal)[row] = c.proximal_mm;
  curve.values_of(Quantity::lateral)[row] = c.lateral_mm;
  curve.values_of(Quantity::origin_anterior)[row] = origin_mm.x();
  curve.values_of(Quantity::origin_proximal)[row] = origin_mm.y();
  curve.values_of(Quantity::origin_lateral)[row] =
      side_of(model) == Side::left ? -origin_mm.z() : origin_mm.z();
}

// The varus at which a smoothed set is evaluated: that of the flexion-only motion, so that curves differ only
// by smoothing.
double varus_rad(const store::MotionModel& model, const store::Motion& motion, std::size_t row)
{
  if (model.zero_varus && std::isfinite(model.zero_varus->varus_deg[row]))
    return rad_from_deg(model.zero_varus->varus_deg[row]);
  return motion.balanced_varus_rad(rad_from_deg(model.flexion_deg[row]));
}

/// The curve of the poses of `pose_of(row)`; empty without a pose.
template <typename PoseOf>
ClinicalCurve curve_of(const TrackedModel& tracked, const std::string& name, const PoseOf& pose_of)
{
  ClinicalCurve curve = empty_curve(tracked.model, name);
  ContinuousCoordinates along = tracked.start();
  for (std::size_t i = 0; i < curve.flexion_deg.size(); ++i) {
    if (const std::optional<Pose> X = pose_of(i)) set_row(curve, i, *X, tracked.model, along);
  }
  return curve;
}

ClinicalCurve raw_curve(const TrackedModel& tracked)
{
  const std::vector<Eigen::Index> spine = store::solved_spine(tracked.model);
  return curve_of(tracked, "raw", [&](std::size_t i) -> std::optional<Pose> {
    if (spine[i] < 0) return std::nullopt;
    return store::pose_in(tracked.model.X_reference_moving, static_cast<std::size_t>(spine[i]));
  });
}

ClinicalCurve zero_varus_curve(const TrackedModel& tracked)
{
  const store::ZeroVarus& zero = *tracked.model.zero_varus;
  return curve_of(tracked, "zero_varus", [&](std::size_t i) -> std::optional<Pose> {
    if (zero.source[i] == static_cast<std::int8_t>(store::ZeroVarusSource::none)) return std::nullopt;
    return store::pose_in(zero.X_reference_moving, i);
  });
}

ClinicalCurve curve_of_set(const TrackedModel& tracked, const std::string& set)
{
  const store::MotionModel& model = tracked.model;
  const store::Motion motion(model, set);
  const std::vector<double> flexion_deg = empty_curve(model, set).flexion_deg;
  return curve_of(tracked, set, [&](std::size_t i) -> std::optional<Pose> {
    const store::JointPose pose = motion.at({rad_from_deg(flexion_deg[i]), varus_rad(model, motion, i)});
    if (pose.status != store::PoseStatus::solved) return std::nullopt;
    return pose.X_reference_moving;
  });
}

/// The finite points of a curve by ascending flexion.
std::vector<std::pair<double, double>> points_of(const ClinicalCurve& curve, Quantity quantity)
{
  std::vector<std::pair<double, double>> points;
  const std::vector<double>& values = curve.values_of(quantity);
  for (std::size_t k = 0; k < values.size(); ++k) {
    if (std::isfinite(values[k]) && std::isfinite(curve.flexion_deg[k]))
      points.emplace_back(curve.flexion_deg[k], values[k]);
  }
  std::stable_sort(points.begin(), points.end(),
                   [](const auto& a, const auto& b) { return a.first < b.first; });
  return points;
}

// Linear between the points; NaN outside.
double value_at(const std::vector<std::pair<double, double>>& points, double flexion_deg)
{
  if (points.empty() || flexion_deg < points.front().first - same_flexion_deg ||
      flexion_deg > points.back().first + same_flexion_deg)
    return nan;
  const auto after = std::lower_bound(points.begin(), points.end(), flexion_deg,
                                      [](const auto& point, double x) { return point.first < x; });
  if (after == points.begin()) return points.front().second;
  if (after == points.end()) return points.back().second;
  const auto before = std::prev(after);
  const double fraction = (flexion_deg - before->first) / (after->first - before->first);
  return before->second + fraction * (after->second - before->second);
}

}  // namespace

std::vector<ClinicalCurve> clinical_curves(const store::MotionModel& model, const Eigen::Vector3d& point_mm)
{
  const TrackedModel tracked{model, point_mm};
  std::vector<ClinicalCurve> curves;
  if (model.zero_varus) curves.push_back(zero_varus_curve(tracked));
  for (const std::string& set : store::set_names(model)) {
    if (set != "raw" && set != "zero_varus") curves.push_back(curve_of_set(tracked, set));
  }
  if (model.prior) curves.push_back(curve_of_set(tracked, store::bones_alone_name));
  curves.push_back(raw_curve(tracked));
  return curves;
}

Eigen::Vector3d comparison_point_mm(const store::MotionModel& first, const store::MotionModel& model)
{
  const auto are_equal = [](const Body& a, const Body& b) {
    const Points& p_mm = a.contact.mesh.vertices_mm;
    const Points& q_mm = b.contact.mesh.vertices_mm;
    return p_mm.rows() == q_mm.rows() && (p_mm.array() == q_mm.array()).all();
  };
  const bool is_one_joint = first.side == model.side && are_equal(first.reference, model.reference) &&
                            are_equal(first.moving, model.moving);
  return is_one_joint ? first.rotation_centre_mm : model.rotation_centre_mm;
}

CurveDifference difference(const ClinicalCurve& curve, const ClinicalCurve& other, Quantity quantity)
{
  const auto points = points_of(curve, quantity);
  std::vector<double> found, measured;
  for (const auto& [flexion_deg, value] : points_of(other, quantity)) {
    const double here = value_at(points, flexion_deg);
    if (!std::isfinite(here)) continue;
    found.push_back(quantity == Quantity::internal ? nearest_turn(here, value, 360.0) : here);
    measured.push_back(value);
  }
  const analysis::Statistics s = analysis::statistics(found, measured);
  return {s.n, s.rms, s.largest, s.bias, s.shape};
}

namespace {

constexpr std::uintmax_t largest_curve_bytes = 64u << 20;
constexpr const char* wanted_columns =
    "a header, separated by commas, semicolons, tabs or |, with flexion_deg and at least one of "
    "internal_deg, "
    "varus_deg, anterior_mm, proximal_mm, lateral_mm, ant_mm, prox_mm, lat_mm";

/// The content of a column.
struct Column {
  enum class Kind { flexion, quantity, point, ignored } kind = Kind::ignored;
  Quantity quantity = Quantity::internal;
  Eigen::Index axis = 0;  ///< of the point
};

bool is_ignored(std::string_view name)
{
  const bool is_matrix_entry = name.size() == 3 && name[0] == 'T' && name[1] >= '1' && name[1] <= '3' &&
                               name[2] >= '1' && name[2] <= '4';
  return is_matrix_entry || tables::is_flexion_csv_column(name) || name == "frame" || name == "time_s" ||
         name == "femur_rel_tibia_prox_mm" || name == "femur_rel_tibia_ant_mm" ||
         name == "femur_rel_tibia_lat_mm";
}

std::optional<Column> column_named(std::string_view name)
{
  if (name == "flexion_deg") return Column{Column::Kind::flexion, {}, {}};
  for (const QuantityName& known : quantity_names)
    if (name == known.column) return Column{Column::Kind::quantity, known.quantity, {}};
  if (name.size() == 11 && name.starts_with("centre_") && name.ends_with("_mm") && name[7] >= 'x' &&
      name[7] <= 'z')
    return Column{Column::Kind::point, {}, name[7] - 'x'};
  if (is_ignored(name)) return Column{};
  return std::nullopt;
}

/// Parses a curve line by line.
class CurveReader {
 public:
  explicit CurveReader(const std::string& file) : file_(file)
  {
    result_.curve.name = std::filesystem::path(file).stem().string();
  }

  void take(std::string_view line)
  {
    ++n_lines_;
    line = job::trimmed(line, " \r");  // tabs may separate empty fields
    if (job::trimmed(line).empty() || (n_lines_ == 1 && line.starts_with("sep="))) return;
    if (job::trimmed(line).front() == '#') {
      result_.comments.emplace_back(job::trimmed(job::trimmed(line).substr(1)));
    } else if (columns_.empty()) {
      take_header(line);
    } else {
      take_row(line);
    }
  }

  CurveFile finish()
  {
    if (columns_.empty()) refuse("", "no header", wanted_columns);
    if (result_.point_mm && !result_.point_mm->allFinite())
      refuse("header", "a part of centre_x_mm, centre_y_mm, centre_z_mm", "all three, or none");
    if (result_.curve.flexion_deg.empty()) refuse("", "no rows", "rows of numbers below the header");
    std::vector<double>& internal_deg = result_.curve.values_of(Quantity::internal);
    internal_deg = unwrapped(std::move(internal_deg), 360.0);
    return std::move(result_);
  }

 private:
  [[noreturn]] void refuse(const std::string& field, const std::string& found,
                           const std::string& wanted) const
  {
    throw InputError({file_, field, found, wanted});
  }
  std::string here() const { return "line " + std::to_string(n_lines_); }

  void take_header(std::string_view line)
  {
    bool has_flexion = false, has_quantity = false;
    separator_ = job::separator_of(line);
    for (const std::string_view name : job::split_fields(line, separator_)) {
      const std::optional<Column> column = column_named(name);
      if (!column) refuse("column '" + std::string(name) + "'", "an unknown column", wanted_columns);
      const bool is_repeated = column->kind != Column::Kind::ignored &&
                               std::find(names_.begin(), names_.end(), name) != names_.end();
      if (is_repeated) refuse("column '" + std::string(name) + "'", "the column twice", "each column once");
      names_.emplace_back(name);
      columns_.push_back(*column);
      has_flexion = has_flexion || column->kind == Column::Kind::flexion;
      has_quantity = has_quantity || column->kind == Column::Kind::quantity;
    }
    if (!has_flexion) refuse("header", "no column flexion_deg", wanted_columns);
    if (!has_quantity) refuse("header", "no clinical quantity besides flexion_deg", wanted_columns);
  }

  void take_row(std::string_view line)
  {
    const std::vector<std::string_view> fields = job::split_fields(line, separator_);
    if (fields.size() != columns_.size())
      refuse(here(), std::to_string(fields.size()) + " fields",
             std::to_string(columns_.size()) + ", as in the header");
    for (std::size_t k = 0; k < fields.size(); ++k) take_field(columns_[k], names_[k], fields[k]);
  }

  void take_field(const Column& column, const std::string& name, std::string_view field)
  {
    if (column.kind == Column::Kind::ignored) return;
    const bool may_be_empty = column.kind == Column::Kind::quantity;
    double number = std::numeric_limits<double>::quiet_NaN();
    if (!field.empty() || !may_be_empty) {
      const std::optional<double> read = job::parse_real(field);
      if (!read || !std::isfinite(*read))
        refuse(here() + ", " + name, "'" + std::string(field) + "'",
               read ? "a finite number" : job::wanted_number(field));
      number = *read;
    }
    if (column.kind == Column::Kind::flexion) {
      result_.curve.flexion_deg.push_back(number);
    } else if (column.kind == Column::Kind::point) {
      if (!result_.point_mm) result_.point_mm = Eigen::Vector3d::Constant(nan);
      double& mm = (*result_.point_mm)[column.axis];
      if (std::isfinite(mm) && mm != number)
        refuse(here() + ", " + name, "'" + std::string(field) + "'", "one point in all rows");
      mm = number;
    } else {
      result_.curve.values_of(column.quantity).push_back(number);
    }
  }

  std::string file_;
  CurveFile result_;
  std::vector<std::string> names_;
  char separator_ = ',';
  std::vector<Column> columns_;
  int n_lines_ = 0;
};

}  // namespace

CurveFile curve_from_text(const std::string& file, std::string_view text)
{
  CurveReader reader(file);
  for (std::size_t begin = 0; begin < text.size();) {
    const std::size_t end = std::min(text.find('\n', begin), text.size());
    reader.take(text.substr(begin, end - begin));
    begin = end + 1;
  }
  return reader.finish();
}

namespace {

constexpr Quantity other_angles[] = {Quantity::varus, Quantity::internal};
constexpr Quantity grood_suntay[] = {Quantity::anterior, Quantity::proximal, Quantity::lateral};
constexpr Quantity mesh_origin[] = {Quantity::origin_anterior, Quantity::origin_proximal,
                                    Quantity::origin_lateral};

std::ptrdiff_t n_known(const ClinicalCurve& curve, std::span<const Quantity> quantities)
{
  return std::ranges::count_if(quantities, [&](Quantity q) { return !curve.values_of(q).empty(); });
}

// The mirror image of a left joint: clinical numbers are those of a right one.
Eigen::Vector3d right_sided(const Eigen::Vector3d& p_mm, Side side)
{
  return {p_mm.x(), p_mm.y(), side == Side::left ? -p_mm.z() : p_mm.z()};
}

}  // namespace

CurveFile about_point(CurveFile file, Side side, const Eigen::Vector3d& point_mm)
{
  ClinicalCurve& curve = file.curve;
  const bool is_of_centre = n_known(curve, grood_suntay) > 0;
  const bool is_of_origin = !is_of_centre && n_known(curve, mesh_origin) > 0;
  const bool is_there = is_of_centre ? !file.point_mm || *file.point_mm == point_mm : !is_of_origin;
  if (is_there) return file;
  const std::span<const Quantity> from = is_of_centre ? grood_suntay : mesh_origin;
  file.is_incomplete = n_known(curve, other_angles) < 2 || n_known(curve, from) < 3;
  if (file.is_incomplete) return file;
  const Eigen::Vector3d to_mm = right_sided(point_mm, side);
  const Eigen::Vector3d from_mm = is_of_centre ? right_sided(*file.point_mm, side) : Eigen::Vector3d::Zero();
  std::array<std::vector<double>, 3> moved;
  for (std::size_t k = 0; k < curve.flexion_deg.size(); ++k) {
    JointCoordinates q = JointCoordinates::Zero();
    q.head<3>() << rad_from_deg(curve.flexion_deg[k]), rad_from_deg(curve.values_of(Quantity::varus)[k]),
        rad_from_deg(curve.values_of(Quantity::internal)[k]);
    Eigen::Vector3d t_mm;
    for (std::size_t axis = 0; axis < 3; ++axis)
      t_mm[static_cast<Eigen::Index>(axis)] = curve.values_of(from[axis])[k];
    if (!q.allFinite() || !t_mm.allFinite()) {
      for (std::vector<double>& values : moved) values.push_back(nan);
      continue;
    }
    if (is_of_centre) q.tail<3>() = t_mm;
    Pose X = joint_pose(q);
    if (!is_of_centre) X.translation() = t_mm;
    X.translation() += X.linear() * (to_mm - from_mm) - (to_mm - from_mm);
    const JointCoordinates about = joint_coordinates(X);
    for (std::size_t axis = 0; axis < 3; ++axis)
      moved[axis].push_back(about[3 + static_cast<Eigen::Index>(axis)]);
  }
  for (std::size_t axis = 0; axis < 3; ++axis) curve.values_of(grood_suntay[axis]) = std::move(moved[axis]);
  if (is_of_centre) file.point_mm = point_mm;
  return file;
}

CurveFile read_curve_file(const std::string& file)
{
  std::string text = job::file_bytes(file, {file, "", "", "a CSV file of a curve"}, largest_curve_bytes);
  job::require_table(file, text);
  job::normalise_text(text);
  return curve_from_text(file, text);
}

}  // namespace vrda::report
