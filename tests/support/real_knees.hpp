/// Location of the real knees; tests that need them are skipped if they are missing.
#pragma once

#include <filesystem>
#include <optional>

namespace vrda::test {

/// $VRDA_DATA, or ../shared/data of the checkout; nullopt if neither contains `knees`.
std::optional<std::filesystem::path> data_directory();

/// Root of the checkout.
std::filesystem::path source_directory();

}  // namespace vrda::test

/// Skips the running test if the real knees are missing.
#define VRDA_REQUIRE_REAL_KNEES()    \
  if (!vrda::test::data_directory()) \
  GTEST_SKIP() << "real knees not found: set VRDA_DATA to the folder that contains `knees` (see README)"
