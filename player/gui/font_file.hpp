/// The font that travels in the program: DejaVu Sans.
#pragma once

#include <string_view>

namespace vrda {

/// The bytes of a TrueType file.
std::string_view font_file();

}  // namespace vrda
