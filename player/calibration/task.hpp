/// Tasks of the operator and the parts of a calibration, as objects. An object of TaskKind knows everything
/// that is particular to a kind of task: what is drawn, its diagram, the row of its mark, and how a simulated
/// operator does it. An object of Part knows when a part applies, what it depends on, its tasks, and how its
/// marks are solved. A new task is one file NAME_part.cpp and one row of the list in parts.cpp.
/// Positions on the screen are in pixels of the frame buffer (x right, y down) before or after pre-distortion
/// as stated; tracker poses are in the tracker's frame, mm and unit quaternions.
#pragma once

#include <array>
#include <limits>

#include "bench/simulation.hpp"
#include "calibration/functional_fit.hpp"

namespace vrda::calibration {

using bench::BenchFile;
using bench::BodyRole;
using bench::Calibration;
using bench::CalibrationLandmarks;
using bench::CalibrationMark;
using bench::CalibrationPart;
using bench::CalibrationPoint;
using bench::CalibrationRecord;
using bench::CalibrationRectangle;
using bench::CalibrationSettings;
using bench::Estimate;
using bench::HeadKind;
using bench::LegKind;
using bench::RandomSequence;

class TaskKind;
struct BenchPoses;
struct BodyOutline;
struct DrawnLine;
struct Sketch;
struct VirtualNoise;
struct VirtualTruth;
using DrawnLines = std::vector<DrawnLine>;

/// A number that the operator adjusts by keys and potentiometer.
struct Dial {
  std::string name, unit;
  double value = 0.0, minimum = 0.0, maximum = 0.0, step = 0.0;
  /// A reading outside is refused once.
  double least_plausible = -std::numeric_limits<double>::infinity();
  double most_plausible = std::numeric_limits<double>::infinity();
};

struct Task {
  const TaskKind* kind = nullptr;  ///< never null for a task of a part
  std::string name = {};           ///< unique within its part: "left eye, left edge, 2"
  std::string instruction = {};    ///< for the screen, up to three lines
  bool is_right = false;           ///< eye, for tasks of one eye
  bool is_row = false;             ///< scan line: a row, which moves vertically; else a column
  /// Start values, in the units of the dials; empty for a task that only samples or confirms.
  std::vector<Dial> dials = {};
  bool is_start_valid = false;  ///< the start values may be confirmed as they are: a setting, not a reading
  int n_samples = 0;            ///< number of tracker samples; 0: none
  std::string tool = {};        ///< tracker tool that is sampled
  std::optional<BodyRole> body =
      std::nullopt;  ///< body whose pose is sampled with the tool, or that carries the model
  /// whole grid: columns and rows; node: column and row relative to the grid centre.
  Eigen::Vector2d node = Eigen::Vector2d::Zero();
  int index = 0;  ///< of the edge, rectangle, model point, marker position or number
};

/// Distance of the dials from the truth: lines, crosses and nodes of a grid (root mean square) in px, points
/// of a model (root mean square) in mm, numbers in their unit.
struct Deviation {
  double value = 0.0;
  std::string unit;
};

/// A task and with what a simulated operator does it.
struct TaskContext {
  const Task& task;
  const Calibration& found;  ///< found so far, used for drawing
  const BenchFile& bench;
  const VirtualTruth& truth;
  const VirtualNoise& noise;
  RandomSequence& draws;  ///< of the hand, for this task
};

class TaskKind {
 public:
  /// Rows that are collected from tracker and stage (schemas/calibration.md).
  enum class Samples {
    none,
    sweep,     ///< pose of the tool (7 numbers), then stage_mm if the board sends it
    hold,      ///< poses of the tool and of `body` (14); both are static
    position,  ///< after the cross {x_px, y_px as drawn, stage_mm}: position of the tool (3), pose of `body`
    leg        ///< poses of the bodies of femur and tibia (14), which move
  };
  struct Traits {
    const char* name;              ///< unique
    double typical_s = 120.0;      ///< time that a practised operator needs
    const char* thing = "number";  ///< what the operator moves, in messages
    Samples samples = Samples::none;
    std::size_t n_numbers = 1;   ///< of the row of a task without samples
    bool is_cross = false;       ///< the dials are x and y, which follow all four arrow keys
    bool is_reading = false;     ///< the row is one number that has a plausible range
    bool is_seen = true;         ///< false: read from an instrument
    bool uses_stage = false;     ///< confirmed only with messages of the stage's board
    bool has_two_lines = false;  ///< each dial must be touched
    bool shows_result = false;   ///< drawn with the part's result before that is confirmed
    bool places_model = false;   ///< the dials are the pose of the model: mm, deg
  };

  constexpr explicit TaskKind(const Traits& traits) : traits_(traits) {}
  TaskKind(const TaskKind&) = delete;
  TaskKind& operator=(const TaskKind&) = delete;

  const Traits& traits() const { return traits_; }

  /// Lines of `task` with its dials at `values`, in the frame buffer. Curves have a point at least every 8
  /// px.
  virtual DrawnLines draw(const Task& task, std::span<const double> values, const Calibration& found) const;
  /// The same as a virtual bench shows it, where no model is drawn.
  virtual DrawnLines draw_simulated(const Task& task, std::span<const double> values,
                                    const Calibration& found, const BenchFile& bench,
                                    const VirtualTruth& truth) const;
  /// Adds what the operator sets up, moves and reads.
  virtual void sketch(Sketch& sketch, const Task& task, const BenchFile& bench) const = 0;
  /// Row of the mark for a task without samples; for `position` its first row without the stage.
  virtual std::vector<double> mark_row(const Task& task, std::span<const double> values,
                                       const Calibration& calibration) const;

