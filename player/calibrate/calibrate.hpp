/// Command `vrda-player calibrate`.
#pragma once

#include <cstdint>
#include <string>

#include "loop/loop.hpp"

namespace vrda::calibrate {

struct CalibrateOptions {
  std::string step;         ///< viewport, ..., all, bench, person; status; solve
  std::string bench;        ///< empty with is_virtual: built-in bench file
  std::string calibration;  ///< empty with is_virtual: not saved
  std::string bench_from;   ///< calibration file of another person; may be empty
  bool is_repeated = false;
  std::string model, set;  ///< for adjustment by eye and for pictures
  bool is_headless = false;
  std::string script;  ///< file with keys
  int samples = 1;     ///< samples a pixel
  bool is_virtual = false;
  std::uint64_t seed = 1;
  std::string head = "stage";  ///< or "tracker", in the built-in bench file
  int n_benches = 0;           ///< number of benches for statistics; 0: one bench with a report
  std::string pictures;        ///< folder; empty: no pictures
  bool has_json = false;
  bool is_quiet = false;
};

enum class CalibrateEnd {
  finished,
  quit  ///< quit before all requested parts were done; finished tasks are saved
};

/// Runs the command. Throws InputError for invalid options and files before it starts.
CalibrateEnd calibrate(const CalibrateOptions& options, const loop::Streams& streams);

}  // namespace vrda::calibrate
