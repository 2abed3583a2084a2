#include "tables/motion_table.hpp"

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <span>
#include <utility>

#include "core/text.hpp"
#include "core/units.hpp"
#include "job/job.hpp"
#include "job/mesh_file.hpp"
#include "model/coordinates.hpp"
#include "model/linear_algebra.hpp"

namespace vrda::tables {

std::string opensim_name(const std::string& text)
{
  std::string name;
  for (const char c : text) {
    const bool is_plain = (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') ||
                          c == '_' || c == '-' || c == '.';
    name += is_plain ? c : '_';
  }
  return name.empty() ? "unnamed" : name;
}

std::string length_unit_name(double length_mm)
{
  return length_mm == 1000.0 ? "m" : length_mm == 10.0 ? "cm" : "mm";
}

std::map<std::string, std::string> names_by_coordinate(const std::string& command, const std::string& option,
                                                       const std::vector<std::string>& texts)
{
  std::map<std::string, std::string> names;
  for (const std::string& text : texts) {
    const std::size_t equals = text.find('=');
    const bool has_sign = equals != std::string::npos && text.find_first_of("+-", equals) == equals + 1;
    if (equals == std::string::npos || equals == 0 || equals + (has_sign ? 2 : 1) >= text.size())
      throw InputError({command, option, text, "COORDINATE=NAME, such as flexion=knee_angle_r"});
    if (!names.emplace(text.substr(0, equals), text.substr(equals + 1)).second)
      throw InputError({command, option, text.substr(0, equals) + " twice", "once"});
  }
  return names;
}

Convention completed(const StatedConvention& stated, const StatedConvention& file, Side joint_side)
{
  const auto chosen = [](const auto& first, const auto& second, auto otherwise) {
    return first ? *first : second.value_or(otherwise);
  };
  const Convention standard;
  return {chosen(stated.length_mm, file.length_mm, standard.length_mm),
          chosen(stated.angles, file.angles, standard.angles),
          chosen(stated.order, file.order, standard.order),
          chosen(stated.direction, file.direction, standard.direction),
          chosen(stated.axes, file.axes, standard.axes),
          chosen(stated.side, file.side, joint_side),
          chosen(stated.lengths, file.lengths, standard.lengths)};
}

namespace {

/// A gigabyte would be 100000 frames of 10000 characters.
constexpr std::uintmax_t largest_file = std::uintmax_t{1} << 28;
constexpr double largest_number = 1e9;
/// Keys may be no nearer: rates between them must be finite (as in a motion model).
constexpr double min_key_step = 1e-9;
/// Of the last row of a 4 x 4 matrix: rounding of text.
constexpr double last_row_tolerance = 1e-6;

using Fields = std::vector<std::string_view>;

struct Row {
  int line = 0;
  Fields fields;
};

/// The fields of a file, whose text must outlive them.
struct FieldTable {
  std::string file;
  int name_line = 0;
  std::vector<std::string> names;  ///< empty in a .tra file
  std::vector<Row> rows;
  TableHeader header = {};
  bool is_opensim = false;

  [[noreturn]] void refuse(int line, const std::string& column, const std::string& found,
                           const std::string& wanted) const
  {
    throw InputError({file, column, found, wanted, line});
  }

  double number(const Row& row, std::size_t column) const
  {
    const std::string_view text = row.fields[column];
    const std::optional<double> value = job::parse_real(text);
    if (value && std::abs(*value) <= largest_number) return *value;
    const std::string name =
        names.empty() ? "column " + std::to_string(column + 1) : "column " + names[column];
    const std::string found = text.empty()                                 ? "nothing"
                              : value && std::isnan(*value)                ? "NaN"
                              : value && std::abs(*value) > largest_number ? std::string(text)
                                                                           : '"' + std::string(text) + '"';
    refuse(row.line, name, found,
           value ? "a finite number of magnitude up to 1e9; leave out frames without a pose"
                 : job::wanted_number(text) + " of magnitude up to 1e9; leave out frames without a pose");
  }
};

void add_rows(FieldTable& table, const std::vector<job::TableLine>& lines, std::size_t first,
              const std::function<Fields(std::string_view)>& split)
{
  if (lines.size() - first > max_frames) {
    table.refuse(0, "", std::to_string(lines.size() - first) + " rows",
                 "at most " + std::to_string(max_frames));
  }
  for (std::size_t i = first; i < lines.size(); ++i) {
    Row row{static_cast<int>(lines[i].number), split(lines[i].text)};
    const std::size_t wanted = table.names.empty() && !table.rows.empty() ? table.rows[0].fields.size()
                               : table.names.empty()                      ? row.fields.size()
                                                                          : table.names.size();
    if (row.fields.size() != wanted) {
      table.refuse(row.line, "", std::to_string(row.fields.size()) + " fields",
                   std::to_string(wanted) + ", as many as " +
                       (table.names.empty() ? "in the first row" : "there are column names"));
    }
    table.rows.push_back(std::move(row));
  }
  if (table.rows.empty()) table.refuse(0, "", "no row of numbers", "one row for each frame");
}

void set_names(FieldTable& table, const job::TableLine& line, const Fields& names)
{
  table.name_line = static_cast<int>(line.number);
  for (const std::string_view name : names) {
    if (!is_utf8(name) || has_control_characters(name))
      table.refuse(table.name_line, "", "a column name that is not plain text", "column names in UTF-8");
    table.names.emplace_back(name);
  }
}

FieldTable csv_table(const std::string& file, std::string_view text)
{
  FieldTable table{file, 0, {}, {}};
  const std::vector<job::TableLine> lines = job::table_lines(text);
  if (lines.empty())
    table.refuse(0, "", "no line except comments", "column names, then one row for each frame");
  table.header = table_header(file, text, lines[0].number);  // of comments
  const char separator = job::separator_of(lines[0].text);
  const auto split = [separator](std::string_view line) { return job::split_fields(line, separator); };
  set_names(table, lines[0], split(lines[0].text));
  add_rows(table, lines, 1, split);
  return table;
}

FieldTable opensim_table(const std::string& file, std::string_view text)
{
  FieldTable table{file, 0, {}, {}};
  const std::vector<job::TableLine> lines = job::table_lines(text);
  std::size_t i = 0;
  while (i < lines.size() && lower_case(std::string(job::trimmed(lines[i].text))) != "endheader") ++i;
  if (i >= lines.size()) table.refuse(0, "", "no line \"endheader\"", "the header of an OpenSim table");
  table.header = table_header(file, text, lines[i].number);
  table.is_opensim = true;
  if (i + 1 >= lines.size())
    table.refuse(0, "", "no line after endheader", "column names, then one row for each frame");
  set_names(table, lines[i + 1], job::split_words(lines[i + 1].text));
  add_rows(table, lines, i + 2, job::split_words);
  return table;
}

Fields comma_or_blank_fields(std::string_view line)
{
  const char separator = job::separator_of(line);
  return separator == '\t' || line.find(separator) == line.npos ? job::split_words(line)
                                                                : job::split_fields(line, separator);
}

FieldTable autoscoper_table(const std::string& file, std::string_view text)
{
  FieldTable table{file, 0, {}, {}};
  add_rows(table, job::table_lines(text), 0, comma_or_blank_fields);
  const std::size_t n = table.rows[0].fields.size();
  if (n != 16 && n != 12)
    table.refuse(table.rows[0].line, "", std::to_string(n) + " numbers",
                 "the 16 or 12 of a matrix, row by row");
  return table;
}

std::optional<std::size_t> column_named(const FieldTable& table, const std::string& name)
{
  std::optional<std::size_t> found;
  for (std::size_t k = 0; k < table.names.size(); ++k) {
    if (table.names[k] != name && coordinate_name(table.names[k]) != name) continue;
    if (found) table.refuse(table.name_line, "column " + name, "twice", "once");
    found = k;
  }
  return found;
}

std::size_t required_column(const FieldTable& table, const std::string& name)
{
  const std::optional<std::size_t> found = column_named(table, name);
  if (found) return *found;
  table.refuse(
      table.name_line, "", "no column " + name,
      table.names.empty() ? "column names" : "it; the nearest is " + nearest_word(name, table.names));
}

/// Three columns of one meaning, about or along X, Y and Z.
struct Family {
  bool is_clinical;
  std::optional<LengthPoint> point;                    ///< stated by the names
  std::optional<double> length_mm;                     ///< unit stated by the names without a suffix
  std::array<const char*, 3> coordinate;               ///< of --column; "" none
  std::array<std::vector<std::string>, 3> base_names;  ///< by preference, without a unit
};

const std::vector<Family>& angle_families()
{
  static const std::vector<Family> families{
      {true,
       {},
       {},
       {"varus", "internal", "flexion"},
       {with_opensim_names({"clinical_varus", "varus"}, "add"),
        with_opensim_names({"internal_rotation", "internal"}, "rot"),
        with_opensim_names({"clinical_flexion", "flexion"}, "flex")}},
      {false, {}, {}, {"rx", "ry", "rz"}, {{{"rx", "xrot"}, {"ry", "yrot"}, {"rz", "zrot"}}}}};
  return families;
}

// The world translations of an export (tx_mm, ...) come last: they are not those of the pose.
const std::vector<Family>& length_families()
{
  static const std::vector<Family> families{
      {true, LengthPoint::origin, {}, {"ant", "prox", "lat"}, {{{"ant"}, {"prox"}, {"lat"}}}},
      {false,
       LengthPoint::origin,
       1000.0,
       {"", "", ""},
       {with_opensim_names({}, "tx"), with_opensim_names({}, "ty"), with_opensim_names({}, "tz")}},
      {true,
       LengthPoint::grood_suntay,
       {},
       {"anterior", "proximal", "lateral"},
       {{{"anterior", "gs_anterior"}, {"proximal", "gs_proximal"}, {"lateral", "gs_lateral"}}}},
      {false,
       {},
       {},
       {"tx", "ty", "tz"},
       {{{"tx", "xtrans", "x"}, {"ty", "ytrans", "y"}, {"tz", "ztrans", "z"}}}}};
  return families;
}

struct Unit {
  const char* suffix;
  double value;
};
constexpr Unit angle_units[] = {{"_deg", 0.0}, {"_rad", 1.0}};
constexpr Unit length_units[] = {{"_mm", 1.0}, {"_cm", 10.0}, {"_m", 1000.0}};

/// The columns of a family, their signs, and the unit in their names.
struct FoundFamily {
  const Family* family = nullptr;
  std::array<std::size_t, 3> column{};
  std::array<double, 3> sign{};
  std::optional<double> unit;
};

std::string without_sign(const std::string& column)
{
  return column.find_first_of("+-") == 0 ? column.substr(1) : column;
}

/// The sign that the user gives, else that of the header.
double sign_of(const FieldTable& table, const TableColumns& columns, const char* coordinate,
               std::size_t column)
{
  const auto named = columns.of_coordinate.find(coordinate);
  if (named != columns.of_coordinate.end() && without_sign(named->second) != named->second)
    return named->second[0] == '-' ? -1.0 : 1.0;
  for (const std::string& negated : table.header.negated_columns)
    if (required_column(table, negated) == column) return -1.0;
  return 1.0;
}

template <typename Units>
std::optional<std::size_t> column_of(const FieldTable& table, const TableColumns& columns,
                                     const Family& family, std::size_t axis, const Units& units)
{
  const auto named = columns.of_coordinate.find(family.coordinate[axis]);
  if (named != columns.of_coordinate.end()) return required_column(table, without_sign(named->second));
  for (const std::string& base : family.base_names[axis]) {
    if (const auto column = column_named(table, base)) return column;
    for (const Unit& unit : units)
      if (const auto column = column_named(table, base + unit.suffix)) return column;
  }
  return std::nullopt;
}

template <typename Units>
std::optional<double> common_unit(const FieldTable& table, const FoundFamily& found, const Units& units)
{
  std::optional<double> common;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    std::optional<double> here;
    for (const Unit& unit : units)
      if (table.names[found.column[axis]].ends_with(unit.suffix)) here = unit.value;
    if (axis > 0 && here != common) {
      table.refuse(table.name_line, "column " + table.names[found.column[axis]],
                   "another unit than in column " + table.names[found.column[0]], "one unit");
    }
    common = here;
  }
  return common;
}

/// The first family of which the table has all columns. Refuses a table without any.
template <typename Units>
FoundFamily found_family(const FieldTable& table, const TableColumns& columns,
                         const std::vector<Family>& families, const Units& units, const std::string& what)
{
  std::string missing;
  for (const Family& family : families) {
    FoundFamily found{&family, {}, {}, {}};
    std::size_t n = 0;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const std::optional<std::size_t> column = column_of(table, columns, family, axis, units);
      if (column) {
        found.column[axis] = *column;
        found.sign[axis] = sign_of(table, columns, family.coordinate[axis], *column);
        ++n;
      } else if (missing.empty() && n > 0) {
        missing = family.base_names[axis].front();
      }
    }
    if (n < 3) continue;
    found.unit = common_unit(table, found, units);
    if (!found.unit) found.unit = family.length_mm;
    return found;
  }
  table.refuse(table.name_line, "",
               missing.empty() ? "no columns of " + what : "no column " + missing + ", one of three " + what,
               "matrices (T11 to T34), or " + what + " named as in schemas/motion-files.md or by --column");
}

/// A column and what its numbers are multiplied by: rad or mm.
struct NumberColumn {
  std::size_t column = 0;
  double factor = 1.0;
};

/// Suffixes of a column's name, in the order in which they are looked for.
std::span<const Unit> units_of(std::size_t coordinate)
{
  if (is_rotation(coordinate)) return angle_units;
  return length_units;
}

/// The unit in a column's name, else that of the header or degrees, and of an OpenSim table m, of others mm.
double follower_unit(const FieldTable& table, const std::string& column, std::size_t coordinate)
{
  constexpr double degree = rad_from_deg(1.0);
  for (const Unit& unit : units_of(coordinate))
    if (column.ends_with(unit.suffix)) return unit.value > 0.0 ? unit.value : degree;
  if (is_rotation(coordinate)) return table.header.angles == AngleUnit::radians ? 1.0 : degree;
  return table.is_opensim ? 1000.0 : 1.0;
}

std::optional<NumberColumn> follower_column(const FieldTable& table, const std::string& follower,
                                            std::size_t coordinate,
                                            const std::map<std::string, std::string>& columns)
{
  const auto number_column = [&](std::size_t column, double sign) {
    return NumberColumn{column, sign * follower_unit(table, table.names[column], coordinate)};
  };
  const std::string word = follower_coordinate_names[coordinate];
  const auto named = columns.find(word);
  if (named != columns.end())
    return number_column(required_column(table, without_sign(named->second)),
                         named->second[0] == '-' ? -1.0 : 1.0);
  for (const std::string& own : {follower, opensim_name(follower)}) {
    for (const std::string& name : {"follower_" + own + "_" + word, own + "_" + word}) {
      if (const auto column = column_named(table, name)) return number_column(*column, 1.0);
      for (const Unit& unit : units_of(coordinate))
        if (const auto column = column_named(table, name + unit.suffix)) return number_column(*column, 1.0);
    }
  }
  return std::nullopt;
}

void require_known_coordinates(const FieldTable& table, const TableColumns& columns)
{
  std::vector<std::string> known;
  for (const auto* families : {&angle_families(), &length_families()})
    for (const Family& family : *families)
      for (const char* name : family.coordinate)
        if (*name != '\0') known.emplace_back(name);
  for (const auto& [coordinate, column] : columns.of_coordinate) {
    if (std::find(known.begin(), known.end(), coordinate) == known.end())
      table.refuse(0, "--column", "the coordinate \"" + coordinate + "\"", join_alternatives(known));
  }
}

/// The columns of an export that name the point of its translations.
std::optional<Eigen::Vector3d> point_of_columns(const FieldTable& table)
{
  Eigen::Vector3d point_mm = Eigen::Vector3d::Zero();
  for (const int axis : {0, 1, 2}) {
    const std::string name = std::string("centre_") + "xyz"[axis] + "_mm";
    const std::optional<std::size_t> column = column_named(table, name);
    if (!column) return std::nullopt;
    point_mm[axis] = table.number(table.rows[0], *column);
    for (const Row& row : table.rows) {
      if (table.number(row, *column) == point_mm[axis]) continue;
      table.refuse(row.line, "column " + name, std::string(row.fields[*column]), "one point in all rows");
    }
  }
  return point_mm;
}

void add_coordinates(MotionTable& motion, const FieldTable& table, const TableColumns& columns)
{
  require_known_coordinates(table, columns);
  const FoundFamily angles = found_family(table, columns, angle_families(), angle_units, "rotations");
  const FoundFamily lengths = found_family(table, columns, length_families(), length_units, "lengths");
  motion.are_angles_clinical = angles.family->is_clinical;
  motion.are_lengths_clinical = lengths.family->is_clinical;
  StatedConvention& stated = motion.stated;
  if (angles.unit) stated.angles = *angles.unit == 0.0 ? AngleUnit::degrees : AngleUnit::radians;
  if (table.header.angles && table.header.angles != stated.angles)
    motion.warnings.push_back(table.file + ": header and column names differ in the unit of angles: it is " +
                              name_of(*stated.angles));
  if (lengths.unit) stated.length_mm = lengths.unit;
  stated.lengths = table.header.lengths ? table.header.lengths : lengths.family->point;
  motion.point_mm = table.header.point_mm ? table.header.point_mm : point_of_columns(table);
  for (std::size_t axis = 0; axis < 3; ++axis) motion.angle_columns[axis] = table.names[angles.column[axis]];
  if (motion.are_angles_clinical) {
    stated.order = AngleOrder::zxy;
    stated.direction = Direction::moving_in_reference;
    stated.axes = TableAxes::canonical;
  }
  for (const Row& row : table.rows) {
    PoseCoordinates& pose = motion.coordinates.emplace_back();
    for (std::size_t axis = 0; axis < 3; ++axis) {
      pose.angle[axis] = angles.sign[axis] * table.number(row, angles.column[axis]);
      pose.length[axis] = lengths.sign[axis] * table.number(row, lengths.column[axis]);
    }
    // Flexion is a rotation about -Z.
    if (motion.are_angles_clinical) pose.angle[2] = -pose.angle[2];
  }
}

std::string entry_name(const std::string& prefix, std::size_t entry)
{
  return prefix + "T" + std::to_string(entry / 4 + 1) + std::to_string(entry % 4 + 1);
}

std::vector<PoseEntries> matrices_of(const FieldTable& table, const std::string& prefix)
{
  std::array<std::size_t, 12> column{};
  for (std::size_t k = 0; k < column.size(); ++k)
    column[k] = table.names.empty() ? k : required_column(table, entry_name(prefix, k));
  std::vector<PoseEntries> matrices;
  for (const Row& row : table.rows) {
    PoseEntries& entries = matrices.emplace_back();
    for (std::size_t k = 0; k < entries.size(); ++k) entries[k] = table.number(row, column[k]);
    if (!table.names.empty() || row.fields.size() < 16) continue;
    for (std::size_t k = 12; k < 16; ++k) {
      if (std::abs(table.number(row, k) - (k == 15 ? 1.0 : 0.0)) <= last_row_tolerance) continue;
      table.refuse(row.line, "column " + std::to_string(k + 1), std::string(row.fields[k]),
                   "0 0 0 1 in the last four columns: matrices row by row");
    }
  }
  return matrices;
}

/// A name that a motion model accepts (core/text.hpp, is_key_name).
std::string key_name_of(const std::string& column)
{
  std::string name = lower_case(column) == "time" ? "time_s" : lower_case(column);
  for (char& c : name) {
    const bool is_valid = (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9') || c == '_';
    if (!is_valid) c = '_';
  }
  if (name.empty() || name[0] < 'a' || name[0] > 'z') name = "key_" + name;
  return name.substr(0, 40);
}

std::optional<std::size_t> key_column(const FieldTable& table, const TableColumns& columns)
{
  if (!columns.key.empty()) return required_column(table, columns.key);
  if (table.names.empty()) return std::nullopt;
  for (const char* name : {"time", "time_s", "frame", "gait_percent", "stance_percent"})
    if (const auto column = column_named(table, name)) return column;
  // An export of a sequence of frames has its key before the angles.
  const bool is_export = column_named(table, "attitude_flexion_deg").has_value();
  if (is_export && table.names[0] != "flexion_deg") return 0;
  return std::nullopt;
}

void add_keys(MotionTable& motion, const FieldTable& table, const TableColumns& columns)
{
  const std::optional<std::size_t> column = key_column(table, columns);
  motion.key_name =
      column ? key_name_of(table.header.key_name.empty() ? table.names[*column] : table.header.key_name)
             : "frame";
  // An export puts key_ before the name of a key that is also a coordinate's.
  constexpr std::string_view taken = "key_";
  if (motion.key_name.starts_with(taken) && column_named(table, motion.key_name.substr(taken.size())))
    motion.key_name.erase(0, taken.size());
  for (std::size_t i = 0; i < table.rows.size(); ++i) {
    const Row& row = table.rows[i];
    const double key = column ? table.number(row, *column) : static_cast<double>(i + 1);
    if (i > 0 && !(key - motion.key.back() >= min_key_step)) {
      table.refuse(row.line, "column " + table.names[*column],
                   shortest_decimal(key) + " after " + shortest_decimal(motion.key.back()),
                   "keys that increase; --key names another column");
    }
    motion.key.push_back(key);
    motion.line.push_back(row.line);
  }
}

std::string text_of_file(const std::string& file)
{
  std::string text = job::file_bytes(file, {file, "", "", "a table with one pose per frame"}, largest_file);
  job::require_table(file, text);
  job::normalise_text(text);
  return text;
}

FieldTable fields_of(const std::string& file, const std::string& text)
{
  const std::string extension = lower_case(std::filesystem::path(file).extension().string());
  if (extension == ".tra") return autoscoper_table(file, text);
  return extension == ".sto" || extension == ".mot" ? opensim_table(file, text) : csv_table(file, text);
}

}  // namespace

MotionTable motion_table_from_text(const std::string& file, const std::string& text,
                                   const TableColumns& all_columns)
{
  const FieldTable table = fields_of(file, text);
  MotionTable motion;
  motion.file = file;
  motion.stated.angles = table.header.angles;
  motion.stated.lengths = table.header.lengths;
  motion.warnings = table.header.warnings;
  TableColumns columns = all_columns;
  for (const auto& [coordinate, column] : all_columns.of_coordinate) {
    if (!columns.may_be_absent || column_named(table, without_sign(column))) continue;
    columns.of_coordinate.erase(coordinate);
    motion.absent_columns.push_back(without_sign(column));
  }
  add_keys(motion, table, columns);
  const bool has_matrices = table.names.empty() || !columns.moving_prefix.empty() ||
                            (columns.of_coordinate.empty() && column_named(table, "T11"));
  if (has_matrices) {
    motion.matrices = matrices_of(table, columns.moving_prefix);
    if (!columns.reference_prefix.empty()) motion.of_reference = matrices_of(table, columns.reference_prefix);
  } else {
    add_coordinates(motion, table, columns);
  }
  return motion;
}

std::vector<JointCoordinates> read_follower(const std::string& file, const std::string& follower,
                                            const std::map<std::string, std::string>& columns)
{
  const std::string text = text_of_file(file);
  const FieldTable table = fields_of(file, text);
  std::array<std::optional<NumberColumn>, n_joint_coordinates> found;
  std::size_t n_found = 0, missing = 0;
  for (std::size_t c = 0; c < n_joint_coordinates; ++c) {
    found[c] = follower_column(table, follower, c, columns);
    if (found[c]) ++n_found;
    if (!found[c]) missing = c;
  }
  if (n_found == 0) return {};
  if (n_found < n_joint_coordinates)
    table.refuse(table.name_line, "",
                 "no column follower_" + follower + "_" + follower_coordinate_names[missing],
                 "all six coordinates of " + follower + ", or none");
  std::vector<JointCoordinates> coordinates;
  for (const Row& row : table.rows) {
    JointCoordinates& q = coordinates.emplace_back();
    for (std::size_t c = 0; c < n_joint_coordinates; ++c)
      q(static_cast<Eigen::Index>(c)) = found[c]->factor * table.number(row, found[c]->column);
  }
  return coordinates;
}

MotionTable read_motion_table(const std::string& file, const TableColumns& columns)
{
  MotionTable motion = motion_table_from_text(file, text_of_file(file), columns);
  if (columns.reference_file.empty()) return motion;
  TableColumns of_reference = columns;
  of_reference.moving_prefix = columns.reference_prefix;
  of_reference.reference_prefix.clear();
  const MotionTable reference =
      motion_table_from_text(columns.reference_file, text_of_file(columns.reference_file), of_reference);
  if (!motion.has_matrices() || !reference.has_matrices())
    throw InputError(
        {columns.reference_file, "", "coordinates", "matrices of both bodies in a common frame"});
  if (reference.key != motion.key) {
    throw InputError({columns.reference_file, "",
                      std::to_string(reference.key.size()) + " frames with other keys",
                      "the " + std::to_string(motion.key.size()) + " frames of " + file});
  }
  motion.of_reference = reference.matrices;
  return motion;
}

namespace {

constexpr double largest_coordinate_mm = 1e9;

enum class Key { in_degrees, translations, rotation_centre, key, negated };

struct KeyName {
  Key key;
  const char* written;  ///< as `vrda export` writes it
  const char* plain;    ///< plain_word() of it
};
constexpr KeyName key_names[] = {{Key::in_degrees, "inDegrees", "indegrees"},
                                 {Key::translations, "translations", "translations"},
                                 {Key::rotation_centre, "rotation_centre_mm", "rotationcentremm"},
                                 {Key::rotation_centre, "rotation_centre_mm", "rotationcentermm"},
                                 {Key::key, "key", "key"},
                                 {Key::negated, "negated", "negated"}};

/// Letters and digits alone, in lower case: "indegrees" of " In_Degrees".
std::string plain_word(std::string_view text)
{
  std::string word;
  for (const char c : text) {
    if (c >= 'A' && c <= 'Z') word += static_cast<char>(c - 'A' + 'a');
    if ((c >= 'a' && c <= 'z') || (c >= '0' && c <= '9')) word += c;
  }
  return word;
}

/// Without the marks around it: quotes, and the separators that a spreadsheet appends.
std::string_view bare_value(std::string_view text)
{
  constexpr std::string_view marks = " \t\r\"';,";
  const std::size_t first = text.find_first_not_of(marks);
  if (first == std::string_view::npos) return {};
  return text.substr(first, text.find_last_not_of(marks) - first + 1);
}

/// "No" is a truth value; "-1" and "n/o" are not.
std::optional<bool> truth_of(std::string_view text)
{
  const std::string word = plain_word(text);
  if (word.size() != bare_value(text).size()) return std::nullopt;
  for (const char* yes : {"yes", "y", "true", "t", "1", "on"})
    if (word == yes) return true;
  for (const char* no : {"no", "n", "false", "f", "0", "off"})
    if (word == no) return false;
  return std::nullopt;
}

std::optional<LengthPoint> point_named(std::string_view value)
{
  const std::string word = plain_word(value);
  for (const char* centre : {"rotationcentre", "rotationcenter", "centre", "center"})
    if (word == centre) return LengthPoint::centre;
  for (const char* origin : {"meshorigin", "origin"})
    if (word == origin) return LengthPoint::origin;
  return std::nullopt;
}

/// The words of a list, separated by blanks and `marks`.
std::vector<std::string> list_of(std::string value, std::string_view marks)
{
  for (char& c : value)
    if (marks.find(c) != std::string_view::npos) c = ' ';
  const std::vector<std::string_view> words = job::split_words(value);
  return {words.begin(), words.end()};
}

std::optional<Eigen::Vector3d> point_of(const std::string& value)
{
  std::vector<double> mm;
  for (const std::string& word : list_of(value, ",;()[]"))
    mm.push_back(job::parse_real(word).value_or(HUGE_VAL));
  if (mm.size() != 3 || !(Eigen::Map<Eigen::Array3d>(mm.data()).abs() <= largest_coordinate_mm).all())
    return {};
  return Eigen::Vector3d(mm[0], mm[1], mm[2]);
}

/// A line that may state something.
struct Statement {
  std::size_t line = 0;
  std::string key, value;  ///< as written, trimmed
  bool is_comment = false;
  bool has_equals = false;
};

/// Text in which a program finds no value.
bool is_comment(std::string_view trimmed)
{
  return trimmed.starts_with("//") ||
         (!trimmed.empty() && std::string_view("#%;!").find(trimmed[0]) != std::string_view::npos);
}

/// Empty for text. Without "=" or ":" only a line that begins with inDegrees is one ("inDegrees yes").
std::optional<Statement> statement_of(std::string_view line, std::size_t number)
{
  line = job::trimmed(line);
  Statement statement;
  statement.line = number;
  statement.is_comment = is_comment(line);
  std::size_t at = line.find('=');
  statement.has_equals = at != std::string_view::npos;
  if (at == std::string_view::npos) at = line.find(':');
  if (at == std::string_view::npos) {
    if (!plain_word(line).starts_with(key_names[0].plain)) return {};
    at = line.find_first_of(" \t,;");
    if (at == std::string_view::npos || !truth_of(line.substr(at))) {
      statement.key = std::string(line);
      return statement;
    }
  }
  statement.key = std::string(bare_value(line.substr(0, at)));
  statement.value = std::string(bare_value(line.substr(at + 1)));
  return statement;
}

/// Of an unknown key: whether it may be meant to state the unit of angles.
bool is_about_angles(const Statement& statement)
{
  const std::string key = plain_word(statement.key), value = plain_word(statement.value);
  for (const char* unit : {"deg", "degree", "degrees", "rad", "radian", "radians"})
    if (value == unit) return true;
  return key.find("degree") != std::string::npos || key.find("radian") != std::string::npos ||
         (truth_of(statement.value) && (key == "indeg" || key == "inrad")) ||
         value.find(key_names[0].plain) != std::string::npos;
}

/// The name that `word` is but for a typing slip; a short name has fewer.
const KeyName* slip_of(const std::string& word)
{
  for (const KeyName& name : key_names) {
    const std::string_view plain = name.plain;
    if (edit_distance(word, plain) <= (plain.size() < 6 ? 1u : 2u)) return &name;
  }
  return nullptr;
}

class HeaderReader {
 public:
  explicit HeaderReader(std::string file) : file_(std::move(file)) {}

