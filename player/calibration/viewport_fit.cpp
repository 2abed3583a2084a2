#include "calibration/viewport_fit.hpp"

#include <algorithm>
#include <boost/math/statistics/univariate_statistics.hpp>
#include <cmath>
#include <limits>
#include <numeric>

#include "show/settings_text.hpp"
#include "bench/rigid_body.hpp"

namespace vrda::calibration {
namespace {

constexpr double furthest_reading_px = 5.0;
constexpr int least_side_px = 16;

std::string px_text(double px)
{
  return bench::text(px, 2, "px");
}

double mean(const std::vector<double>& values)
{
  double sum = 0.0;
  for (const double value : values) sum += value;
  return sum / static_cast<double>(values.size());
}

/// Indices of an edge's readings among all marks.
std::vector<std::size_t> marks_of(Edge edge, const ViewportMarks& marks)
{
  std::size_t first = 0;
  for (std::size_t before = 0; before < static_cast<std::size_t>(edge); ++before)
    first += marks.line_px[before].size();
  std::vector<std::size_t> indices(marks.line_px[static_cast<std::size_t>(edge)].size());
  std::iota(indices.begin(), indices.end(), first);
  return indices;
}

void require_readings(const ViewportMarks& marks, Edge edge, const bench::FitErrorContext& context)
{
  const std::string field = std::string(".") + name_of(edge);
  const std::vector<double>& readings = marks.line_px[static_cast<std::size_t>(edge)];
  const std::vector<std::size_t> indices = marks_of(edge, marks);
  if (readings.empty()) context.fail(field, "no readings", "one or more; scan this edge");
  for (std::size_t k = 0; k < readings.size(); ++k) {
    if (!std::isfinite(readings[k]))
      context.fail(field, "a reading that is not a finite number", "px", {indices[k]});
    if (readings.size() == 1) break;
    std::vector<double> others = readings;
    others.erase(others.begin() + static_cast<std::ptrdiff_t>(k));
    const double about_px = boost::math::statistics::median(others);
    if (std::abs(readings[k] - about_px) > furthest_reading_px) {
      context.fail(field,
                   "reading " + std::to_string(k + 1) + " at " + px_text(readings[k]) +
                       ", the others at about " + px_text(about_px),
                   "readings within " + px_text(furthest_reading_px) + " of each other; scan it again",
                   {indices[k]});
    }
  }
}

/// Borders between pixels (left, right, top, bottom) with their variances.
struct Borders {
  Eigen::Vector4d at_px = Eigen::Vector4d::Zero();
  Eigen::Vector4d variance_px2 = Eigen::Vector4d::Zero();
  double dof = 0.0;
  std::vector<double> residuals_px;
};

Borders borders_of(const ViewportMarks& marks)
{
  Borders borders;
  double sum_sq_px2 = 0.0;
  for (std::size_t edge = 0; edge < n_edges; ++edge) {
    // The centre of the first pixel that is at least half visible is on average half a pixel inside the
    // border, so its outer side is the border. The same holds for the last pixel.
    const bool is_last =
        edge == static_cast<std::size_t>(Edge::right) || edge == static_cast<std::size_t>(Edge::bottom);
    const double at_px = mean(marks.line_px[edge]);
    borders.at_px(static_cast<Eigen::Index>(edge)) = at_px + (is_last ? 1.0 : 0.0);
    for (const double reading : marks.line_px[edge]) {
      borders.residuals_px.push_back(reading - at_px);
      sum_sq_px2 += (reading - at_px) * (reading - at_px);
    }
  }
  // Rounding to whole pixels adds 1/12 px^2. If the readings scatter, their variance includes it and it
  // averages out; the remainder does not depend on the number of repeats.
  constexpr double rounding_px2 = 1.0 / 12.0;
  borders.dof = static_cast<double>(borders.residuals_px.size()) - static_cast<double>(n_edges);
  const double noise_px2 = borders.dof > 0.0 ? sum_sq_px2 / borders.dof : 0.0;
  const double stays_px2 = std::max(0.0, rounding_px2 - noise_px2);
  for (std::size_t edge = 0; edge < n_edges; ++edge) {
    borders.variance_px2(static_cast<Eigen::Index>(edge)) =
        stays_px2 + noise_px2 / static_cast<double>(marks.line_px[edge].size());
  }
  if (borders.dof == 0.0) borders.dof = std::numeric_limits<double>::infinity();
  return borders;
}

void require_order(const Eigen::Vector4d& at_px, const ViewportMarks& marks, const bench::FitErrorContext& context)
{
  for (const Edge edge : {Edge::left, Edge::top}) {
    const Edge opposite = edge == Edge::left ? Edge::right : Edge::bottom;
    const double low_px = at_px(static_cast<int>(edge)), high_px = at_px(static_cast<int>(opposite));
    const std::string field = std::string(".") + name_of(edge);
    if (!(low_px < high_px)) {
      context.fail(
          field,
          "crossed edges: at " + px_text(low_px) + ", and " + name_of(opposite) + " at " + px_text(high_px),
          std::string(name_of(edge)) + " before " + name_of(opposite), marks_of(edge, marks));
    }
    if (high_px - low_px < least_side_px) {
      context.fail(field, px_text(high_px - low_px) + " up to " + name_of(opposite),
                   std::to_string(least_side_px) + " px or more", marks_of(edge, marks));
    }
  }
}

void require_within(const Eigen::Vector4d& at_px, const view::Viewport& window, const ViewportMarks& marks,
                    const bench::FitErrorContext& context)
{
  const std::array<double, n_edges> border_px = {
      static_cast<double>(window.x), static_cast<double>(window.x + window.width),
      static_cast<double>(window.y), static_cast<double>(window.y + window.height)};
  for (std::size_t edge = 0; edge < n_edges; ++edge) {
    const bool is_last = edge % 2 == 1;
    const double beyond_px =
        (at_px(static_cast<Eigen::Index>(edge)) - border_px[edge]) * (is_last ? 1.0 : -1.0);
    // An edge that rounds to the window's border is inside.
    if (beyond_px < 0.5) continue;
    context.fail(std::string(".") + name_of(static_cast<Edge>(edge)),
                 px_text(beyond_px) + " outside the eye's window", "an edge inside the window",
                 marks_of(static_cast<Edge>(edge), marks));
  }
}

void require_size(const ViewportMarks& marks, const bench::FitErrorContext& context)
{
  const std::size_t n_readings = marks_of(Edge::bottom, marks).back() + 1;
  const bool is_size = marks.screen_mm.allFinite() && marks.screen_mm.minCoeff() > 0.0;
  if (!is_size) {
    context.fail(".screen",
                 show::rounded_text(marks.screen_mm.x(), 2) + " x " + bench::text(marks.screen_mm.y(), 2, "mm"),
                 "width and height of the visible part above 0, measured with a ruler",
                 {n_readings, n_readings + 1});
  }
  if (!(marks.screen_sd_mm >= 0.0) || !std::isfinite(marks.screen_sd_mm))
    context.fail(".screen_sd", bench::text(marks.screen_sd_mm, 3, "mm"), "0 mm or more");
}

/// The aspect's variance is mostly the ruler's, which is known. This factor scales its variance and
/// covariances so that bench::t_95 with the readings' degrees of freedom gives the interval with its own ones (Welch
/// and Satterthwaite: dof divided by the squared share of the readings).
double aspect_scale(double dof, double readings_share)
{
  constexpr double most_dof = 1e9;  // as good as infinite
  const double own_dof = std::min(most_dof, dof / (readings_share * readings_share));
  return bench::t_95(own_dof) / bench::t_95(std::min(most_dof, dof));
}

bench::Estimate estimate_of(const Borders& borders, const ViewportMarks& marks, const std::string& name)
{
  const double width_px = borders.at_px(1) - borders.at_px(0),
               height_px = borders.at_px(3) - borders.at_px(2);
  const double pixel_aspect = (marks.screen_mm.y() / height_px) / (marks.screen_mm.x() / width_px);
  bench::Estimate estimate;
  for (const Edge edge : {Edge::left, Edge::right, Edge::top, Edge::bottom})
    estimate.names.push_back(name + ".edge_" + name_of(edge));
  estimate.names.push_back(name + ".pixel_aspect");
  estimate.units = {"px", "px", "px", "px", ""};
  estimate.values.resize(5);
  estimate.values << borders.at_px, pixel_aspect;
  estimate.dof = borders.dof;
  bench::set_residuals(estimate, borders.residuals_px, "px");

  Eigen::Vector4d by_border = {-1.0 / width_px, 1.0 / width_px, 1.0 / height_px, -1.0 / height_px};
  by_border *= pixel_aspect;
  const Eigen::Vector4d with_border = borders.variance_px2.cwiseProduct(by_border);
  const double by_marks = by_border.dot(with_border);
  const double by_ruler = pixel_aspect * pixel_aspect * marks.screen_sd_mm * marks.screen_sd_mm *
                          marks.screen_mm.cwiseAbs2().cwiseInverse().sum();
  const double scale = aspect_scale(borders.dof, by_marks / (by_marks + by_ruler));
  estimate.covariance = Eigen::MatrixXd::Zero(5, 5);
  estimate.covariance.diagonal().head<4>() = borders.variance_px2;
  estimate.covariance.block<4, 1>(0, 4) = scale * with_border;
  estimate.covariance.block<1, 4>(4, 0) = scale * with_border.transpose();
  estimate.covariance(4, 4) = scale * scale * (by_marks + by_ruler);
  return estimate;
}

}  // namespace

const char* name_of(Edge edge)
{
  return std::array{"left", "right", "top", "bottom"}.at(static_cast<std::size_t>(edge));
}

bench::Estimate fit_viewport(const ViewportMarks& marks, const view::Viewport& window, const std::string& name,
                      const std::string& file)
{
  const bench::FitErrorContext context{name, file};
  for (std::size_t edge = 0; edge < n_edges; ++edge)
    require_readings(marks, static_cast<Edge>(edge), context);
  require_size(marks, context);
  const Borders borders = borders_of(marks);
  require_order(borders.at_px, marks, context);
  require_within(borders.at_px, window, marks, context);
  return estimate_of(borders, marks, name);
}

}  // namespace vrda::calibration
