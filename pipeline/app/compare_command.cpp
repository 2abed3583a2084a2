#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdio>
#include <nlohmann/json.hpp>
#include <set>

#include "app/model_commands.hpp"
#include "audit/audit.hpp"
#include "compare/compare.hpp"
#include "compare/recommend.hpp"
#include "core/error.hpp"
#include "run/summary.hpp"

namespace vrda {
namespace {

using Json = nlohmann::ordered_json;
using Cells = std::vector<std::string>;

std::string number(double value)
{
  if (std::isnan(value)) return "-";
  char text[32];
  std::snprintf(text, sizeof text, "%.3g", value);
  return text;
}

/// Errors of the translation vector, then of the angles.
std::vector<ErrorMeasures> errors_of(const DegreeRow& row)
{
  std::vector<ErrorMeasures> errors{row.translation};
  for (std::size_t s = 3; s < row.surfaces.size(); ++s) errors.push_back(row.surfaces[s].errors);
  return errors;
}

constexpr double ErrorMeasures::*measures[] = {&ErrorMeasures::rms, &ErrorMeasures::largest,
                                               &ErrorMeasures::leave_one_out, &ErrorMeasures::roughness};

/// Two heading lines: the measure above its first column, the unit above every column.
std::pair<Cells, Cells> headings(const DegreeRow& row)
{
  Cells upper{""}, lower{"degree"};
  for (const char* measure : {"RMS", "largest", "leave-one-out", "roughness"}) {
    const bool is_roughness = std::string(measure) == "roughness";
    upper.push_back(measure);
    lower.push_back(is_roughness ? "mm/deg2" : "mm");
    for (std::size_t s = 3; s < row.surfaces.size(); ++s) {
      upper.push_back("");
      lower.push_back(row.surfaces[s].name + (is_roughness ? " 1/deg" : " deg"));
    }
  }
  upper.push_back("perceptible");
  lower.push_back("%");
  if (!row.faults) return {upper, lower};
  for (const char* fault : {"penetration", "gap"}) {
    upper.insert(upper.end(), {fault, ""});
    lower.insert(lower.end(), {"grid mm", "between mm"});
  }
  return {upper, lower};
}

Cells cells_of(const DegreeRow& row)
{
  Cells cells{std::to_string(row.set.degree)};
  for (const auto measure : measures) {
    for (const ErrorMeasures& errors : errors_of(row)) cells.push_back(number(errors.*measure));
  }
  cells.push_back(number(100.0 * row.perceptible_share));
  if (!row.faults) return cells;
  for (const auto fault : {&Faults::largest_penetration_mm, &Faults::largest_gap_mm}) {
    cells.push_back(number(row.faults->at_grid.*fault));
    cells.push_back(number(row.faults->between.*fault));
  }
  return cells;
}

Json json_of(const ErrorMeasures& errors)
{
  return {{"rms", errors.rms},
          {"largest_residual", errors.largest},
          {"leave_one_out_rms", errors.leave_one_out},
          {"roughness", errors.roughness}};
}

Json json_of(const Faults& faults)
{
  return {{"attitudes", faults.n_attitudes},
          {"overlapping", faults.n_overlapping},
          {"nothing_ahead", faults.n_nothing_ahead},
          {"largest_penetration_mm", faults.largest_penetration_mm},
          {"largest_gap_mm", faults.largest_gap_mm}};
}

Json json_of(const SurfaceRow& surface, bool is_length)
{
  Json json = {{"unit", is_length ? "mm" : "degree"},
               {"cells", surface.n_cells},
               {"condition_number", surface.condition_number}};
  json.update(json_of(surface.errors));
  return json;
}

Json json_of(const DegreeRow& row, const RankedDegree& ranked)
{
  Json surfaces = Json::object();
  for (std::size_t s = 0; s < row.surfaces.size(); ++s)
    surfaces[row.surfaces[s].name] = json_of(row.surfaces[s], s < 3);
  Json json = {{"degree", row.set.degree},
               {"terms", row.set.exponents.rows()},
               {"converged", row.is_converged},
               {"translation", json_of(row.translation)},
               {"surfaces", surfaces},
               {"perceptible_share", row.perceptible_share},
               {"left_out",
                {{"error", ranked.error},
                 {"excess_sq", ranked.excess_sq},
                 {"standard_error", ranked.standard_error},
                 {"is_within", ranked.is_within}}}};
  if (row.faults) {
    json["at_grid"] = json_of(row.faults->at_grid);
    json["between"] = json_of(row.faults->between);
  }
  return json;
}

}  // namespace

std::string table_of(const Comparison& comparison)
{
  const auto [upper, lower] = headings(comparison.rows.front());
  std::vector<Cells> lines{upper, lower};
  for (const DegreeRow& row : comparison.rows) lines.push_back(cells_of(row));
  std::vector<std::size_t> widths(lower.size(), 0);
  for (const Cells& line : lines) {
    for (std::size_t c = 0; c < line.size(); ++c) widths[c] = std::max(widths[c], line[c].size());
  }
  std::string text;
  for (const Cells& line : lines) {
    for (std::size_t c = 0; c < line.size(); ++c)
      text += (c == 0 ? "" : "  ") + std::string(widths[c] - line[c].size(), ' ') + line[c];
    text.erase(text.find_last_not_of(' ') + 1);
    text += '\n';
  }
  return text;
}

std::string sentence_of(const Recommendation& recommendation)
{
  return "recommended: " + recommendation.reason;
}

Json json_of(const Comparison& comparison)
{
  Json rows = Json::array();
  for (std::size_t k = 0; k < comparison.rows.size(); ++k)
    rows.push_back(json_of(comparison.rows[k], comparison.recommendation.ranked[k]));
  const Recommendation& r = comparison.recommendation;
  const auto degree = [](int value) { return value < 0 ? Json() : Json(value); };
  return {{"perceptible", {{"mm", perceptible_mm}, {"degree", perceptible_deg}}},
          {"degrees", rows},
          {"not_carried", comparison.degrees_not_carried},
          {"recommendation",
           {{"degree", degree(r.degree)}, {"best_degree", degree(r.best_degree)}, {"reason", r.reason}}}};
}

namespace {

[[noreturn]] void refuse(const std::string& text)
{
  throw InputError({"vrda compare", "--degrees", "\"" + text + "\"",
                    "degrees from 0 to " + std::to_string(largest_smoothed_degree) +
                        " as a range or a list: 1..12 or 2,4,6"});
}

int degree_of(const std::string& word, const std::string& text)
{
  int degree = -1;
  const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), degree);
  const bool is_whole = error == std::errc() && end == word.data() + word.size();
  if (!is_whole || degree < 0 || degree > largest_smoothed_degree) refuse(text);
  return degree;
}

