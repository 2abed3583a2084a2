#include "store/derived.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <limits>
#include <utility>

#include "core/units.hpp"
#include "store/evaluate_smoothed.hpp"

namespace vrda::store {
namespace {

double largest_number_in(const GridD& values)
{
  double largest = std::numeric_limits<double>::quiet_NaN();
  for (Eigen::Index k = 0; k < values.size(); ++k) {
    const double value = values.data()[k];
    if (std::isnan(largest) || value > largest) largest = value;
  }
  return largest;
}

std::string dataset_of(const std::string& name)
{
  return name == "varus" ? "varus_solved" : name;
}

}  // namespace

std::string smoothed_group(std::int32_t degree)
{
  return "/smoothed/degree_" + std::to_string(degree);
}

std::string smoothed_path(std::int32_t degree, const std::string& name)
{
  return smoothed_group(degree) + "/" + dataset_of(name);
}

std::string coefficients_path(std::int32_t degree, const std::string& name)
{
  return smoothed_group(degree) + "/coefficients_" + dataset_of(name);
}

bool is_audit_name(const std::string& name)
{
  if (name == "raw" || name == "two_sided" || name == "zero_varus") return true;
  for (int degree = 0; degree <= max_smoothed_degree; ++degree) {
    const std::string set = "degree_" + std::to_string(degree);
    if (name == set || name == set + "_recontacted") return true;
  }
  return false;
}

std::string audit_group(const std::string& name)
{
  return "/audit/" + name;
}

std::string group_name(const SmoothedSet& set)
{
  return "degree_" + std::to_string(set.degree);
}

bool set_group_name(SmoothedSet& set, const std::string& name)
{
  const std::size_t start = std::string("degree_").size();
  if (name.size() <= start) return false;
  std::from_chars(name.data() + start, name.data() + name.size(), set.degree);
  return group_name(set) == name;
}

std::string group_name(const AuditSet& audit)
{
  return audit.name;
}

bool set_group_name(AuditSet& audit, const std::string& name)
{
  audit.name = name;
  return is_audit_name(name);
}

AuditSummary summary_of(const AuditSet& audit)
{
  return {largest_number_in(audit.penetration_mm), largest_number_in(audit.gap_mm)};
}

void TwoSidedFigures::include(double medial_mm, double lateral_mm)
{
  ++n_poses;
  if (std::abs(medial_mm) <= perceptible_mm && std::abs(lateral_mm) <= perceptible_mm) ++n_both_in_contact;
  largest_gap_medial_mm = std::fmax(largest_gap_medial_mm, medial_mm);
  largest_overlap_medial_mm = std::fmax(largest_overlap_medial_mm, -medial_mm);
  largest_gap_lateral_mm = std::fmax(largest_gap_lateral_mm, lateral_mm);
  largest_overlap_lateral_mm = std::fmax(largest_overlap_lateral_mm, -lateral_mm);
}

TwoSidedFigures two_sided_figures(const AuditSet& audit)
{
  TwoSidedFigures figures;
  if (audit.gap_medial_mm.size() == 0) return figures;
  for (Eigen::Index k = 0; k < audit.state.size(); ++k) {
    if (audit.state.data()[k] != code_of(AuditState::no_pose))
      figures.include(audit.gap_medial_mm.data()[k], audit.gap_lateral_mm.data()[k]);
  }
  return figures;
}

std::vector<AuditSet> with_audit(std::vector<AuditSet> audits, AuditSet audit)
{
  std::erase_if(audits, [&](const AuditSet& other) { return other.name == audit.name; });
  const auto next = std::find_if(audits.begin(), audits.end(),
                                 [&](const AuditSet& other) { return audit.name < other.name; });
  audits.insert(next, std::move(audit));
  return audits;
}

}  // namespace vrda::store
