/// Laxity tests: how far a load moves the joint at a held flexion, and which fibres resist it.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "model/joint_coordinates.hpp"
#include "model/step_record.hpp"
#include "job/case.hpp"
#include "job/job.hpp"

namespace vrda::analysis {

/// The direction of a load. The values are those of the files.
enum class LaxityTest : std::int8_t { anterior, posterior, internal, external, varus, valgus };
inline constexpr std::size_t n_laxity_tests = 6;

/// The load acts along `coordinate` times `sign`: its work is load times the change of the coordinate with
/// the other four held.
struct TestKind {
  const char* name;
  const char* both;  ///< name of the test and its opposite together: "anterior-posterior"
  JointCoordinate coordinate;
  double sign;

  bool is_force() const { return !is_rotation(static_cast<std::size_t>(coordinate)); }
};
const TestKind& kind_of(LaxityTest test);

/// Name of the state with all fibres.
inline constexpr const char* whole_state = "intact";

/// The equilibrium under one load.
struct LoadedPose {
  double load = 0.0;  ///< N or N mm
  StepStatus status = StepStatus::pending;
  JointCoordinates coordinates = JointCoordinates::Constant(nan);  ///< rad, mm
};

/// Resistance of a bundle against a load, along the coordinate of the test.
struct BundleResistance {
  std::string bundle;
  double force = nan;  ///< generalised force against the load at the last pose: N or N mm
  double share = nan;  ///< its change from the unloaded pose, as a share of the load
};

struct LaxityCurve {
  std::size_t state = 0;    ///< 0: all fibres; else 1 + row of the cut
  std::size_t flexion = 0;  ///< row
  LaxityTest test = LaxityTest::anterior;
  std::vector<LoadedPose> poses;  ///< unloaded, then up to the whole load or to the first that is not stable
  std::vector<BundleResistance> bundles;  ///< at the whole load; with `contact` the shares add up to 1
  BundleResistance contact;
  /// Of a cut: its equilibrium with the cut fibres' own forces at the loaded pose of the intact joint in
  /// their place, as constant tensions. Its distance from that pose is zero if they carried that share.
  double replaced_mm = nan, replaced_rad = nan;

  bool is_complete() const { return !poses.empty() && poses.back().status == StepStatus::stable; }
  /// Change of the coordinate, in the direction of the test: rad or mm; NaN unless complete.
  double laxity() const;
  /// The coordinate at the whole load, in the direction of the test; NaN unless complete.
  double position() const;
};

struct LaxityResult {
  job::LaxityJob loads;
  std::vector<std::string> states;   ///< "intact" and the names of the cuts
  std::vector<LaxityCurve> curves;   ///< by state, flexion, test
  std::vector<StepRecord> unloaded;  ///< [n_flexion] of the intact joint
};

struct LaxityPlan {
  job::LaxityJob loads;
  int n_threads = 1;
  /// [n_flexion] Equilibria of a joint that is nearly the same, from which the unloaded poses are solved
  /// instead of by the spine; without cuts. Empty: by the spine.
  std::vector<StepRecord> unloaded = {};
  std::function<void()> on_progress = {};  ///< after each curve, from any worker
  std::function<bool()> is_stopped = {};   ///< true: returns with no curves
};

/// Number of curves.
std::size_t n_curves(const job::LaxityJob& loads);

/// `job_case` at the subject's size, of job::over_flexions() with the flexions of the plan. Each state
/// starts from its own unloaded equilibrium of lowest energy (sweep/free_spine.hpp); the load then grows in
/// equal steps, each from the pose before, halved where no equilibrium is found. The same bits for any number
/// of threads. Throws InputError naming the key if a cut has no fibre or the case has none.
LaxityResult laxity_of(const job::Case& job_case, const LaxityPlan& plan);

/// Change of the coordinate under `load`, linear between the steps of a curve: rad or mm. NaN beyond them.
double laxity_at_load(const LaxityCurve& curve, double load);

}  // namespace vrda::analysis
