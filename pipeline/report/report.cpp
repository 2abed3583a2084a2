// The report as one HTML page: data as JSON, scripts, style and images embedded.
#include "report/report.hpp"

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <cstdio>
#include <map>

#include "analysis/reduce.hpp"
#include "core/document.hpp"
#include "core/text.hpp"
#include "core/units.hpp"
#include "model/coordinates.hpp"
#include "model/frames.hpp"
#include "report/model_json.hpp"
#include "store/motion.hpp"

namespace vrda::report {
namespace {

constexpr Quantity compared[] = {Quantity::internal, Quantity::varus, Quantity::anterior, Quantity::proximal,
                                 Quantity::lateral};
// Shown only where a curve file has nothing else.
constexpr Quantity of_origin[] = {Quantity::origin_anterior, Quantity::origin_proximal,
                                  Quantity::origin_lateral};

Json quantities_json()
{
  Json list = Json::array();
  for (const QuantityName& q : quantity_names)
    list.push_back({{"key", q.key}, {"name", q.name}, {"unit", q.unit}});
  return list;
}

Eigen::Vector3d point_of(const Report& report, const ReportModel& entry)
{
  return comparison_point_mm(report.models.front().model, entry.model);
}

// The curve files by the point of the first model.
std::vector<CurveFile> compared_files(const Report& report)
{
  const store::MotionModel& first = report.models.front().model;
  std::vector<CurveFile> files;
  for (const CurveFile& file : report.against)
    files.push_back(about_point(file, side_named(first.side), first.rotation_centre_mm));
  return files;
}

Json against_json(const std::vector<CurveFile>& files)
{
  Json list = Json::array();
  for (const CurveFile& file : files) {
    Json curve = curve_json(file.curve);
    curve["notes"] = file.comments;
    list.push_back(std::move(curve));
  }
  return list;
}

const char* key_of(Quantity quantity)
{
  return quantity_names[static_cast<std::size_t>(quantity)].key;
}

Json difference_json(const ClinicalCurve& curve, const ClinicalCurve& other, bool is_of_origin)
{
  std::vector<Quantity> quantities(std::begin(compared), std::end(compared));
  if (is_of_origin) quantities.insert(quantities.end(), std::begin(of_origin), std::end(of_origin));
  Json by_quantity = Json::object();
  for (const Quantity quantity : quantities) {
    const CurveDifference d = difference(curve, other, quantity);
    if (d.n == 0) continue;
    by_quantity[key_of(quantity)] = {{"n", d.n},
                                     {"rms", d.rms},
                                     {"largest", d.largest},
                                     {"mean", d.mean},
                                     {"rms_about_mean", d.rms_about_mean}};
  }
  return by_quantity;
}

// Every curve of every model against every file; further models also against the first model's first curve.
Json differences_json(const Report& report, const std::vector<CurveFile>& files)
{
  Json list = Json::array();
  const auto add = [&](const std::string& model, const ClinicalCurve& curve, const std::string& against,
                       const ClinicalCurve& other, bool is_of_origin = false) {
    list.push_back({{"model", model},
                    {"curve", curve.name},
                    {"against", against},
                    {"by_quantity", difference_json(curve, other, is_of_origin)}});
  };
  const std::vector<ClinicalCurve> first =
      clinical_curves(report.models.front().model, point_of(report, report.models.front()));
  for (std::size_t m = 0; m < report.models.size(); ++m) {
    const ReportModel& entry = report.models[m];
    for (const ClinicalCurve& curve : clinical_curves(entry.model, point_of(report, entry))) {
      for (const CurveFile& file : files)
        add(entry.name, curve, file.curve.name, file.curve, file.is_incomplete);
      if (m > 0)
        add(entry.name, curve, report.models.front().name + ", " + first.front().name, first.front());
    }
  }
  return list;
}

Json json_of(const Report& report)
{
  Json models = Json::array();
  for (const ReportModel& entry : report.models)
    models.push_back(
        model_json(entry, {.is_whole = report.models.size() == 1, .point_mm = point_of(report, entry)}));
  const std::vector<CurveFile> files = compared_files(report);
  const bool has_incomplete =
      std::any_of(files.begin(), files.end(), [](const CurveFile& file) { return file.is_incomplete; });
  return {{"program", report.program},      {"quantities", quantities_json()},
          {"models", std::move(models)},    {"against", against_json(files)},
          {"shows_origin", has_incomplete}, {"differences", differences_json(report, files)}};
}

void round_numbers(Json& json)
{
  constexpr double per_unit = 1e6;
  if (json.is_number_float()) {
    const auto value = json.get<double>();
    json = std::isfinite(value) ? Json(std::round(value * per_unit) / per_unit) : Json();
  } else if (json.is_structured()) {
    for (Json& part : json) round_numbers(part);
  }
}

// Escapes JSON for a script element: with '<' a title could end the element.
std::string within_script(const std::string& json)
{
  constexpr std::string_view unsafe = "<>&";
  constexpr std::array<const char*, 3> escapes{"\\u003c", "\\u003e", "\\u0026"};
  std::string text;
  text.reserve(json.size());
  for (const char c : json) {
    if (const std::size_t k = unsafe.find(c); k != std::string_view::npos) {
      text += escapes[k];
    } else {
      text += c;
    }
  }
  return text;
}

// A single pass over the template, so inserted text is not searched for placeholders.
std::string filled(std::string_view text, const std::map<std::string_view, std::string_view>& values)
{
  std::string page;
  while (true) {
    const std::size_t begin = text.find("{{");
    if (begin == std::string_view::npos) return page += text;
    const std::size_t end = text.find("}}", begin);
    check(end != std::string_view::npos, "a placeholder of the page template is not closed");
    const auto value = values.find(text.substr(begin + 2, end - begin - 2));
    check(value != values.end(), "every placeholder of the page template has a value");
    page += text.substr(0, begin);
    page += value->second;
    text.remove_prefix(end + 2);
  }
}

std::string title_of(const Report& report)
{
  if (report.models.size() == 1) return report.models.front().model.title;
  return "Comparison of " + std::to_string(report.models.size()) + " motion models";
}

}  // namespace

std::string data_text(Json data)
{
  round_numbers(data);
  return core::json_text(data, -1);
}

std::string page_of(const std::string& title, Json data)
{
  const std::string script = within_script(data_text(std::move(data)));
  const std::string heading = escape_markup(title);
  return filled(page_template(), {{"title", heading},
                                  {"style", page_style()},
                                  {"plot_style", plot_style()},
                                  {"plot_licence", plot_licence()},
                                  {"code", page_code()},
                                  {"data", script}});
}

std::string report_json(const Report& report)
{
  check(!report.models.empty(), "a report has a motion model");
  return data_text(json_of(report));
}

std::string report_page(const Report& report)
{
  check(!report.models.empty(), "a report has a motion model");
  return page_of(title_of(report), json_of(report));
}

// What a report says in words: summary of a motion, warnings of a model.

namespace {

// The certificate of an equilibrium (solve/equilibrium.cpp) allows this share of the push.
constexpr double residual_share = 1e-2;

void add_equilibrium(const store::MotionModel& model, MotionSummary& numbers)
{
  const store::EquilibriumSurfaces& e = *model.equilibrium;
  numbers.n_several_optima =
      std::count_if(e.spine.n_optima.begin(), e.spine.n_optima.end(), [](std::int32_t n) { return n > 1; });
  numbers.largest_optima_spread_deg = store::largest_of(e.spine.optima_theta_spread_deg);
  numbers.balance_residual_n = store::largest_of(e.balance_residual_n);
  numbers.worst_gap_mm = store::smallest_of(e.worst_gap_mm);
  numbers.push_n = model.push.force_n.rows() > 0 ? model.push.force_n.rowwise().norm().maxCoeff() : nan;
}

using Lines = std::vector<std::string>;

// "Theta jumps ..." of "theta jumps ..."; nothing for an empty text.
void add_sentence(std::string text, Lines& lines)
{
  if (text.empty()) return;
  text.front() = static_cast<char>(std::toupper(text.front()));
  lines.push_back(text + ".");
}

void add_unsolved(const store::MotionModel& model, Lines& lines)
{
  for (const StepStatus status : all_step_statuses) {
    const auto n = (model.status == static_cast<std::int8_t>(status)).count();
    if (status == StepStatus::stable || n == 0) continue;
    lines.push_back(printed("%lld of %lld attitudes ended as %s: %s.", static_cast<long long>(n),
                            static_cast<long long>(model.status.size()), name_of(status),
                            meaning_of(status)));
  }
  const std::vector<Eigen::Index> spine = store::solved_spine(model);
  const auto n_missing = std::count(spine.begin(), spine.end(), -1);
  if (n_missing > 0)
    lines.push_back(printed(
        "%lld of %zu flexions have no solved pose on the spine; curves over flexion have holes there.",
        static_cast<long long>(n_missing), spine.size()));
}

// `of`: " of patella", or empty.
void add_doubtful(const store::GridB& plausibilities, const std::string& of, Lines& lines)
{
  for (const Plausibility plausibility : doubtful_plausibilities) {
    const auto n = (plausibilities == static_cast<std::int8_t>(plausibility)).count();
    if (n == 0) continue;
    lines.push_back(printed("%lld stable attitudes%s are doubtful, %s: %s.", static_cast<long long>(n),
                            of.c_str(), name_of(plausibility), meaning_of(plausibility)));
  }
}

void add_raw_extremes(const ReportModel& entry, Lines& lines)
{
  if (entry.raw.largest_penetration_mm > perceptible_mm)
    lines.push_back(printed(
        "The raw motion overlaps by up to %.3g mm (%lld attitudes overlap), above the perceptible "
        "%.3g mm.",
        entry.raw.largest_penetration_mm, static_cast<long long>(entry.raw.n_overlapping), perceptible_mm));
  if (std::isinf(entry.raw.largest_gap_mm)) {
    lines.push_back("At some attitudes no contact is ahead along Delta: the objects have separated.");
  } else if (entry.raw.largest_gap_mm > std::max(perceptible_mm, entry.model.contact_resolution_mm)) {
    lines.push_back(printed("The raw motion has a gap of up to %.3g mm, above the perceptible %.3g mm.",
                            entry.raw.largest_gap_mm, perceptible_mm));
  }
}

// One line for all degrees, since most of them overlap.
void add_audits(const store::MotionModel& model, Lines& lines)
{
  std::string found;
  for (const store::AuditSet& audit : model.audits) {
    if (audit.name == "raw") continue;
    const double deepest_mm = store::largest_of(audit.penetration_mm);
    const auto n = (audit.state == static_cast<std::int8_t>(store::AuditState::overlapping)).count();
    if (deepest_mm > perceptible_mm)
      found += printed("%s%s by up to %.3g mm (%lld of %lld attitudes overlap)", found.empty() ? "" : ", ",
                       audit.name.c_str(), deepest_mm, static_cast<long long>(n),
                       static_cast<long long>(audit.state.size()));
  }
  if (!found.empty())
    lines.push_back(printed("Audits found overlaps above the perceptible %.3g mm: ", perceptible_mm) + found +
                    ".");
}

void add_comparison(const ReportModel& entry, Lines& lines)
{
  const store::DefaultMotion shown = store::default_motion(entry.model);
  if (!shown.reason.empty()) {
    lines.push_back("The solved poses are shown and exported: " + shown.reason + ".");
  } else if (entry.comparison && entry.comparison->recommendation.degree < 0) {
    lines.push_back("No smoothing degree meets the criteria: " + entry.comparison->recommendation.reason +
                    ".");
  }
}

void add_rotation(const store::MotionModel& model, const MotionSummary& numbers, Lines& lines)
{
  if (numbers.theta_undetermined_share > 0.0)
    lines.push_back(
        printed("Internal rotation is not determined by contact in %.3g %% of the solved attitudes; the pose "
                "nearest to the neighbour's is used there.",
                100.0 * numbers.theta_undetermined_share));
  if (numbers.n_several_optima > 0)
    lines.push_back(
        printed("%lld of %zu flexions have several equilibria, up to %.3g degrees of theta apart; "
                "solver.equilibrium.branch chooses one.",
                static_cast<long long>(numbers.n_several_optima), model.flexion_deg.size(),
                numbers.largest_optima_spread_deg));
  if (!store::has_turned_axes(model))  // theta then also follows the other rotations
    add_sentence(store::text_of(numbers.spine_jump), lines);
}

void add_spine_at_border(const store::MotionModel& model, Lines& lines)
{
  const auto n_varus = static_cast<Eigen::Index>(model.varus_deg.size());
  if (n_varus < 3) return;
  const std::vector<Eigen::Index> spine = store::solved_spine(model);
  const auto n = std::count_if(spine.begin(), spine.end(), [&](Eigen::Index cell) {
    return cell >= 0 && (cell % n_varus == 0 || cell % n_varus == n_varus - 1);
  });
  if (n > 0 && model.has_compartments)
    lines.push_back(
        printed("At %lld flexions the compartments balance at the border of the varus range: use a wider "
                "range.",
                static_cast<long long>(n)));
}

void add_interpolated(const store::MotionModel& model, Lines& lines)
{
  if (!model.zero_varus) return;
  const std::vector<std::int8_t>& source = model.zero_varus->source;
  const auto n = std::count(source.begin(), source.end(),
                            static_cast<std::int8_t>(store::ZeroVarusSource::interpolated));
  const auto n_none =
      std::count(source.begin(), source.end(), static_cast<std::int8_t>(store::ZeroVarusSource::none));
  if (n > 0 && model.zero_varus->set != "two_sided")  // that motion has its own varus
    lines.push_back(
        printed("The zero-varus pose is interpolated between two varus columns at %lld of %zu flexions.",
                static_cast<long long>(n), source.size()));
  add_sentence(analysis::cut_off_warning(*model.zero_varus), lines);
  if (n_none > 0)
    lines.push_back(printed("%lld of %zu flexions have no zero-varus pose.", static_cast<long long>(n_none),
                            source.size()));
}

}  // namespace

MotionSummary motion_summary(const store::MotionModel& model)
{
  MotionSummary numbers;
  numbers.n_cells = model.status.size();
  numbers.n_stable = (model.status == status_stable).count();
  const auto n_undetermined = (model.theta_determined == 0).count();
  if (numbers.n_stable > 0)
    numbers.theta_undetermined_share =
        static_cast<double>(n_undetermined) / static_cast<double>(numbers.n_stable);
  numbers.rotation = store::curve_figures(store::spine_rotation(model));
  numbers.spine_jump = store::spine_jump(model);
  numbers.balance_residual_n = numbers.worst_gap_mm = numbers.push_n = nan;
  numbers.largest_optima_spread_deg = nan;
  if (model.equilibrium) add_equilibrium(model, numbers);
  numbers.largest_strain = model.ligaments ? store::largest_of(model.ligaments->strain) : nan;
  numbers.largest_tension_n = model.ligaments ? store::largest_of(model.ligaments->tension_n) : nan;
  return numbers;
}

std::vector<std::string> warnings_of(const ReportModel& entry)
{
  const store::MotionModel& model = entry.model;
  const MotionSummary numbers = motion_summary(model);
  Lines lines = model.job.warnings;
  add_unsolved(model, lines);
  add_doubtful(model.plausibility, "", lines);
  for (const store::FollowerRows& follower : model.followers)
    add_doubtful(follower.plausibility, " of " + follower.name, lines);
  add_raw_extremes(entry, lines);
  if (numbers.balance_residual_n > residual_share * numbers.push_n)
    lines.push_back(printed(
        "The balance of forces has a residual of up to %.3g N, more than one hundredth of the push of "
        "%.3g N.",
        numbers.balance_residual_n, numbers.push_n));
  add_rotation(model, numbers, lines);
  add_sentence(gimbal_lock_text(store::clinical_curves(model).n_locked), lines);
  add_spine_at_border(model, lines);
  add_comparison(entry, lines);
  add_audits(model, lines);
  add_interpolated(model, lines);
  return lines;
}

}  // namespace vrda::report
