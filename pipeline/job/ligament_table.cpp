#include "job/ligament_table.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "core/error.hpp"
#include "job/csv_table.hpp"

namespace vrda::job {
namespace {

constexpr std::size_t max_fibres = 10000;  // the limit of the job schema

enum Quantity : std::size_t {
  q_name,
  q_bundle,
  q_wrap,
  q_reference,  // x, y, z
  q_moving = q_reference + 3,
  q_stiffness = q_moving + 3,
  q_slack_length,
  q_strain,
  q_slack_length_sd,  // of vrda fit; not used
  n_quantities
};

// A permitted column name, its quantity and the factor of its unit.
struct ColumnName {
  std::string name;
  std::size_t quantity;
  double scale = 1.0;
};

struct Unit {
  const char* suffix;
  double mm;
};
constexpr std::array<Unit, 3> units{{{"_mm", 1.0}, {"_cm", 10.0}, {"_m", 1000.0}}};

// Summary of known_columns() for messages.
constexpr const char* fibre_columns =
    "name, bundle, wrap, reference_x_mm, _y_mm, _z_mm (or femur_...), moving_x_mm, _y_mm, _z_mm (or "
    "tibia_...), "
    "stiffness_n_per_strain (or stiffness_n), slack_length_mm or reference_strain, lengths also in _cm or _m";

std::vector<ColumnName> known_columns()
{
  std::vector<ColumnName> known{{"name", q_name}, {"bundle", q_bundle}, {"wrap", q_wrap}};
  struct Object {
    const char* word;
    std::size_t quantity;
  };
  for (const Object object : {Object{"reference", q_reference},
                              {"femur", q_reference},
                              {"moving", q_moving},
                              {"tibia", q_moving}}) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const std::string name = std::string(object.word) + "_" + "xyz"[axis];
      for (const Unit& unit : units) known.push_back({name + unit.suffix, object.quantity + axis, unit.mm});
    }
  }
  known.push_back({"stiffness_n_per_strain", q_stiffness});
  known.push_back({"stiffness_n", q_stiffness});
  for (const Unit& unit : units)
    known.push_back({std::string("slack_length") + unit.suffix, q_slack_length, unit.mm});
  known.push_back({"reference_strain", q_strain});
  known.push_back({"slack_length_sd_mm", q_slack_length_sd});
  return known;
}

class Fibres {
 public:
  explicit Fibres(const CsvTable& table) : table_(table)
  {
    for (const std::string_view field : split_fields(table.header().text))
      columns_.push_back(column_named(field));
    for (std::size_t i = 0; i < columns_.size(); ++i) {
      for (std::size_t j = 0; j < i; ++j) {
        if (columns_[i].quantity != columns_[j].quantity) continue;
        table_.refuse(table_.header(), columns_[i].name,
                      "a second column for the quantity of " + columns_[j].name, "one column for each");
      }
    }
    for (const char* needed : {"name", "reference_x_mm", "reference_y_mm", "reference_z_mm", "moving_x_mm",
                               "moving_y_mm", "moving_z_mm", "stiffness_n_per_strain"}) {
      if (has(column_named(needed).quantity)) continue;
      table_.refuse(table_.header(), needed, "no such column",
                    "this column, in mm, cm or m (or femur for reference, tibia for moving)");
    }
    if (has(q_slack_length) || has(q_strain)) return;
    table_.refuse(table_.header(), "slack_length_mm", "no such column",
                  "slack_length_mm or reference_strain");
  }

  FibreJob fibre(const TableLine& line) const
  {
    const std::vector<std::string_view> fields = table_.fields(line);
    FibreJob fibre;
    fibre.source = table_.file();
    fibre.field = "line " + std::to_string(line.number);
    std::array<std::optional<double>, n_quantities> number;
    for (std::size_t i = 0; i < columns_.size(); ++i) {
      const ColumnName& column = columns_[i];
      if (column.quantity == q_name) fibre.name = fields[i];
      if (column.quantity == q_bundle) fibre.bundle = fields[i];
      if (column.quantity == q_wrap) fibre.wrap = fields[i];
      const bool may_be_empty = column.quantity == q_slack_length || column.quantity == q_strain ||
                                column.quantity == q_slack_length_sd;
      if (column.quantity >= q_reference && !(fields[i].empty() && may_be_empty))
        number[column.quantity] = number_in(line, column, fields[i]);
    }
    if (fibre.name.empty()) table_.refuse(line, "name", "nothing", "a unique name for each fibre");
    for (Eigen::Index axis = 0; axis < 3; ++axis) {
      fibre.reference_native_mm[axis] = *number[q_reference + static_cast<std::size_t>(axis)];
      fibre.moving_native_mm[axis] = *number[q_moving + static_cast<std::size_t>(axis)];
    }
    fibre.stiffness_n = *number[q_stiffness];
    fibre.slack_length_mm = number[q_slack_length];
    fibre.reference_strain = number[q_strain];
    if (fibre.slack_length_mm.has_value() == fibre.reference_strain.has_value()) {
      table_.refuse(line, "",
                    fibre.slack_length_mm ? "both a slack length and a reference strain" : "neither",
                    "one of slack_length_mm and reference_strain");
    }
    return fibre;
  }

 private:
  bool has(std::size_t quantity) const
  {
    return std::any_of(columns_.begin(), columns_.end(),
                       [&](const ColumnName& column) { return column.quantity == quantity; });
  }

  ColumnName column_named(std::string_view name) const
  {
    static const std::vector<ColumnName> known = known_columns();
    std::vector<std::string> names;
    for (const ColumnName& column : known) {
      if (column.name == name) return column;
      names.push_back(column.name);
    }
    table_.refuse_unknown_column(name, names, fibre_columns);
  }

  double number_in(const TableLine& line, const ColumnName& column, std::string_view field) const
  {
    const std::optional<double> value = parse_real(field);
    if (!value || !std::isfinite(column.scale * *value)) table_.refuse_number(line, column.name, field);
    if ((column.quantity == q_stiffness || column.quantity == q_slack_length) && !(*value > 0.0))
      table_.refuse(line, column.name, std::string(field), "a number above 0");
    if (column.quantity == q_strain && !(*value > -1.0 && *value <= 1.0))
      table_.refuse(line, column.name, std::string(field), "a strain above -1, at most 1 (3 % is 0.03)");
    return column.scale * *value;
  }

  const CsvTable& table_;
  std::vector<ColumnName> columns_;
};

}  // namespace

std::string default_bundle(const std::string& fibre_name)
{
  std::size_t end = fibre_name.find_last_not_of("0123456789");
  if (end == std::string::npos) return fibre_name;
  const bool has_separator = end + 1 < fibre_name.size() && end > 0 &&
                             std::string_view("_-. ").find(fibre_name[end]) != std::string_view::npos;
  return fibre_name.substr(0, has_separator ? end : end + 1);
}

std::vector<FibreJob> read_ligament_table(const std::string& file, std::string_view text)
{
  const CsvTable table(file, text, {"fibre", "fibres", "fibres"});
  const Fibres rows(table);
  table.require_rows(max_fibres);
  std::vector<FibreJob> fibres;
  for (std::size_t i = 0; i < table.n_rows(); ++i) fibres.push_back(rows.fibre(table.row(i)));
  return fibres;
}

}  // namespace vrda::job
