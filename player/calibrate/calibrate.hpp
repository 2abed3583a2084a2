/// The mode `calibrate`.
#pragma once

#include <cstdint>
#include <string>

#include "loop/loop.hpp"

namespace vrda {

struct CalibrateOptions {
  std::string step;         ///< viewport, ..., all, bench, person; status; solve
  std::string bench;        ///< empty with is_virtual: the virtual bench's own
  std::string calibration;  ///< empty with is_virtual: nothing is kept
  std::string bench_from;   ///< calibration of another person; empty: none
  bool is_anew = false;
  std::string model, set;  ///< for places that are adjusted by eye, and pictures
  bool is_headless = false;
  std::string script;  ///< keys from a file
  int samples = 1;     ///< a pixel
  bool is_virtual = false;
  std::uint64_t seed = 1;
  std::string head = "stage";  ///< or "tracker": of the virtual bench's own bench file
  int n_benches = 0;           ///< 0: one, in full
  std::string pictures;        ///< folder; empty: none
  bool has_json = false;
  bool is_quiet = false;
};

enum class CalibrateEnd {
  finished,
  left  ///< before all that was asked for is done; the file holds what is
};

/// Throws InputError for everything a user can put right before it begins.
CalibrateEnd calibrate(const CalibrateOptions& options, const Streams& streams);

}  // namespace vrda
