// The table's frame from sweeps of a marker along two rails, the zero of the stage, and the tip of the probe
// (thesis 8.5).
#include <cmath>

#include "bench/rigid_body.hpp"
#include "calibration/marks.hpp"
#include "calibration/parts.hpp"
#include "calibration/virtual_bench.hpp"
#include "core/units.hpp"

namespace vrda::calibration {
namespace {

using enum DiagramInk;

/// Task names in the order of Rail.
const std::vector<std::string> rail_names{"x rail", "z rail"};

/// From above: rails of the stage (x) and of the slide (z).
void sketch_rails(Sketch& sketch, bool is_x)
{
  sketch.box(plain, {0.08, 0.04}, {0.92, 0.56});
  sketch.line(is_x ? real : plain, {{0.15, 0.46}, {0.85, 0.46}});
  sketch.line(is_x ? plain : real, {{0.5, 0.1}, {0.5, 0.4}});
}

/// The marker on the carriage of a rail, to the viewer's right or towards the viewer.
struct RailSweepTask final : TaskKind {
  using TaskKind::TaskKind;

  void sketch(Sketch& sketch, const Task& task, const BenchFile&) const override
  {
    const bool is_x = task.index == static_cast<int>(Rail::x);
    sketch_rails(sketch, is_x);
    const Eigen::Vector2d from = is_x ? Eigen::Vector2d(0.2, 0.46) : Eigen::Vector2d(0.5, 0.12),
                          to = is_x ? Eigen::Vector2d(0.8, 0.46) : Eigen::Vector2d(0.5, 0.38);
    sketch.circle(real, from, 0.025);
    sketch.arrow(lit, from, to);
  }

  BenchPoses poses(const TaskContext& context, double way) const override
  {
    constexpr double sweep_mm = 300.0;
    const VirtualTruth& truth = context.truth;
    const bool is_x = context.task.index == static_cast<int>(Rail::x);
    // The marker of the x rail is on the stage.
    BenchPoses poses = resting_poses(truth, is_x ? sweep_mm * way : 0.0);
    const double along_mm = sweep_mm * (way - 0.5);
    Eigen::Vector3d p_table_mm(along_mm, 0.0, 0.0);
    if (!is_x) p_table_mm = Eigen::Vector3d(0.0, truth.z_rail_above_mm, 0.0) + along_mm * truth.z_rail_table;
    poses.X_tracker_tool = bench::pose_of(truth.calibration.X_tracker_table);
    poses.X_tracker_tool.translation() = poses.X_tracker_tool * p_table_mm;
    return poses;
  }
};

/// Zeroes the stage at its stop; the row is {stage_mm before}.
struct StageStop final : TaskKind {
  using TaskKind::TaskKind;

  void sketch(Sketch& sketch, const Task&, const BenchFile&) const override
  {
    sketch_rails(sketch, true);
    sketch.box(real, {0.1, 0.42}, {0.14, 0.5});
    sketch.box(plain, {0.3, 0.43}, {0.4, 0.49});
    sketch.arrow(lit, {0.3, 0.46}, {0.15, 0.46});
  }
};

/// The probe's tip rests on a point of the table while the probe turns by 40 degrees about two axes.
struct ProbeSweep final : TaskKind {
  using TaskKind::TaskKind;

  void sketch(Sketch& sketch, const Task&, const BenchFile&) const override
  {
    using Point = Eigen::Vector2d;
    const Point tip(0.5, 0.55);
    sketch.line(plain, {{0.1, 0.56}, {0.9, 0.56}});
    for (const double turn : {-0.35, 0.0, 0.35}) {
      const Point end = tip + 0.45 * Point(std::sin(turn), -std::cos(turn));
      sketch.line(turn == 0.0 ? real : plain, {tip, end});
    }
    sketch.arrow(lit, {0.52, 0.1}, {0.66, 0.14});
    sketch.arrow(lit, {0.48, 0.1}, {0.34, 0.14});
  }

