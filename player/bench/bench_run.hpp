/// Commands `vrda-player bench`, `serve`, `devices` and `simulate`: show a joint on the tracked leg, send it
/// to other programs, list the devices, simulate them. In: motion model, bench file, calibration. Out: the
/// displayed frames, recordings, pictures. Throw InputError before anything is shown if a file or device
/// setting cannot be used.
#pragma once

#include "bench/body_tracker.hpp"
#include "bench/calibration_file.hpp"
#include "bench/joint_stream.hpp"
#include "bench/recording.hpp"
#include "view/player_state.hpp"

namespace vrda::bench {

struct BenchOptions {
  std::string file;         ///< motion model
  std::string bench;        ///< bench file; empty with a replay, which contains it
  std::string calibration;  ///< empty: nominal
  std::string set;          ///< surface set; empty: the default one
  view::AppearanceOptions look;
  int samples = 4;  ///< per pixel
  bool is_headless = false;
  std::string pictures;  ///< folder; empty: no pictures
  int every = 1;         ///< saves every n-th frame
  std::string video;
  std::optional<double> seconds;  ///< duration; empty: until the user quits
  std::string record, replay, timing;
  double from_s = 0.0;
  std::optional<double> speed;    ///< of a replay; default 1 in a window, else unpaced
  std::optional<bool> has_panel;  ///< operator's panel; default only in a window
  IgtlOptions igtl;
  bool is_quiet = false;
};

struct DevicesOptions {
  std::string bench;
  double seconds = 2.0;
  bool has_json = false;
};

/// Runs the bench from its devices or from a recording. Throws InputError for invalid options and files
/// before it starts. Device failures during the run are shown and do not end it.
void run_bench(const BenchOptions& options, const show::Streams& streams);

/// Plays the recording `options.replay`. Throws InputError for invalid options and files.
void replay_bench(const BenchOptions& options, const show::Streams& streams);

/// Lists the devices with link state, rate and last values. Returns the number of devices that do not answer.
int list_devices(const DevicesOptions& options, const show::Streams& streams);

/// Passes device samples to `take` for `seconds` or until a stop signal.
void receive_samples(Devices& devices, double seconds, show::StopSignals& stop,
                     const std::function<void(const Sample&)>& take);

/// Validated inputs of a bench run.
struct BenchSetup {
  store::MotionModel model;
  store::Motion motion;
  SolverFrame frame;  ///< solver frame of the model at the first flexion
  BenchFile bench;
  Calibration calibration;
  RecordingFacts facts;  ///< header of a new recording
};

/// A file of --calibration that does not exist: an error, or nominal values where the command can write it.
enum class MissingCalibration { is_refused, is_nominal };

/// Reads the files of the options. Throws InputError.
BenchSetup read_bench_setup(const BenchOptions& options,
                            MissingCalibration missing = MissingCalibration::is_refused);

/// Setup of a recording. The motion model of the options must be the recorded one. Throws InputError.
BenchSetup recorded_setup(RecordingFacts facts, const BenchOptions& options);

struct ServeOptions {
  std::string file;         ///< motion model
  std::string set;          ///< surface set; empty: the default one
  std::string bench;        ///< bench file: the tracked leg; empty: the motion, bent to and fro
  std::string calibration;  ///< of the bench; empty: nominal
  IgtlOptions igtl;
  double rate_hz = 60.0;
  std::optional<double> flexion_deg;  ///< held; empty: to and fro over the whole range
  std::optional<double> varus_deg;    ///< empty: balanced
  double period_s = 8.0;              ///< of a bend and a stretch
  std::optional<double> seconds;      ///< empty: until Ctrl-C
  bool is_quiet = false;
};

/// Sends the joint by OpenIGTLink, without a picture. Throws InputError for invalid options and files.
void serve(const ServeOptions& options, const show::Streams& streams);

struct SimulateOptions {
  std::string bench;
  std::string model;     ///< motion model for theta and the tibia's translation; may be empty
  std::string address;   ///< empty: the bench file's address
  std::string rehearse;  ///< calibration file that is followed (calibration/operator.hpp); may be empty
  std::optional<double> seconds;  ///< empty: until Ctrl-C
  bool is_quiet = false;
};

/// Simulates tracker and board as described in [simulation] of the bench file. Throws InputError.
void simulate(const SimulateOptions& options, const show::Streams& streams);

// The tracked joint as messages for browsers (schemas/live.md). In: motion model, bench file, calibration.
// Out: one JSON text per moment, complete in itself. Device failures are marks in the messages.

class LiveBench {
 public:
  /// Uses file, bench, calibration and set of the options, and connects to the devices. Throws InputError.
  explicit LiveBench(const BenchOptions& options);

