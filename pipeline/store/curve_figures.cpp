#include "store/curve_figures.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdio>

#include "model/coordinates.hpp"
#include "store/solved_cells.hpp"

namespace vrda::store {
namespace {

double value_at(const FlexionCurve& curve, double flexion_deg)
{
  const auto& at = curve.flexion_deg;
  const auto after = std::lower_bound(at.begin(), at.end(), flexion_deg);
  const auto i = static_cast<std::size_t>(after - at.begin());
  if (i == 0 || *after == flexion_deg) return curve.value_deg[i];
  const double share = (flexion_deg - at[i - 1]) / (at[i] - at[i - 1]);
  return curve.value_deg[i - 1] + share * (curve.value_deg[i] - curve.value_deg[i - 1]);
}

/// Of a polygon, the largest change within a window has a corner at one end, and at the other a corner or the
/// width of the window.
void set_largest_change(CurveFigures& figures, const FlexionCurve& curve)
{
  const auto& at = curve.flexion_deg;
  const auto compare = [&](double from_deg, double to_deg) {
    const double change_deg = value_at(curve, to_deg) - value_at(curve, from_deg);
    const bool is_narrower = to_deg - from_deg < figures.change_to_deg - figures.change_from_deg;
    const double least_deg = std::abs(figures.change_deg);  // the comparisons are false for NaN
    if (std::abs(change_deg) < least_deg || (std::abs(change_deg) == least_deg && !is_narrower)) return;
    figures.change_deg = change_deg;
    figures.change_from_deg = from_deg;
    figures.change_to_deg = to_deg;
  };
  for (std::size_t i = 0; i < at.size(); ++i) {
    for (std::size_t k = i + 1; k < at.size() && at[k] - at[i] <= change_window_deg; ++k)
      compare(at[i], at[k]);
    compare(at[i], std::min(at[i] + change_window_deg, at.back()));
    compare(std::max(at[i] - change_window_deg, at.front()), at[i]);
  }
}

}  // namespace

CurveFigures curve_figures(const FlexionCurve& curve)
{
  FlexionCurve known;
  for (std::size_t i = 0; i < curve.value_deg.size(); ++i) {
    if (std::isnan(curve.value_deg[i])) continue;
    known.flexion_deg.push_back(curve.flexion_deg[i]);
    known.value_deg.push_back(curve.value_deg[i]);
  }
  CurveFigures figures;
  if (known.value_deg.size() < 2) return figures;
  figures.first_deg = known.flexion_deg.front();
  figures.last_deg = known.flexion_deg.back();
  figures.net_deg = known.value_deg.back() - known.value_deg.front();
  for (std::size_t i = 0; i < known.value_deg.size(); ++i) {
    const double turned_deg = known.value_deg[i] - known.value_deg.front();
    if (std::abs(turned_deg) <= std::abs(figures.peak_deg)) continue;
    figures.peak_deg = turned_deg;
    figures.peak_at_deg = known.flexion_deg[i];
  }
  if (std::ranges::is_sorted(known.flexion_deg, std::ranges::less_equal{}))
    set_largest_change(figures, known);
  return figures;
}

FlexionCurve spine_rotation(const store::MotionModel& model)
{
  FlexionCurve curve;
  const store::ClinicalCurves clinical = store::clinical_curves(model);
  for (Eigen::Index i = 0; i < model.is_spine.rows(); ++i) {
    for (Eigen::Index j = 0; j < model.is_spine.cols(); ++j) {
      if (model.is_spine(i, j) != 1) continue;
      // Past gimbal lock the measured flexion of a frame turns over; its curve does not.
      curve.flexion_deg.push_back(model.frames ? clinical.surfaces.flexion_deg(i, j)
                                               : model.flexion_deg[static_cast<std::size_t>(i)]);
      curve.value_deg.push_back(clinical.surfaces.internal_rotation_deg(i, j));
    }
  }
  return curve;
}

SpineJump spine_jump(const store::MotionModel& model)
{
  SpineJump jump;
  if (model.frames) return jump;
  double before_deg = nan;
  for (Eigen::Index i = 0; i < model.is_spine.rows(); ++i) {
    double here_deg = nan;
    for (Eigen::Index j = 0; j < model.is_spine.cols(); ++j)
      if (model.is_spine(i, j) == 1 && model.status(i, j) == status_stable) here_deg = model.theta_deg(i, j);
    const double change_deg = std::abs(nearest_turn(here_deg, before_deg, 360.0) - before_deg);
    before_deg = here_deg;
    if (std::isnan(change_deg) || change_deg <= jump.change_deg) continue;  // the second is false for NaN
    const auto row = static_cast<std::size_t>(i);
    jump = {change_deg, model.flexion_deg[row - 1], model.flexion_deg[row]};
  }
  return jump;
}

std::string text_of(const SpineJump& jump)
{
  if (!(jump.change_deg > spine_jump_deg)) return "";
  std::array<char, 120> text{};
  std::snprintf(text.data(), text.size(),
                "theta jumps by %.3g degrees between flexion %.4g and %.4g of the spine", jump.change_deg,
                jump.from_deg, jump.to_deg);
  return text.data();
}

std::string text_of(const CurveFigures& figures)
{
  if (std::isnan(figures.net_deg)) return "none";
  const auto tenths = [](double deg) { return std::round(10.0 * deg) / 10.0 + 0.0; };
  std::array<char, 240> text{};
  int n = std::snprintf(text.data(), text.size(),
                        "net %+.3g degrees from flexion %.4g to %.4g, peak %+.3g at %.4g",
                        tenths(figures.net_deg), tenths(figures.first_deg), tenths(figures.last_deg),
                        tenths(figures.peak_deg), tenths(figures.peak_at_deg));
  if (!std::isnan(figures.change_deg))
    std::snprintf(text.data() + n, text.size() - static_cast<std::size_t>(n),
                  ", largest change %+.3g per %g degrees of flexion (%.4g to %.4g)",
                  tenths(figures.change_deg), change_window_deg, tenths(figures.change_from_deg),
                  tenths(figures.change_to_deg));
  return text.data();
}

}  // namespace vrda::store
