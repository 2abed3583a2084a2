#include "store/verdict.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <functional>
#include <set>
#include <utility>

#include "core/text.hpp"
#include "model/coordinates.hpp"
#include "store/motion.hpp"
#include "store/solved_cells.hpp"

namespace vrda::store {
namespace {

// Published values, with their sources in schemas/verdict.md.

enum class Quantity {
  rotation,
  drop,
  early_share,
  change,
  middle,
  medial_facet,
  lateral_facet,
  medial_contact,
  lateral_contact,
  patellar_flexion,
  patellar_shift
};
enum class Spread { published, assumed };

struct Published {
  Quantity quantity;
  double flexion_deg;      ///< NaN: of the whole motion
  double mean, low, high;  ///< degrees, mm or %; NaN: not bounded there
  Spread spread;
  const char* source;
};

constexpr const char* walker = "Walker 1988, passive cadaver knees";
constexpr const char* derived = "Walker 1988, 22 mm from the middle";
constexpr const char* chen = "Chen 2014, in vivo, active";
constexpr const char* limit = "mean curve of Walker 1988";
constexpr const char* judged = "judgement after Johal 2005, Freeman 2005";
constexpr const char* review = "review of Yu 2019: 30 to 40 % behind";
constexpr const char* eisenhart = "von Eisenhart-Rothe 2004, in vivo, from 30 degrees";

/// By quantity, then flexion. Ranges are two standard deviations. Assumed ones: 5 degrees; 2.5 mm of the
/// middle, 3 and 4 mm of the facet centres, half of each at 15 degrees, where knees have moved less.
constexpr Published published_values[] = {
    {Quantity::rotation, 15, 4.9, -0.1, 9.9, Spread::assumed, walker},
    {Quantity::rotation, 30, 8.6, -1.4, 18.6, Spread::assumed, walker},
    {Quantity::rotation, 40, 11.55, 5.15, 17.95, Spread::published, chen},
    {Quantity::rotation, 45, 11.3, 1.3, 21.3, Spread::assumed, walker},
    {Quantity::rotation, 60, 13.2, 3.2, 23.2, Spread::assumed, walker},
    {Quantity::rotation, 75, 14.3, 4.3, 24.3, Spread::assumed, walker},
    {Quantity::rotation, 90, 14.9, 4.9, 24.9, Spread::assumed, walker},
    {Quantity::drop, nan, 0, nan, 3, Spread::assumed, limit},
    {Quantity::early_share, nan, 58, 55, nan, Spread::assumed, limit},
    {Quantity::change, nan, 1.8, nan, 3, Spread::assumed, limit},
    {Quantity::middle, 15, -1.8, -4.3, 0.7, Spread::assumed, walker},
    {Quantity::middle, 30, -3.4, -8.4, 1.6, Spread::assumed, walker},
    {Quantity::middle, 45, -4.8, -9.8, 0.2, Spread::assumed, walker},
    {Quantity::middle, 60, -6.0, -11.0, -1.0, Spread::assumed, walker},
    {Quantity::middle, 75, -6.9, -11.9, -1.9, Spread::assumed, walker},
    {Quantity::middle, 90, -7.7, -12.7, -2.7, Spread::assumed, walker},
    {Quantity::medial_facet, 15, 0.1, -2.9, 3.1, Spread::assumed, derived},
    {Quantity::medial_facet, 30, -0.1, -6.1, 5.9, Spread::assumed, derived},
    {Quantity::medial_facet, 45, -0.5, -6.5, 5.5, Spread::assumed, derived},
    {Quantity::medial_facet, 60, -1.0, -7.0, 5.0, Spread::assumed, derived},
    {Quantity::medial_facet, 75, -1.5, -7.5, 4.5, Spread::assumed, derived},
    {Quantity::medial_facet, 90, -2.0, -8.0, 4.0, Spread::assumed, derived},
    {Quantity::lateral_facet, 15, -3.7, -7.7, 0.3, Spread::assumed, derived},
    {Quantity::lateral_facet, 30, -6.7, -14.7, 1.3, Spread::assumed, derived},
    {Quantity::lateral_facet, 45, -9.1, -17.1, -1.1, Spread::assumed, derived},
    {Quantity::lateral_facet, 60, -11.0, -19.0, -3.0, Spread::assumed, derived},
    {Quantity::lateral_facet, 75, -12.4, -20.4, -4.4, Spread::assumed, derived},
    {Quantity::lateral_facet, 90, -13.3, -21.3, -5.3, Spread::assumed, derived},
    {Quantity::medial_contact, 90, -8, -14, -3, Spread::assumed, judged},
    {Quantity::lateral_contact, 90, -12, -20, -6, Spread::assumed, judged},
    {Quantity::patellar_flexion, nan, 65, 45, 85, Spread::assumed, review},
    {Quantity::patellar_shift, 90, 1.8, -4.2, 7.8, Spread::assumed, eisenhart},
};

/// A published value farther away than this is not compared: the table's flexions are 15 degrees apart.
constexpr double farthest_published_deg = 10.0;

/// Null if nothing is near enough; of two equally near ones that of less flexion.
const Published* published_near(Quantity quantity, double flexion_deg)
{
  const Published* nearest = nullptr;
  double least_deg = farthest_published_deg;
  for (const Published& row : published_values) {
    const double away_deg = std::isnan(row.flexion_deg) ? 0.0 : std::abs(row.flexion_deg - flexion_deg);
    const bool is_nearer = nearest == nullptr ? away_deg <= least_deg : away_deg < least_deg;
    if (row.quantity != quantity || !is_nearer) continue;
    nearest = &row;
    least_deg = away_deg;
  }
  return nearest;
}

Standing standing_of(double value, double low, double high)
{
  // Comparisons with NaN, an open end, are false.
  return value < low ? Standing::below : value > high ? Standing::above : Standing::within;
}

// The motion as curves over flexion.

constexpr double start_deg = 0.0, end_deg = 90.0, early_deg = 30.0;
constexpr double farthest_start_deg = 5.0;
constexpr double facet_distance_mm = 22.0;  // half the distance between the centres of both flexion facets
constexpr double same_flexion_deg = 1e-6;   // rounding of poses
/// A share of a smaller peak means nothing.
constexpr double least_peak_deg = 1.0;

double value_at(const FlexionCurve& curve, double flexion_deg)
{
  return value_at(curve, flexion_deg, same_flexion_deg);
}

struct Facets {
  double medial_mm, middle_mm, lateral_mm;  ///< anterior positions
};

struct MotionCurves {
  std::vector<double> flexion_deg;  ///< the joint's own; of the set's axis where there is no pose
  std::vector<double> internal_deg, medial_mm, middle_mm, lateral_mm;

