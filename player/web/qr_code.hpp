/// QR codes for terminals.
#pragma once

#include <string>

namespace vrda::web {

/// Lines of half blocks (UTF-8), light modules drawn: readable on dark terminals, and by most phones on light
/// ones. Two module rows per line, with the border of four modules that ISO/IEC 18004 requires.
std::string qr_code_text(const std::string& content);

}  // namespace vrda::web