  void take(const Statement& s)
  {
    const std::string word = plain_word(s.key);
    const auto* name = std::find_if(std::begin(key_names), std::end(key_names),
                                    [&](const KeyName& known) { return word == known.plain; });
    if (name == std::end(key_names)) {
      const KeyName* meant = s.is_comment ? nullptr : slip_of(word);
      if (meant) warn(s, "is not used: no such key; " + std::string(meant->written) + " is one");
      if (!meant && is_about_angles(s)) unused_units_.push_back(s);
      return;
    }
    const auto before = stated_.find(name->key);
    if (s.is_comment) {  // states the unit if no other line does
      if (name->key != Key::in_degrees || before != stated_.end() || !truth_of(s.value)) return;
      warn(s, "is a comment, read as " + std::string(name->written) + "=" + s.value);
    } else if (!s.has_equals && name->key != Key::in_degrees) {  // text
      return warn(s, "is not used without \"=\": " + std::string(name->written) + "=VALUE");
    }
    const std::string meaning = set(*name, s);
    if (before != stated_.end() && before->second.meaning != meaning) {
      refuse(*name, s,
             '"' + s.value + "\" after another value in line " + std::to_string(before->second.line),
             "one value");
    }
    stated_.emplace(name->key, Stated{s.line, meaning});
  }

