/// Numbers as text.
#pragma once

#include <string>

namespace vrda {

/// `value` in the fewest digits that read back as the same double; -0 as 0, so that equal numbers give equal
/// text.
std::string shortest(double value);

}  // namespace vrda
