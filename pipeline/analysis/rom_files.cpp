#include "analysis/rom_files.hpp"

#include <nlohmann/json.hpp>

#include <algorithm>
#include <cmath>

#include "analysis/result_journal.hpp"
#include "core/document.hpp"
#include "core/fields_json.hpp"
#include "core/text.hpp"
#include "core/units.hpp"
#include "job/job.hpp"
#include "model/coordinates.hpp"
#include "solve/case_solver.hpp"

namespace vrda::analysis {
namespace {

using Json = nlohmann::ordered_json;

constexpr const char* format_name = "vrda range of motion";
constexpr int rom_version = 2;
constexpr std::size_t most_cells = 10'000'000;

std::vector<std::string> component_names(const Body& body)
{
  std::vector<std::string> names;
  for (const Component& component : body.components) names.push_back(component.name);
  return names;
}

// Of an angle in radians, without the rounding of its conversion.
std::string degree_field(double rad)
{
  constexpr double a_degree = 1e9;
  return csv_number(std::round(deg_from_rad(rad) * a_degree) / a_degree + 0.0);
}

/// The first columns of the row of a cell, with the comma after each.
std::string attitude_fields(const RomAxes& axes, std::size_t cell)
{
  const std::array<double, 3> rad = axes.rotations_at(cell);
  return degree_field(rad[0]) + ',' + degree_field(rad[1]) + ',' + degree_field(rad[2]) + ',';
}

std::string name_at(const std::vector<std::string>& names, std::int32_t row)
{
  return row >= 0 && static_cast<std::size_t>(row) < names.size() ? names[static_cast<std::size_t>(row)] : "";
}

RomAxes axes_of(const core::JsonFile& reader)
{
  RomAxes axes;
  for (std::size_t a = 0; a < 3; ++a) {
    const std::string key = std::string("axes/") + rotation_names[a];
    for (const double deg : reader.numbers(key, 0, 0.0)) {
      const double rad = rad_from_deg(deg);
      if (!axes.rad[a].empty() && !(rad > axes.rad[a].back()))
        reader.refuse(key, "not ascending", "ascending angles");
      axes.rad[a].push_back(rad);
    }
    if (axes.rad[a].empty()) reader.refuse(key, "an empty list", "at least one angle");
  }
  if (axes.n_cells() > most_cells)
    reader.refuse("axes", "more cells", std::to_string(most_cells) + " at most");
  return axes;
}

std::int32_t row_in(const core::JsonFile& reader, const std::string& key, double value, std::size_t n)
{
  if (!(value >= -1.0 && value < static_cast<double>(n)) || value != std::floor(value))
    reader.refuse(key, shortest_decimal(value), "a row below " + std::to_string(n) + ", or -1");
  return static_cast<std::int32_t>(value);
}

std::vector<RomCell> cells_of(const core::JsonFile& reader, const RomDocument& document, std::size_t n)
{
  const std::vector<double> status = reader.numbers("cells/status", n, 0.0);
  const std::vector<double> opening = reader.numbers("cells/opening_mm", n, nan);
  const std::vector<double> strain = reader.numbers("cells/largest_strain", n, nan);
  const std::vector<double> translation = reader.numbers("cells/translation_mm", 3 * n, 0.0);
  const std::vector<double> reference = reader.numbers("cells/component_reference", n, 0.0);
  const std::vector<double> moving = reader.numbers("cells/component_moving", n, 0.0);
  const std::vector<double> fibre = reader.numbers("cells/fibre", n, 0.0);
  const std::vector<double> connected = reader.numbers("cells/connected", n, 0.0);
  std::vector<RomCell> cells(n);
  for (std::size_t k = 0; k < n; ++k) {
    RomCell& cell = cells[k];
    const std::int32_t code = row_in(reader, "cells/status", status[k], std::size(rom_status_names));
    if (code < 0) reader.refuse("cells/status", "-1", "0 to 5");
    cell.status = static_cast<RomStatus>(code);
    cell.opening_mm = opening[k];
    cell.largest_strain = strain[k];
    cell.translation_mm = Eigen::Vector3d(translation[3 * k], translation[3 * k + 1], translation[3 * k + 2]);
    cell.component_reference =
        row_in(reader, "cells/component_reference", reference[k], document.reference_names.size());
    cell.component_moving = row_in(reader, "cells/component_moving", moving[k], document.moving_names.size());
    cell.fibre = row_in(reader, "cells/fibre", fibre[k], document.fibre_names.size());
    cell.is_connected = connected[k] == 1.0;
  }
  return cells;
}

RangeEnd end_at(const RangeOfMotion& range, const std::array<std::size_t, 3>& from, std::size_t axis,
                int direction)
{
  std::array<std::size_t, 3> at = from;
  const auto n = static_cast<std::ptrdiff_t>(range.axes.rad[axis].size());
  RangeEnd end;
  for (std::ptrdiff_t k = static_cast<std::ptrdiff_t>(from[axis]);; k += direction) {
    if (k < 0 || k >= n) {
      end.is_of_axis = true;
      return end;
    }
    at[axis] = static_cast<std::size_t>(k);
    const RomCell& cell = range.cells[cell_at(range.axes, at[0], at[1], at[2])];
    if (cell.status != RomStatus::in_range) {
      end.beyond = cell.status;
      end.component_reference = cell.component_reference;
      end.component_moving = cell.component_moving;
      end.fibre = cell.fibre;
      return end;
    }
    end.deg = deg_from_rad(range.axes.rad[axis][at[axis]]);
  }
}

}  // namespace

RomDocument rom_document(const job::Case& job_case, const RangeOfMotion& range, const std::string& program)
{
  std::vector<std::string> fibre_names;
  for (const model::Fibre& fibre : job_case.ligaments.fibres) fibre_names.push_back(fibre.name);
  return {program,
          job_case.title,
          job_case.joint,
          job_case.frame.side == Side::left ? "left" : "right",
          job_case.resolved_job,
          job_case.inputs,
          component_names(job_case.reference),
          component_names(job_case.moving),
          fibre_names,
          range};
}

std::string rom_json(const RomDocument& document)
{
  const RangeOfMotion& range = document.range;
  Json axes, cells, inputs = Json::array();
  for (std::size_t a = 0; a < 3; ++a) axes[rotation_names[a]] = degrees(range.axes.rad[a]);
  for (const job::LoadedInput& input : document.inputs)
    inputs.push_back({{"name", input.name}, {"sha256", input.sha256}});
  for (const RomCell& cell : range.cells) {
    cells["status"].push_back(static_cast<int>(cell.status));
    cells["connected"].push_back(cell.is_connected ? 1 : 0);
    cells["opening_mm"].push_back(core::json_value(cell.opening_mm));
    for (const double mm : cell.translation_mm) cells["translation_mm"].push_back(mm);
    cells["largest_strain"].push_back(core::json_value(cell.largest_strain));
    cells["component_reference"].push_back(cell.component_reference);
    cells["component_moving"].push_back(cell.component_moving);
    cells["fibre"].push_back(cell.fibre);
  }
  Json pose = Json::array();
  for (Eigen::Index r = 0; r < 4; ++r) {
    for (Eigen::Index c = 0; c < 4; ++c) pose.push_back(range.X_neutral.matrix()(r, c));
  }
  Json names = Json::array();
  for (const Named<RomStatus>& status : rom_status_names) names.push_back(status.name);
  const Json json = {
      {"format", format_name},
      {"version", rom_version},
      {"program", document.program},
      {"title", document.title},
      {"joint", document.joint},
      {"side", document.side},
      {"job", document.job},
      {"inputs", inputs},
      {"axes", axes},
      {"limits",
       {{"translation_mm", core::json_value(range.limits.translation_mm)},
        {"opening_mm", range.limits.opening_mm},
        {"strain", range.limits.strain}}},
      {"delta_of", name_of(range.delta_body)},
      {"neutral", {{"cell", range.neutral}, {"X_reference_moving", pose}}},
      {"statuses", names},
      {"components", {{"reference", document.reference_names}, {"moving", document.moving_names}}},
      {"fibres", document.fibre_names},
      {"cells", cells}};
  return core::json_text(json, -1) + "\n";
}

RomDocument parse_rom(const std::string& file, const std::string& text)
{
  const core::JsonFile reader(file, text, "rom.json of vrda rom");
  if (reader.text("format") != format_name) reader.refuse("format", reader.text("format"), format_name);
  if (reader.number("version") != rom_version)
    reader.refuse("version", core::shown_json(reader.at("version")), std::to_string(rom_version));
  RomDocument document;
  document.program = reader.text("program");
  document.title = reader.text("title");
  document.joint = reader.text("joint");
  if (std::find(joint_kind_names.begin(), joint_kind_names.end(), document.joint) == joint_kind_names.end())
    reader.refuse("joint", '"' + document.joint + '"', "a kind of joint");
  document.side = reader.text("side");
  document.job = reader.text("job");
  document.reference_names = reader.texts("components/reference");
  document.moving_names = reader.texts("components/moving");
  document.fibre_names = reader.texts("fibres");
  RangeOfMotion& range = document.range;
  range.axes = axes_of(reader);
  const bool is_free = reader.at("limits/translation_mm").is_null();
  range.limits.translation_mm =
      is_free ? std::numeric_limits<double>::infinity() : reader.number("limits/translation_mm");
  range.limits.opening_mm = reader.number("limits/opening_mm");
  range.limits.strain = reader.number("limits/strain");
  range.delta_body = value_named<BodyIndex>(reader.text("delta_of")).value_or(BodyIndex::moving);
  const std::vector<double> neutral = reader.numbers("neutral/cell", 3, 0.0);
  for (std::size_t a = 0; a < 3; ++a) {
    const std::int32_t row = row_in(reader, "neutral/cell", neutral[a], range.axes.rad[a].size());
    if (row < 0) reader.refuse("neutral/cell", "-1", "a row");
    range.neutral[a] = static_cast<std::size_t>(row);
  }
  const std::vector<double> pose = reader.numbers("neutral/X_reference_moving", 16, 0.0);
  for (Eigen::Index k = 0; k < 16; ++k)
    range.X_neutral.matrix()(k / 4, k % 4) = pose[static_cast<std::size_t>(k)];
  range.cells = cells_of(reader, document, range.axes.n_cells());
  return document;
}

std::string rom_csv(const RomDocument& document)
{
  const RangeOfMotion& range = document.range;
  std::string text =
      "flexion_deg,varus_deg,internal_deg,status,connected,opening_mm,translation_x_mm,translation_y_mm,"
      "translation_z_mm,largest_strain,fibre,reference_component,moving_component\n";
  for (std::size_t row = 0; row < range.cells.size(); ++row) {
    const RomCell& cell = range.cells[row];
    text += attitude_fields(range.axes, row) + name_of(cell.status) + (cell.is_connected ? ",1," : ",0,") +
            csv_number(cell.opening_mm);
    for (Eigen::Index c = 0; c < 3; ++c) text += ',' + csv_number(cell.translation_mm[c]);
    text += ',' + csv_number(cell.largest_strain) + ',' + name_at(document.fibre_names, cell.fibre) + ',' +
            name_at(document.reference_names, cell.component_reference) + ',' +
            name_at(document.moving_names, cell.component_moving) + '\n';
  }
  return text;
}

std::vector<RangeAlong> boundaries_of(const RangeOfMotion& range)
{
  std::vector<RangeAlong> list;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    if (range.axes.rad[axis].size() == 1) continue;
    const std::size_t b = axis == 0 ? 1 : 0, c = axis == 2 ? 1 : 2;
    for (std::size_t i = 0; i < range.axes.rad[b].size(); ++i) {
      for (std::size_t k = 0; k < range.axes.rad[c].size(); ++k) {
        RangeAlong along;
        along.axis = axis;
        along.at[axis] = range.neutral[axis];
        along.at[b] = i;
        along.at[c] = k;
        along.is_empty = range.cells[cell_at(range.axes, along.at[0], along.at[1], along.at[2])].status !=
                         RomStatus::in_range;
        if (!along.is_empty) {
          along.low = end_at(range, along.at, axis, -1);
          along.high = end_at(range, along.at, axis, 1);
        }
        list.push_back(along);
      }
    }
  }
  return list;
}