  TableHeader finish()
  {
    if (!header_.angles) {
      for (const Statement& s : unused_units_)
        warn(s, "is not used: a line inDegrees=yes or inDegrees=no states the unit of angles");
    }
    return std::move(header_);
  }

 private:
  struct Stated {
    std::size_t line;
    std::string meaning;
  };

  void warn(const Statement& s, const std::string& what)
  {
    header_.warnings.push_back(file_ + ": line " + std::to_string(s.line) + ": \"" + s.key + "\" " + what);
  }

  [[noreturn]] void refuse(const KeyName& name, const Statement& s, const std::string& found,
                           const std::string& wanted) const
  {
    throw InputError({file_, name.written, found, wanted, static_cast<int>(s.line)});
  }

  /// Stores the value; returns its meaning, equal for values that mean the same.
  std::string set(const KeyName& name, const Statement& s)
  {
    const std::string found = '"' + s.value + '"';
    switch (name.key) {
      case Key::in_degrees: {
        const std::optional<bool> is_true = truth_of(s.value);
        if (!is_true) refuse(name, s, found, "yes or no");
        header_.angles = *is_true ? AngleUnit::degrees : AngleUnit::radians;
        return name_of(*header_.angles);
      }
      case Key::translations:
        header_.lengths = point_named(s.value);
        if (!header_.lengths) refuse(name, s, found, "rotation-centre or mesh-origin");
        return name_of(*header_.lengths);
      case Key::rotation_centre: {
        header_.point_mm = point_of(s.value);
        if (!header_.point_mm) refuse(name, s, found, "three numbers of magnitude up to 1e9");
        const Eigen::Vector3d& p = *header_.point_mm;
        return shortest_decimal(p.x()) + " " + shortest_decimal(p.y()) + " " + shortest_decimal(p.z());
      }
      case Key::key:
        if (s.value.empty()) refuse(name, s, "nothing", "the name of the key");
        header_.key_name = s.value;
        return s.value;
      case Key::negated:
        header_.negated_columns = list_of(s.value, ",;");
        return s.value;
    }
    throw InternalError("a key of a header without a meaning");
  }

