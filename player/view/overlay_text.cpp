#include "view/overlay_text.hpp"

#include <imgui.h>
#include <zlib.h>

#include <algorithm>
#include <cmath>

#include "core/text.hpp"

namespace vrda::view {
namespace {

/// Uncompressed size: the last four bytes of a gzip file, little-endian.
std::size_t content_size(std::string_view gzip)
{
  std::size_t size = 0;
  for (std::size_t i = 1; i <= 4; ++i) size = size << 8 | static_cast<unsigned char>(gzip[gzip.size() - i]);
  return size;
}

std::string font_file()
{
  const std::string_view gzip = compressed_font_file();
  std::string file(content_size(gzip), '\0');
  z_stream stream{};
  // zlib only reads its input, but the pointer is not const.
  stream.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(gzip.data()));
  stream.avail_in = static_cast<uInt>(gzip.size());
  stream.next_out = reinterpret_cast<Bytef*>(file.data());
  stream.avail_out = static_cast<uInt>(file.size());
  constexpr int gzip_window = 15 + 16;  // the largest window, with a gzip header
  check(inflateInit2(&stream, gzip_window) == Z_OK, "zlib starts");
  const int ended = inflate(&stream, Z_FINISH);
  inflateEnd(&stream);
  check(ended == Z_STREAM_END && stream.avail_out == 0, "the embedded font is complete");
  return file;
}

/// Two triangles of one colour.
void add_quad(Overlay& overlay, const OverlayBox& box, const OverlayBox& uv, const VertexColour& colour)
{
  const auto first = static_cast<std::uint32_t>(overlay.vertices.size());
  overlay.vertices.push_back({box.left_px, box.top_px, uv.left_px, uv.top_px, colour});
  overlay.vertices.push_back({box.right_px, box.top_px, uv.right_px, uv.top_px, colour});
  overlay.vertices.push_back({box.right_px, box.bottom_px, uv.right_px, uv.bottom_px, colour});
  overlay.vertices.push_back({box.left_px, box.bottom_px, uv.left_px, uv.bottom_px, colour});
  for (const std::uint32_t corner : {0U, 1U, 2U, 0U, 2U, 3U}) overlay.indices.push_back(first + corner);
}

/// Mitre vector at point `k`: its component normal to both adjacent segments is 1.
Eigen::Vector2d across(std::span<const Eigen::Vector2d> points_px, std::size_t k)
{
  const auto normal = [&](std::size_t first) {
    const Eigen::Vector2d segment = points_px[first + 1] - points_px[first];
    const double length = segment.norm();
    return length > 0.0 ? Eigen::Vector2d(-segment.y() / length, segment.x() / length)
                        : Eigen::Vector2d::Zero();
  };
  const std::size_t last = points_px.size() - 1;
  const Eigen::Vector2d before = normal(k == 0 ? 0 : k - 1), after = normal(k == last ? last - 1 : k);
  const Eigen::Vector2d sum = before + after;
  // |sum|^2 / 2 is 1 + the cosine of the turning angle; 0.5 at 120 degrees.
  return sum / std::max(0.5, 0.5 * sum.squaredNorm());
}

}  // namespace

OverlayFont built_font(ImFontAtlas& atlas, double size_px)
{
  std::string file = font_file();
  ImFontConfig config;
  config.FontDataOwnedByAtlas = false;
  config.OversampleH = 2;
  config.OversampleV = 1;
  const auto size = static_cast<float>(std::round(size_px));
  atlas.AddFontFromMemoryTTF(file.data(), static_cast<int>(file.size()), size, &config);
  unsigned char* coverage = nullptr;
  OverlayFont font;
  atlas.GetTexDataAsAlpha8(&coverage, &font.width, &font.height);
  check(coverage != nullptr, "the font has been rasterised");
  font.coverage.assign(coverage, coverage + static_cast<std::ptrdiff_t>(font.width) * font.height);
  atlas.ClearInputData();  // it points into `file`
  return font;
}

struct OverlayText::Inner {
  explicit Inner(double size_px) : font(built_font(atlas, size_px)) {}

  ImFontAtlas atlas;
  OverlayFont font;

  const ImFont& face() const { return *atlas.Fonts[0]; }
  const ImFontGlyph& glyph(char character) const
  {
    const bool is_printable = character >= ' ' && character <= '~';
    const ImFontGlyph* const found = face().FindGlyph(static_cast<ImWchar>(is_printable ? character : '?'));
    check(found != nullptr, "the font has all printable ASCII characters");
    return *found;
  }
};

OverlayText::OverlayText(double size_px) : inner_(std::make_unique<Inner>(size_px)) {}

OverlayText::~OverlayText() = default;

const OverlayFont& OverlayText::font() const
{
  return inner_->font;
}

float OverlayText::line_px() const
{
  return std::round(1.25F * inner_->face().FontSize);
}

float OverlayText::width_px(std::string_view words) const
{
  float width = 0.0F;
  for (const char character : words) width += inner_->glyph(character).AdvanceX;
  return width;
}

std::string OverlayText::fitted(std::string words, float width_px) const
{
  while (words.size() > 1 && this->width_px(words) > width_px) {
    words.resize(words.size() - 1);
    words.back() = '.';
  }
  return words;
}

OverlayBox overlay_box(const Viewport& v)
{
  return {static_cast<float>(v.x), static_cast<float>(v.y), static_cast<float>(v.x + v.width),
          static_cast<float>(v.y + v.height)};
}

