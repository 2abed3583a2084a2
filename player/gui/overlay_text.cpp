#include "gui/overlay_text.hpp"

#include <imgui.h>

#include <cmath>

#include "core/error.hpp"
#include "gui/font_file.hpp"

namespace vrda {
namespace {

/// Two triangles with the same colour all over.
void add_quad(Overlay& overlay, const OverlayBox& box, const OverlayBox& uv, const VertexColour& colour)
{
  const auto first = static_cast<std::uint32_t>(overlay.vertices.size());
  overlay.vertices.push_back({box.left_px, box.top_px, uv.left_px, uv.top_px, colour});
  overlay.vertices.push_back({box.right_px, box.top_px, uv.right_px, uv.top_px, colour});
  overlay.vertices.push_back({box.right_px, box.bottom_px, uv.right_px, uv.bottom_px, colour});
  overlay.vertices.push_back({box.left_px, box.bottom_px, uv.left_px, uv.bottom_px, colour});
  for (const std::uint32_t corner : {0U, 1U, 2U, 0U, 2U, 3U}) overlay.indices.push_back(first + corner);
}

}  // namespace

struct OverlayText::Inner {
  ImFontAtlas atlas;
  const ImFont* face = nullptr;
  OverlayFont font;

  const ImFontGlyph& glyph(char character) const
  {
    const bool is_printable = character >= ' ' && character <= '~';
    const ImFontGlyph* const found = face->FindGlyph(static_cast<ImWchar>(is_printable ? character : '?'));
    check(found != nullptr, "the font has every printable character");
    return *found;
  }
};

OverlayText::OverlayText(double size_px) : inner_(std::make_unique<Inner>())
{
  std::string file = font_file();
  ImFontConfig config;
  config.FontDataOwnedByAtlas = false;
  config.OversampleH = 2;
  config.OversampleV = 1;
  const auto size = static_cast<float>(std::round(size_px));
  inner_->face =
      inner_->atlas.AddFontFromMemoryTTF(file.data(), static_cast<int>(file.size()), size, &config);
  unsigned char* coverage = nullptr;
  OverlayFont& font = inner_->font;
  inner_->atlas.GetTexDataAsAlpha8(&coverage, &font.width, &font.height);
  check(coverage != nullptr && inner_->face != nullptr, "the font gives an image");
  font.coverage.assign(coverage, coverage + static_cast<std::ptrdiff_t>(font.width) * font.height);
  inner_->atlas.ClearInputData();  // what points into `file`
}

OverlayText::~OverlayText() = default;

const OverlayFont& OverlayText::font() const
{
  return inner_->font;
}

float OverlayText::line_px() const
{
  return std::round(1.25F * inner_->face->FontSize);
}

float OverlayText::width_px(std::string_view words) const
{
  float width = 0.0F;
  for (const char character : words) width += inner_->glyph(character).AdvanceX;
  return width;
}

void OverlayText::add_words(Overlay& overlay, float left_px, float top_px, std::string_view words,
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

void empty_overlay(Overlay& overlay, int width, int height)
{
  overlay.vertices.clear();
  overlay.indices.clear();
  overlay.commands.clear();
  overlay.commands.push_back({{0.0F, 0.0F, static_cast<float>(width), static_cast<float>(height)}, 0, 0, 0});
}

void close_overlay(Overlay& overlay)
{
  overlay.commands.back().n_indices = static_cast<std::uint32_t>(overlay.indices.size());
}

}  // namespace vrda
