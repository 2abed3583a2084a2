#include "core/canvas.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/text.hpp"

#define STB_TRUETYPE_IMPLEMENTATION
#define STBTT_STATIC
#include <stb/stb_truetype.h>
#define STB_IMAGE_WRITE_IMPLEMENTATION
#define STB_IMAGE_WRITE_STATIC
#include <stb/stb_image_write.h>

namespace vrda::inline core {
namespace {

constexpr int fineness = 2;              // samples per pixel along each axis
constexpr float hidden_share = 0.4F;     // opacity of a hidden line
constexpr double depth_tolerance = 0.5;  // px: a line on a surface is visible

std::vector<int> latin_letters(std::string_view utf8)
{
  std::vector<int> letters;
  for (std::size_t i = 0; i < utf8.size(); ++i) {
    const auto byte = static_cast<unsigned char>(utf8[i]);
    const bool is_continued = (byte & 0xC0U) == 0x80U;
    const bool is_latin_pair = (byte == 0xC2U || byte == 0xC3U) && i + 1 < utf8.size();
    if (byte < 0x80U) {
      letters.push_back(byte);
    } else if (is_latin_pair) {
      letters.push_back(
          static_cast<int>((byte & 0x03U) << 6U | (static_cast<unsigned char>(utf8[++i]) & 0x3FU)));
    } else if (!is_continued) {
      letters.push_back('?');
    }
  }
  return letters;
}

const stbtt_fontinfo& font()
{
  static const stbtt_fontinfo loaded = [] {
    stbtt_fontinfo info{};
    const auto* bytes = reinterpret_cast<const unsigned char*>(picture_font().data());
    check(stbtt_InitFont(&info, bytes, 0) != 0, "the embedded font is valid");
    return info;
  }();
  return loaded;
}

double text_width(const std::vector<int>& letters, double scale)
{
  double width = 0.0;
  for (const int letter : letters) {
    int advance = 0, bearing = 0;
    stbtt_GetCodepointHMetrics(&font(), letter, &advance, &bearing);
    width += scale * advance;
  }
  return width;
}

double turn(const Eigen::Vector3d& a, const Eigen::Vector3d& b, double x, double y)
{
  return (b.x() - a.x()) * (y - a.y()) - (b.y() - a.y()) * (x - a.x());
}

void append_bytes(void* text, void* bytes, int n)
{
  static_cast<std::string*>(text)->append(static_cast<const char*>(bytes), static_cast<std::size_t>(n));
}

}  // namespace

Canvas::Canvas(int width_px, int height_px)
    : width_(fineness * width_px),
      height_(fineness * height_px),
      columns_{0, width_ - 1},
      rows_{0, height_ - 1},
      colour_(static_cast<std::size_t>(width_) * static_cast<std::size_t>(height_), Colour::Ones()),
      depth_(colour_.size(), -std::numeric_limits<float>::infinity())
{
}

Canvas::Samples Canvas::samples(double least, double largest, const Samples& within)
{
  const double first = within.first, last = within.last;
  return {static_cast<int>(std::clamp(std::floor(least), first, last + 1.0)),
          static_cast<int>(std::clamp(std::ceil(largest), first - 1.0, last))};
}

void Canvas::set_clip(const Eigen::Vector2d& upper_left_px, const Eigen::Vector2d& lower_right_px)
{
  const Eigen::Vector2d first = fineness * upper_left_px, last = fineness * lower_right_px;
  columns_ = samples(first.x(), last.x(), {0, width_ - 1});
  rows_ = samples(first.y(), last.y(), {0, height_ - 1});
}

std::size_t Canvas::index(int x, int y) const
{
  return static_cast<std::size_t>(y) * static_cast<std::size_t>(width_) + static_cast<std::size_t>(x);
}

void Canvas::blend(int x, int y, const Colour& colour, float share)
{
  Colour& old = colour_[index(x, y)];
  old += share * (colour - old);
}

void Canvas::draw_triangle(const std::array<Eigen::Vector3d, 3>& corners_px, const Colour& colour)
{
  const Eigen::Vector3d a = fineness * corners_px[0], b = fineness * corners_px[1],
                        c = fineness * corners_px[2];
  const double area = turn(a, b, c.x(), c.y());
  if (area == 0.0) return;
  const Samples columns = samples(std::min({a.x(), b.x(), c.x()}), std::max({a.x(), b.x(), c.x()}), columns_);
  const Samples rows = samples(std::min({a.y(), b.y(), c.y()}), std::max({a.y(), b.y(), c.y()}), rows_);
  for (int y = rows.first; y <= rows.last; ++y) {
    for (int x = columns.first; x <= columns.last; ++x) {
      const double of_a = turn(b, c, x, y) / area, of_b = turn(c, a, x, y) / area;
      const double of_c = 1.0 - of_a - of_b;
      if (of_a < 0.0 || of_b < 0.0 || of_c < 0.0) continue;
      const auto z = static_cast<float>(of_a * a.z() + of_b * b.z() + of_c * c.z());
      if (z <= depth_[index(x, y)]) continue;
      depth_[index(x, y)] = z;
      colour_[index(x, y)] = colour;
    }
  }
}

void Canvas::draw_line(const Eigen::Vector3d& from_px, const Eigen::Vector3d& to_px, double width_px,
                       const Colour& colour)
{
  const Eigen::Vector3d a = fineness * from_px, b = fineness * to_px;
  const double half = 0.5 * fineness * width_px;
  const Eigen::Vector2d along = (b - a).head<2>();
  const double length_sq = std::max(along.squaredNorm(), 1e-12);
  const Samples columns = samples(std::min(a.x(), b.x()) - half, std::max(a.x(), b.x()) + half, columns_);
  const Samples rows = samples(std::min(a.y(), b.y()) - half, std::max(a.y(), b.y()) + half, rows_);
  for (int y = rows.first; y <= rows.last; ++y) {
    for (int x = columns.first; x <= columns.last; ++x) {
      const Eigen::Vector2d arm(x - a.x(), y - a.y());
      const double share = std::clamp(arm.dot(along) / length_sq, 0.0, 1.0);
      if ((arm - share * along).norm() > half) continue;
      const double z = a.z() + share * (b.z() - a.z());
      const bool is_hidden = z < static_cast<double>(depth_[index(x, y)]) - depth_tolerance;
      blend(x, y, colour, is_hidden ? hidden_share : 1.0F);
    }
  }
}

void Canvas::draw_disc(const Eigen::Vector2d& centre_px, double radius_px, const Colour& colour)
{
  const Eigen::Vector2d centre = fineness * centre_px;
  const double radius = fineness * radius_px;
  const Samples columns = samples(centre.x() - radius, centre.x() + radius, columns_);
  const Samples rows = samples(centre.y() - radius, centre.y() + radius, rows_);
  for (int y = rows.first; y <= rows.last; ++y) {
    for (int x = columns.first; x <= columns.last; ++x) {
      if ((Eigen::Vector2d(x, y) - centre).norm() <= radius) blend(x, y, colour, 1.0F);
    }
  }
}

void Canvas::draw_text(const Eigen::Vector2d& at_px, double height_px, std::string_view utf8, TextAlign align,
                       const Colour& colour)
{
  const std::vector<int> letters = latin_letters(utf8);
  const float scale = stbtt_ScaleForPixelHeight(&font(), static_cast<float>(fineness * height_px));
  const double shift = align == TextAlign::left ? 0.0 : align == TextAlign::centre ? 0.5 : 1.0;
  const double width = text_width(letters, static_cast<double>(scale));
  double x = std::min(fineness * at_px.x() - shift * width, columns_.last - width);
  x = std::max(x, static_cast<double>(columns_.first));
  const int baseline = static_cast<int>(std::lround(fineness * at_px.y()));
  for (const int letter : letters) {
    int left = 0, top = 0, right = 0, bottom = 0, advance = 0, bearing = 0;
    stbtt_GetCodepointHMetrics(&font(), letter, &advance, &bearing);
    stbtt_GetCodepointBitmapBox(&font(), letter, scale, scale, &left, &top, &right, &bottom);
    const int columns = right - left, rows = bottom - top;
    std::vector<unsigned char> cover(static_cast<std::size_t>(columns) * static_cast<std::size_t>(rows));
    stbtt_MakeCodepointBitmap(&font(), cover.data(), columns, rows, columns, scale, scale, letter);
    for (int k = 0; k < columns * rows; ++k) {
      const int column = static_cast<int>(std::lround(x)) + left + k % columns;
      const int row = baseline + top + k / columns;
      if (column < 0 || column >= width_ || row < 0 || row >= height_) continue;
      blend(column, row, colour, static_cast<float>(cover[static_cast<std::size_t>(k)]) / 255.0F);
    }
    x += static_cast<double>(scale) * advance;
  }
}

std::string Canvas::png() const
{
  std::vector<unsigned char> rgb;
  for (int y = 0; y < height_; y += fineness) {
    for (int x = 0; x < width_; x += fineness) {
      Colour sum = Colour::Zero();
      for (int k = 0; k < fineness * fineness; ++k) sum += colour_[index(x + k % fineness, y + k / fineness)];
      for (const float part : sum)
        rgb.push_back(static_cast<unsigned char>(std::lround(255.0F * part / (fineness * fineness))));
    }
  }
  std::string bytes;
  const int width = width_ / fineness;
  check(
      stbi_write_png_to_func(append_bytes, &bytes, width, height_ / fineness, 3, rgb.data(), 3 * width) != 0,
      "the image is encoded as PNG");
  return bytes;
}

}  // namespace vrda::inline core
