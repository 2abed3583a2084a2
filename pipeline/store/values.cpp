#include "store/values.hpp"

#include <algorithm>
#include <cmath>
#include <set>
#include <utility>

#include "core/error.hpp"
#include "model/joint_kind.hpp"
#include "store/evaluate_smoothed.hpp"
#include "store/registry.hpp"
#include "store/row_check.hpp"

namespace vrda::store {
namespace {

/// Tolerance of smoothed values against their polynomial: sums of at most 231 terms of up to 1e3 mm.
constexpr double smoothed_tolerance = 1e-9;

// For sums of squares that may be accumulated in another order.
bool is_near(double a, double b)
{
  return std::abs(a - b) <= exact_tolerance * (1.0 + std::abs(b));
}

/// Rules beyond the rows of the registry: attributes, and relations between datasets.
class ModelRules {
 public:
  ModelRules(const MotionModel& model, ValueFindings& findings)
      : model_(model),
        findings_(findings),
        n_varus_(model.varus_deg.size()),
        n_cells_(model.flexion_deg.size() * model.varus_deg.size())
  {
  }

  void check_root_attributes()
  {
    one_of("/@joint", model_.joint, {joint_kind_names.begin(), joint_kind_names.end()});
    one_of("/@side", model_.side, {"right", "left"});
    one_of("/@method", model_.method, {"stability-search", "equilibrium", "import"});
    findings_.report_not_finite("/@rotation_centre_mm", model_.rotation_centre_mm.data(), 3);
    const double length = model_.delta.norm();
    if (!(std::abs(length - 1.0) <= exact_tolerance)) {
      findings_.add("/@delta", "a vector of length " + text_of(length), "length 1");
    } else if ((model_.push.delta.row(0).transpose() - model_.delta).norm() > exact_tolerance) {
      findings_.add("/@delta", "a different direction", "that of the first row of /push/delta");
    }
    if (!(model_.contact_resolution_mm > 0.0) || !is_number(model_.contact_resolution_mm)) {
      findings_.add("/@contact_resolution_mm", text_of(model_.contact_resolution_mm), "a positive length");
    }
  }

  void run()
  {
    check_cells();
    if (model_.frames) check_frames(*model_.frames);
    if (model_.repair && !model_.frames) findings_.add("/repair", "a repair", "nothing without /frame");
    findings_.report_not_finite("/push@point_mm", model_.push.point_mm.data(), 3);
    if (model_.equilibrium) check_equilibrium(*model_.equilibrium);
    if (model_.ligaments &&
        !(is_number(model_.ligaments->transition_strain) && model_.ligaments->transition_strain > 0.0)) {
      findings_.add("/ligaments@transition_strain", text_of(model_.ligaments->transition_strain),
                    "a strain above 0");
    }
    for (const auto& [group, body] :
         {std::pair("/bodies/reference", &model_.reference), std::pair("/bodies/moving", &model_.moving)}) {
      if (body->contact.mesh.triangles.rows() == 0)
        findings_.add(std::string(group) + "/triangles", "no triangles", "at least one");
    }
    for (const SmoothedSet& set : model_.smoothed) check_smoothed(set);
    if (model_.zero_varus) check_zero_varus(*model_.zero_varus);
    for (const AuditSet& audit : model_.audits) check_audit(audit);
    if (model_.job.scaling) check_scaling(*model_.job.scaling);
    if (model_.default_motion && !is_audit_name(model_.default_motion->set))
      findings_.add("/default_motion@set", "\"" + model_.default_motion->set + "\"",
                    allowed_group_names(AuditSet()));
  }

 private:
  bool is_stable(std::size_t cell) const { return model_.status.data()[cell] == status_stable; }

  void one_of(const std::string& where, const std::string& value, const std::vector<std::string>& allowed)
  {
    if (std::find(allowed.begin(), allowed.end(), value) != allowed.end()) return;
    std::string wanted;
    for (const std::string& word : allowed) wanted += (wanted.empty() ? "\"" : ", \"") + word + "\"";
    findings_.add(where, "\"" + value + "\"", "one of " + wanted);
  }