  /// What stays the same: title, set, scale, points to touch.
  std::string greeting() const;
  /// Processes all samples that have arrived; never waits.
  std::string next();
  double interval_s() const;

 private:
  BenchSetup setup_;
  BenchState state_;
  Devices devices_;
  std::uint64_t n_messages_ = 0;
};

/// The message of a frame. `error_message`: of the tracker's link; may be empty.
std::string live_message(const BenchFrame& frame, std::uint64_t number, const std::string& error_message);

// Keys of the bench (thesis 7.2), which select and change parameters of the displayed joint and of the
// calibration. In: a key press. Out: the changed BenchState and a request to the loop. Texts show degrees
// and mm.

/// Request of a key to the loop.
enum class BenchRequest {
  none,
  zero_stage,         ///< the stage is at its stop
  write_calibration,  ///< with the current values of all saved parameters
  screenshot,
  show_panel,  ///< toggle
  show_help,   ///< toggle
  close_help,
  quit
};

/// Applies a key to `state` and returns the remaining request.
BenchRequest apply_key(BenchState& state, const view::KeyPress& press);

/// Help lines of the keys, for the help page and the command line.
std::span<const view::HelpLine> bench_key_lines();

/// "flexion 35.5 deg"; "left.k1 0.021".
std::string parameter_text(const BenchState& state, std::size_t parameter);

// The bench's state at any frame of a recording.

/// Playing on gives the frames of the session, bit by bit. A jump replays the last `run_up` frames before the
/// target; of earlier frames it applies only what lasts: keys, board, pointer and links, and the last poses
/// of each tool. Clocks, filters and predictors have forgotten the rest by then.
class ReplayState {
 public:
  static constexpr std::size_t run_up = 7200;  ///< two minutes at 60 frames a second

  /// Both must outlive the state.
  ReplayState(const BenchSetup& setup, RecordingReader& recording);
  /// Frame `n`.
  const BenchFrame& at(std::size_t n);
  BenchState& state() { return *state_; }

 private:
  void begin();
  void skip_to(std::size_t n);
  void take_next();

  const BenchSetup& setup_;
  RecordingReader& recording_;
  std::optional<BenchState> state_;
  const BenchFrame* frame_ = nullptr;
  std::size_t n_taken_ = 0;
};

// Motion of the tracked bodies in a recording, and the error that prediction would have had on it. Poses
// take points of the tool to the tracker's frame, mm; times are ns of the local clock. An unseen body gives
// an empty list.

/// Collects the poses of all bodies from the frames of a recording, in order, up to a bound.
class MotionCollector {
 public:
  static constexpr std::size_t most_poses = 36'000;  ///< 10 minutes at 60 Hz; 5 MB a body

  explicit MotionCollector(const BenchFile& bench) : bodies_(bench) {}
  /// The next frame of the recording.
  void take(const RecordedFrame& frame);
  bool is_full() const;
  /// Poses with their device times mapped to the local clock. Ends the last message.
  const std::vector<TimedPose>& motion(BodyRole role);

 private:
  void end_message(BodyRole role);

  TrackedBodies bodies_;
  ByRole<std::vector<TimedPose>> motions_;
};

struct BodyPrediction {
  BodyRole role = BodyRole::leg;
  double horizon_ms = 0.0;
  PosePredictionError error;
};

/// Prediction errors of every body, 16, 33 and 50 ms ahead.
std::vector<BodyPrediction> predictions_of(MotionCollector& collector);

/// One line each: error of the held and of the predicted pose.
std::string prediction_text(const std::vector<BodyPrediction>& predictions);

}  // namespace vrda::bench
