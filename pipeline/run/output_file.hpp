/// Folders for outputs.
#pragma once

#include <string>

namespace vrda {

/// Makes the folder and those above it. Throws InputError naming it.
void make_folder(const std::string& folder);

}  // namespace vrda
