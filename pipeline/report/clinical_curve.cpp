#include "report/clinical_curve.hpp"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <span>
#include <utility>

#include "analysis/score.hpp"
#include "core/text.hpp"
#include "core/units.hpp"
#include "job/job.hpp"
#include "job/ligament_files.hpp"
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

// The mirror image of a left joint: clinical numbers are those of a right one.
Eigen::Vector3d right_sided(const Eigen::Vector3d& p_mm, Side side)
{
  return {p_mm.x(), p_mm.y(), side == Side::left ? -p_mm.z() : p_mm.z()};
}

ClinicalCurve empty_curve(const store::MotionModel& model, std::string name)
{
  ClinicalCurve curve;
  curve.name = std::move(name);
  curve.flexion_deg = model.frames ? model.frames->key : model.flexion_deg;
  curve.values.fill(std::vector<double>(model.flexion_deg.size(), nan));
  return curve;
}

/// `along` is that of the rows before.
void set_row(ClinicalCurve& curve, std::size_t row, const Pose& X_reference_moving,
             const store::MotionModel& model, ContinuousCoordinates& along)
{
  const auto [flexion_deg, varus_deg, internal_deg, anterior_mm, proximal_mm, lateral_mm] =
      std::array<double, n_joint_coordinates>(in_files(along.next(X_reference_moving)));
  const Eigen::Vector3d origin_mm = right_sided(X_reference_moving.translation(), side_of(model));
  if (store::has_turned_axes(model)) curve.flexion_deg[row] = flexion_deg;
  const double numbers[n_quantities] = {internal_deg, varus_deg,     anterior_mm,   proximal_mm,
                                        lateral_mm,   origin_mm.x(), origin_mm.y(), origin_mm.z()};
  for (std::size_t k = 0; k < n_quantities; ++k) curve.values[k][row] = numbers[k];
}

// Smoothed sets are evaluated at the varus of the flexion-only motion, so that curves differ only by
// smoothing.
ClinicalCurve curve_of(const store::MotionModel& model, const std::string& set,
                       const Eigen::Vector3d& point_mm)
{
  ClinicalCurve curve = empty_curve(model, set);
  const std::optional<store::ZeroVarus>& zero = model.zero_varus;
  std::vector<std::optional<Pose>> poses(curve.flexion_deg.size());
  if (set != "zero_varus")
    poses = store::poses_over_flexion(model, set, curve.flexion_deg,
                                      zero ? zero->varus_deg : std::vector<double>{});
  ContinuousCoordinates along(side_of(model), point_mm);
  for (std::size_t i = 0; i < poses.size(); ++i) {
    if (set == "zero_varus" && zero->source[i] != store::code_of(store::ZeroVarusSource::none))
      poses[i] = store::pose_in(zero->X_reference_moving, i);
    if (poses[i]) set_row(curve, i, *poses[i], model, along);
  }
  return curve;
}

/// The finite points of a curve by ascending flexion.
store::FlexionCurve points_of(const ClinicalCurve& curve, Quantity quantity)
{
  const std::vector<double>& values = curve.values_of(quantity);
  std::vector<std::size_t> order;
  for (std::size_t k = 0; k < values.size(); ++k)
    if (std::isfinite(values[k]) && std::isfinite(curve.flexion_deg[k])) order.push_back(k);
  std::ranges::stable_sort(order, {}, [&](std::size_t k) { return curve.flexion_deg[k]; });
  store::FlexionCurve points;
  for (const std::size_t k : order) points.add(curve.flexion_deg[k], values[k]);
  return points;
}

}  // namespace

std::vector<ClinicalCurve> clinical_curves(const store::MotionModel& model, const Eigen::Vector3d& point_mm)
{
  std::vector<std::string> sets = store::set_names(model);
  std::erase_if(sets, [](const std::string& set) { return set == "raw" || set == "zero_varus"; });
  if (model.zero_varus) sets.insert(sets.begin(), "zero_varus");
  if (model.prior) sets.emplace_back(store::bones_alone_name);
  sets.emplace_back("raw");
  std::vector<ClinicalCurve> curves;
  for (const std::string& set : sets) curves.push_back(curve_of(model, set, point_mm));
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
  const store::FlexionCurve points = points_of(curve, quantity), others = points_of(other, quantity);
  std::vector<double> found, measured;
  for (std::size_t k = 0; k < others.value.size(); ++k) {
    const double value = others.value[k];
    const double here = store::value_at(points, others.flexion_deg[k], same_flexion_deg);
    if (!std::isfinite(here)) continue;
    found.push_back(quantity == Quantity::internal ? nearest_turn(here, value, 360.0) : here);
    measured.push_back(value);
  }
  const analysis::Statistics s = analysis::statistics(found, measured);
  return {s.n, s.rms, s.largest, s.bias, s.shape};
}

