/// The frames of a job: of the joint and of a body (schemas/frames.md).
#pragma once

#include "load/job.hpp"

namespace vrda::load {

/// The frame at a key of a validated job.
FrameJob frame_at(const documents::DocumentValue& root, const std::string& key);

/// The frame of "reference" or "moving"; absent if the body has none. Throws InputError for "auto" in another
/// joint than a knee, and for axes next to `align = "auto"`.
std::optional<FrameJob> body_frame_at(const documents::Document& document, const std::string& body);

/// Replaces "auto" in the document and in the body by what was found.
void set_found_frame(documents::Document& document, BodyJob& body, const FoundFrame& found);

}  // namespace vrda::load
