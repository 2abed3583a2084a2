/// A raster image: triangles with a depth buffer, and lines, discs and text over them.
#pragma once

#include <Eigen/Core>
#include <array>
#include <string>
#include <string_view>
#include <vector>

namespace vrda::inline core {

using Colour = Eigen::Vector3f;  ///< red, green, blue from 0 to 1, sRGB

enum class TextAlign { left, centre, right };

/// Coordinates in pixels from the upper left, x to the right, y down; larger z is nearer.
class Canvas {
 public:
  Canvas(int width_px, int height_px);

  /// Triangles, lines and discs are drawn inside this rectangle only; at first the whole image.
  void set_clip(const Eigen::Vector2d& upper_left_px, const Eigen::Vector2d& lower_right_px);

  void draw_triangle(const std::array<Eigen::Vector3d, 3>& corners_px, const Colour& colour);
  /// Parts hidden by triangles are drawn translucent.
  void draw_line(const Eigen::Vector3d& from_px, const Eigen::Vector3d& to_px, double width_px,
                 const Colour& colour);
  /// Without depth test.
  void draw_disc(const Eigen::Vector2d& centre_px, double radius_px, const Colour& colour);
  /// One line without depth test, baseline at `at_px`, moved sideways into the clip rectangle if it would
  /// leave it. Characters outside Latin-1 become question marks.
  void draw_text(const Eigen::Vector2d& at_px, double height_px, std::string_view utf8, TextAlign align,
                 const Colour& colour);

  /// 8-bit RGB; deterministic.
  std::string png() const;

 private:
  // Range of samples along one axis.
  struct Samples {
    int first, last;
  };
  static Samples samples(double least, double largest, const Samples& within);
  void blend(int x, int y, const Colour& colour, float share);
  std::size_t index(int x, int y) const;

  int width_, height_;      // of the supersampled raster that png() averages
  Samples columns_, rows_;  // that triangles, lines and discs may draw
  std::vector<Colour> colour_;
  std::vector<float> depth_;
};

/// The bytes of a TrueType file.
std::string_view picture_font();

}  // namespace vrda::inline core
