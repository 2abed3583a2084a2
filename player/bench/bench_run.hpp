/// Commands `vrda-player bench`, `serve`, `devices` and `simulate`: show a joint on the tracked leg, send it
/// to other programs, list the devices, simulate them. In: motion model, bench file, calibration. Out: the
/// displayed frames, recordings, pictures. Throw InputError before anything is shown if a file or device
/// setting cannot be used.
#pragma once

#include <functional>
#include <optional>
#include <string>

#include "bench/joint_stream.hpp"
#include "bench/calibration.hpp"
#include "bench/devices.hpp"
#include "show/loop.hpp"
#include "store/poses.hpp"
#include "view/appearance.hpp"
#include "bench/recording.hpp"
#include "store/motion_model.hpp"

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
void receive_samples(bench::Devices& devices, double seconds, show::StopSignals& stop,
                     const std::function<void(const bench::Sample&)>& take);

/// Validated inputs of a bench run.
struct BenchSetup {
  store::MotionModel model;
  store::Motion motion;
  SolverFrame frame;  ///< solver frame of the model at the first flexion
  bench::BenchFile bench;
  bench::Calibration calibration;
  bench::RecordingFacts facts;  ///< header of a new recording
};

/// A file of --calibration that does not exist: an error, or nominal values where the command can write it.
enum class MissingCalibration { is_refused, is_nominal };

/// Reads the files of the options. Throws InputError.
BenchSetup read_bench_setup(const BenchOptions& options,
                            MissingCalibration missing = MissingCalibration::is_refused);

/// Setup of a recording. The motion model of the options must be the recorded one. Throws InputError.
BenchSetup recorded_setup(const bench::Recording& recording, const BenchOptions& options);

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
  std::string rehearse;  ///< calibration file that is followed (calibrate/rehearsal.hpp); may be empty
  std::optional<double> seconds;  ///< empty: until Ctrl-C
  bool is_quiet = false;
};

/// Simulates tracker and board as described in [simulation] of the bench file. Throws InputError.
void simulate(const SimulateOptions& options, const show::Streams& streams);

}  // namespace vrda::bench
