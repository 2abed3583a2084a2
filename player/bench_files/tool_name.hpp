/// Names of tracker tools in a bench file.
#pragma once

#include <string>
#include <vector>

namespace vrda::documents {
struct Document;
}

namespace vrda::bench_files {

/// Length of the device name field of an OpenIGTLink message, bytes.
inline constexpr std::size_t longest_tool_name = 20;

/// Read one name or a list of names. Throw InputError with file and key if a name is longer.
std::string tool_name(const documents::Document& document, const std::string& key);
std::vector<std::string> tool_names(const documents::Document& document, const std::string& key);

}  // namespace vrda::bench_files
