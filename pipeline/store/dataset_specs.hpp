/// Rows of the layouts' tables, by the kinds that return in them.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "store/layout.hpp"

namespace vrda {

using Dimensions = std::vector<std::string>;

inline const Dimensions& grid_dimensions()
{
  static const Dimensions dimensions{"/flexion", "/varus"};
  return dimensions;
}

inline DatasetSpec numbers(const std::string& path, ValueKind kind, Dimensions dimensions, const char* units,
                           const char* long_name)
{
  return {path, kind, std::move(dimensions), units, long_name, false, FlagSet::none};
}

/// Numbers that are NaN where there is no answer.
inline DatasetSpec answers(const std::string& path, Dimensions dimensions, const char* units,
                           const char* long_name)
{
  return {path, ValueKind::float64, std::move(dimensions), units, long_name, true, FlagSet::none};
}

/// A surface over the grid: NaN where a cell has no answer.
inline DatasetSpec surface(const std::string& path, const char* units, const char* long_name)
{
  return answers(path, grid_dimensions(), units, long_name);
}

inline DatasetSpec codes(const std::string& path, Dimensions dimensions, FlagSet flags, const char* long_name)
{
  return {path, ValueKind::int8, std::move(dimensions), "", long_name, false, flags};
}

inline DatasetSpec flag_surface(const std::string& path, FlagSet flags, const char* long_name)
{
  return codes(path, grid_dimensions(), flags, long_name);
}

}  // namespace vrda
