/// Pixels.
#pragma once

#include <cstdint>
#include <vector>

namespace vrda {

/// Top row first, rows without padding; sRGB with straight alpha.
struct Image {
  int width = 0;
  int height = 0;
  std::vector<std::uint8_t> rgba;  ///< [height * width * 4]
};

}  // namespace vrda