void OverlayText::add_text(Overlay& overlay, float left_px, float top_px, std::string_view words,
                           const VertexColour& colour) const
{
  float x = std::round(left_px);
  const float y = std::round(top_px);
  for (const char character : words) {
    const ImFontGlyph& glyph = inner_->glyph(character);
    if (glyph.Visible != 0U) {
      add_quad(overlay, {x + glyph.X0, y + glyph.Y0, x + glyph.X1, y + glyph.Y1},
               {glyph.U0, glyph.V0, glyph.U1, glyph.V1}, colour);
    }
    x += glyph.AdvanceX;
  }
}

void OverlayText::add_area(Overlay& overlay, const OverlayBox& box, const VertexColour& colour) const
{
  const ImVec2 white = inner_->atlas.TexUvWhitePixel;
  add_quad(overlay, box, {white.x, white.y, white.x, white.y}, colour);
}

void OverlayText::add_line(Overlay& overlay, std::span<const Eigen::Vector2d> points_px, double width_px,
                           const VertexColour& colour) const
{
  check(points_px.size() > 1, "a line has at least two points");
  const ImVec2 white = inner_->atlas.TexUvWhitePixel;
  // Coverage falls from 1 to 0 over one pixel at each edge; lines narrower than a pixel are fainter instead.
  const double inner_px = std::max(0.0, 0.5 * (width_px - 1.0)), outer_px = inner_px + 1.0;
  const double covered = std::min(1.0, width_px);
  VertexColour solid = colour, clear = colour;
  solid[3] = static_cast<std::uint8_t>(std::lround(covered * colour[3]));
  clear[3] = 0;
  const std::array<std::pair<double, const VertexColour*>, 4> rows{
      {{-outer_px, &clear}, {-inner_px, &solid}, {inner_px, &solid}, {outer_px, &clear}}};
  const auto first = static_cast<std::uint32_t>(overlay.vertices.size());
  for (std::size_t k = 0; k < points_px.size(); ++k) {
    const Eigen::Vector2d n = across(points_px, k);
    for (const auto& [offset_px, tint] : rows) {
      const Eigen::Vector2f at = (points_px[k] + offset_px * n).cast<float>();
      overlay.vertices.push_back({at.x(), at.y(), white.x, white.y, *tint});
    }
  }
  for (std::uint32_t k = 0; k + 1 < points_px.size(); ++k) {
    for (std::uint32_t row = 0; row < 3; ++row) {
      const std::uint32_t a = first + 4 * k + row;
      for (const std::uint32_t corner : {a, a + 1, a + 5, a, a + 5, a + 4}) overlay.indices.push_back(corner);
    }
  }
}

void clear_overlay(Overlay& overlay, int width, int height)
{
  overlay.vertices.clear();
  overlay.indices.clear();
  overlay.commands.clear();
  overlay.commands.push_back({{0.0F, 0.0F, static_cast<float>(width), static_cast<float>(height)}, 0, 0, 0});
}

void clip_overlay(Overlay& overlay, const OverlayBox& box)
{
  finish_overlay(overlay);
  const auto n = static_cast<std::uint32_t>(overlay.indices.size());
  overlay.commands.push_back({{box.left_px, box.top_px, box.right_px, box.bottom_px}, n, 0, 0});
}

void finish_overlay(Overlay& overlay)
{
  OverlayCommand& last = overlay.commands.back();
  last.n_indices = static_cast<std::uint32_t>(overlay.indices.size()) - last.first_index;
}

namespace {

bool contains(const Viewport& window, const Eigen::Vector2f& at)
{
  return at.x() > static_cast<float>(window.x) && at.x() < static_cast<float>(window.x + window.width) &&
         at.y() > static_cast<float>(window.y) && at.y() < static_cast<float>(window.y + window.height);
}

bool contains(const Viewport& window, const std::array<float, 4>& box)
{
  return box[0] >= static_cast<float>(window.x) && box[1] >= static_cast<float>(window.y) &&
         box[2] <= static_cast<float>(window.x + window.width) &&
         box[3] <= static_cast<float>(window.y + window.height);
}

}  // namespace

void OverlayReflector::reflect(Overlay& overlay)
{
  if (reflection_ == Reflection{}) return;
  is_done_.assign(overlay.vertices.size(), false);
  for (const Viewport& window : windows_) {
    for (std::size_t k = 0; k + 2 < overlay.indices.size(); k += 3) {
      const std::span<const std::uint32_t> corners = std::span(overlay.indices).subspan(k, 3);
      Eigen::Vector2f sum = Eigen::Vector2f::Zero();
      bool is_done = false;
      for (const std::uint32_t corner : corners) {
        sum += Eigen::Vector2f(overlay.vertices[corner].x_px, overlay.vertices[corner].y_px);
        is_done = is_done || is_done_[corner];
      }
      if (!is_done && !contains(window, sum / 3.0F)) continue;
      for (const std::uint32_t corner : corners) {
        if (is_done_[corner]) continue;
        OverlayVertex& vertex = overlay.vertices[corner];
        const Eigen::Vector2f at = reflected_px(reflection_, window, {vertex.x_px, vertex.y_px});
        vertex.x_px = at.x();
        vertex.y_px = at.y();
        is_done_[corner] = true;
      }
    }
    for (OverlayCommand& command : overlay.commands) {
      std::array<float, 4>& box = command.clip_px;
      if (!contains(window, box)) continue;
      const Eigen::Vector2f a = reflected_px(reflection_, window, {box[0], box[1]});
      const Eigen::Vector2f b = reflected_px(reflection_, window, {box[2], box[3]});
      box = {std::min(a.x(), b.x()), std::min(a.y(), b.y()), std::max(a.x(), b.x()), std::max(a.y(), b.y())};
    }
  }
}

}  // namespace vrda::view
