#include "store/solved_cells.hpp"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdio>
#include <span>
#include <sstream>

#include "core/text.hpp"
#include "model/coordinates.hpp"
#include "model/frames.hpp"
#include "model/mesh.hpp"
#include "store/h5_file.hpp"
#include "store/motion.hpp"

namespace vrda::store {
namespace {

// The axis value where varus was prescribed: conversion to radians and back may change the last bit.
double solved_varus_deg(const MotionModel& model, const StepRecord& r)
{
  const double axis_deg = model.varus_deg[static_cast<std::size_t>(r.key.varus)];
  return r.varus_rad == rad_from_deg(axis_deg) ? axis_deg : deg_from_rad(r.varus_rad);
}

Attitude attitude_of(const MotionModel& model, const StepRecord& r)
{
  return {rad_from_deg(model.flexion_deg[static_cast<std::size_t>(r.key.flexion)]), r.varus_rad};
}

void set_pose(MotionModel& model, const StepRecord& r)
{
  const SolverFrame frame = solver_frame(model, r.key.flexion);
  const Eigen::Index i = r.key.flexion, j = r.key.varus;
  const Attitude attitude = attitude_of(model, r);
  const Eigen::Vector3d t = world_translation_mm(frame, r.pose);
  model.tx_mm(i, j) = t.x();
  model.ty_mm(i, j) = t.y();
  model.tz_mm(i, j) = t.z();
  model.theta_deg(i, j) = deg_from_rad(r.pose.theta_rad);
  model.varus_solved_deg(i, j) = solved_varus_deg(model, r);

  const Pose X = X_reference_moving(frame, attitude, r.pose);
  const std::size_t first = 16 * static_cast<std::size_t>(i * model.status.cols() + j);
  for (int row = 0; row < 4; ++row) {
    for (int column = 0; column < 4; ++column) {
      model.X_reference_moving[first + static_cast<std::size_t>(4 * row + column)] = X.matrix()(row, column);
    }
  }
  const auto numbers = in_files(clinical_coordinates(X, frame.side, frame.rotation_centre_mm));
  for (std::size_t k = 0; k < numbers.size(); ++k) model.clinical[k](i, j) = numbers[k];
}

/// Replaces a number only where it differs by more than rounding, so that the others keep their bits.
void replace(double& number, double by)
{
  constexpr double rounding = 1e-6;  // degrees or mm
  if (std::abs(by - number) > rounding) number = by;
}

void set_next(ClinicalSurfaces& surfaces, const MotionModel& model, Eigen::Index cell,
              ContinuousCoordinates& along)
{
  const auto numbers =
      in_files(along.next(pose_in(model.X_reference_moving, static_cast<std::size_t>(cell))));
  for (std::size_t k = 0; k < 4; ++k) replace(surfaces[k].data()[cell], numbers[k]);  // others are unique
}

/// The stable cell of a row from which the others follow: that of the spine, else the first; -1 without any.
Eigen::Index first_of_row(const MotionModel& model, Eigen::Index i)
{
  Eigen::Index found = -1;
  for (Eigen::Index j = model.status.cols() - 1; j >= 0; --j) {
    if (model.status(i, j) != status_stable) continue;
    if (model.is_spine(i, j) == 1) return j;
    found = j;
  }
  return found;
}

}  // namespace

std::vector<Eigen::Index> solved_spine(const MotionModel& model)
{
  std::vector<Eigen::Index> cells(model.flexion_deg.size(), -1);
  for (Eigen::Index i = 0; i < model.status.rows(); ++i) {
    for (Eigen::Index j = 0; j < model.status.cols(); ++j) {
      if (model.is_spine(i, j) == 1 && model.status(i, j) == status_stable)
        cells[static_cast<std::size_t>(i)] = i * model.status.cols() + j;
    }
  }
  return cells;
}

std::vector<std::optional<Pose>> poses_over_flexion(const MotionModel& model, const std::string& set,
                                                    const std::vector<double>& flexion_deg,
                                                    const std::vector<double>& varus_deg)
{
  std::vector<std::optional<Pose>> poses(flexion_deg.size());
  if (set == "raw") {
    const std::vector<Eigen::Index> spine = solved_spine(model);
    for (std::size_t i = 0; i < spine.size(); ++i)
      if (spine[i] >= 0) poses[i] = pose_in(model.X_reference_moving, static_cast<std::size_t>(spine[i]));
    return poses;
  }
  const Motion motion(model, set);
  for (std::size_t i = 0; i < flexion_deg.size(); ++i) {
    const double flexion_rad = rad_from_deg(flexion_deg[i]);
    const bool is_given = i < varus_deg.size() && std::isfinite(varus_deg[i]);
    const JointPose pose = motion.at(
        {flexion_rad, is_given ? rad_from_deg(varus_deg[i]) : motion.balanced_varus_rad(flexion_rad)});
    if (pose.status == PoseStatus::solved) poses[i] = pose.X_reference_moving;
  }
  return poses;
}

ClinicalCurves clinical_curves(const MotionModel& model)
{
  ClinicalCurves curves{model.clinical};
  ContinuousCoordinates over_rows(side_named(model.side), model.rotation_centre_mm);
  const Eigen::Index n = model.status.cols();
  for (Eigen::Index i = 0; i < model.status.rows(); ++i) {
    const Eigen::Index first = first_of_row(model, i);
    if (first < 0) continue;
    set_next(curves.surfaces, model, i * n + first, over_rows);
    for (const Eigen::Index step : {1, -1}) {
      ContinuousCoordinates along = over_rows;
      for (Eigen::Index j = first + step; j >= 0 && j < n; j += step)
        if (model.status(i, j) == status_stable) set_next(curves.surfaces, model, i * n + j, along);
      curves.n_locked += along.n_locked() - over_rows.n_locked();
    }
  }
  curves.n_locked += over_rows.n_locked();
  return curves;
}

SolverFrame solver_frame(const MotionModel& model, std::int32_t flexion)
{
  return {side_named(model.side), model.rotation_centre_mm, model.push.delta.row(flexion).transpose()};
}

void set_cell(MotionModel& model, const StepRecord& r)
{
  const Eigen::Index i = r.key.flexion, j = r.key.varus;
  model.status(i, j) = static_cast<std::int8_t>(r.status);
  model.iterations(i, j) = r.iterations;
  model.queries(i, j) = r.queries;
  if (r.status != StepStatus::stable) return;
  set_pose(model, r);
  model.residual_mm(i, j) = r.residual_mm;
  for (const Compartment side : all_compartments) {
    model.gap_mm[side](i, j) = r.gap_mm[side];
    model.is_in_contact[side](i, j) = r.is_in_contact[side] ? 1 : 0;
  }
  model.theta_determined(i, j) = r.theta_determined ? 1 : 0;
}

ContactRows contact_rows(const MotionModel& model, const std::vector<StepRecord>& cells)
{
  const auto contacts_of = [](const StepRecord& r) { return std::span<const ContactRecord>(r.contacts); };
  return compressed_rows(model, cells, contacts_of, &ContactRecord::distance_mm, &ContactRows::distance_mm);
}

// Centre of contact of each compartment, from the contacts or the contact forces of a motion model.

namespace {

using CellPoints = OfCompartments<Eigen::Vector3d>;  // world W

/// Weighted means of the rows [first, last); `weight(row)` is above 0.
template <typename Rows, typename Weight>
CellPoints weighted_means(const Rows& rows, std::int64_t first, std::int64_t last, Weight weight)
{
  double sums[3] = {};
  Eigen::Vector3d moments[3] = {Eigen::Vector3d::Zero(), Eigen::Vector3d::Zero(), Eigen::Vector3d::Zero()};
  for (std::int64_t row = first; row < last; ++row) {
    const std::int8_t compartment = rows.compartment[static_cast<std::size_t>(row)];
    const double w = weight(row);
    sums[compartment] += w;
    moments[compartment] += w * rows.point_world_mm.row(row).transpose();
  }
  CellPoints points;
  for (std::size_t side = 0; side < points.size(); ++side)
    points[side] = sums[side + 1] > 0.0 ? Eigen::Vector3d(moments[side + 1] / sums[side + 1])
                                        : Eigen::Vector3d::Constant(nan);
  return points;
}

CellPoints points_of(const MotionModel& model, std::size_t cell, const Eigen::Vector3d& delta)
{
  if (!model.equilibrium) {
    const ContactRows& contacts = model.contacts;
    return weighted_means(contacts, contacts.row_start[cell], contacts.row_start[cell + 1],
                          [](std::int64_t) { return 1.0; });
  }
  const ForceRows& forces = model.equilibrium->forces;
  return weighted_means(forces, forces.row_start[cell], forces.row_start[cell + 1], [&](std::int64_t row) {
    return forces.along_delta_n[static_cast<std::size_t>(row)] / -forces.normal_world.row(row).dot(delta);
  });
}

void set_point(std::vector<double>& path_mm, std::size_t cell, const Eigen::Vector3d& point_mm)
{
  for (std::size_t axis = 0; axis < 3; ++axis)
    path_mm[3 * cell + axis] = point_mm[static_cast<Eigen::Index>(axis)];
}

}  // namespace

ContactPaths contact_paths_of(const MotionModel& model)
{
  using Matrix4 = Eigen::Matrix<double, 4, 4, Eigen::RowMajor>;
  const std::size_t n_varus = model.varus_deg.size(), n_cells = model.flexion_deg.size() * n_varus;
  const std::vector<double> no_points(3 * n_cells, nan);
  ContactPaths paths;
  paths.fill({no_points, no_points});
  SolverFrame frame{side_named(model.side), model.rotation_centre_mm, {}};
  for (std::size_t cell = 0; cell < n_cells; ++cell) {
    if (model.status.data()[cell] != status_stable) continue;
    const std::size_t flexion = cell / n_varus;
    frame.delta = model.push.delta.row(static_cast<Eigen::Index>(flexion)).transpose();
    const Eigen::Matrix3d R_reference_world_solver =
        reference_rotation(
            {rad_from_deg(model.flexion_deg[flexion]), rad_from_deg(model.varus_solved_deg.data()[cell])})
            .transpose();
    const Matrix4 X = Eigen::Map<const Matrix4>(&model.X_reference_moving[16 * cell]);
    const auto in_reference = [&](const Eigen::Vector3d& p_world_mm) -> Eigen::Vector3d {
      return world_from_solver(frame, R_reference_world_solver * solver_translation_mm(frame, p_world_mm)) +
             model.rotation_centre_mm;
    };
    const auto in_moving = [&](const Eigen::Vector3d& p_reference_mm) -> Eigen::Vector3d {
      return X.topLeftCorner<3, 3>().transpose() * (p_reference_mm - X.topRightCorner<3, 1>());
    };
    const CellPoints points = points_of(model, cell, frame.delta);
    for (const Compartment side : all_compartments) {
      const Eigen::Vector3d centre_mm = in_reference(points[side]);
      set_point(paths[side].reference_mm, cell, centre_mm);
      set_point(paths[side].moving_mm, cell, in_moving(centre_mm));
    }
  }
  return paths;
}

namespace {

std::size_t n_rows_of(const IndexTable& table)
{
  check(!table.columns.empty(), "an index must have a first column, the names of its rows");
  return std::get<std::vector<std::string>>(table.columns.front().values).size();
}

Dataset dataset_of(const IndexColumn& column, const std::string& dimension)
{
  Dataset dataset{"/" + column.name, {dimension}, {column.units.c_str(), 0}, {}, column.long_name};
  if (std::holds_alternative<std::vector<double>>(column.values)) dataset.valid.rule = Rule::number_or_nan;
  if (std::holds_alternative<std::vector<std::int8_t>>(column.values))
    dataset.valid = {.rule = Rule::codes, .flags = column.flags};
  return dataset;
}

std::string word_of(FlagSet flags, std::int8_t code)
{
  const FlagTable table = flag_table(flags);
  std::istringstream words(table.meanings);
  std::string word;
  for (const std::int8_t value : table.values) {
    words >> word;
    if (value == code) return word;
  }
  throw InternalError("a code of an index must be in its flag table");
}

std::string field_of(const IndexColumn& column, std::size_t row)
{
  if (const auto* texts = std::get_if<std::vector<std::string>>(&column.values))
    return csv_field(texts->at(row));
  if (const auto* codes = std::get_if<std::vector<std::int8_t>>(&column.values))
    return word_of(column.flags, codes->at(row));
  return csv_number(std::get<std::vector<double>>(column.values).at(row));
}

}  // namespace

std::string index_bytes(const std::string& path, const IndexTable& table)
{
  const std::string dimension = "/" + table.columns.front().name;
  H5Writer writer(path);
  write_format(writer, {index_format_name, index_format_version});
  writer.write_attribute("/", "title", table.title);
  Hdf5WriteVisitor write(writer, Hdf5WriteVisitor::Pass::datasets);
  write.dimension(dimension, DimensionSize::counted(n_rows_of(table)));
  for (const IndexColumn& column : table.columns)
    std::visit([&](auto values) { write(dataset_of(column, dimension), values); }, column.values);
  return writer.bytes();
}

std::string index_csv(const IndexTable& table)
{
  const std::size_t n_rows = n_rows_of(table);
  std::string out;
  for (const IndexColumn& column : table.columns) out += (out.empty() ? "" : ",") + column.name;
  out += "\n";
  for (std::size_t row = 0; row < n_rows; ++row) {
    for (std::size_t k = 0; k < table.columns.size(); ++k) {
      out += (k == 0 ? "" : ",") + field_of(table.columns[k], row);
    }
    out += "\n";
  }
  return out;
}

CellForces forces_in(const ForceRows& forces, std::size_t cell)
{
  CellForces sum;
  for (auto k = static_cast<std::size_t>(forces.row_start[cell]);
       k < static_cast<std::size_t>(forces.row_start[cell + 1]); ++k) {
    sum.all_n += forces.along_delta_n[k];
    sum.of_n.at(static_cast<std::size_t>(forces.compartment[k])) += forces.along_delta_n[k];
  }
  return sum;
}

double value_at(const FlexionCurve& curve, double flexion_deg, double rounding_deg)
{
  const std::vector<double>& at = curve.flexion_deg;
  const auto after = std::lower_bound(at.begin(), at.end(), flexion_deg - rounding_deg);
  if (after == at.end()) return nan;
  const auto i = static_cast<std::size_t>(after - at.begin());
  if (at[i] - flexion_deg <= rounding_deg) return curve.value[i];
  if (i == 0) return nan;
  const double share = (flexion_deg - at[i - 1]) / (at[i] - at[i - 1]);
  return curve.value[i - 1] + share * (curve.value[i] - curve.value[i - 1]);
}

namespace {

/// Of a polygon, the largest change within a window has a corner at one end, and at the other a corner or the
/// width of the window.
void set_largest_change(CurveFigures& figures, const FlexionCurve& curve)
{
  const auto& at = curve.flexion_deg;
  const auto compare = [&](double from_deg, double to_deg) {
    const double change_deg = value_at(curve, to_deg, 0.0) - value_at(curve, from_deg, 0.0);
    const bool is_narrower = to_deg - from_deg < figures.change_to_deg - figures.change_from_deg;
    const double least_deg = std::abs(figures.change_deg);  // the comparisons are false for NaN
    if (std::abs(change_deg) < least_deg || (std::abs(change_deg) == least_deg && !is_narrower)) return;
    figures.change_deg = change_deg;
    figures.change_from_deg = from_deg;
    figures.change_to_deg = to_deg;
  };
  for (std::size_t i = 0; i < at.size(); ++i) {
    for (std::size_t k = i + 1; k < at.size() && at[k] - at[i] <= change_window_deg; ++k)
      compare(at[i], at[k]);
    compare(at[i], std::min(at[i] + change_window_deg, at.back()));
    compare(std::max(at[i] - change_window_deg, at.front()), at[i]);
  }
}

}  // namespace

CurveFigures curve_figures(const FlexionCurve& curve)
{
  FlexionCurve known;
  for (std::size_t i = 0; i < curve.value.size(); ++i)
    if (!std::isnan(curve.value[i])) known.add(curve.flexion_deg[i], curve.value[i]);
  CurveFigures figures;
  if (known.value.size() < 2) return figures;
  figures.first_deg = known.flexion_deg.front();
  figures.last_deg = known.flexion_deg.back();
  figures.net_deg = known.value.back() - known.value.front();
  for (std::size_t i = 0; i < known.value.size(); ++i) {
    const double turned_deg = known.value[i] - known.value.front();
    if (std::abs(turned_deg) <= std::abs(figures.peak_deg)) continue;
    figures.peak_deg = turned_deg;
    figures.peak_at_deg = known.flexion_deg[i];
  }
  if (std::ranges::is_sorted(known.flexion_deg, std::ranges::less_equal{}))
    set_largest_change(figures, known);
  return figures;
}

FlexionCurve spine_rotation(const store::MotionModel& model)
{
  FlexionCurve curve;
  const store::ClinicalCurves clinical = store::clinical_curves(model);
  for (Eigen::Index i = 0; i < model.is_spine.rows(); ++i) {
    for (Eigen::Index j = 0; j < model.is_spine.cols(); ++j) {
      if (model.is_spine(i, j) != 1) continue;
      // Past gimbal lock the measured flexion of a frame turns over; its curve does not.
      curve.add(model.frames ? clinical.surfaces[JointCoordinate::flexion](i, j)
                             : model.flexion_deg[static_cast<std::size_t>(i)],
                clinical.surfaces[JointCoordinate::internal](i, j));
    }
  }
  return curve;
}

SpineJump spine_jump(const store::MotionModel& model)
{
  SpineJump jump;
  if (model.frames) return jump;
  double before_deg = nan;
  for (Eigen::Index i = 0; i < model.is_spine.rows(); ++i) {
    double here_deg = nan;
    for (Eigen::Index j = 0; j < model.is_spine.cols(); ++j)
      if (model.is_spine(i, j) == 1 && model.status(i, j) == status_stable) here_deg = model.theta_deg(i, j);
    const double change_deg = std::abs(nearest_turn(here_deg, before_deg, 360.0) - before_deg);
    before_deg = here_deg;
    if (std::isnan(change_deg) || change_deg <= jump.change_deg) continue;  // the second is false for NaN
    const auto row = static_cast<std::size_t>(i);
    jump = {change_deg, model.flexion_deg[row - 1], model.flexion_deg[row]};
  }
  return jump;
}

std::string text_of(const SpineJump& jump)
{
  if (!(jump.change_deg > spine_jump_deg)) return "";
  std::array<char, 120> text{};
  std::snprintf(text.data(), text.size(),
                "theta jumps by %.3g degrees between flexion %.4g and %.4g of the spine", jump.change_deg,
                jump.from_deg, jump.to_deg);
  return text.data();
}

std::string text_of(const CurveFigures& figures)
{
  if (std::isnan(figures.net_deg)) return "none";
  const auto tenths = [](double deg) { return std::round(10.0 * deg) / 10.0 + 0.0; };
  std::array<char, 240> text{};
  int n = std::snprintf(text.data(), text.size(),
                        "net %+.3g degrees from flexion %.4g to %.4g, peak %+.3g at %.4g",
                        tenths(figures.net_deg), tenths(figures.first_deg), tenths(figures.last_deg),
                        tenths(figures.peak_deg), tenths(figures.peak_at_deg));
  if (!std::isnan(figures.change_deg))
    std::snprintf(text.data() + n, text.size() - static_cast<std::size_t>(n),
                  ", largest change %+.3g per %g degrees of flexion (%.4g to %.4g)",
                  tenths(figures.change_deg), change_window_deg, tenths(figures.change_from_deg),
                  tenths(figures.change_to_deg));
  return text.data();
}

}  // namespace vrda::store
