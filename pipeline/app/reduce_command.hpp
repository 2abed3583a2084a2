/// `vrda reduce`: the flexion-only motion of a motion model, added to its file and printed.
#pragma once

#include <string>

#include "talk/talk.hpp"

namespace vrda {

struct ReduceOptions {
  std::string file;
  std::string set = "raw";  ///< whose poses: one of set_names, but zero_varus
  bool as_json = false;
};

/// Replaces a zero-varus motion that the file holds, and drops the audit of the old one where poses differ.
/// Throws InputError for a joint without compartments whose varus was given, for a set that the file does not
/// hold, and where no flexion can be reduced; the file is untouched then.
ExitCode reduce_command(const ReduceOptions& options);

}  // namespace vrda
