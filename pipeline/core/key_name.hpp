/// The rule for names of the key of a sequence of frames ("time_s").
#pragma once

#include <string>

namespace vrda::inline core {

/// A lower-case letter, then at most 39 lower-case letters, digits and underscores.
bool is_key_name(const std::string& name);

}  // namespace vrda::inline core