std::string cause_of(const RomDocument& document, const RangeEnd& end)
{
  if (end.is_of_axis) return "end of the driven values";
  if (end.beyond == RomStatus::fibre)
    return std::string(name_of(end.beyond)) + ": " + name_at(document.fibre_names, end.fibre);
  const std::string reference = name_at(document.reference_names, end.component_reference);
  if (reference.empty()) return name_of(end.beyond);
  return std::string(name_of(end.beyond)) + ": " + reference + " on " +
         name_at(document.moving_names, end.component_moving);
}

std::string boundary_csv(const RomDocument& document)
{
  const RangeOfMotion& range = document.range;
  std::string text =
      "along,flexion_deg,varus_deg,internal_deg,from_deg,from_ended_by,from_reference,from_moving,from_fibre,"
      "to_deg,to_ended_by,to_reference,to_moving,to_fibre\n";
  for (const RangeAlong& along : boundaries_of(range)) {
    text += rotation_names[along.axis];
    for (std::size_t a = 0; a < 3; ++a)
      text += ',' + (a == along.axis ? "" : degree_field(range.axes.rad[a][along.at[a]]));
    for (const RangeEnd& end : {along.low, along.high}) {
      text += along.is_empty ? std::string(",,,,,")
                             : ',' + degree_field(rad_from_deg(end.deg)) + ',' +
                                   (end.is_of_axis ? "not_tried" : name_of(end.beyond)) + ',' +
                                   name_at(document.reference_names, end.component_reference) + ',' +
                                   name_at(document.moving_names, end.component_moving) + ',' +
                                   name_at(document.fibre_names, end.fibre);
    }
    text += '\n';
  }
  return text;
}

