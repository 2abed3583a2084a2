// `vrda compare`: polynomial degrees side by side and a recommendation, as a table or JSON.
#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdio>
#include <nlohmann/json.hpp>
#include <set>

#include "analysis/audit.hpp"
#include "analysis/compare.hpp"
#include "app/commands.hpp"
#include "app/printing.hpp"
#include "core/document.hpp"
#include "core/text.hpp"
#include "core/units.hpp"
#include "model/coordinates.hpp"
#include "report/model_json.hpp"
#include "run/result.hpp"
#include "run/run_output.hpp"

namespace vrda::app {
namespace {

using Json = nlohmann::ordered_json;
using Cells = std::vector<std::string>;

std::string number(double value)
{
  return formatted("%.3g", value);
}

/// Errors of the translation vector, then of the angles.
std::vector<analysis::ErrorMeasures> errors_of(const analysis::DegreeRow& row)
{
  std::vector<analysis::ErrorMeasures> errors{row.translation};
  for (std::size_t s = 3; s < row.surfaces.size(); ++s) errors.push_back(row.surfaces[s].errors);
  return errors;
}

constexpr double analysis::ErrorMeasures::*measures[] = {
    &analysis::ErrorMeasures::rms, &analysis::ErrorMeasures::largest, &analysis::ErrorMeasures::leave_one_out,
    &analysis::ErrorMeasures::roughness};

constexpr const char* measure_names[] = {"RMS", "largest", "leave-one-out", "roughness"};

void add_audit_headings(Cells& upper, Cells& lower)
{
  for (const char* fault : {"penetration", "gap"}) {
    upper.insert(upper.end(), {fault, ""});
    lower.insert(lower.end(), {"grid mm", "between mm"});
  }
}

/// Two heading lines: the measure above its first column, the unit above every column.
std::pair<Cells, Cells> headings(const analysis::DegreeRow& row)
{
  Cells upper{""}, lower{"degree"};
  for (const char* measure : measure_names) {
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
  upper.insert(upper.end(), {"in perceptible errors", ""});
  lower.insert(lower.end(), {"left out", "2nd diff"});
  if (row.contact) {
    upper.insert(upper.end(), {"in contact", ""});
    lower.insert(lower.end(), {"overlap mm", "gap mm"});
  }
  if (row.audit_totals) add_audit_headings(upper, lower);
  return {upper, lower};
}

void add_audit(const std::optional<analysis::MotionAuditTotals>& totals, Cells& cells)
{
  if (!totals) return;
  for (const auto fault :
       {&analysis::AuditTotals::largest_penetration_mm, &analysis::AuditTotals::largest_gap_mm}) {
    cells.push_back(number(totals->at_grid.*fault));
    cells.push_back(number(totals->between.*fault));
  }
}

Cells cells_of(const analysis::DegreeRow& row, const analysis::RankedDegree& ranked)
{
  Cells cells{std::to_string(row.set.degree)};
  for (const auto measure : measures) {
    for (const analysis::ErrorMeasures& errors : errors_of(row)) cells.push_back(number(errors.*measure));
  }
  cells.push_back(number(100.0 * row.perceptible_share));
  cells.insert(cells.end(), {number(ranked.error), number(row.second_difference)});
  if (row.contact)
    cells.insert(cells.end(), {number(row.contact->largest_overlap_mm), number(row.contact->largest_gap_mm)});
  add_audit(row.audit_totals, cells);
  return cells;
}

// Residuals of a follower's coordinates, a line a degree.
std::vector<Cells> follower_lines(const analysis::Comparison& comparison, const std::string& name)
{
  Cells upper{name}, lower{"degree"};
  for (std::size_t m = 0; m < std::size(measures); ++m) {
    for (std::size_t k = 0; k < n_joint_coordinates; ++k) {
      upper.push_back(k == 0 ? measure_names[m] : "");
      lower.push_back(std::string(follower_coordinate_names[k]) + (is_rotation(k) ? " deg" : " mm"));
    }
  }
  std::vector<Cells> lines{upper, lower};
  for (const analysis::DegreeRow& row : comparison.rows) {
    for (const analysis::FollowerRow& follower : row.followers) {
      if (follower.name != name) continue;
      Cells cells{std::to_string(row.set.degree)};
      for (const auto measure : measures) {
        for (const analysis::SurfaceRow& surface : follower.surfaces)
          cells.push_back(number(surface.errors.*measure));
      }
      if (follower.audit_totals && lines[1].size() == cells.size()) add_audit_headings(lines[0], lines[1]);
      add_audit(follower.audit_totals, cells);
      lines.push_back(cells);
    }
  }
  return lines;
}

std::string aligned(const std::vector<Cells>& lines)
{
  std::vector<std::size_t> widths(lines[1].size(), 0);
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

Json json_of(const analysis::ErrorMeasures& errors)
{
  return {{"rms", errors.rms},
          {"largest_residual", errors.largest},
          {"leave_one_out_rms", errors.leave_one_out},
          {"roughness", errors.roughness}};
}

Json json_of(const analysis::AuditTotals& faults)
{
  return {{"attitudes", faults.n_attitudes},
          {"overlapping", faults.n_overlapping},
          {"nothing_ahead", faults.n_nothing_ahead},
          {"largest_penetration_mm", faults.largest_penetration_mm},
          {"largest_gap_mm", faults.largest_gap_mm}};
}

Json json_of(const analysis::ContactFigures& contact)
{
  Json json = {{"poses", contact.n_poses},
               {"lifted_off", contact.n_lifted_off},
               {"largest_gap_mm", contact.largest_gap_mm},
               {"largest_overlap_mm", contact.largest_overlap_mm}};
  if (contact.sides) json["two_sided"] = report::two_sided_json(*contact.sides);
  return json;
}

Json json_of(const analysis::SurfaceRow& surface, bool is_length)
{
  Json json = {{"unit", is_length ? "mm" : "degree"},
               {"cells", surface.n_cells},
               {"condition_number", surface.condition_number}};
  json.update(json_of(surface.errors));
  return json;
}

void add_audit(const std::optional<analysis::MotionAuditTotals>& totals, Json& json)
{
  if (!totals) return;
  json["at_grid"] = json_of(totals->at_grid);
  json["between"] = json_of(totals->between);
}

Json json_of(const analysis::FollowerRow& follower)
{
  Json surfaces = Json::object();
  for (std::size_t s = 0; s < follower.surfaces.size(); ++s)
    surfaces[follower.surfaces[s].name] = json_of(follower.surfaces[s], !is_rotation(s));
  Json json = {{"surfaces", surfaces}};
  add_audit(follower.audit_totals, json);
  return json;
}

Json json_of(const analysis::DegreeRow& row, const analysis::RankedDegree& ranked)
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
                 {"is_within", ranked.is_within}}},
               {"second_difference", row.second_difference},
               {"fault", name_of(ranked.fault)}};
  if (row.contact) json["contact"] = json_of(*row.contact);
  add_audit(row.audit_totals, json);
  for (const analysis::FollowerRow& follower : row.followers)
    json["followers"][follower.name] = json_of(follower);
  return json;
}

}  // namespace

