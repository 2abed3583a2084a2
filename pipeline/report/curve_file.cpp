#include "report/curve_file.hpp"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <limits>
#include <optional>

#include "core/error.hpp"
#include "exports/csv_tables.hpp"
#include "load/file_bytes.hpp"
#include "load/words.hpp"

namespace vrda {
namespace {

constexpr std::uintmax_t largest_curve_bytes = 64u << 20;
constexpr const char* wanted_columns =
    "a header with flexion_deg and at least one of internal_deg, varus_deg, ant_mm, prox_mm, lat_mm";

/// What stands in a column.
struct Column {
  enum class Kind { flexion, quantity, passed_over } kind = Kind::passed_over;
  Quantity quantity = Quantity::internal;
};

bool is_passed_over(std::string_view name)
{
  const bool is_matrix_entry = name.size() == 3 && name[0] == 'T' && name[1] >= '1' && name[1] <= '3' &&
                               name[2] >= '1' && name[2] <= '4';
  static const std::vector<std::string> exported = flexion_csv_columns();
  return is_matrix_entry || std::find(exported.begin(), exported.end(), name) != exported.end() ||
         name == "frame" || name == "time_s" || name == "femur_rel_tibia_prox_mm" ||
         name == "femur_rel_tibia_ant_mm" || name == "femur_rel_tibia_lat_mm";
}

std::optional<Column> column_named(std::string_view name)
{
  struct Known {
    const char* name;
    Quantity quantity;
  };
  static constexpr Known known[] = {{"internal_deg", Quantity::internal},
                                    {"varus_deg", Quantity::varus},
                                    {"ant_mm", Quantity::origin_anterior},
                                    {"prox_mm", Quantity::origin_proximal},
                                    {"lat_mm", Quantity::origin_lateral}};
  if (name == "flexion_deg") return Column{Column::Kind::flexion, {}};
  for (const Known& k : known) {
    if (name == k.name) return Column{Column::Kind::quantity, k.quantity};
  }
  if (is_passed_over(name)) return Column{};
  return std::nullopt;
}

/// Fills a curve line by line.
class CurveReader {
 public:
  explicit CurveReader(const std::string& file) : file_(file)
  {
    result_.curve.name = std::filesystem::path(file).stem().string();
  }

  void take(std::string_view line)
  {
    ++n_lines_;
    line = trimmed(line);
    if (line.empty()) return;
    if (line.front() == '#') {
      result_.notes.emplace_back(trimmed(line.substr(1)));
    } else if (columns_.empty()) {
      take_header(line);
    } else {
      take_row(line);
    }
  }

  CurveFile finish()
  {
    if (columns_.empty()) refuse("", "no header", wanted_columns);
    if (result_.curve.flexion_deg.empty()) refuse("", "no rows", "rows of numbers below the header");
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
    for (const std::string_view name : fields_in(line)) {
      const std::optional<Column> column = column_named(name);
      if (!column) refuse("column '" + std::string(name) + "'", "an unknown column", wanted_columns);
      const bool is_repeated = column->kind != Column::Kind::passed_over &&
                               std::find(names_.begin(), names_.end(), name) != names_.end();
      if (is_repeated) refuse("column '" + std::string(name) + "'", "the column twice", "each column once");
      names_.emplace_back(name);
      columns_.push_back(*column);
      has_flexion = has_flexion || column->kind == Column::Kind::flexion;
      has_quantity = has_quantity || column->kind == Column::Kind::quantity;
    }
    if (!has_flexion) refuse("header", "no column flexion_deg", wanted_columns);
    if (!has_quantity) refuse("header", "no clinical number beside flexion_deg", wanted_columns);
  }

  void take_row(std::string_view line)
  {
    const std::vector<std::string_view> fields = fields_in(line);
    if (fields.size() != columns_.size())
      refuse(here(), std::to_string(fields.size()) + " fields",
             std::to_string(columns_.size()) + ", as in the header");
    for (std::size_t k = 0; k < fields.size(); ++k) take_field(columns_[k], names_[k], fields[k]);
  }

  void take_field(const Column& column, const std::string& name, std::string_view field)
  {
    if (column.kind == Column::Kind::passed_over) return;
    const bool may_be_empty = column.kind == Column::Kind::quantity;
    double number = std::numeric_limits<double>::quiet_NaN();
    if (!field.empty() || !may_be_empty) {
      const std::optional<double> read = real_in(field);
      if (!read || !std::isfinite(*read))
        refuse(here() + ", " + name, "'" + std::string(field) + "'", "a finite number");
      number = *read;
    }
    if (column.kind == Column::Kind::flexion) {
      result_.curve.flexion_deg.push_back(number);
    } else {
      result_.curve.of(column.quantity).push_back(number);
    }
  }

  std::string file_;
  CurveFile result_;
  std::vector<std::string> names_;
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

CurveFile read_curve_file(const std::string& file)
{
  return curve_from_text(file,
                         file_bytes(file, {file, "", "", "a CSV file of a curve"}, largest_curve_bytes));
}

}  // namespace vrda
