/// The page, which travels inside the program.
#pragma once

#include <string_view>

namespace vrda {

/// One HTML file with all it needs, compressed by gzip.
std::string_view compressed_page();

}  // namespace vrda