std::string comparison_table(const analysis::Comparison& comparison)
{
  const auto [upper, lower] = headings(comparison.rows.front());
  std::vector<Cells> lines{upper, lower};
  for (std::size_t k = 0; k < comparison.rows.size(); ++k)
    lines.push_back(cells_of(comparison.rows[k], comparison.recommendation.ranked[k]));
  std::string text = aligned(lines);
  // The lowest degree has every follower that a higher one has.
  for (const analysis::FollowerRow& follower : comparison.rows.front().followers)
    text += aligned(follower_lines(comparison, follower.name));
  return text;
}

std::string recommendation_text(const analysis::Recommendation& recommendation)
{
  if (recommendation.degree >= 0) return "recommended: " + recommendation.reason;
  return std::string("no degree meets the criteria (") + name_of(recommendation.fault) +
         "): " + recommendation.reason;
}

Json json_of(const analysis::Comparison& comparison)
{
  Json rows = Json::array();
  for (std::size_t k = 0; k < comparison.rows.size(); ++k)
    rows.push_back(json_of(comparison.rows[k], comparison.recommendation.ranked[k]));
  const analysis::Recommendation& r = comparison.recommendation;
  const auto degree = [](int value) { return value < 0 ? Json() : Json(value); };
  return {{"perceptible", {{"mm", perceptible_mm}, {"degree", deg_from_rad(perceptible_rad)}}},
          {"degrees", rows},
          {"not_carried", comparison.undetermined_degrees},
          {"recommendation",
           {{"status", r.degree >= 0 ? "recommended" : name_of(r.fault)},
            {"degree", degree(r.degree)},
            {"best_degree", degree(r.best_degree)},
            {"left_out", {{"flexions", r.block_size.flexion}, {"varus_columns", r.block_size.varus}}},
            {"reason", r.reason}}}};
}

