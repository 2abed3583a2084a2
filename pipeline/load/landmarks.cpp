#include "load/landmarks.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "core/error.hpp"
#include "core/text.hpp"
#include "load/comma_table.hpp"

namespace vrda {
namespace {

constexpr std::size_t most_pairs = 10000;  // a table of markers; more is another file

// Squares of distances have to be numbers above 0 and finite: from an atom's width to a million kilometres.
constexpr double least_distance = 1e-9, largest_number = 1e12;

enum Column : std::size_t { c_name, c_ax, c_ay, c_az, c_bx, c_by, c_bz, c_subject, n_columns };
const std::array<std::string, n_columns> column_names{"name", "ax", "ay", "az",
                                                      "bx",   "by", "bz", "subject_mm"};
constexpr const char* landmark_columns = "name, ax, ay, az, bx, by, bz and subject_mm";

class Landmarks {
 public:
  explicit Landmarks(const CommaTable& table) : table_(table)
  {
    for (const std::string_view field : fields_in(table.header().text))
      columns_.push_back(column_named(field));
    for (std::size_t column = 0; column < n_columns; ++column) {
      const auto n = std::count(columns_.begin(), columns_.end(), column);
      if (n == 1) continue;
      table_.refuse(table_.header(), column_names[column], n == 0 ? "no such column" : "a second such column",
                    std::string("each of ") + landmark_columns + " once");
    }
  }

  LandmarkPair pair(const TableLine& line) const
  {
    const std::vector<std::string_view> fields = table_.fields(line);
    LandmarkPair pair;
    std::array<double, n_columns> number{};
    for (std::size_t i = 0; i < columns_.size(); ++i) {
      if (columns_[i] == c_name) pair.name = fields[i];
      if (columns_[i] != c_name) number[columns_[i]] = number_in(line, columns_[i], fields[i]);
    }
    if (pair.name.empty()) table_.refuse(line, "name", "nothing", "a name of its own for each pair");
    pair.a_native = {number[c_ax], number[c_ay], number[c_az]};
    pair.b_native = {number[c_bx], number[c_by], number[c_bz]};
    pair.subject_mm = number[c_subject];
    if (!((pair.a_native - pair.b_native).norm() > least_distance))
      table_.refuse(line, "", "two points in the same place", "two landmarks with a distance between them");
    if (!(pair.subject_mm > least_distance))
      table_.refuse(line, "subject_mm", shortest(pair.subject_mm), "a distance above 0 mm");
    return pair;
  }

 private:
  std::size_t column_named(std::string_view name) const
  {
    const auto found = std::find(column_names.begin(), column_names.end(), name);
    if (found == column_names.end())
      table_.refuse_unknown(name, {column_names.begin(), column_names.end()}, landmark_columns);
    return static_cast<std::size_t>(found - column_names.begin());
  }

  double number_in(const TableLine& line, std::size_t column, std::string_view field) const
  {
    const std::optional<double> value = real_in(field);
    if (value && std::abs(*value) <= largest_number) return *value;
    table_.refuse_number(line, column_names[column], field);
  }

  const CommaTable& table_;
  std::vector<std::size_t> columns_;
};

}  // namespace

std::vector<LandmarkPair> read_landmarks(const std::string& file, std::string_view text)
{
  const CommaTable table(file, text, {"pair", "pairs", "pairs of landmarks"});
  const Landmarks landmarks(table);
  table.require_rows(most_pairs);
  std::vector<LandmarkPair> pairs;
  std::vector<std::string> names;
  for (std::size_t i = 0; i < table.n_rows(); ++i) {
    pairs.push_back(landmarks.pair(table.row(i)));
    names.push_back(pairs.back().name);
    if (std::find(names.begin(), names.end() - 1, names.back()) == names.end() - 1) continue;
    table.refuse(table.row(i), "name", CommaTable::quoted(names.back()) + " a second time",
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