CompareOptions compare_options(const CompareCommandOptions& options)
{
  const int n_threads = threads_or_all(options.n_threads);
  CompareOptions compare;
  compare.name = options.file;
  compare.degrees = degrees_of(options.degrees);
  compare.smooth.is_robust = options.is_robust;
  if (options.is_recontacted) {
    compare.recontact = [n_threads](const MotionModel& model, const SmoothedSet& set) {
      return recontact(model, set, n_threads);
    };
  }
  if (options.refine > 0) {
    compare.audit = [n_threads, refine = options.refine](const MotionModel& model, const std::string& set) {
      say("measuring " + set);
      return audit(model, set, refine, n_threads);
    };
  }
  return compare;
}

void report_skipped_degrees(const std::string& file, const Comparison& comparison)
{
  if (!comparison.degrees_not_carried.empty()) {
    say(file + ": too few solved cells to fit degree " +
        std::to_string(comparison.degrees_not_carried.front()) + " and above");
  }
  for (const DegreeRow& row : comparison.rows) {
    if (!row.is_converged)
      warn("degree " + std::to_string(row.set.degree) +
           ": the robust weights did not converge within the iteration limit");
  }
}

}  // namespace

std::vector<int> degrees_of(const std::string& text)
{
  std::set<int> degrees;
  for (std::size_t from = 0; from <= text.size();) {
    const std::size_t comma = std::min(text.find(',', from), text.size());
    const std::string part = text.substr(from, comma - from);
    const std::size_t dots = part.find("..");
    const int first = degree_of(part.substr(0, dots), text);
    const int last = dots == std::string::npos ? first : degree_of(part.substr(dots + 2), text);
    if (last < first) refuse(text);
    for (int degree = first; degree <= last; ++degree) degrees.insert(degree);
    from = comma + 1;
  }
  return {degrees.begin(), degrees.end()};
}

ExitCode compare_command(const CompareCommandOptions& options)
{
  const CompareOptions compare_with = compare_options(options);
  const Comparison comparison = compare(read_solved_model(options.file), compare_with);
  report_skipped_degrees(options.file, comparison);
  if (!options.as_json) {
    std::printf("%s%s\n", table_of(comparison).c_str(), sentence_of(comparison.recommendation).c_str());
    return ExitCode::done;
  }
  nlohmann::ordered_json json = {{"file", options.file},
                                 {"robust", options.is_robust},
                                 {"recontacted", options.is_recontacted},
                                 {"refine", options.refine}};
  json.update(json_of(comparison));
  std::printf("%s\n", json.dump(2).c_str());
  return ExitCode::done;
}

}  // namespace vrda
