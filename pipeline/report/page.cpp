// The report as one HTML page: data as JSON, scripts, style and images embedded.
#include "report/report.hpp"

#include <algorithm>
#include <map>
#include <string_view>

#include "core/error.hpp"
#include "model/side.hpp"
#include "core/text.hpp"
#include "report/model_json.hpp"

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
                                     {"rms", short_number(d.rms)},
                                     {"largest", short_number(d.largest)},
                                     {"mean", short_number(d.mean)},
                                     {"rms_about_mean", short_number(d.rms_about_mean)}};
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

// Escapes JSON for a script element: with '<' a title could end the element.
std::string within_script(const std::string& json)
{
  std::string text;
  text.reserve(json.size());
  for (const char c : json) {
    if (c == '<') {
      text += "\\u003c";
    } else if (c == '>') {
      text += "\\u003e";
    } else if (c == '&') {
      text += "\\u0026";
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

std::string report_json(const Report& report)
{
  check(!report.models.empty(), "a report has a motion model");
  // Titles and names come from files; invalid UTF-8 must not stop the report.
  return json_of(report).dump(-1, ' ', false, Json::error_handler_t::replace);
}

std::string report_page(const Report& report)
{
  const std::string data = within_script(report_json(report));
  const std::string title = escape_markup(title_of(report));
  return filled(page_template(), {{"title", title},
                                  {"style", page_style()},
                                  {"plotly_licence", plotly_licence()},
                                  {"plotly", plotly_library()},
                                  {"code", page_code()},
                                  {"data", data}});
}

}  // namespace vrda::report
