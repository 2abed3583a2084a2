/// Where the real knees are; tests that need them skip by name when they are absent.
#pragma once

#include <filesystem>
#include <optional>

namespace vrda::test {

/// $VRDA_DATA, or ../shared/data beside the checkout; nothing when neither holds `knees`.
std::optional<std::filesystem::path> data_directory();

/// The checkout's own folder.
std::filesystem::path source_directory();

}  // namespace vrda::test

/// Skips the running test, by name, when the real knees are absent.
#define VRDA_REQUIRE_REAL_KNEES()    \
  if (!vrda::test::data_directory()) \
  GTEST_SKIP() << "real knees not found: set VRDA_DATA to the folder that holds `knees` (see README)"
