/// The font that travels in the program, so that pictures need no file: DejaVu Sans, Latin-1.
#pragma once

#include <string_view>

namespace vrda {

/// The bytes of a TrueType file.
std::string_view picture_font();

}  // namespace vrda
