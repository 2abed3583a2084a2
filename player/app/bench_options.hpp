/// The options of `bench` and `devices`.
#pragma once

#include <optional>
#include <string>

#include "app/look.hpp"

namespace CLI {
class App;
}

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

CLI::App* add_bench(CLI::App& app, BenchOptions& options);
CLI::App* add_devices(CLI::App& app, DevicesOptions& options);

}  // namespace vrda