RomComparison compare_ranges(const RangeOfMotion& a, const RangeOfMotion& b, const std::string& file_b)
{
  for (std::size_t axis = 0; axis < 3; ++axis) {
    if (a.axes.rad[axis] == b.axes.rad[axis]) continue;
    throw InputError({file_b, std::string("axes.") + rotation_names[axis], "other angles than the first file",
                      "two ranges over the same rotations"});
  }
  const auto in = [](const RangeOfMotion& range, std::size_t cell) {
    return range.cells[cell].status == RomStatus::in_range;
  };
  return {volume_of(a), volume_of(b), volume_of(a, [&](std::size_t k) { return in(a, k) && in(b, k); }),
          volume_of(a, [&](std::size_t k) { return in(a, k) && !in(b, k); }),
          volume_of(a, [&](std::size_t k) { return !in(a, k) && in(b, k); })};
}

std::string comparison_csv(const RomDocument& a, const RomDocument& b)
{
  std::string text = "flexion_deg,varus_deg,internal_deg,first,second,first_opening_mm,second_opening_mm\n";
  for (std::size_t row = 0; row < a.range.cells.size(); ++row) {
    const RomCell &one = a.range.cells[row], &other = b.range.cells[row];
    text += attitude_fields(a.range.axes, row) + name_of(one.status) + ',' + name_of(other.status) + ',' +
            csv_number(one.opening_mm) + ',' + csv_number(other.opening_mm) + '\n';
  }
  return text;
}

