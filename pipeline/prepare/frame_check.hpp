/// Whether a job's frame, side and unit agree with its bones.
#pragma once

#include <string>
#include <vector>

#include "job/case.hpp"

namespace vrda::prepare {

/// The job's keys of the frames of both bodies.
struct FrameKeys {
  std::string reference = "frame";
  std::string moving = "frame";
};

/// Compares a knee's frame, side and unit with those of the generic template registered onto its bones. Empty
/// if they agree, or if the bones differ too much from the template (in flexion, for example), or if one is
/// missing. Each warning begins with the keys that it is about.
std::vector<std::string> frame_warnings(const job::Case& knee, const FrameKeys& keys = {});

}  // namespace vrda::prepare
