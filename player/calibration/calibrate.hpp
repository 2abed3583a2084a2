/// Command `vrda-player calibrate`: calibrates a bench and a person in steps, with real devices or with
/// simulated ones of which the truth is known. In: bench file, calibration file, for adjustment by eye a
/// motion model. Out: the calibration file (schemas/calibration.md; lengths in mm, angles in degrees),
/// pictures, statistics. Throws InputError for a file or value that cannot be used.
#pragma once

#include <cstdint>
#include <iosfwd>
#include <memory>

#include "bench/bench_show.hpp"
#include "calibration/functional_fit.hpp"
#include "calibration/operator.hpp"
#include "calibration/statistics.hpp"
#include "core/fields.hpp"
#include "show/loop.hpp"

namespace vrda::calibration {

struct CalibrateOptions {
  std::string step;         ///< viewport, ..., all, bench, person; status; solve
  std::string bench;        ///< empty with is_virtual: built-in bench file
  std::string calibration;  ///< empty with is_virtual: not saved
  std::string bench_from;   ///< calibration file of another person; may be empty
  bool is_repeated = false;
  std::string model, set;  ///< for adjustment by eye and for pictures
  bool is_headless = false;
  std::string script;  ///< file with keys
  int samples = 1;     ///< samples per pixel
  bool is_virtual = false;
  std::uint64_t seed = 1;
  std::string head = "stage";  ///< or "tracker", in the built-in bench file
  int n_benches = 0;           ///< number of benches for statistics; 0: one bench with a report
  std::string noise;           ///< of the virtual bench: "touch_mm=5,tracker_deg=0.3"
  std::string pictures;        ///< folder; empty: no pictures
  bool has_json = false;
  bool is_quiet = false;
};

enum class CalibrateEnd {
  finished,
  quit  ///< quit before all requested parts were done; finished tasks are saved
};

/// Default noise with the values of a list NAME=VALUE,...; throws InputError for an unknown name or value.
VirtualNoise noise_of(const std::string& list);

/// Runs the command. Throws InputError for invalid options and files before it starts.
CalibrateEnd calibrate(const CalibrateOptions& options, const show::Streams& streams);

// The bench of a calibration session (real devices or simulated ones), and the motion model whose pose is
// adjusted by eye. Poses take points of the second-named body to the first, mm; dial values have the units
// of their task.

/// A model with motion, state and view as in the mode `bench`.
struct ModelOnBench {
  /// `scaled`: model in the size of the calibration's subject.
  ModelOnBench(const BenchFile& bench, const Calibration& calibration, store::MotionModel scaled,
               const std::string& set);
  ModelOnBench(const ModelOnBench&) = delete;
  ModelOnBench& operator=(const ModelOnBench&) = delete;

  double scale;
  store::MotionModel model;
  store::Motion motion;
  bench::BenchState state;
  bench::BenchView view;
};

/// Model drawn at the pose being adjusted.
class AdjustedModel {
 public:
  /// `model`: unscaled, from `file`. Throws InputError if it does not contain the set.
  AdjustedModel(const BenchFile& bench, store::MotionModel model, const std::string& file,
                const std::string& set);

  void take(const bench::Sample& sample);

  /// Places the model at the dials of the session's task and loads changes into the renderer. Throws
  /// InputError for unusable eyes.
  void place(const CalibrationSession& session, std::int64_t now_ns, view::Renderer& renderer);
  /// Requires place().
  const bench::BenchView& view() const { return shown_->view; }

 private:
  BenchFile bench_;
  store::MotionModel model_;
  std::string set_;
  std::unique_ptr<ModelOnBench> shown_;
};

/// Contents of the window for a task, in window pixels.
struct CalibrationView {
  std::vector<DrawnLine> lines;
  std::optional<std::array<view::ShownBox, 2>> boxes;  ///< clip box of each eye; empty: no clipping
  std::vector<std::string> notes;                      ///< simulated readings
};

class CalibrationBench {
 public:
  virtual ~CalibrationBench() = default;
  /// Passes the device samples since the last call to session and model.
  virtual void send_samples(CalibrationSession& session, AdjustedModel* model) = 0;
  /// Clock of the samples, ns.
  virtual std::int64_t now_ns() const { return 0; }
  virtual void zero_stage() {}
  /// Problems of the devices that the task needs; empty: none.
  virtual std::vector<std::string> device_problems(const Task&) const { return {}; }
  /// How far the dials are from the truth; empty if the truth is unknown or there are no dials.
  virtual std::optional<Deviation> deviation(const CalibrationSession&) const { return std::nullopt; }
  /// View of the current task.
  virtual CalibrationView view(const CalibrationSession& session) const = 0;
};

/// Motion of the file's model along its flexion, mm and rad, unscaled: poses at steps of about 2 degrees,
/// each at the set's own or balanced varus. Throws InputError with the file: a sequence of frames, one
/// flexion only, an unsolved pose.
JointCurve joint_curve(const std::string& file, const std::string& set);

/// Distribution of target errors, by nearest rank.
struct Quantiles {
  double median = 0.0, p90 = 0.0, largest = 0.0;
  bool operator==(const Quantiles&) const = default;
};
constexpr auto fields_of(const Quantiles*)
{
  return std::tuple{Field{"median", &Quantiles::median}, Field{"p90", &Quantiles::p90},
                    Field{"largest", &Quantiles::largest}};
}
struct TargetSummary {
  Quantiles mm, arc_min;
};
constexpr auto fields_of(const TargetSummary*)
{
  return std::tuple{Field{"mm", &TargetSummary::mm}, Field{"arc_min", &TargetSummary::arc_min}};
}
TargetSummary summary_of(std::span<const TargetError> errors);

}  // namespace vrda::calibration