  BenchPoses poses(const TaskContext& context, double way) const override
  {
    // Inclination of 20 degrees in all directions: a range of 40 degrees about x and about y.
    constexpr double turns = 3.0, lean_deg = 20.0;
    const SinCos round = sin_cos(2.0 * pi * turns * way);
    const Eigen::Vector3d lean_rad = rad_from_deg(lean_deg) * Eigen::Vector3d(round.cos, round.sin, 0.0);
    BenchPoses poses = resting_poses(context.truth);
    const Pose X_tracker_table = bench::pose_of(context.truth.calibration.X_tracker_table);
    put_tip_at(context.truth, X_tracker_table * Eigen::Vector3d(100.0, 0.0, 100.0),
               X_tracker_table.linear() * bench::rotation_of(lean_rad), poses);
    return poses;
  }
};

const RailSweepTask rail_sweep({.name = "rail", .typical_s = 30.0, .samples = TaskKind::Samples::sweep});
const StageStop stage_stop({.name = "stop", .typical_s = 10.0, .uses_stage = true});
const ProbeSweep probe_sweep({.name = "probe", .typical_s = 30.0, .samples = TaskKind::Samples::sweep});

/// The marks of a rail; only the x rail is the stage's.
RailSweep sweep_of(Rail rail, const PartInput& in)
{
  constexpr std::size_t stage_at = 7;
  const bool is_on_stage = rail == Rail::x && has_stage(in.bench);
  RailSweep sweep;
  for (const std::vector<double>& row :
       mark_named(CalibrationPart::rails, in, rail_names[static_cast<std::size_t>(rail)]).rows) {
    sweep.p_tracker_mm.push_back(sampled_position(row));
    if (is_on_stage && row.size() > stage_at) sweep.stage_mm.push_back(row[stage_at]);
  }
  // The stage must be known at all positions or none.
  if (sweep.stage_mm.size() != sweep.p_tracker_mm.size()) sweep.stage_mm.clear();
  return sweep;
}

struct RailsPart final : Part {
  using Part::Part;

  bool applies_to(const BenchFile& bench) const override { return bench.head == HeadKind::stage; }

  std::vector<Task> tasks(const BenchFile& bench, const Calibration&) const override
  {
    const std::string& tool = bench.calibration.marker;
    const int n = bench.calibration.rail_samples;
    const char* const along_x =
        "Attach the marker to the stage. Press Enter, then move the stage slowly along its whole rail,\n"
        "from left to right, with the marker visible to the tracker.";
    const char* const along_z =
        "Attach the marker to the slide of the rail along the table. Press Enter, then move it slowly\n"
        "along the whole rail, towards the viewer.";
    return {
        {.kind = &rail_sweep, .name = rail_names[0], .instruction = along_x, .n_samples = n, .tool = tool},
        {.kind = &rail_sweep,
         .name = rail_names[1],
         .instruction = along_z,
         .n_samples = n,
         .tool = tool,
         .index = static_cast<int>(Rail::z)}};
  }

  void solve(const PartInput& in, Calibration& c) const override
  {
    const TableFit fit =
        run_fit(rail_names, [&] { return fit_table(sweep_of(Rail::x, in), sweep_of(Rail::z, in), in.path); });
    c.records.at(id()).estimate = fit.estimate;
    c.X_tracker_table = bench::pose_parameters_of(pose_in(fit.estimate, "table"));
    c.stage_direction_table = Eigen::Vector3d::UnitX();
  }

  std::vector<std::string> remarks(const Task& done, const PartInput& in) const override
  {
    const auto rail = static_cast<Rail>(done.index);
    run_fit(rail_names, [&] { require_valid_rail(sweep_of(rail, in), rail, in.path); });
    return {};
  }
};

struct StopPart final : Part {
  using Part::Part;

  bool applies_to(const BenchFile& bench) const override { return has_stage(bench); }

  std::vector<Task> tasks(const BenchFile&, const Calibration&) const override
  {
    return {{.kind = &stage_stop,
             .name = "stop",
             .instruction = "Move the stage against its stop, hold it there and press Enter to zero it."}};
  }

  /// An empty estimate: the part only zeroes the stage.
  void solve(const PartInput&, Calibration& c) const override
  {
    c.records.at(id()).estimate.emplace().dof = std::numeric_limits<double>::infinity();
  }
};

struct ProbePart final : Part {
  using Part::Part;

  bool applies_to(const BenchFile& bench) const override { return !bench.calibration.is_model_adjusted; }

  std::vector<Task> tasks(const BenchFile& bench, const Calibration&) const override
  {
    return {
        {.kind = &probe_sweep,
         .name = "sweep",
         .instruction =
             "Put the probe's tip into a small hole. Press Enter, then tilt the probe forwards, backwards,\n"
             "to the left and to the right over a range of 40 degrees or more. The tip must not slip.",
         .n_samples = bench.calibration.pivot_samples,
         .tool = bench.calibration.probe}};
  }

  void solve(const PartInput& in, Calibration& c) const override
  {
    std::vector<Pose> poses;
    for (const std::vector<double>& row : mark_named(id(), in, "sweep").rows)
      poses.push_back(sampled_pose(row));
    c.records.at(id()).estimate = run_fit({}, [&] { return fit_pivot(poses, in.path); }).estimate;
  }
};

const RailsPart rails_object({.id = CalibrationPart::rails, .group = Part::Group::task, .is_tracking = true});
const StopPart stop_object({.id = CalibrationPart::stop, .is_tracking = true});
const ProbePart probe_object({.id = CalibrationPart::probe, .is_tracking = true});

}  // namespace

const Part &rails_part = rails_object, &stop_part = stop_object, &probe_part = probe_object;

}  // namespace vrda::calibration
