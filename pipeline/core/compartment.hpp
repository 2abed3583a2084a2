/// The two sides of a joint that are watched separately.
#pragma once

#include <cstdint>

namespace vrda {

enum class Compartment : std::int8_t { none = 0, medial = 1, lateral = 2 };

}  // namespace vrda
