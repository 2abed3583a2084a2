/// The font that travels in the program: DejaVu Sans.
#pragma once

#include <string>
#include <string_view>

namespace vrda {

/// As the program carries it: gzip, half as large.
std::string_view compressed_font_file();

/// The bytes of a TrueType file.
std::string font_file();

}  // namespace vrda