  void check_cells()
  {
    const std::int8_t* plausibility = model_.plausibility.data();
    findings_.report_each(
        "/plausibility", n_cells_, "-1 where status is not stable",
        [&](std::size_t cell) { return !is_stable(cell) && plausibility[cell] != plausibility_not_judged; },
        [&](std::size_t cell) { return std::to_string(plausibility[cell]); });
    findings_.report_each(
        "/is_spine", model_.flexion_deg.size(), "at most one spine cell per flexion",
        [&](std::size_t i) { return (model_.is_spine.row(static_cast<Eigen::Index>(i)) == 1).count() > 1; },
        [&](std::size_t) { return "several spine cells"; });
    if (n_varus_ == 1) return;
    const double* solved_deg = model_.varus_solved_deg.data();
    findings_.report_numbers("/varus_solved", solved_deg, n_cells_,
                             "the cell's varus where the axis has several", [&](std::size_t cell) {
                               const double wanted_deg = model_.varus_deg[cell % n_varus_];
                               return is_stable(cell) && is_number(wanted_deg) &&
                                      std::abs(solved_deg[cell] - wanted_deg) > exact_tolerance;
                             });
  }

  /// A motion derived over flexion has no meaning where flexion may repeat.
  void check_frames(const FrameSequence& frames)
  {
    if (!is_key_name(frames.key_name)) {
      findings_.add("/frame@key_name", "\"" + frames.key_name + "\"",
                    "a lower-case letter, then at most 39 lower-case letters, digits and underscores");
    }
    if (n_varus_ != 1 || model_.varus_deg[0] != 0.0)
      findings_.add("/varus", "other values", "the single value 0 in a sequence of frames");
    const char* wanted = "nothing in a sequence of frames";
    if (!model_.smoothed.empty()) findings_.add("/smoothed", "a smoothed motion", wanted);
    if (model_.two_sided) findings_.add("/two_sided", "a two-sided motion", wanted);
    if (model_.zero_varus) findings_.add("/zero_varus", "a zero-varus motion", wanted);
    for (const AuditSet& audit : model_.audits)
      if (audit.name != "raw") findings_.add(audit_group(audit.name), "an audit", wanted);
  }

  void check_equilibrium(const EquilibriumSurfaces& equilibrium)
  {
    if (!(equilibrium.band_moment_nmm >= 0.0) || !is_number(equilibrium.band_moment_nmm))
      findings_.add("/equilibrium@band_moment_nmm", text_of(equilibrium.band_moment_nmm), "0 or a moment");
    const std::vector<std::int64_t>& start = equilibrium.forces.row_start;
    const auto n = static_cast<std::int64_t>(equilibrium.forces.along_delta_n.size());
    const bool are_rows_sound =
        std::is_sorted(start.begin(), start.end()) && start.front() == 0 && start.back() == n;
    if (are_rows_sound) check_directions(equilibrium.forces);
    check_branches(equilibrium.spine);
  }

  void check_branches(const FreeSpine& spine)
  {
    const SpineBranches& branches = spine.branches;
    const std::vector<std::int64_t>& start = branches.row_start;
    const auto n = static_cast<std::int64_t>(branches.energy_nmm.size());
    if (!std::is_sorted(start.begin(), start.end()) || start.front() != 0 || start.back() != n) return;
    const auto n_chosen = [&](std::size_t i) {
      return std::count(branches.is_chosen.begin() + start[i], branches.is_chosen.begin() + start[i + 1], 1);
    };
    findings_.report_each(
        "/equilibrium/spine/branches/is_chosen", spine.status.size(),
        "one chosen equilibrium where the spine is stable, else none",
        [&](std::size_t i) { return n_chosen(i) != (spine.status[i] == status_stable ? 1 : 0); },
        [&](std::size_t i) { return std::to_string(n_chosen(i)); });
    findings_.report_each(
        "/equilibrium/spine/branches/row_start", spine.status.size(), "n_optima equilibria",
        [&](std::size_t i) { return start[i + 1] - start[i] != spine.n_optima[i]; },
        [&](std::size_t i) { return std::to_string(start[i + 1] - start[i]) + " equilibria"; });
  }

