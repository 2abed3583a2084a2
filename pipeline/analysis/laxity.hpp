/// Laxity tests: how far a load moves the joint at a held flexion, and which fibres resist it.
#pragma once

#include <functional>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "job/case.hpp"
#include "job/job.hpp"
#include "model/coordinates.hpp"
#include "model/step_record.hpp"

namespace vrda::solve {
struct Joint;
}

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
/// The largest load of a test: N or N mm.
double whole_load(const job::LaxityJob& loads, LaxityTest test);

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

/// The curve of a state, flexion and test; null without this curve.
const LaxityCurve* curve_of(const LaxityResult& result, std::size_t state, std::size_t flexion,
                            LaxityTest test);

struct LaxityPlan {
  job::LaxityJob loads;
  int n_threads = 1;
  /// [n_flexion] Equilibria of a joint that is nearly the same, from which the unloaded poses are solved
  /// instead of by the spine; without cuts. Empty: by the spine.
  std::vector<StepRecord> unloaded = {};
  /// Of another case with the same meshes and frame; null: made for this one.
  std::shared_ptr<const solve::Joint> joint = {};
  std::function<void()> on_progress = {};  ///< after each curve, from any worker
  std::function<bool()> is_stopped = {};   ///< true: returns with no curves
};

/// Number of curves.
std::size_t n_curves(const job::LaxityJob& loads);

/// `job_case` at the subject's size, of job::over_flexions() with the flexions of the plan. Each state
/// starts from its own unloaded equilibrium of lowest energy (solve/sweep.hpp); the load then grows in
/// equal steps, each from the pose before, halved where no equilibrium is found. The same bits for any number
/// of threads. Throws InputError naming the key if a cut has no fibre or the case has none.
LaxityResult laxity_of(const job::Case& job_case, const LaxityPlan& plan);

/// Change of the coordinate under `load`, linear between the steps of a curve: rad or mm. NaN beyond them.
double laxity_at_load(const LaxityCurve& curve, double load);

// A table of published or measured laxities, and its comparison with a result.

/// One row of the table; angles in degrees and lengths in mm, as written.
struct PublishedValue {
  std::string test;  ///< name of a test, or of both directions together ("anterior-posterior")
  double flexion_deg = 0.0;
  double load = nan;   ///< N or N mm; NaN: the whole load of the job
  double value = 0.0;  ///< mm or degrees
  double sd = nan;     ///< standard deviation over subjects; NaN: not given
  std::string source;
};

/// Parses the CSV text (schemas/laxity.md). Throws InputError naming file, line and column.
std::vector<PublishedValue> published_values(const std::string& file, std::string_view text);

struct Compared {
  PublishedValue published;
  double found = nan;   ///< of the intact joint, mm or degrees; NaN outside the job's flexions or loads
  std::string missing;  ///< why there is no difference
  double difference() const { return found - published.value; }
};

/// The value of the intact joint at the row's flexion and load, linear between the job's.
std::vector<Compared> compared(const LaxityResult& result, const std::vector<PublishedValue>& published);

/// Whether a name is that of a test or of both directions together.
bool is_test_name(const std::string& name);

/// Angles in degrees, lengths in mm.
double in_file_unit(const TestKind& kind, double value);

// Files of laxity tests (schemas/laxity.md): the document and tables.

struct LaxityDocument {
  std::string program, solver;           ///< that wrote it, and the solver's version
  std::string title, joint, side, job;   ///< of the job; its resolved text
  std::vector<job::LoadedInput> inputs;  ///< names and hashes
  LaxityResult result;
  std::vector<Compared> compared;  ///< empty without published values
};

/// Text of laxity.json. Angles in degrees, lengths in mm; every number reads back exactly.
std::string laxity_json(const LaxityDocument& document);

/// One row per state, flexion, test and both directions together: laxity, position and its change by the cut.
std::string laxity_csv(const LaxityDocument& document);

/// One row per state, flexion and test and bundle: force and share.
std::string share_csv(const LaxityDocument& document);

}  // namespace vrda::analysis
