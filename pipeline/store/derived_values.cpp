#include "store/derived_values.hpp"

#include <algorithm>
#include <cmath>
#include <set>
#include <utility>

#include "store/derived_layout.hpp"
#include "store/evaluate_smoothed.hpp"
#include "store/zero_varus_values.hpp"

namespace vrda {
namespace {

/// Smoothed values against their polynomial: sums of at most 231 terms of up to 1e3 mm.
constexpr double smoothed_tolerance = 1e-9;

class SmoothedCheck {
 public:
  SmoothedCheck(const MotionModel& model, ValueFindings& findings)
      : model_(model),
        findings_(findings),
        n_varus_(model.varus_deg.size()),
        n_cells_(model.flexion_deg.size() * model.varus_deg.size())
  {
  }

  void run()
  {
    for (const SmoothedSet& set : model_.smoothed) check_smoothed(set);
  }

 private:
  /// Every pair (i, j) with i + j <= degree, of an axis with one value its constant only.
  std::size_t wanted_terms(std::int32_t degree) const
  {
    const bool has_flexion = model_.flexion_deg.size() > 1, has_varus = model_.varus_deg.size() > 1;
    const std::size_t n = static_cast<std::size_t>(degree);
    if (has_flexion && has_varus) return (n + 1) * (n + 2) / 2;
    return has_flexion || has_varus ? n + 1 : 1;
  }

  bool has_right_terms(const SmoothedSet& set, const std::string& group)
  {
    const std::size_t n_terms = static_cast<std::size_t>(set.exponents.rows());
    const std::size_t wanted = wanted_terms(set.degree);
    if (n_terms != wanted) {
      findings_.find(
          group + "/exponents", std::to_string(n_terms) + " terms",
          std::to_string(wanted) + " terms for degree " + std::to_string(set.degree) + " on this grid");
      return false;
    }
    std::set<std::pair<std::int32_t, std::int32_t>> seen;
    const std::size_t before = findings_.size();
    findings_.each(
        group + "/exponents", n_terms, "each pair of degrees up to the total degree once",
        [&](std::size_t k) {
          const std::int32_t i = set.exponents(static_cast<Eigen::Index>(k), 0);
          const std::int32_t j = set.exponents(static_cast<Eigen::Index>(k), 1);
          // Compared one by one: the sum of two wild values would overflow.
          return i < 0 || j < 0 || i > set.degree || j > set.degree - i ||
                 (i > 0 && model_.flexion_deg.size() == 1) || (j > 0 && model_.varus_deg.size() == 1) ||
                 !seen.insert({i, j}).second;
        },
        [&](std::size_t k) {
          return std::to_string(set.exponents(static_cast<Eigen::Index>(k), 0)) + ", " +
                 std::to_string(set.exponents(static_cast<Eigen::Index>(k), 1));
        });
    return findings_.size() == before;
  }

  void check_smoothed(const SmoothedSet& set)
  {
    const std::string group = smoothed_group(set.degree);
    if (set.degree < 0 || set.degree > largest_smoothed_degree) {
      findings_.find(group, "degree " + std::to_string(set.degree),
                     "a degree from 0 to " + std::to_string(largest_smoothed_degree));
      return;
    }
    if (set.recontact_mm) {
      findings_.each_number(
          group + "/recontact", set.recontact_mm->data(), n_cells_, "a number or NaN",
          [&](std::size_t cell) { return !is_number_or_nan(set.recontact_mm->data()[cell]); });
    }
    if (set.surfaces.size() == 5 && n_varus_ > 1) {
      findings_.find(smoothed_path(set.degree, "varus"), "a surface", "none where /varus has several values");
    }
    if (!has_right_terms(set, group)) return;
    const AxisRanges ranges = axis_ranges(model_.flexion_deg, model_.varus_deg);
    for (const SmoothedSurface& surface : set.surfaces) {
      findings_.all_finite(coefficients_path(set.degree, surface.name), surface.coefficients.data(),
                           surface.coefficients.size());
      const double* values = surface.values.data();
      findings_.each_number(
          smoothed_path(set.degree, surface.name), values, n_cells_, "the value of the polynomial",
          [&](std::size_t cell) {
            const double wanted = evaluate(set, surface, ranges, model_.flexion_deg[cell / n_varus_],
                                           model_.varus_deg[cell % n_varus_])
                                      .value;
            return !(std::abs(values[cell] - wanted) <= smoothed_tolerance * (1.0 + std::abs(wanted)));
          });
    }
  }

  const MotionModel& model_;
  ValueFindings& findings_;
  std::size_t n_varus_;
  std::size_t n_cells_;
};

void check_audit(const AuditSet& audit, ValueFindings& findings)
{
  const std::string group = audit_group(audit.name);
  const std::size_t n = static_cast<std::size_t>(audit.state.size());
  const std::int8_t* state = audit.state.data();
  const auto is = [&](std::size_t i, AuditState wanted) {
    return state[i] == static_cast<std::int8_t>(wanted);
  };
  if (audit.refine < 1) findings.find(group + "@refine", std::to_string(audit.refine), "at least 1");
  findings.axis(group + "/flexion", audit.flexion_deg);
  findings.axis(group + "/varus", audit.varus_deg);
  findings.codes(group + "/state", state, n, flag_table(FlagSet::audit_state).values);
  const double *gap_mm = audit.gap_mm.data(), *penetration_mm = audit.penetration_mm.data();
  findings.each_number(group + "/gap", gap_mm, n, "a length of at least 0 where state is free, NaN elsewhere",
                       [&](std::size_t i) {
                         if (!is(i, AuditState::free)) return !std::isnan(gap_mm[i]);
                         return !is_number(gap_mm[i]) || gap_mm[i] < 0.0;
                       });
  findings.each_number(group + "/penetration", penetration_mm, n,
                       "a length of at least 0 where state is overlapping, NaN without a pose, 0 elsewhere",
                       [&](std::size_t i) {
                         if (is(i, AuditState::no_pose)) return !std::isnan(penetration_mm[i]);
                         if (!is(i, AuditState::overlapping)) return penetration_mm[i] != 0.0;
                         return !is_number(penetration_mm[i]) || penetration_mm[i] < 0.0;
                       });
}

}  // namespace

void check_derived(const MotionModel& model, ValueFindings& findings)
{
  SmoothedCheck(model, findings).run();
  if (model.zero_varus) check_zero_varus(*model.zero_varus, model, findings);
  for (const AuditSet& audit : model.audits) check_audit(audit, findings);
}

}  // namespace vrda