  /// The force is along_delta * normal / -(normal . Delta): it exists where the normal opposes Delta.
  void check_directions(const ForceRows& forces)
  {
    const std::size_t n_varus = model_.varus_deg.size();
    findings_.report_each(
        "/equilibrium/forces/normal", n_cells_, "normals that oppose Delta",
        [&](std::size_t cell) {
          const Eigen::RowVector3d delta = model_.push.delta.row(static_cast<Eigen::Index>(cell / n_varus));
          for (std::int64_t row = forces.row_start[cell]; row < forces.row_start[cell + 1]; ++row) {
            if (forces.normal_world.row(row).dot(delta) >= 0.0) return true;
          }
          return false;
        },
        [&](std::size_t) { return "a normal that does not oppose Delta"; });
  }

  /// Number of pairs (i, j) with i + j <= degree; an axis with one value has its constant only.
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
      findings_.add(
          group + "/exponents", std::to_string(n_terms) + " terms",
          std::to_string(wanted) + " terms for degree " + std::to_string(set.degree) + " on this grid");
      return false;
    }
    std::set<std::pair<std::int32_t, std::int32_t>> seen;
    const std::size_t before = findings_.size();
    findings_.report_each(
        group + "/exponents", n_terms, "each pair of degrees up to the total degree exactly once",
        [&](std::size_t k) {
          const std::int32_t i = set.exponents(static_cast<Eigen::Index>(k), 0);
          const std::int32_t j = set.exponents(static_cast<Eigen::Index>(k), 1);
          // Compared separately: the sum of two arbitrary values could overflow.
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
    if (set.degree < 0 || set.degree > max_smoothed_degree) {
      findings_.add(group, "degree " + std::to_string(set.degree),
                    "a degree from 0 to " + std::to_string(max_smoothed_degree));
      return;
    }
    if (set.surfaces.size() == 5 && n_varus_ > 1) {
      findings_.add(smoothed_path(set.degree, "varus"), "a surface",
                    "no such surface where /varus has several values");
    }
    if (model_.frames || !has_right_terms(set, group)) return;
    const AxisRanges ranges = axis_ranges(model_.flexion_deg, model_.varus_deg);
    for (const SmoothedSurface& surface : set.surfaces) {
      const double* values = surface.values.data();
      findings_.report_numbers(
          smoothed_path(set.degree, surface.name), values, n_cells_, "the value of the polynomial",
          [&](std::size_t cell) {
            const double wanted = evaluate(set, surface, ranges, model_.flexion_deg[cell / n_varus_],
                                           model_.varus_deg[cell % n_varus_])
                                      .value;
            return !(std::abs(values[cell] - wanted) <= smoothed_tolerance * (1.0 + std::abs(wanted)));
          });
    }
  }

  void check_zero_varus(const ZeroVarus& motion)
  {
    const std::size_t n = motion.source.size();
    const auto is = [&](std::size_t i, ZeroVarusSource source) {
      return motion.source[i] == code_of(source);
    };
    if (!is_audit_name(motion.set) || motion.set == "zero_varus")
      findings_.add("/zero_varus@set", motion.set, "raw, degree_N or degree_N_recontacted");
    findings_.report_each(
        "/zero_varus/source", n, "free only where /varus has one value",
        [&](std::size_t i) { return is(i, ZeroVarusSource::free) && n_varus_ > 1; },
        [](std::size_t) { return "free"; });
    const std::vector<double>&varus = motion.varus_deg, &first = motion.varus_first_deg,
          &last = motion.varus_last_deg;
    findings_.report_numbers("/zero_varus/varus_last", last.data(), n, "at least varus_first",
                             [&](std::size_t i) { return last[i] < first[i]; });
    findings_.report_numbers(
        "/zero_varus/varus", varus.data(), n, "the mean of varus_first and varus_last", [&](std::size_t i) {
          const double mean_deg = 0.5 * (first[i] + last[i]);
          return is(i, ZeroVarusSource::both_touch) && std::abs(varus[i] - mean_deg) > exact_tolerance;
        });
    const auto length = [&](std::size_t i) {
      return Eigen::Map<const Eigen::Vector3d>(&motion.helical_direction[3 * i]).norm();
    };
    findings_.report_each(
        "/zero_varus/helical_direction", motion.helical_direction.size() / 3, "unit vectors",
        [&](std::size_t i) { return is_number(length(i)) && std::abs(length(i) - 1.0) > exact_tolerance; },
        [&](std::size_t i) { return "a vector of length " + text_of(length(i)); });
  }

  void check_audit(const AuditSet& audit)
  {
    const std::string group = audit_group(audit.name);
    if (audit.refine < 1) findings_.add(group + "@refine", std::to_string(audit.refine), "at least 1");
    const double* penetration_mm = audit.penetration_mm.data();
    findings_.report_numbers(group + "/penetration", penetration_mm,
                             static_cast<std::size_t>(audit.penetration_mm.size()),
                             "0 where state is free or nothing_ahead", [&](std::size_t i) {
                               const std::int8_t state = audit.state.data()[i];
                               return state != code_of(AuditState::overlapping) &&
                                      state != code_of(AuditState::no_pose) && penetration_mm[i] > 0.0;
                             });
  }

  void check_scaling(const Scaling& scaling)
  {
    const std::string group = "/job/scaling";
    const std::size_t n = scaling.landmark.size();
    findings_.report_numbers(group + "@factor", scaling.factor.data(), 3, "numbers above 0",
                             [&](std::size_t i) {
                               const double factor = scaling.factor.data()[i];
                               return !is_number(factor) || factor <= 0.0;
                             });
    if ((scaling.keeps_steps || n > 0) && !is_uniform(scaling.factor)) {
      findings_.add(group + "@factor", "unequal numbers",
                    "three equal numbers where steps are kept or landmarks fitted");
    }
    findings_.report_numbers(group + "/residual", scaling.residual_mm.data(), n,
                             "the subject's distance minus the factor times the model's", [&](std::size_t i) {
                               return is_number(scaling.residual_mm[i]) &&
                                      !is_near(
                                          scaling.residual_mm[i],
                                          scaling.subject_mm[i] - scaling.factor.x() * scaling.model_mm[i]);
                             });
    double sum_sq_mm2 = 0.0;
    for (const double residual_mm : scaling.residual_mm) sum_sq_mm2 += residual_mm * residual_mm;
    const double rms_mm = std::sqrt(sum_sq_mm2 / static_cast<double>(n));
    const double found_mm = scaling.residual_rms_mm, error = scaling.standard_error;
    if (n == 0 ? !std::isnan(found_mm) : !is_near(found_mm, rms_mm)) {
      findings_.add(group + "@residual_rms_mm", text_of(found_mm),
                    n == 0 ? "NaN without landmarks" : text_of(rms_mm) + ", the value from the residuals");
    }
    if (n < 2 ? !std::isnan(error) : !(is_number(error) && error >= 0.0)) {
      findings_.add(group + "@standard_error", text_of(error),
                    n < 2 ? "NaN with fewer than two pairs of landmarks" : "a number of at least 0");
    }
  }

  const MotionModel& model_;
  ValueFindings& findings_;
  std::size_t n_varus_;
  std::size_t n_cells_;
};

}  // namespace

std::vector<Finding> check_values(const MotionModel& model)
{
  ValueFindings findings;
  ModelRules rules(model, findings);
  rules.check_root_attributes();
  visit_motion_model(model, RowCheck(findings));
  rules.run();
  return findings.take();
}

void require_no_findings(const std::vector<Finding>& findings, const std::string& file)
{
  if (findings.empty()) return;
  throw InputError({file, findings[0].where, findings[0].found, findings[0].wanted});
}

}  // namespace vrda::store
