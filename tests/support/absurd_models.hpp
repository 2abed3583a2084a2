/// HDF5 files that promise more than they hold.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace vrda::test {

/// Made of the motion model `whole` in `folder`: one of a thousand million vertices, one of more contacts than
/// an index can tell apart, and a file of some kilobytes with one dataset of 80 GB. None of it is stored.
std::vector<std::string> models_that_promise_gigabytes(const std::filesystem::path& whole,
                                                       const std::filesystem::path& folder);

}  // namespace vrda::test
