/// Small files that may not be there.
#pragma once

#include <optional>
#include <string>

namespace vrda {

/// The whole content; nothing where the file cannot be opened.
std::optional<std::string> text_of_file(const std::string& path);

}  // namespace vrda