  bool is_ascending() const
  {
    return std::ranges::adjacent_find(flexion_deg, std::greater_equal<>()) == flexion_deg.end();
  }
};

/// Points fixed in the femur, in the tibia's frame.
Facets facets_of(const MotionModel& model, const Pose& X_reference_moving)
{
  const double lateral = side_named(model.side) == Side::right ? 1.0 : -1.0;
  const auto anterior_mm = [&](double lateral_mm) {
    const Eigen::Vector3d p_mm = model.rotation_centre_mm + lateral * lateral_mm * Eigen::Vector3d::UnitZ();
    return X_reference_moving.linear().col(0).dot(p_mm - X_reference_moving.translation());
  };
  return {anterior_mm(-facet_distance_mm), anterior_mm(0.0), anterior_mm(facet_distance_mm)};
}

MotionCurves curves_of(const MotionModel& model, const std::string& set)
{
  MotionCurves curves;
  curves.flexion_deg = set == "two_sided" ? model.two_sided->flexion_deg : model.flexion_deg;
  const bool is_turned = has_turned_axes(model);
  ContinuousCoordinates along(side_named(model.side), model.rotation_centre_mm);
  const std::vector<std::optional<Pose>> poses = poses_over_flexion(model, set, curves.flexion_deg);
  for (std::size_t i = 0; i < poses.size(); ++i) {
    Facets facets{nan, nan, nan};
    double internal_deg = nan;
    if (poses[i]) {
      const ClinicalCoordinates c = along.next(*poses[i]);
      if (is_turned) curves.flexion_deg[i] = deg_from_rad(c.flexion_rad);
      internal_deg = deg_from_rad(c.internal_rotation_rad);
      facets = facets_of(model, *poses[i]);
    }
    curves.internal_deg.push_back(internal_deg);
    curves.medial_mm.push_back(facets.medial_mm);
    curves.middle_mm.push_back(facets.middle_mm);
    curves.lateral_mm.push_back(facets.lateral_mm);
  }
  return curves;
}

/// Part of a motion that is measured; NaN where it does not begin or end.
struct Extent {
  double from_deg = nan, to_deg = nan;
};

/// From flexion 0, or the first one up to 5 degrees, to 90, or the last one below.
Extent extent_of(const FlexionCurve& curve)
{
  Extent extent;
  if (std::isfinite(value_at(curve, start_deg))) extent.from_deg = start_deg;
  if (std::isfinite(value_at(curve, end_deg))) extent.to_deg = end_deg;
  for (std::size_t i = 0; i < curve.value.size(); ++i) {
    const double flexion_deg = curve.flexion_deg[i];
    if (std::isnan(curve.value[i]) || flexion_deg < start_deg || flexion_deg > end_deg) continue;
    if (std::isnan(extent.from_deg) && flexion_deg <= farthest_start_deg) extent.from_deg = flexion_deg;
    if (extent.to_deg != end_deg) extent.to_deg = flexion_deg;
  }
  return extent;
}

/// The poses within the extent and its ends, with values less the first one.
FlexionCurve rotation_within(const FlexionCurve& curve, const Extent& extent)
{
  const double first_deg = value_at(curve, extent.from_deg);
  FlexionCurve part;
  const auto add = [&](double flexion_deg, double value_deg) {
    part.add(flexion_deg, value_deg - first_deg);
  };
  add(extent.from_deg, first_deg);
  for (std::size_t i = 0; i < curve.value.size(); ++i) {
    const bool is_inside = curve.flexion_deg[i] > extent.from_deg + same_flexion_deg &&
                           curve.flexion_deg[i] < extent.to_deg - same_flexion_deg;
    if (is_inside && std::isfinite(curve.value[i])) add(curve.flexion_deg[i], curve.value[i]);
  }
  add(extent.to_deg, value_at(curve, extent.to_deg));
  return part;
}

// The measures.

struct Found {
  double value = nan, flexion_deg = nan;
};

struct MeasureName {
  const char *name, *label, *unit;
};

/// `at_deg`: the flexion at which the published value is looked up.
VerdictMeasure compared(const MeasureName& name, const Found& found, Quantity quantity, double at_deg)
{
  VerdictMeasure measure{name.name, name.label, name.unit};
  measure.value = found.value;
  measure.flexion_deg = found.flexion_deg;
  const Published* published = published_near(quantity, at_deg);
  if (published == nullptr) return measure;
  measure.published_mean = published->mean;
  measure.low = published->low;
  measure.high = published->high;
  measure.published_flexion_deg = published->flexion_deg;
  measure.is_spread_assumed = published->spread == Spread::assumed;
  measure.source = published->source;
  if (std::isfinite(found.value)) measure.standing = standing_of(found.value, measure.low, measure.high);
  return measure;
}

/// Largest value; the first of equals.
Found peak_of(const FlexionCurve& rotation)
{
  const auto peak = std::ranges::max_element(rotation.value);
  return {*peak, rotation.flexion_deg[static_cast<std::size_t>(peak - rotation.value.begin())]};
}

/// The peak less the smallest value from there on.
Found drop_of(const FlexionCurve& rotation, const Found& peak)
{
  Found drop{0.0, peak.flexion_deg};
  for (std::size_t i = 0; i < rotation.value.size(); ++i) {
    const double dropped_deg = peak.value - rotation.value[i];
    if (rotation.flexion_deg[i] > peak.flexion_deg && dropped_deg > drop.value)
      drop = {dropped_deg, rotation.flexion_deg[i]};
  }
  return drop;
}

/// Largest rotation up to 30 degrees of flexion in percent of the peak.
double early_share_percent(const FlexionCurve& rotation, const Found& peak)
{
  if (peak.value < least_peak_deg) return nan;
  double reached_deg = value_at(rotation, early_deg);
  for (std::size_t i = 0; i < rotation.value.size() && rotation.flexion_deg[i] <= early_deg; ++i)
    reached_deg = std::max(reached_deg, rotation.value[i]);
  return 100.0 * reached_deg / peak.value;
}

void add_rotation(Verdict& verdict, const FlexionCurve& rotation)
{
  const double to_deg = verdict.to_flexion_deg;
  const Found peak = peak_of(rotation);
  const CurveFigures figures = curve_figures(rotation);
  const Found net{rotation.value.back(), to_deg};
  const Found change{std::abs(figures.change_deg), figures.change_from_deg};
  verdict.measures.push_back(compared({"net_internal_rotation", "net internal rotation", "degrees"}, net,
                                      Quantity::rotation, to_deg));
  verdict.measures.push_back(compared({"peak_internal_rotation", "peak internal rotation", "degrees"}, peak,
                                      Quantity::rotation, peak.flexion_deg));
  verdict.measures.push_back(compared({"drop_after_peak", "drop after the peak", "degrees"},
                                      drop_of(rotation, peak), Quantity::drop, end_deg));
  verdict.measures.push_back(compared({"share_by_30", "share of the peak reached by 30 degrees", "%"},
                                      {early_share_percent(rotation, peak), nan}, Quantity::early_share,
                                      end_deg));
  verdict.measures.push_back(compared({"largest_change_per_5", "largest change per 5 degrees", "degrees"},
                                      change, Quantity::change, end_deg));
}

void add_travel(Verdict& verdict, const MeasureName& name, const FlexionCurve& curve, Quantity quantity)
{
  const double to_deg = verdict.to_flexion_deg;
  const double travel_mm = value_at(curve, to_deg) - value_at(curve, verdict.from_flexion_deg);
  verdict.measures.push_back(compared(name, {travel_mm, to_deg}, quantity, to_deg));
}

void add_facets(Verdict& verdict, const MotionCurves& curves)
{
  const std::vector<double>& at = curves.flexion_deg;
  add_travel(verdict, {"middle_travel", "travel of the middle between the condyles", "mm"},
             {at, curves.middle_mm}, Quantity::middle);
  add_travel(verdict, {"medial_facet_travel", "travel of the medial facet centre", "mm"},
             {at, curves.medial_mm}, Quantity::medial_facet);
  add_travel(verdict, {"lateral_facet_travel", "travel of the lateral facet centre", "mm"},
             {at, curves.lateral_mm}, Quantity::lateral_facet);
}

/// The motion that has contact paths, or is smoothed from them; empty of a sample.
std::string contact_set(const MotionModel& model, const std::string& set)
{
  if (!model.contact_paths || set.starts_with("quantile_") || set == bones_alone_name) return "";
  return set == "zero_varus" && !model.zero_varus->centres[0].moving_mm.empty() ? set : "raw";
}

/// Anterior positions of a centre of contact on the tibia, of rows [n, 3]; `cells` are the rows, -1: no pose.
FlexionCurve contact_curve(const std::vector<double>& flexion_deg, const std::vector<double>& points_mm,
                           const std::vector<Eigen::Index>& cells)
{
  FlexionCurve curve{flexion_deg, {}};
  for (const Eigen::Index cell : cells)
    curve.value.push_back(cell < 0 ? nan : points_mm[3 * static_cast<std::size_t>(cell)]);
  return curve;
}

void add_contacts(Verdict& verdict, const MotionModel& model)
{
  verdict.contacts_of = contact_set(model, verdict.set);
  OfCompartments<FlexionCurve> travelled;
  if (!verdict.contacts_of.empty()) {
    const std::vector<double> flexion_deg = curves_of(model, verdict.contacts_of).flexion_deg;
    const bool is_raw = verdict.contacts_of == "raw";
    std::vector<Eigen::Index> cells = solved_spine(model);
    for (std::size_t i = 0; !is_raw && i < cells.size(); ++i) cells[i] = static_cast<Eigen::Index>(i);
    const ContactPaths& paths = is_raw ? *model.contact_paths : model.zero_varus->centres;
    for (const Compartment side : all_compartments)
      travelled[side] = contact_curve(flexion_deg, paths[side].moving_mm, cells);
  }
  add_travel(verdict, {"medial_contact_travel", "travel of the medial contact", "mm"}, travelled[0],
             Quantity::medial_contact);
  add_travel(verdict, {"lateral_contact_travel", "travel of the lateral contact", "mm"}, travelled[1],
             Quantity::lateral_contact);
}

// Runs of flexions, and what is found along them.

template <typename IsFound>
void add_runs(FlexionRuns& runs, const std::vector<double>& flexion_deg, const IsFound& is_found)
{
  bool is_run = false;
  for (std::size_t i = 0; i < flexion_deg.size(); ++i) {
    const bool was_run = std::exchange(is_run, is_found(i));
    if (!is_run) continue;
    runs.flexion_deg.push_back(flexion_deg[i]);
    if (was_run) {
      runs.to_deg.back() = flexion_deg[i];
    } else {
      runs.from_deg.push_back(flexion_deg[i]);
      runs.to_deg.push_back(flexion_deg[i]);
    }
  }
}

/// Sets with poses of the followers that the solver found, or that are smoothed from them.
bool has_solved_followers(const std::string& set)
{
  return !set.starts_with("quantile_") && set != bones_alone_name;
}

/// At a cell: the status of no stable pose, or the objection to it; empty: no finding.
std::string finding_of(const FollowerRows& rows, Eigen::Index cell)
{
  const auto status = static_cast<StepStatus>(rows.status.data()[cell]);
  if (status != StepStatus::stable) return name_of(status);
  if (rows.plausibility.size() == 0) return "";
  const auto plausibility = static_cast<Plausibility>(rows.plausibility.data()[cell]);
  return plausibility > Plausibility::nothing_found ? name_of(plausibility) : "";
}

std::vector<FollowerFinding> follower_findings(const MotionModel& model, const std::string& set)
{
  std::vector<FollowerFinding> all;
  if (!has_solved_followers(set)) return all;
  const std::vector<Eigen::Index> spine = solved_spine(model);
  for (const FollowerRows& rows : model.followers) {
    std::vector<std::string> found;
    for (const Eigen::Index cell : spine) found.push_back(cell < 0 ? "" : finding_of(rows, cell));
    for (const std::string& finding : std::set<std::string>(found.begin(), found.end())) {
      if (finding.empty()) continue;
      FollowerFinding& one = all.emplace_back();
      one.follower = rows.name;
      one.finding = finding;
      add_runs(one, model.flexion_deg, [&](std::size_t i) { return found[i] == finding; });
    }
  }
  return all;
}

/// Flexion of the kneecap in percent of that of the knee, and its lateral shift beyond 30 degrees.
void add_patella(Verdict& verdict, const MotionModel& model)
{
  const auto patella = std::ranges::find(model.followers, "patella", &FollowerRows::name);
  if (patella == model.followers.end() || !has_solved_followers(verdict.set)) return;
  const double to_deg = verdict.to_flexion_deg;
  const std::vector<Eigen::Index> spine = solved_spine(model);
  const std::vector<double> flexion_deg = curves_of(model, "raw").flexion_deg;
  const auto change_from = [&](double from_deg, const GridD& coordinate) {
    FlexionCurve curve{flexion_deg, {}};
    for (const Eigen::Index cell : spine) curve.value.push_back(cell < 0 ? nan : coordinate.data()[cell]);
    return value_at(curve, to_deg) - value_at(curve, from_deg);
  };
  const double from_deg = verdict.from_flexion_deg;
  const double share =
      100.0 * change_from(from_deg, patella->coordinates[JointCoordinate::flexion]) / (to_deg - from_deg);
  verdict.measures.push_back(compared({"patellar_flexion_share", "patellar flexion, of the knee's", "%"},
                                      {share, nan}, Quantity::patellar_flexion, end_deg));
  verdict.measures.push_back(
      compared({"patellar_shift", "lateral patellar shift from 30 degrees", "mm"},
               {change_from(early_deg, patella->coordinates[JointCoordinate::lateral]), to_deg},
               Quantity::patellar_shift, to_deg));
}

// Lift-off.

/// Gaps of both compartments at the flexions that have a pose; NaN where nothing faces.
struct SideGaps {
  std::vector<double> flexion_deg;
  OfCompartments<std::vector<double>> gap_mm;

