/// How a joint was scaled, in words and as JSON.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>

#include "load/case.hpp"

namespace vrda {

/// "scaled by 1.07 from the unscaled joint: uniform scaling keeps contact, the steps are shared", or that it
/// is a new run, and why. Empty without [scaling].
std::string scaling_line(const Case& job_case);

/// Null without scaling; landmarks are an empty list where the job gives the factor.
nlohmann::ordered_json scaling_json(const std::optional<Scaling>& scaling);

/// Prints scaling_json(): the factor, how well it is known, and a line a pair of landmarks. Nothing of null.
void print_scaling(const nlohmann::ordered_json& scaling);

}  // namespace vrda
