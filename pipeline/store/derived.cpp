#include "store/derived.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace vrda {
namespace {

double largest_number(const GridD& values)
{
  double largest = std::numeric_limits<double>::quiet_NaN();
  for (Eigen::Index k = 0; k < values.size(); ++k) {
    const double value = values.data()[k];
    if (std::isnan(largest) || value > largest) largest = value;
  }
  return largest;
}

template <typename Entry, typename Key>
std::vector<Entry> with_entry(std::vector<Entry> entries, Entry entry, Key key)
{
  std::erase_if(entries, [&](const Entry& other) { return key(other) == key(entry); });
  entries.push_back(std::move(entry));
  std::sort(entries.begin(), entries.end(), [&](const Entry& a, const Entry& b) { return key(a) < key(b); });
  return entries;
}

}  // namespace

AuditSummary summary_of(const AuditSet& audit)
{
  return {largest_number(audit.penetration_mm), largest_number(audit.gap_mm)};
}

std::vector<SmoothedSet> with_set(std::vector<SmoothedSet> sets, SmoothedSet set)
{
  return with_entry(std::move(sets), std::move(set), [](const SmoothedSet& entry) { return entry.degree; });
}

std::vector<AuditSet> with_audit(std::vector<AuditSet> audits, AuditSet audit)
{
  return with_entry(std::move(audits), std::move(audit),
                    [](const AuditSet& entry) -> const std::string& { return entry.name; });
}

}  // namespace vrda