  void add(double flexion, double medial, double lateral)
  {
    flexion_deg.push_back(flexion);
    gap_mm[0].push_back(medial);
    gap_mm[1].push_back(lateral);
  }
};

SideGaps raw_gaps(const MotionModel& model)
{
  SideGaps gaps;
  const std::vector<Eigen::Index> spine = solved_spine(model);
  for (std::size_t i = 0; i < spine.size(); ++i)
    if (spine[i] >= 0)
      gaps.add(model.flexion_deg[i], model.gap_mm[0].data()[spine[i]], model.gap_mm[1].data()[spine[i]]);
  return gaps;
}

SideGaps two_sided_gaps(const TwoSided& motion)
{
  SideGaps gaps;
  for (std::size_t i = 0; i < motion.contact.size(); ++i)
    if (motion.contact[i] != code_of(TwoSidedContact::no_pose))
      gaps.add(motion.flexion_deg[i], motion.gap_mm[0][i], motion.gap_mm[1][i]);
  return gaps;
}

/// Those of an audit over flexion alone; empty without one.
std::optional<SideGaps> audited_gaps(const MotionModel& model, const std::string& set)
{
  const auto audit = std::ranges::find(model.audits, set, &AuditSet::name);
  if (audit == model.audits.end() || audit->varus_deg.size() != 1) return std::nullopt;
  SideGaps gaps;
  for (std::size_t i = 0; i < audit->flexion_deg.size(); ++i) {
    const auto row = static_cast<Eigen::Index>(i);
    if (audit->state(row, 0) != code_of(AuditState::no_pose))
      gaps.add(audit->flexion_deg[i], audit->compartment_gap_mm[0](row, 0),
               audit->compartment_gap_mm[1](row, 0));
  }
  return gaps;
}

std::optional<std::vector<LiftOff>> lift_off_of(const MotionModel& model, const std::string& set)
{
  if (!model.has_compartments) return std::nullopt;
  const std::optional<SideGaps> gaps = set == "raw"         ? raw_gaps(model)
                                       : set == "two_sided" ? two_sided_gaps(*model.two_sided)
                                                            : audited_gaps(model, set);
  if (!gaps) return std::nullopt;
  std::vector<LiftOff> both;
  for (const auto& [side, name, meaning] : compartment_names) {
    LiftOff& lift_off = both.emplace_back();
    lift_off.compartment = name;
    const std::vector<double>& gap_mm = gaps->gap_mm[side];
    add_runs(lift_off, gaps->flexion_deg, [&](std::size_t i) { return !(gap_mm[i] <= perceptible_mm); });
  }
  return both;
}

/// The part of the motion that a prior decided.
double prior_share_of(const MotionModel& model, const std::string& set)
{
  return model.prior && set != bones_alone_name ? rotation_share_of(*model.prior) : nan;
}

// Texts.

/// To a tenth, without negative zero.
std::string tenths(double value)
{
  return std::isnan(value) ? "-" : rounded_text(std::round(10.0 * value) / 10.0 + 0.0, 4);
}

std::string range_text(const VerdictMeasure& m)
{
  std::string text = std::isnan(m.low)    ? "at most " + tenths(m.high)
                     : std::isnan(m.high) ? "at least " + tenths(m.low)
                                          : tenths(m.low) + " to " + tenths(m.high);
  return text + (m.is_spread_assumed ? ", spread assumed" : "");
}

std::string line_of(const VerdictMeasure& m)
{
  std::string line = printed("  %-42s %6s %s", m.label.c_str(), tenths(m.value).c_str(), m.unit.c_str());
  if (std::isfinite(m.value) && std::isfinite(m.flexion_deg)) line += " at " + tenths(m.flexion_deg);
  if (std::isnan(m.published_mean)) return line + "; nothing published near that flexion";
  line += "; published " + tenths(m.published_mean) + " (" + range_text(m) + ")";
  if (std::isfinite(m.published_flexion_deg)) line += " at " + tenths(m.published_flexion_deg);
  return m.standing == Standing::not_compared ? line : line + ": " + name_of(m.standing);
}

/// "at flexion 5 to 10, 20".
std::string runs_text(const FlexionRuns& runs)
{
  std::vector<std::string> flexions;
  for (std::size_t k = 0; k < runs.from_deg.size(); ++k)
    flexions.push_back(runs.from_deg[k] == runs.to_deg[k]
                           ? tenths(runs.from_deg[k])
                           : tenths(runs.from_deg[k]) + " to " + tenths(runs.to_deg[k]));
  return " at flexion " + joined(flexions);
}

std::string line_of(const std::vector<LiftOff>& both)
{
  std::vector<std::string> sides;
  for (const LiftOff& side : both)
    if (!side.flexion_deg.empty()) sides.push_back(side.compartment + runs_text(side));
  return "  lift-off (gap above " + rounded_text(perceptible_mm) +
         " mm): " + (sides.empty() ? "at no flexion" : joined(sides, "; "));
}

std::string extent_text(const Verdict& verdict)
{
  return "From " + tenths(verdict.from_flexion_deg) + " to " + tenths(verdict.to_flexion_deg) +
         " degrees of flexion" + (verdict.to_flexion_deg < end_deg ? " (the last below 90)" : "");
}

}  // namespace

std::string sentence_of(const Verdict& verdict)
{
  std::vector<std::string> outside;
  bool is_assumed = false;
  for (const VerdictMeasure& measure : verdict.measures) {
    if (measure.standing == Standing::not_compared) continue;
    is_assumed = is_assumed || measure.is_spread_assumed;
    if (measure.standing != Standing::within) outside.push_back(measure.label);
  }
  std::string text = extent_text(verdict) + " the motion is " + (outside.empty() ? "within" : "outside") +
                     " the published range" + (is_assumed ? " (spread assumed)" : "") +
                     (outside.empty() ? "" : " in " + joined(outside));
  if (std::isfinite(verdict.prior_share))
    text += "; decided by the prior to " + rounded_text(std::round(100.0 * verdict.prior_share)) + " %";
  for (const FollowerFinding& found : verdict.followers)
    text += "; " + found.follower + ": " + found.finding + " at " + std::to_string(found.flexion_deg.size()) +
            (found.flexion_deg.size() == 1 ? " flexion" : " flexions");
  return text + ".";
}

std::optional<Verdict> verdict_of(const MotionModel& model, const std::string& set)
{
  if (model.joint != "knee") return std::nullopt;
  Verdict verdict;
  verdict.set = set;
  if (model.frames) {
    verdict.sentence = "No verdict: a sequence of frames is not a motion over flexion.";
    return verdict;
  }
  const MotionCurves curves = curves_of(model, set);
  const FlexionCurve rotation{curves.flexion_deg, curves.internal_deg};
  const Extent extent = curves.is_ascending() ? extent_of(rotation) : Extent{};
  if (!(extent.from_deg <= farthest_start_deg && extent.to_deg > early_deg)) {
    verdict.sentence = "No verdict: the motion needs poses from flexion 0 (at most " +
                       tenths(farthest_start_deg) + ") to more than " + tenths(early_deg) + " degrees.";
    return verdict;
  }
  verdict.from_flexion_deg = extent.from_deg;
  verdict.to_flexion_deg = extent.to_deg;
  add_rotation(verdict, rotation_within(rotation, extent));
  add_facets(verdict, curves);
  add_contacts(verdict, model);
  add_patella(verdict, model);
  verdict.followers = follower_findings(model, set);
  verdict.lift_off = lift_off_of(model, set);
  verdict.prior_share = prior_share_of(model, set);
  verdict.sentence = sentence_of(verdict);
  return verdict;
}

namespace {

/// Net internal rotation of a set from 0 to 90 degrees of flexion, or as far as it goes.
double net_rotation_deg(const MotionModel& model, const std::string& set)
{
  const std::optional<Verdict> verdict = verdict_of(model, set);
  return verdict && !verdict->measures.empty() ? verdict->measures.front().value : nan;
}

/// " (90 % band 6.1 to 15)": of the net rotation of the samples that are solved at both ends.
std::string band_text(const MotionModel& model)
{
  if (!model.uncertainty) return "";
  const UncertainMotion& samples = *model.uncertainty;
  const std::size_t n = model.flexion_deg.size();
  std::vector<double> net_deg;
  for (std::size_t s = 0; s < samples.n_samples(); ++s) {
    constexpr std::size_t internal = 2;
    const double net =
        samples.rotation_deg[3 * (s * n + n - 1) + internal] - samples.rotation_deg[3 * s * n + internal];
    if (std::isfinite(net)) net_deg.push_back(net);
  }
  if (net_deg.size() < 2) return "";
  std::ranges::sort(net_deg);
  const auto quantile = [&](double probability) {
    const double at = probability * static_cast<double>(net_deg.size() - 1);
    const auto below = std::min(static_cast<std::size_t>(at), net_deg.size() - 2);
    return net_deg[below] + (at - static_cast<double>(below)) * (net_deg[below + 1] - net_deg[below]);
  };
  return " (90 % band " + tenths(quantile(0.05)) + " to " + tenths(quantile(0.95)) + ")";
}

}  // namespace

std::string prior_statement(const MotionModel& model, const std::string& default_set)
{
  if (!model.prior) return "";
  std::string shapes;
  for (const PriorTermRows& term : model.prior->terms)
    if (shapes.find(term.shape) == std::string::npos) shapes += (shapes.empty() ? "" : ", ") + term.shape;
  std::string text = "A model, not a measurement: the population motion " + shapes + " fitted to these bones";
  const double share = rotation_share_of(*model.prior);
  if (std::isfinite(share))
    text += " decides " + rounded_text(std::round(100.0 * share)) + " % of the rotation";
  const double net_deg = net_rotation_deg(model, default_set);
  if (std::isnan(net_deg)) return text + ".";
  return text + ". Net internal rotation: " + tenths(net_deg) + " degrees" + band_text(model) +
         "; of the bones alone: " + tenths(net_rotation_deg(model, bones_alone_name)) + ".";
}

std::vector<std::string> lines_of(const Verdict& verdict)
{
  std::vector<std::string> lines{"verdict on the motion " + verdict.set, "  " + verdict.sentence};
  for (const VerdictMeasure& measure : verdict.measures) lines.push_back(line_of(measure));
  if (verdict.measures.empty()) return lines;
  if (!verdict.contacts_of.empty() && verdict.contacts_of != verdict.set)
    lines.emplace_back("  contacts are those of the solved poses (" + verdict.contacts_of + ")");
  lines.push_back(verdict.lift_off ? line_of(*verdict.lift_off)
                                   : "  lift-off: the gaps of this motion are not known");
  for (const FollowerFinding& found : verdict.followers)
    lines.push_back("  " + found.follower + ": " + found.finding + runs_text(found));
  return lines;
}

}  // namespace vrda::store