namespace {

[[noreturn]] void refuse(const std::string& text)
{
  throw InputError({"vrda compare", "--degrees", "\"" + text + "\"",
                    "degrees from 0 to " + std::to_string(store::max_smoothed_degree) +
                        " as a range or a list: 1..12 or 2,4,6"});
}

int degree_of(const std::string& word, const std::string& text)
{
  int degree = -1;
  const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), degree);
  const bool is_whole = error == std::errc() && end == word.data() + word.size();
  if (!is_whole || degree < 0 || degree > store::max_smoothed_degree) refuse(text);
  return degree;
}

analysis::CompareOptions compare_options(const CompareCommandOptions& options, std::vector<int> degrees,
                                         const analysis::Measuring& with)
{
  const std::function<void()>& hook = options.before_measuring;
  analysis::CompareOptions compare;
  compare.name = options.file;
  compare.degrees = std::move(degrees);
  compare.smooth.is_robust = options.is_robust;
  if (options.is_recontacted) {
    compare.recontact = [with, hook](const store::MotionModel& model, store::SmoothedSet& set) {
      if (hook) hook();
      analysis::add_recontact(model, set, with);
    };
  }
  if (options.refine > 0) {
    compare.contact = [measure = run::contact_measure(with), hook](const store::MotionModel& model,
                                                                   const store::SmoothedSet& set) {
      if (hook) hook();
      return measure(model, set);
    };
    compare.audit = [with, hook, refine = options.refine](const store::MotionModel& model,
                                                          const std::string& set) {
      if (hook) hook();
      core::log_info("measuring " + set);
      return analysis::audit(model, set, refine, with, analysis::OverlapTest::sweep);
    };
  }
  return compare;
}

void report_skipped_degrees(const std::string& file, const analysis::Comparison& comparison)
{
  if (!comparison.undetermined_degrees.empty()) {
    core::log_info(file + ": too few solved cells to fit degree " +
                   std::to_string(comparison.undetermined_degrees.front()) + " and above");
  }
  for (const analysis::DegreeRow& row : comparison.rows) {
    if (!row.is_converged)
      core::log_warning("degree " + std::to_string(row.set.degree) +
                        ": the robust weights did not converge within the iteration limit");
  }
}

}  // namespace

std::vector<int> parse_degrees(const std::string& text)
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

analysis::Comparison compare_degrees(const CompareCommandOptions& options)
{
  std::vector<int> degrees = parse_degrees(options.degrees);
  const store::MotionModel model = run::read_solved_model(options.file);
  store::require_grid(model, options.file, "vrda compare");
  const int n_threads = run::thread_count_or_all(options.n_threads);
  analysis::AuditScenes scenes(model, n_threads);
  analysis::Comparison comparison =
      analysis::compare(model, compare_options(options, std::move(degrees), {n_threads, &scenes}));
  report_skipped_degrees(options.file, comparison);
  return comparison;
}

core::ExitCode compare_command(const CompareCommandOptions& options)
{
  const analysis::Comparison comparison = compare_degrees(options);
  if (!options.as_json) {
    std::printf("%s%s\n", comparison_table(comparison).c_str(),
                recommendation_text(comparison.recommendation).c_str());
    return core::ExitCode::done;
  }
  nlohmann::ordered_json json = {{"file", options.file},
                                 {"robust", options.is_robust},
                                 {"recontacted", options.is_recontacted},
                                 {"refine", options.refine}};
  json.update(json_of(comparison));
  return print_json(json);
}

void declare_compare(Command& c)
{
  auto& o = c.options<CompareCommandOptions>();
  c.model(o.file);
  c.option("--degrees", o.degrees, "A range or a list: 1..12 or 2,4,6").shows_default();
  c.option("--refine", o.refine,
           "Subdivisions of a grid step at which gap and penetration are measured; 0: no audit")
      .whole_number(0, 16)
      .shows_default();
  c.threads(o.n_threads);
  c.flag("--robust", o.is_robust, "Fit with Huber weights, which reduce the effect of outliers");
  c.flag("--recontact", o.is_recontacted, "Compare the motions after moving them into contact along Delta");
  c.json(o.as_json);
  c.runs([&o] { return compare_command(o); });
}

}  // namespace vrda::app
