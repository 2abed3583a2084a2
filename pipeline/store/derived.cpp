#include "store/derived.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace vrda {
namespace {

double largest_known(const GridD& values)
{
  double largest = std::numeric_limits<double>::quiet_NaN();
  for (Eigen::Index k = 0; k < values.size(); ++k) {
    const double value = values.data()[k];
    if (std::isnan(largest) || value > largest) largest = value;
  }
  return largest;
}

}  // namespace

AuditSummary summary_of(const AuditSet& audit)
{
  return {largest_known(audit.penetration_mm), largest_known(audit.gap_mm)};
}

std::vector<AuditSet> with_audit(std::vector<AuditSet> audits, AuditSet audit)
{
  std::erase_if(audits, [&](const AuditSet& other) { return other.name == audit.name; });
  const auto next = std::find_if(audits.begin(), audits.end(),
                                 [&](const AuditSet& other) { return audit.name < other.name; });
  audits.insert(next, std::move(audit));
  return audits;
}

}  // namespace vrda