namespace {

constexpr std::uintmax_t largest_curve_bytes = 64u << 20;
constexpr std::size_t most_rows = 1000000;

bool is_ignored(std::string_view name)
{
  const bool is_matrix_entry = name.size() == 3 && name[0] == 'T' && name[1] >= '1' && name[1] <= '3' &&
                               name[2] >= '1' && name[2] <= '4';
  return is_matrix_entry || tables::is_flexion_csv_column(name) || name == "frame" || name == "time_s" ||
         name == "femur_rel_tibia_prox_mm" || name == "femur_rel_tibia_ant_mm" ||
         name == "femur_rel_tibia_lat_mm";
}

void require_known(const job::CsvTable& table)
{
  std::vector<std::string> known{"flexion_deg"};
  for (const QuantityName& q : quantity_names) known.emplace_back(q.column);
  const std::vector<std::string_view>& names = table.columns();
  const auto is_among = [&](std::string_view name) { return std::ranges::count(known, name) > 0; };
  for (const std::string_view name : names) {
    if (!is_among(name) && !is_ignored(name)) table.refuse_unknown_column(name, known, joined(known));
    if ((is_among(name) || name.starts_with("centre_")) && std::ranges::count(names, name) > 1)
      table.refuse(table.header(), std::string(name), "the column twice", "each column once");
  }
  if (std::ranges::count_if(names, is_among) < 2 || std::ranges::count(names, known.front()) == 0)
    table.refuse(table.header(), "", "not flexion_deg and a clinical quantity",
                 "flexion_deg and at least one more of " + joined(known));
}

std::optional<Eigen::Vector3d> point_of(const job::CsvTable& table)
{
  Eigen::Vector3d point_mm = Eigen::Vector3d::Zero();
  int n_found = 0;
  for (const int axis : {0, 1, 2}) {
    const std::string name = std::string("centre_") + "xyz"[axis] + "_mm";
    const auto column = std::ranges::find(table.columns(), name) - table.columns().begin();
    if (static_cast<std::size_t>(column) == table.columns().size()) continue;
    ++n_found;
    const std::vector<double> mm = table.numbers(static_cast<std::size_t>(column));
    point_mm[axis] = mm.front();
    for (std::size_t i = 0; i < mm.size(); ++i)
      if (mm[i] != mm.front())
        table.refuse(table.row(i), name, shortest_decimal(mm[i]), "one point in all rows");
  }
  if (n_found == 1 || n_found == 2)
    table.refuse(table.header(), "", "a part of centre_x_mm, centre_y_mm, centre_z_mm", "all three, or none");
  return n_found == 3 ? std::optional(point_mm) : std::nullopt;
}

std::vector<std::string> comments_of(std::string_view text)
{
  std::vector<std::string> comments;
  while (!text.empty()) {
    const std::size_t end = std::min(text.find('\n'), text.size());
    const std::string_view line = job::trimmed(text.substr(0, end));
    if (line.starts_with('#')) comments.emplace_back(job::trimmed(line.substr(1)));
    text.remove_prefix(std::min(end + 1, text.size()));
  }
  return comments;
}

}  // namespace

CurveFile curve_from_text(const std::string& file, std::string_view text)
{
  const job::CsvTable table(file, text, {"row", "rows", "rows of clinical numbers over flexion_deg"});
  require_known(table);
  table.require_rows(most_rows);
  CurveFile result;
  result.comments = comments_of(text);
  result.point_mm = point_of(table);
  ClinicalCurve& curve = result.curve;
  curve.name = std::filesystem::path(file).stem().string();
  curve.flexion_deg = table.numbers(table.column_named("flexion_deg"));
  for (const QuantityName& q : quantity_names) {
    if (std::ranges::count(table.columns(), std::string_view(q.column)) > 0)
      curve.values_of(q.quantity) = table.numbers(table.column_named(q.column), job::EmptyField::missing);
  }
  curve.values_of(Quantity::internal) = unwrapped(std::move(curve.values_of(Quantity::internal)), 360.0);
  return result;
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
  job::normalise_text(text);
  return curve_from_text(file, text);
}

}  // namespace vrda::report
