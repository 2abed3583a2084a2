// Balance of the compartments of a step: the rule of the spine by search.
#include "solve/sweep.hpp"

#include <cmath>
#include <limits>

namespace vrda::solve {

double imbalance_mm(const StepRecord& record)
{
  const double difference = std::abs(record.gap_medial_mm - record.gap_lateral_mm);
  const bool is_known = record.status == StepStatus::stable && std::isfinite(difference);
  return is_known ? difference : std::numeric_limits<double>::infinity();
}

bool is_better_balanced(const StepRecord& a, const StepRecord& b)
{
  const bool a_touches = a.status == StepStatus::stable && a.contact_medial && a.contact_lateral;
  const bool b_touches = b.status == StepStatus::stable && b.contact_medial && b.contact_lateral;
  if (a_touches != b_touches) return a_touches;
  if (a_touches) return a.pose.translation_mm.y() > b.pose.translation_mm.y();
  return imbalance_mm(a) < imbalance_mm(b);
}

}  // namespace vrda::solve
