// Names of coordinates in OpenSim tables.
#include "tables/motion_table.hpp"

namespace vrda::tables {

std::string coordinate_name(std::string_view column)
{
  constexpr std::string_view value = "/value";
  if (column.ends_with(value)) column.remove_suffix(value.size());
  const std::size_t slash = column.rfind('/');
  return std::string(slash == std::string_view::npos ? column : column.substr(slash + 1));
}

std::vector<std::string> with_opensim_names(std::vector<std::string> names, const std::string& coordinate)
{
  for (const char* joint : {"knee", "hip", "ankle", "subtalar", "joint"})
    for (const char* side : {"_r", "_l"}) names.push_back(joint + ("_" + coordinate) + side);
  return names;
}

}  // namespace vrda::tables
