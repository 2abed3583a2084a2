/// The one place that decides what is said about a job: `check`, `run` and the commands like it print these
/// warnings, and /job/warnings of the motion model holds them.
#pragma once

#include <cstdint>
#include <string>

#include "job/case.hpp"

namespace vrda::run {

/// How the moving object starts at the first flexion.
struct InitialContact {
  bool is_overlapping = false;
  double travel_mm = 0.0;   ///< along Delta to the first contact; infinite with nothing ahead
  double substep_mm = 0.0;  ///< of solve::Joint
};

struct CheckedCase {
  job::Case job_case;  ///< `warnings` has every warning about the job
  InitialContact initial;
};

/// load_case(), whose warnings (load/case_warnings.hpp) come first; then the initial pose, triangles that
/// intersect each other, and unit, side and frame by registration. They depend on the job and its files only.
/// Cost beside load_case(): 20 ms for the generic knee, 0.3 s for bones of 40,000 triangles. Mesh files of
/// together at least `large_bytes` are announced on standard error.
CheckedCase load_checked_case(const job::Job& job, const std::string& data_directory,
                              std::uintmax_t large_bytes = 50'000'000);

}  // namespace vrda::run
