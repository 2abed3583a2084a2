#include "view/viewport.hpp"

#include <algorithm>

#include "core/error.hpp"

namespace vrda::view {

const std::vector<std::string>& layout_names()
{
  static const std::vector<std::string> names{"quarters", "side-by-side", "top-bottom", "two-outputs"};
  return names;
}

std::optional<Layout> layout_named(const std::string& name)
{
  const std::vector<std::string>& names = layout_names();
  const auto found = std::ranges::find(names, name);
  if (found == names.end()) return std::nullopt;
  return static_cast<Layout>(found - names.begin());
}

namespace {

/// 640 x 480, or all of a smaller quarter, centred in the quarter with corner (x, y): the part of the
/// thesis's 640 x 512 that NTSC displays.
Viewport in_quarter(int x, int y, int width, int height)
{
  constexpr int most_width = 640, most_height = 480;
  const int w = std::min(width, most_width), h = std::min(height, most_height);
  return {x + (width - w) / 2, y + (height - h) / 2, w, h};
}

}  // namespace

EyeWindows eye_windows(Layout layout, int width, int height, const std::string& file)
{
  if (width < 2 || height < 2) {
    throw InputError({file, "display.size", std::to_string(width) + "x" + std::to_string(height),
                      "at least 2 pixels each way"});
  }
  const int w = width / 2, h = height / 2;
  switch (layout) {
    case Layout::quarters:
      return {in_quarter(width - w, 0, w, h), in_quarter(width - w, height - h, w, h)};
    case Layout::top_bottom:
      return {{0, 0, width, h}, {0, height - h, width, h}};
    case Layout::side_by_side:
    case Layout::two_outputs:
      break;
  }
  return {{0, 0, w, height}, {width - w, 0, w, height}};
}

Eigen::Vector2f reflected_px(const Reflection& reflection, const Viewport& window, const Eigen::Vector2f& at)
{
  const Eigen::Vector2f across(static_cast<float>(2 * window.x + window.width),
                               static_cast<float>(2 * window.y + window.height));
  return {reflection.is_mirrored ? across.x() - at.x() : at.x(),
          reflection.is_flipped ? across.y() - at.y() : at.y()};
}

Viewport within(const Viewport& inner, const Viewport& outer)
{
  const int left = std::max(inner.x, outer.x), top = std::max(inner.y, outer.y);
  const int right = std::min(inner.x + inner.width, outer.x + outer.width);
  const int bottom = std::min(inner.y + inner.height, outer.y + outer.height);
  if (right <= left || bottom <= top) return {};
  return {left, top, right - left, bottom - top};
}

Eigen::Vector2d middle_px(const Viewport& v)
{
  return {v.x + 0.5 * v.width, v.y + 0.5 * v.height};
}

}  // namespace vrda::view