  std::string file_;
  TableHeader header_;
  std::map<Key, Stated> stated_;
  std::vector<Statement> unused_units_;
};

}  // namespace

TableHeader table_header(const std::string& file, std::string_view text, std::size_t end_line)
{
  std::vector<Statement> statements;
  for (std::size_t number = 1; number < end_line; ++number) {
    const std::size_t end = std::min(text.find('\n'), text.size());
    if (const auto statement = statement_of(text.substr(0, end), number)) statements.push_back(*statement);
    text.remove_prefix(std::min(end + 1, text.size()));
  }
  std::stable_partition(statements.begin(), statements.end(),
                        [](const Statement& s) { return !s.is_comment; });
  HeaderReader reader(file);
  for (const Statement& statement : statements) reader.take(statement);
  return reader.finish();
}

// Names of coordinates in OpenSim tables.

std::string coordinate_name(std::string_view column)
{
  constexpr std::string_view value = "/value";
  if (column.ends_with(value)) column.remove_suffix(value.size());
  const std::size_t slash = column.rfind('/');
  return std::string(slash == std::string_view::npos ? column : column.substr(slash + 1));
}

std::vector<std::string> with_opensim_names(std::vector<std::string> names, const std::string& coordinate)
{
  for (const char* joint : {"knee", "hip", "ankle", "subtalar", "joint"})
    for (const char* side : {"_r", "_l"}) names.push_back(joint + ("_" + coordinate) + side);
  return names;
}

// From a table to poses.

namespace {

/// Tables with three decimals are off by at most a few thousandths.
constexpr double rotation_tolerance = 1e-2;

/// As of a motion model.
constexpr double largest_length_mm = 1e9;

Eigen::Matrix3d mirrored(const Eigen::Matrix3d& R)
{
  const Eigen::Vector3d m(1.0, 1.0, -1.0);
  return m.asDiagonal() * R * m.asDiagonal();
}

Eigen::Vector3d mirrored(const Eigen::Vector3d& v)
{
  return {v.x(), v.y(), -v.z()};
}

Pose pose_of(const Eigen::Matrix3d& R, const Eigen::Vector3d& t_mm)
{
  Pose X = Pose::Identity();
  X.linear() = R;
  X.translation() = t_mm;
  return X;
}

Eigen::Matrix3d rotation_of(const Eigen::Matrix3d& M, const MotionTable& table, std::size_t frame)
{
  const double error = (M.transpose() * M - Eigen::Matrix3d::Identity()).cwiseAbs().maxCoeff();
  if (!(error <= rotation_tolerance) || M.determinant() < 0.0) {
    throw InputError(
        {table.file, "",
         M.determinant() < 0.0 ? "a matrix that mirrors" : "a matrix off by " + shortest_decimal(error),
         "a rotation: R^T R = 1 within 0.01 and determinant 1", table.line[frame]});
  }
  return nearest_rotation(M);
}

Pose matrix_pose(const MotionTable& table, const PoseEntries& e, std::size_t frame, double length_mm)
{
  Eigen::Matrix3d R;
  R << e[0], e[1], e[2], e[4], e[5], e[6], e[8], e[9], e[10];
  return pose_of(rotation_of(R, table, frame), length_mm * Eigen::Vector3d(e[3], e[7], e[11]));
}

Eigen::Matrix3d about(char axis, const Eigen::Vector3d& angle_rad)
{
  return axis == 'x'   ? rotation_x(angle_rad.x())
         : axis == 'y' ? rotation_y(angle_rad.y())
                       : rotation_z(angle_rad.z());
}

/// Displacement from Grood-Suntay translations, on a right joint (schemas/clinical.md, Remarks). With a varus
/// beyond 90 degrees the floating axis stays that of the flexion, (cf, -sf, 0).
Eigen::Vector3d displacement_mm(const Eigen::Matrix3d& R, const Eigen::Vector3d& q_mm, bool is_beyond)
{
  const Eigen::Vector3d e1 = Eigen::Vector3d::UnitZ(), e3 = R.col(1);
  const Eigen::Vector3d e2 = (is_beyond ? -1.0 : 1.0) * e3.cross(e1).normalized();
  const double sv = e3.z(), cv_sq = 1.0 - sv * sv;
  return q_mm.x() * e2 + ((q_mm.z() - q_mm.y() * sv) * e1 + (q_mm.y() - q_mm.z() * sv) * e3) / cv_sq;
}

/// Rotation and lengths of a row, signs of the joint's own side.
struct Numbers {
  Eigen::Matrix3d R;
  Eigen::Vector3d length_mm;
};

Numbers numbers_of(const MotionTable& table, const PoseCoordinates& row, const Convention& c, Side joint_side)
{
  const double to_rad = c.angles == AngleUnit::degrees ? pi / 180.0 : 1.0;
  const Eigen::Vector3d angle_rad = to_rad * Eigen::Vector3d(row.angle[0], row.angle[1], row.angle[2]);
  const Eigen::Vector3d length_mm =
      c.length_mm * Eigen::Vector3d(row.length[0], row.length[1], row.length[2]);
  const char* order = name_of(c.order);
  const Eigen::Matrix3d R =
      about(order[0], angle_rad) * about(order[1], angle_rad) * about(order[2], angle_rad);
  // Clinical numbers are positive on both sides: those of a left joint are of its mirror image.
  const bool flips_angles = table.are_angles_clinical ? c.side == Side::left : c.side != joint_side;
  const bool flips_lengths = table.are_lengths_clinical ? c.side == Side::left : c.side != joint_side;
  const Eigen::Vector3d d_mm =
      c.lengths == LengthPoint::grood_suntay
          ? displacement_mm(R, length_mm, table.are_angles_clinical && cosine(angle_rad.x()) < 0.0)
          : length_mm;
  return {flips_angles ? mirrored(R) : R, flips_lengths ? mirrored(d_mm) : d_mm};
}

/// The two bodies in the roles of the table: `second` is posed in `first`.
struct Roles {
  Pose X_canonical_first, X_canonical_second;
};

Roles roles_of(const Convention& c, const JointFrame& joint)
{
  if (c.axes == TableAxes::canonical) return {Pose::Identity(), Pose::Identity()};
  if (c.direction == Direction::moving_in_reference)
    return {joint.X_canonical_reference, joint.X_canonical_moving};
  return {joint.X_canonical_moving, joint.X_canonical_reference};
}

/// The pose of `second` in `first`, canonical.
Pose coordinate_pose(const Numbers& numbers, const Convention& c, const Roles& roles,
                     const Eigen::Vector3d& centre_mm)
{
  if (c.lengths == LengthPoint::origin)
    return roles.X_canonical_first * pose_of(numbers.R, numbers.length_mm) *
           roles.X_canonical_second.inverse();
  const Eigen::Matrix3d R_first = roles.X_canonical_first.linear();
  const Eigen::Matrix3d R = R_first * numbers.R * roles.X_canonical_second.linear().transpose();
  return pose_of(R, centre_mm + R_first * numbers.length_mm - R * centre_mm);
}

Pose matrix_in_roles(const MotionTable& table, std::size_t frame, const Convention& c, const Roles& roles,
                     Side joint_side)
{
  Pose X = matrix_pose(table, table.matrices[frame], frame, c.length_mm);
  if (!table.of_reference.empty())
    X = matrix_pose(table, table.of_reference[frame], frame, c.length_mm).inverse() * X;
  if (c.side != joint_side)
    X = pose_of(mirrored(Eigen::Matrix3d(X.linear())), mirrored(Eigen::Vector3d(X.translation())));
  return roles.X_canonical_first * X * roles.X_canonical_second.inverse();
}

}  // namespace

std::vector<Pose> poses_of(const MotionTable& table, const Convention& convention, const JointFrame& joint)
{
  const Roles roles = roles_of(convention, joint);
  Eigen::Vector3d point_mm = joint.rotation_centre_mm;
  if (table.point_mm) point_mm = convention.side == joint.side ? *table.point_mm : mirrored(*table.point_mm);
  std::vector<Pose> poses;
  poses.reserve(table.key.size());
  for (std::size_t frame = 0; frame < table.key.size(); ++frame) {
    const Pose X = table.has_matrices()
                       ? matrix_in_roles(table, frame, convention, roles, joint.side)
                       : coordinate_pose(numbers_of(table, table.coordinates[frame], convention, joint.side),
                                         convention, roles, point_mm);
    if (!(X.matrix().array().abs() <= largest_length_mm).all()) {
      throw InputError({table.file, "",
                        "a position beyond 1e9 mm, or a varus of 90 degrees with Grood-Suntay lengths",
                        "poses within 1e9 mm", table.line[frame]});
    }
    poses.push_back(convention.direction == Direction::moving_in_reference ? X : X.inverse(Eigen::Isometry));
  }
  return poses;
}

}  // namespace vrda::tables
