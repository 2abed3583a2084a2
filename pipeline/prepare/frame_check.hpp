/// Whether a job's frame, side and unit agree with its bones.
#pragma once

#include <string>
#include <vector>

#include "load/case.hpp"

namespace vrda::prepare {

/// Compares a knee's frame, side and unit with those of the generic template registered onto its bones. Empty
/// if they agree, or if the bones are too unlike the template to tell (in flexion, say), or not both are
/// there.
std::vector<std::string> frame_warnings(const load::Case& knee);

}  // namespace vrda::prepare
