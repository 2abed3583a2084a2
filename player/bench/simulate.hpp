/// The mode `simulate`.
#pragma once

#include <optional>
#include <string>

#include "loop/loop.hpp"

namespace vrda {

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
