/// Names of a tracker's tools in a bench file.
#pragma once

#include <string>
#include <vector>

namespace vrda {

class SettingsTable;

/// OpenIGTLink's messages hold so many bytes of a name: no tool that they tell of has a longer one.
inline constexpr std::size_t longest_tool_name = 20;

/// Of the key `name`. Throw InputError naming file and key where one is longer.
std::string tool_name(const SettingsTable& table, const char* name);
std::string tool_name_or(const SettingsTable& table, const char* name, const std::string& otherwise);
std::vector<std::string> tool_names(const SettingsTable& table, const char* name);

}  // namespace vrda
