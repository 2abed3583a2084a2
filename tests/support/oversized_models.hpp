/// HDF5 files that declare more data than they contain.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace vrda::test {

/// Made from the motion model `whole` in `folder`: one with a thousand million vertices, one with more
/// contacts than an index can address, and a file of some kilobytes with one dataset of 80 GB. None of
/// these data are stored.
std::vector<std::string> models_that_promise_gigabytes(const std::filesystem::path& whole,
                                                       const std::filesystem::path& folder);

}  // namespace vrda::test
