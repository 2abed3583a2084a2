#include "load/landmarks.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "core/error.hpp"
#include "core/nearest_word.hpp"
#include "core/number_text.hpp"
#include "load/words.hpp"

namespace vrda {
namespace {

constexpr std::size_t most_pairs = 10000;  // a table of markers; more is another file

// Squares of distances have to be numbers above 0 and finite: from an atom's width to a million kilometres.
constexpr double least_distance = 1e-9, largest_number = 1e12;

enum Column : std::size_t { c_name, c_ax, c_ay, c_az, c_bx, c_by, c_bz, c_subject, n_columns };
const std::array<std::string, n_columns> column_names{"name", "ax", "ay", "az",
                                                      "bx",   "by", "bz", "subject_mm"};

std::string quoted(std::string_view text)
{
  return '"' + std::string(text) + '"';
}

class Table {
 public:
  Table(const std::string& file, const TableLine& header) : file_(file), header_(header)
  {
    for (const std::string_view field : fields_in(header.text)) columns_.push_back(column_named(field));
    for (std::size_t column = 0; column < n_columns; ++column) {
      const auto n = std::count(columns_.begin(), columns_.end(), column);
      if (n == 1) continue;
      refuse(header_, column_names[column], n == 0 ? "no such column" : "a second such column",
             "each of name, ax, ay, az, bx, by, bz and subject_mm once");
    }
  }

  LandmarkPair pair(const TableLine& line) const
  {
    const std::vector<std::string_view> fields = fields_in(line.text);
    if (fields.size() != columns_.size()) {
      refuse(line, "", std::to_string(fields.size()) + " fields",
             "as many as the columns of line " + std::to_string(header_.number) + ", " +
                 std::to_string(columns_.size()));
    }
    LandmarkPair pair;
    std::array<double, n_columns> number{};
    for (std::size_t i = 0; i < columns_.size(); ++i) {
      if (columns_[i] == c_name) pair.name = fields[i];
      if (columns_[i] != c_name) number[columns_[i]] = number_in(line, columns_[i], fields[i]);
    }
    if (pair.name.empty()) refuse(line, "name", "nothing", "a name of its own for each pair");
    pair.a_native = {number[c_ax], number[c_ay], number[c_az]};
    pair.b_native = {number[c_bx], number[c_by], number[c_bz]};
    pair.subject_mm = number[c_subject];
    if (!((pair.a_native - pair.b_native).norm() > least_distance))
      refuse(line, "", "two points in the same place", "two landmarks with a distance between them");
    if (!(pair.subject_mm > least_distance))
      refuse(line, "subject_mm", shortest(pair.subject_mm), "a distance above 0 mm");
    return pair;
  }

  [[noreturn]] void refuse(const TableLine& line, const std::string& column, const std::string& found,
                           const std::string& wanted) const
  {
    const std::string place = "line " + std::to_string(line.number);
    throw InputError({file_, column.empty() ? place : place + ", " + column, found, wanted});
  }

 private:
  std::size_t column_named(std::string_view name) const
  {
    constexpr std::size_t longest = 100;  // of what is compared with known names
    const auto found = std::find(column_names.begin(), column_names.end(), name);
    if (found != column_names.end()) return static_cast<std::size_t>(found - column_names.begin());
    refuse(header_, "", "the unknown column " + quoted(name),
           "known ones; the nearest is " + quoted(nearest_word(std::string(name.substr(0, longest)),
                                                               {column_names.begin(), column_names.end()})));
  }

  double number_in(const TableLine& line, std::size_t column, std::string_view field) const
  {
    const std::optional<double> value = real_in(field);
    if (value && std::abs(*value) <= largest_number) return *value;
    refuse(line, column_names[column], field.empty() ? "nothing" : quoted(field), "a number");
  }

  const std::string& file_;
  TableLine header_;
  std::vector<std::size_t> columns_;
};

}  // namespace

std::vector<LandmarkPair> read_landmarks(const std::string& file, std::string_view text)
{
  const std::vector<TableLine> lines = table_lines(text);
  if (lines.empty()) {
    throw InputError({file, "", "no line but comments", "names of columns, then pairs of landmarks"});
  }
  const Table table(file, lines.front());
  if (lines.size() == 1) table.refuse(lines.front(), "", "names of columns but no pair", "at least one");
  if (lines.size() - 1 > most_pairs) {
    table.refuse(lines.front(), "", std::to_string(lines.size() - 1) + " pairs",
                 "at most " + std::to_string(most_pairs));
  }
  std::vector<LandmarkPair> pairs;
  std::vector<std::string> names;
  for (std::size_t i = 1; i < lines.size(); ++i) {
    pairs.push_back(table.pair(lines[i]));
    names.push_back(pairs.back().name);
    if (std::find(names.begin(), names.end() - 1, names.back()) == names.end() - 1) continue;
    table.refuse(lines[i], "name", quoted(names.back()) + " a second time",
                 "a name of its own for each pair");
  }
  return pairs;
}

Scaling fitted_scaling(const std::vector<LandmarkPair>& pairs, double unit_mm)
{
  check(!pairs.empty(), "a factor is fitted to one pair at least");
  Scaling scaling;
  double model_subject = 0.0, model_sq = 0.0, residual_sq = 0.0;
  for (const LandmarkPair& pair : pairs) {
    const double model_mm = unit_mm * (pair.a_native - pair.b_native).norm();
    scaling.landmark.push_back(pair.name);
    scaling.model_mm.push_back(model_mm);
    scaling.subject_mm.push_back(pair.subject_mm);
    model_subject += model_mm * pair.subject_mm;
    model_sq += model_mm * model_mm;
  }
  const double factor = model_subject / model_sq;
  scaling.factor.setConstant(factor);
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    const double residual_mm = scaling.subject_mm[i] - factor * scaling.model_mm[i];
    scaling.residual_mm.push_back(residual_mm);
    residual_sq += residual_mm * residual_mm;
  }
  const auto n = static_cast<double>(pairs.size());
  scaling.residual_rms_mm = std::sqrt(residual_sq / n);
  if (pairs.size() > 1) scaling.standard_error = std::sqrt(residual_sq / (n - 1.0) / model_sq);
  return scaling;
}

}  // namespace vrda