namespace {

constexpr JournalFormat lines_format{{"VRDAROMJ", 2, std::uint32_t{1} << 28, "line"},
                                     "another job, other rotations or other limits"};
// Must be changed when the same job may give other cells.
constexpr const char* rom_solver = "highest seat 1";

auto adds_to(RomLines& lines)
{
  return [&lines](RomLine line) {
    const std::pair at{line.axis, line.at};
    lines.insert_or_assign(at, std::move(line));
  };
}

}  // namespace

std::string rom_key(const job::Case& job_case, const RomPlan& plan)
{
  std::string text = std::string(rom_solver) + '\n' + solve::fingerprint_of(job_case);
  for (const std::vector<double>& axis : plan.axes.rad) {
    text += '\n';
    for (const double rad : axis) text += shortest_decimal(rad) + ' ';
  }
  for (const double limit : {plan.limits.translation_mm, plan.limits.opening_mm, plan.limits.strain})
    text += '\n' + (std::isfinite(limit) ? shortest_decimal(limit) : "free");
  return job::sha256_of(text + '\n' + std::to_string(static_cast<int>(plan.delta_body)));
}

void read_lines(const std::string& path, const std::string& key, RomLines& lines)
{
  read_journal<RomLine>(path, key, lines_format, adds_to(lines));
}

core::FrameWriter open_lines(const std::string& path, const std::string& key, bool is_fresh, RomLines& lines)
{
  return open_journal<RomLine>(path, key, is_fresh, lines_format, adds_to(lines));
}

}  // namespace vrda::analysis
