/// Names of the sides of the body, as in job files, motion models and messages.
#pragma once

#include <string>

#include "model/frames.hpp"

namespace vrda::inline model {

/// "right" or "left".
inline std::string side_name(Side side)
{
  return side == Side::left ? "left" : "right";
}

/// The side of that name; right for any other text, which the readers of files refuse.
inline Side side_named(const std::string& name)
{
  return name == "left" ? Side::left : Side::right;
}

}  // namespace vrda::inline model
