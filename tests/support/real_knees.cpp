#include "support/real_knees.hpp"

#include <cstdlib>

namespace vrda::test {

std::filesystem::path source_directory()
{
  return VRDA_SOURCE_DIR;
}

std::optional<std::filesystem::path> data_directory()
{
  const char* given = std::getenv("VRDA_DATA");
  const std::filesystem::path candidate = given != nullptr && *given != '\0'
                                              ? std::filesystem::path(given)
                                              : source_directory() / "../shared/data";
  if (std::filesystem::is_directory(candidate / "knees")) return std::filesystem::weakly_canonical(candidate);
  return std::nullopt;
}

}  // namespace vrda::test