  /// Dial values at which everything appears aligned to a simulated operator, in the units of the dials;
  /// empty without dials.
  virtual std::vector<double> aligned_values(const TaskContext& context) const;
  /// Of a task with dials. By default the difference to the aligned values, of several the largest.
  virtual Deviation deviation(const TaskContext& context, std::span<const double> values) const;
  /// Outlines of the physical things that the task is aligned with, as seen by the eye, in undistorted px.
  virtual DrawnLines outlines(const Task& task, const BenchFile& bench, const VirtualTruth& truth) const;
  /// Poses of everything on the bench; `way` in [0, 1]: progress of a sweep.
  virtual BenchPoses poses(const TaskContext& context, double way) const;

 protected:
  ~TaskKind() = default;  // the objects are constants

 private:
  Traits traits_;
};

/// What a part is checked and solved with.
struct PartInput {
  const BenchFile& bench;
  const Calibration& begun;  ///< marks and estimates so far
  const std::string& path;   ///< calibration file, for messages
  /// Motion of the model as given now, unscaled; nullptr: not given, only its record may be used.
  const JointCurve* joint = nullptr;
};

class Part {
 public:
  /// Tasks that are checked together.
  enum class Group { part, eye, task };
  struct Traits {
    CalibrationPart id;
    Group group = Group::part;
    bool is_tracking = false;    ///< done by the step "tracking"
    bool is_optional = false;    ///< only refines others and is done only when requested by name
    const char* bench_key = "";  ///< bench file key of made_with()
    /// Parts whose results it uses, if that does not depend on the bench.
    std::array<std::optional<CalibrationPart>, 2> below = {};
    /// The stored rows depend on made_with(), so that solving again cannot mend them.
    bool is_made_of_them = false;
  };

  constexpr explicit Part(const Traits& traits) : traits_(traits) {}
  Part(const Part&) = delete;
  Part& operator=(const Part&) = delete;

  const Traits& traits() const { return traits_; }
  CalibrationPart id() const { return traits_.id; }
  const char* name() const { return bench::name_of(traits_.id); }

  virtual bool applies_to(const BenchFile&) const { return true; }
  /// Parts whose results it uses, including parts that the bench does not have.
  virtual std::vector<CalibrationPart> below(const BenchFile&) const;
  /// Throws InputError with the bench file's key if it lacks data for the part.
  virtual void require_bench_data(const BenchFile&) const {}
  /// Numbers of the bench file, or of the model's motion, to which the marks belong; nullopt: unknown now.
  virtual std::optional<std::vector<double>> made_with(const PartInput&) const
  {
    return std::vector<double>();
  }
  /// Throws InputError with `bench_key`.
  [[noreturn]] void refuse_bench(const BenchFile& bench, const std::string& found,
                                 const std::string& wanted) const;
  /// What to do if they have changed, as "restore X or repeat ".
  virtual std::string restore_text(const BenchFile& bench) const;

  virtual std::vector<Task> tasks(const BenchFile& bench, const Calibration& calibration) const = 0;
  /// A message when the part begins; may be empty.
  virtual std::string introduction(const BenchFile&, const Calibration&) const { return {}; }

  /// Applies an estimate of the part to the eyes; only for parts that determine the display.
  virtual void apply(view::EyePair&, const Estimate&) const {}
  /// Writes the estimate into the part's record of `c` and its values into `c`, a copy of `in.begun`. Throws
  /// PartRefusal.
  virtual void solve(const PartInput& in, Calibration& c) const = 0;
  /// Remarks on the group of tasks that ends with `done`. Throws PartRefusal if it must be repeated.
  virtual std::vector<std::string> remarks(const Task&, const PartInput&) const { return {}; }
  /// Whether solving repeats the fits to the rectangles of the part eyepoints.
  virtual bool uses_rectangles(const BenchFile&) const { return false; }

 protected:
  ~Part() = default;  // the objects are constants

 private:
  Traits traits_;
};

/// A part whose eyes are solved one after the other.
class EyePart : public Part {
 public:
  using Part::Part;
  /// Estimate of one eye. Throws PartRefusal.
  virtual Estimate solve_eye(const PartInput& in, bool is_right) const = 0;
  void solve(const PartInput& in, Calibration& c) const override;
  std::vector<std::string> remarks(const Task& done, const PartInput& in) const override;

 protected:
  ~EyePart() = default;
};

/// "left", "right" and "left eye"
const char* side_name(bool is_right);
std::string eye_text(bool is_right);
/// A dial without a plausible range: any value between `least` and `most` is taken.
Dial dial(std::string name, const char* unit, double value, double least, double most, double step);
/// The dial with a range of plausible values.
Dial within(Dial dial, double least_plausible, double most_plausible);

/// Below visual resolution, but coarse enough for keys.
inline constexpr double dial_step_px = 0.25, dial_step_mm = 0.05;

}  // namespace vrda::calibration
