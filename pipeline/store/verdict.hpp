/// A knee's motion in clinical words: rotation, travel and lift-off beside published values of healthy knees
/// (schemas/verdict.md). Units are those of the file: mm and degrees.
#pragma once

#include <optional>
#include <string>
#include <tuple>
#include <vector>

#include "core/fields.hpp"
#include "core/units.hpp"
#include "store/motion_model.hpp"

namespace vrda::store {

/// Where a value is relative to the published range.
enum class Standing { not_compared, within, below, above };

inline constexpr Named<Standing> standing_names[] = {
    {Standing::not_compared, "not_compared", "the value or a published one near its flexion is missing"},
    {Standing::within, "within"},
    {Standing::below, "below"},
    {Standing::above, "above"}};
constexpr const auto& names_of(Standing)
{
  return standing_names;
}

/// One quantity of a motion beside the published one.
struct VerdictMeasure {
  std::string name;   ///< key: "net_internal_rotation"
  std::string label;  ///< "net internal rotation"
  std::string unit;   ///< of the value and of the published ones: "degrees", "mm", "%"
  double value = nan;
  double flexion_deg = nan;            ///< where the value is reached; NaN of a share
  double published_mean = nan;         ///< NaN, as those below, if nothing is published near that flexion
  double low = nan, high = nan;        ///< two standard deviations; NaN: not bounded there
  double published_flexion_deg = nan;  ///< the nearest one; NaN: of the whole motion
  bool is_spread_assumed = false;      ///< low and high are assumed, not published
  Standing standing = Standing::not_compared;
  std::string source = {};

  bool operator==(const VerdictMeasure&) const = default;
};

constexpr auto fields_of(const VerdictMeasure*)
{
  using M = VerdictMeasure;
  return std::tuple{Field{"name", &M::name},
                    Field{"label", &M::label},
                    Field{"unit", &M::unit},
                    Field{"value", &M::value},
                    Field{"flexion_deg", &M::flexion_deg, unit::degree},
                    Field{"published_mean", &M::published_mean},
                    Field{"low", &M::low},
                    Field{"high", &M::high},
                    Field{"published_flexion_deg", &M::published_flexion_deg, unit::degree},
                    Field{"is_spread_assumed", &M::is_spread_assumed},
                    Field{"standing", &M::standing},
                    Field{"source", &M::source}};
}

/// Flexions at which something was found, and the first and last of those that follow each other.
struct FlexionRuns {
  std::vector<double> flexion_deg;
  std::vector<double> from_deg = {}, to_deg = {};

  bool operator==(const FlexionRuns&) const = default;
};

template <typename M>
constexpr auto fields_of_runs()
{
  return std::tuple{Field{"flexion_deg", &M::flexion_deg, unit::degree},
                    Field{"from_deg", &M::from_deg, unit::degree}, Field{"to_deg", &M::to_deg, unit::degree}};
}

/// Flexions at which a compartment is not in contact: its gap is above perceptible_mm, or nothing faces it.
struct LiftOff : FlexionRuns {
  std::string compartment;  ///< "medial" or "lateral"
};

constexpr auto fields_of(const LiftOff*)
{
  return std::tuple_cat(std::tuple{Field{"compartment", &LiftOff::compartment}}, fields_of_runs<LiftOff>());
}

/// Solved flexions of the joint at which a follower has no stable pose, or an implausible one.
struct FollowerFinding : FlexionRuns {
  std::string follower;
  std::string finding;  ///< name of the status or of the plausibility

  bool operator==(const FollowerFinding&) const = default;
};

constexpr auto fields_of(const FollowerFinding*)
{
  using F = FollowerFinding;
  return std::tuple_cat(std::tuple{Field{"follower", &F::follower}, Field{"finding", &F::finding}},
                        fields_of_runs<F>());
}

struct Verdict {
  std::string set;                                      ///< the motion
  std::string sentence;                                 ///< the verdict, or why there is no verdict
  double from_flexion_deg = nan, to_flexion_deg = nan;  ///< the measured part
  std::vector<VerdictMeasure> measures;                 ///< empty: no verdict
  std::string contacts_of;  ///< the set whose contact paths are measured; may be empty
  std::optional<std::vector<LiftOff>> lift_off = std::nullopt;  ///< both compartments, if gaps are known
  std::vector<FollowerFinding> followers = {};                  ///< of the solved poses along the spine
  double prior_share = nan;  ///< part of the motion that a prior decided, 0 to 1; NaN: none
};

constexpr auto fields_of(const Verdict*)
{
  return std::tuple{Field{"set", &Verdict::set},
                    Field{"sentence", &Verdict::sentence},
                    Field{"from_flexion_deg", &Verdict::from_flexion_deg, unit::degree},
                    Field{"to_flexion_deg", &Verdict::to_flexion_deg, unit::degree},
                    Field{"measures", &Verdict::measures},
                    Field{"contacts_of", &Verdict::contacts_of},
                    Field{"lift_off", &Verdict::lift_off},
                    Field{"followers", &Verdict::followers},
                    Field{"prior_share", &Verdict::prior_share, unit::one}};
}

/// The verdict on the motion of `set`, one of all_set_names(model); empty for joints other than knees. It has
/// no measures unless the motion has poses from flexion 5 or less to more than 30 degrees. Left knees as
/// their mirror images. Cost: a pose a flexion.
std::optional<Verdict> verdict_of(const MotionModel& model, const std::string& set);

/// "From 0 to 90 degrees of flexion the motion is outside the published range (spread assumed) in net
/// internal rotation; decided by the prior to 80 %; patella: dislocated at 3 flexions." from the measures,
/// the prior's share and the followers.
std::string sentence_of(const Verdict& verdict);

/// Of a model with a prior: that its default motion is a model, what the prior decided, the net rotation with
/// the band of the samples, and that of the bones alone; empty without a prior. Two sentences.
std::string prior_statement(const MotionModel& model, const std::string& default_set);

/// Heading, sentence, a line a measure, lift-off: as `vrda info` prints them.
std::vector<std::string> lines_of(const Verdict& verdict);

}  // namespace vrda::store
