/// The modes `bench`, `devices` and `simulate`.
#pragma once

#include <functional>
#include <optional>
#include <string>

#include "devices/devices.hpp"
#include "loop/loop.hpp"
#include "motion/poses.hpp"
#include "recording/recording.hpp"
#include "setup/calibration.hpp"
#include "store/motion_model.hpp"
#include "view/look.hpp"

namespace vrda {

struct BenchOptions {
  std::string file;         ///< motion model
  std::string bench;        ///< empty with a replay: that of the recording
  std::string calibration;  ///< empty: nominal
  std::string set;          ///< empty: what is shown first
  LookOptions look;
  int samples = 1;
  bool is_headless = false;
  std::string pictures;  ///< folder; empty: none
  int every = 1;         ///< one of so many pictures
  std::string video;
  std::optional<double> seconds;  ///< to run; without, until the user ends it
  std::string record, replay, timing;
  double from_s = 0.0;
  std::optional<double> speed;    ///< of a replay; default 1 in a window, else as fast as it goes
  std::optional<bool> has_panel;  ///< the operator's; default in a window only
  bool is_quiet = false;
};

struct DevicesOptions {
  std::string bench;
  double seconds = 2.0;
  bool has_json = false;
};

/// Drives the bench from its devices, or from a recording. Throws InputError for everything a user can put
/// right before it runs; while it runs a device that fails is shown as such and never ends it.
void run_bench(const BenchOptions& options, const Streams& streams);

/// Shows the recording `options.replay`. Throws InputError for everything a user can put right.
void replay_bench(const BenchOptions& options, const Streams& streams);

/// Lists the devices: whether each answers, its rate, its last values. Returns how many do not answer.
int list_devices(const DevicesOptions& options, const Streams& streams);

/// Hands on what the devices say for so long, or until a signal comes.
void listen(Devices& devices, double seconds, StopSignals& stop,
            const std::function<void(const Sample&)>& take);

/// What `bench` starts from, read and checked.
struct BenchSetup {
  MotionModel model;
  Motion motion;
  SolverFrame frame;  ///< of the model's first flexion
  BenchFile bench;
  Calibration calibration;
  RecordingFacts facts;  ///< to record with
};

/// From the files that the options name. Throws InputError.
BenchSetup read_bench_setup(const BenchOptions& options);

/// As `recording` was made, but for the motion model, which is read again and has to be the same file.
BenchSetup setup_of(const Recording& recording, const BenchOptions& options);

/// The mode `simulate`.
struct SimulateOptions {
  std::string bench;
  std::string model;              ///< motion model that theta and the tibia's place come from; empty: none
  std::string address;            ///< empty: the bench file's
  std::optional<double> seconds;  ///< until Ctrl-C without
  bool is_quiet = false;
};

/// Stands in for the bench's tracker and board, as its [simulation] says. Throws InputError.
void simulate(const SimulateOptions& options, const Streams& streams);

}  // namespace vrda
