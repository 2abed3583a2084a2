/// `origin = "auto"` and `align = "auto"` of a knee's bodies: the generic template registered onto their
/// bones.
#pragma once

#include <optional>

#include "job/component_loader.hpp"
#include "job/job.hpp"

namespace vrda::job {

struct AutoFrames {
  FoundFrames frames;
  std::vector<std::string> warnings;  ///< a side that the bones contradict, short bones
};

/// Absent if no frame of the job is "auto". The mesh files of both bodies must show the bones in one pose.
/// Numbers are rounded to 1e-7 degrees and 1e-6 mm, so that a job with these numbers is the same job.
/// Throws InputError naming the key for bones that are not those of one knee.
std::optional<AutoFrames> auto_frames(const Job& job, ComponentLoader& source);

/// The frame of the joint or of a body (schemas/frames.md) at a key of a validated job.
FrameJob frame_at(const core::DocumentValue& root, const std::string& key);

/// The frame of "reference" or "moving"; absent if the body has none. Throws InputError for "auto" in another
/// joint than a knee, and for axes next to `align = "auto"`.
std::optional<FrameJob> body_frame_at(const core::Document& document, const std::string& body);

/// Replaces "auto" in the document and in the body by what was found.
void set_found_frame(core::Document& document, BodyJob& body, const FoundFrame& found);

}  // namespace vrda::job
