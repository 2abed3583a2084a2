/// `origin = "auto"` and `align = "auto"` of a knee's bodies: the generic template registered onto their
/// bones.
#pragma once

#include <optional>

#include "load/component_loader.hpp"

namespace vrda::load {

struct AutoFrames {
  FoundFrames frames;
  std::vector<std::string> warnings;  ///< a side that the bones contradict, short bones
};

/// Absent if no frame of the job is "auto". The mesh files of both bodies must show the bones in one pose.
/// Numbers are rounded to 1e-7 degrees and 1e-6 mm, so that a job with these numbers is the same job.
/// Throws InputError naming the key for bones that are not those of one knee.
std::optional<AutoFrames> auto_frames(const Job& job, ComponentLoader& source);

}  // namespace vrda::load
