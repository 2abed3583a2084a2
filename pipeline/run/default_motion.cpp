#include "run/default_motion.hpp"

#include <algorithm>
#include <cmath>
#include <set>
#include <utility>

#include "analysis/audit.hpp"
#include "store/curve_figures.hpp"
#include "store/poses.hpp"
#include "analysis/two_sided.hpp"
#include "analysis/smooth.hpp"

namespace vrda::run {
namespace {

analysis::ContactFigures two_sided_figures(const std::optional<store::TwoSided>& motion)
{
  analysis::ContactFigures figures;
  figures.sides.emplace();
  if (!motion) return figures;
  for (std::size_t i = 0; i < motion->contact.size(); ++i) {
    const auto contact = static_cast<store::TwoSidedContact>(motion->contact[i]);
    if (contact == store::TwoSidedContact::no_pose) continue;
    const double medial_mm = motion->gap_medial_mm[i], lateral_mm = motion->gap_lateral_mm[i];
    figures.sides->include(medial_mm, lateral_mm);
    ++figures.n_poses;
    figures.n_lifted_off += contact == store::TwoSidedContact::both ? 0 : 1;
    for (const auto& [gap_mm, lifted] : {std::pair{medial_mm, store::TwoSidedContact::lateral},
                                         std::pair{lateral_mm, store::TwoSidedContact::medial}}) {
      if (contact != lifted) figures.largest_gap_mm = std::max(figures.largest_gap_mm, gap_mm);
      figures.largest_overlap_mm = std::max(figures.largest_overlap_mm, -gap_mm);
    }
  }
  return figures;
}

analysis::ContactFigures recontacted_figures(store::MotionModel model, store::SmoothedSet set, int n_threads)
{
  constexpr int refine = 2;
  if (!set.recontact_mm) set.recontact_mm = analysis::recontact(model, set, n_threads);
  model.smoothed = {set};
  const std::string name = "degree_" + std::to_string(set.degree) + "_recontacted";
  const analysis::MotionAuditTotals totals =
      analysis::motion_audit_totals(model, analysis::audit(model, name, refine, n_threads));
  analysis::ContactFigures figures;
  for (const analysis::AuditTotals& part : {totals.at_grid, totals.between}) {
    figures.n_poses += part.n_attitudes - part.n_nothing_ahead;
    figures.largest_gap_mm = std::fmax(figures.largest_gap_mm, part.largest_gap_mm);
    figures.largest_overlap_mm = std::fmax(figures.largest_overlap_mm, part.largest_penetration_mm);
  }
  return figures;
}

/// The model's set of that polynomial, with its travel into contact, or the set itself.
const store::SmoothedSet& stored_set(const store::MotionModel& model, const store::SmoothedSet& set)
{
  for (const store::SmoothedSet& stored : model.smoothed)
    if (stored.degree == set.degree && stored.is_robust == set.is_robust) return stored;
  return set;
}

analysis::CompareOptions criteria_of(const store::MotionModel& model, bool is_robust, int n_threads)
{
  std::set<int> degrees;
  for (const store::SmoothedSet& set : model.smoothed) degrees.insert(set.degree);
  if (model.two_sided) degrees.insert(model.two_sided->degree);
  analysis::CompareOptions options;
  options.name = model.title;
  options.degrees.assign(degrees.begin(), degrees.end());
  options.smooth.is_robust = is_robust;
  options.contact = [&model, measure = contact_measure(n_threads)](const store::MotionModel& bare,
                                                                   const store::SmoothedSet& set) {
    if (model.two_sided && model.two_sided->degree == set.degree) return two_sided_figures(model.two_sided);
    return measure(bare, stored_set(model, set));
  };
  return options;
}

}  // namespace

analysis::MeasureContact contact_measure(int n_threads)
{
  return [n_threads](const store::MotionModel& model, const store::SmoothedSet& set) {
    if (!model.has_compartments) return recontacted_figures(model, set, n_threads);
    return two_sided_figures(analysis::two_sided(model, {set.degree, set.is_robust}, n_threads));
  };
}

store::DefaultMotion evaluated_default_motion(const store::MotionModel& model, bool is_robust, int n_threads)
{
  const std::string smoothed = store::set_names(model).front();
  if (smoothed == "raw") return {smoothed, ""};
  const int degree = model.two_sided ? model.two_sided->degree : model.smoothed.back().degree;
  const std::string name = model.two_sided ? smoothed + " (degree " + std::to_string(degree) + ")" : smoothed;
  if (analysis::largest_degree(analysis::smooth_input(model, model.title), degree) < degree)
    return {"raw", name + " cannot be compared: the grid has too few solved cells for that degree"};
  const analysis::Comparison comparison = analysis::compare(model, criteria_of(model, is_robust, n_threads));
  const auto ranked =
      std::ranges::find(comparison.recommendation.ranked, degree, &analysis::RankedDegree::degree);
  if (ranked->fault == analysis::Fault::none) return {smoothed, ""};
  return {"raw", name + " does not meet the criteria of vrda compare: " + ranked->fault_reason};
}

std::string default_motion_line(const store::MotionModel& model)
{
  const store::DefaultMotion shown = store::default_motion(model);
  std::string line = "default motion: " + shown.set;
  if (!shown.reason.empty()) return line + ", the solved poses; " + shown.reason;
  if (shown.set != "raw" && !model.default_motion) line += " (not compared: the file has no /default_motion)";
  return line;
}

std::string screw_home_line(const store::MotionModel& model)
{
  if (model.joint != "knee") return "";
  return "screw-home along the spine: internal rotation " +
         store::text_of(store::curve_figures(store::spine_rotation(model)));
}

std::vector<std::string> jump_lines(const store::MotionModel& model)
{
  std::vector<std::string> lines;
  const std::string spine = store::text_of(store::spine_jump(model));
  if (!spine.empty() && !store::has_turned_axes(model)) lines.push_back(spine);
  const analysis::RawJump jump = analysis::raw_jump(model);
  const std::string line = analysis::jump_text(jump);
  const bool is_named = store::default_motion(model).reason.find(line) != std::string::npos;
  if (jump.size > analysis::largest_raw_jump && !is_named) lines.push_back(line);
  return lines;
}

}  // namespace vrda::run
