/// Whole files on their way out.
#pragma once

#include <string>

namespace vrda {

/// Writes `bytes` to `path`, over what is there. Throws InputError naming the file, and leaves no part of it.
void write_file(const std::string& path, const std::string& bytes);

/// Makes the folder and those above it. Throws InputError naming it.
void make_folder(const std::string& folder);

}  // namespace vrda
