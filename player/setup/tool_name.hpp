/// Names of a tracker's tools in a bench file.
#pragma once

#include <string>
#include <vector>

namespace vrda {

struct Document;

/// OpenIGTLink's messages hold so many bytes of a name: no tool that they tell of has a longer one.
inline constexpr std::size_t longest_tool_name = 20;

/// Of a checked bench file's key. Throw InputError naming file and key where a name is longer.
std::string tool_name(const Document& document, const std::string& key);
std::vector<std::string> tool_names(const Document& document, const std::string& key);

}  // namespace vrda
