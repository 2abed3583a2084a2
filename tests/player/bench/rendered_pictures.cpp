#include "player/bench/rendered_pictures.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>
#include <random>

#include "bench/body_sheet.hpp"

namespace vrda::test {
namespace {

using Grey = std::vector<double>;

constexpr double paper_grey = 215.0, ink_grey = 35.0, background_grey = 120.0, hand_grey = 150.0;

/// The ray (x, y, 1) that the lens maps to a pixel: fixed-point iteration of the distortion.
Eigen::Vector3d ray_at(const bench::Camera& camera, double x_px, double y_px)
{
  const auto& [k1, k2, p1, p2, k3] = camera.distortion;
  const double xd = (x_px - camera.centre_px.x()) / camera.focal_px.x(),
               yd = (y_px - camera.centre_px.y()) / camera.focal_px.y();
  double x = xd, y = yd;
  for (int n = 0; n < 8; ++n) {
    const double r2 = x * x + y * y, radial = 1.0 + r2 * (k1 + r2 * (k2 + r2 * k3));
    const double dx = 2.0 * p1 * x * y + p2 * (r2 + 2.0 * x * x),
                 dy = p1 * (r2 + 2.0 * y * y) + 2.0 * p2 * x * y;
    x = (xd - dx) / radial;
    y = (yd - dy) / radial;
  }
  return {x, y, 1.0};
}

/// A sheet's face: along it from the edge, and up.
struct Face {
  Pose X_face_camera;  ///< x along, y up, z outwards
  Eigen::Vector3d camera_face_mm;
  std::size_t body = 0;
  bool is_right = false;
};

std::vector<Face> faces_of(const RenderedPicture& picture)
{
  std::vector<Face> faces;
  const double half_rad = 0.5 * picture.fold_deg * std::numbers::pi / 180.0;
  for (std::size_t body = 0; body < picture.X_camera_body.size(); ++body) {
    for (const bool is_right : {false, true}) {
      const double sign = is_right ? 1.0 : -1.0;
      Pose X_body_face = Pose::Identity();
      const Eigen::Vector3d along(sign * std::sin(half_rad), 0.0, -std::cos(half_rad)),
          up = Eigen::Vector3d::UnitY();
      // Outwards on both faces.
      Eigen::Matrix3d axes;
      axes << along, up, sign * along.cross(up);
      X_body_face.linear() = axes;
      const Pose X_face_camera(
          Eigen::Isometry3d((picture.X_camera_body[body] * X_body_face).inverse(Eigen::Affine)));
      faces.push_back({X_face_camera, X_face_camera.translation(), body, is_right});
    }
  }
  return faces;
}

/// Brightness of a sheet's point; empty beside the sheet.
std::optional<double> sheet_grey(const Face& face, double s_mm, double y_mm,
                                 const std::vector<std::array<std::array<bool, 6>, 6>>& cells)
{
  if (s_mm < 0.0 || s_mm > 56.0 || std::abs(y_mm) > 52.0) return std::nullopt;
  const bool is_lower = y_mm < 0.0;
  // From the marker's upper left corner, as seen from outside.
  const double across = face.is_right ? s_mm - 8.0 : 48.0 - s_mm, down = (is_lower ? -4.0 : 44.0) - y_mm;
  if (across < 0.0 || across >= 40.0 || down < 0.0 || down >= 40.0) return paper_grey;
  const std::size_t marker = 4 * face.body + (is_lower ? 2 : 0) + (face.is_right ? 1 : 0);
  const auto cell = [](double mm) { return static_cast<std::size_t>(mm * 6.0 / 40.0); };
  return cells[marker][cell(down)][cell(across)] ? ink_grey : paper_grey;
}

void blur(Grey& grey, int width, int height, double sd_px)
{
  if (sd_px <= 0.0) return;
  const int reach = static_cast<int>(std::ceil(3.0 * sd_px));
  std::vector<double> weights;
  for (int k = -reach; k <= reach; ++k) weights.push_back(std::exp(-0.5 * k * k / (sd_px * sd_px)));
  double sum = 0.0;
  for (const double w : weights) sum += w;
  for (const bool is_across : {true, false}) {
    Grey out(grey.size());
    for (int y = 0; y < height; ++y) {
      for (int x = 0; x < width; ++x) {
        double value = 0.0;
        for (int k = -reach; k <= reach; ++k) {
          const int xx = std::clamp(is_across ? x + k : x, 0, width - 1),
                    yy = std::clamp(is_across ? y : y + k, 0, height - 1);
          value +=
              weights[static_cast<std::size_t>(k + reach)] * grey[static_cast<std::size_t>(yy * width + xx)];
        }
        out[static_cast<std::size_t>(y * width + x)] = value / sum;
      }
    }
    grey = std::move(out);
  }
}

bench::GreyPicture finished(const bench::Camera& camera, Grey grey, const RenderedPicture& picture)
{
  for (const Occluder& hand : picture.occluders) {
    for (int y = std::max(0, hand.y); y < std::min(camera.height, hand.y + hand.height); ++y) {
      for (int x = std::max(0, hand.x); x < std::min(camera.width, hand.x + hand.width); ++x)
        grey[static_cast<std::size_t>(y * camera.width + x)] = hand_grey;
    }
  }
  blur(grey, camera.width, camera.height, picture.blur_px);
  std::mt19937_64 random(picture.seed);
  std::normal_distribution<double> noise(0.0, picture.noise_grey);
  bench::GreyPicture out{camera.width, camera.height, {}};
  out.pixels.reserve(grey.size());
  for (const double value : grey)
    out.pixels.push_back(
        static_cast<std::uint8_t>(std::lround(std::clamp(value + noise(random), 0.0, 255.0))));
  return out;
}

/// Mean over 3 x 3 rays a pixel where `has_edges(ray)`, else one ray.
template <typename GreyOf, typename HasEdges>
Grey sampled(const bench::Camera& camera, GreyOf grey_of, HasEdges has_edges)
{
  Grey grey(static_cast<std::size_t>(camera.width * camera.height));
  for (int y = 0; y < camera.height; ++y) {
    for (int x = 0; x < camera.width; ++x) {
      double sum = 0.0;
      const int n = has_edges(ray_at(camera, x, y)) ? 3 : 1;
      for (int k = 0; k < n * n; ++k)
        sum += grey_of(ray_at(camera, x + (k % n + 0.5) / n - 0.5, y + (k / n + 0.5) / n - 0.5));
      grey[static_cast<std::size_t>(y * camera.width + x)] = sum / (n * n);
    }
  }
  return grey;
}

}  // namespace

bench::Camera webcam_camera()
{
  bench::Camera camera;
  camera.focal_px = {602.0, 604.5};
  camera.centre_px = {322.3, 236.1};
  camera.distortion = {-0.12, 0.05, 0.0008, -0.0005, 0.0};
  return camera;
}

bench::GreyPicture rendered(const bench::Camera& camera, const RenderedPicture& picture)
{
  const std::vector<Face> faces = faces_of(picture);
  std::vector<std::array<std::array<bool, 6>, 6>> cells;
  for (std::size_t id = 0; id < 4 * picture.X_camera_body.size(); ++id)
    cells.push_back(bench::marker_cells(id));
  const auto grey_of = [&](const Eigen::Vector3d& ray) {
    double nearest = 1e9, grey = background_grey + 40.0 * std::sin(9.0 * ray.x()) * std::cos(7.0 * ray.y());
    for (const Face& face : faces) {
      const Eigen::Vector3d direction = face.X_face_camera.linear() * ray;
      // Only the printed side is drawn.
      if (face.camera_face_mm.z() <= 0.0 || direction.z() >= 0.0) continue;
      const double depth = -face.camera_face_mm.z() / direction.z();
      if (depth >= nearest) continue;
      const Eigen::Vector3d p = face.camera_face_mm + depth * direction;
      if (const std::optional<double> hit = sheet_grey(face, p.x(), p.y(), cells)) {
        nearest = depth;
        grey = *hit;
      }
    }
    return grey;
  };
  // A sheet is within 100 mm of its body's origin.
  const auto is_near = [&](const Eigen::Vector3d& ray) {
    return std::ranges::any_of(picture.X_camera_body, [&](const Pose& X) {
      return X.translation().cross(ray.normalized()).norm() < 100.0;
    });
  };
  return finished(camera, sampled(camera, grey_of, is_near), picture);
}

bench::GreyPicture rendered_plane(const bench::Camera& camera, const Pose& X_camera_plane,
                                  const PlanePattern& pattern, const RenderedPicture& appearance)
{
  const Pose X_plane_camera = X_camera_plane.inverse();
  const Eigen::Vector3d from = X_plane_camera.translation();
  const auto grey_of = [&](const Eigen::Vector3d& ray) {
    const Eigen::Vector3d direction = X_plane_camera.linear() * ray;
    const double depth = -from.z() / direction.z();
    if (!(depth > 0.0)) return background_grey;
    const Eigen::Vector3d p = from + depth * direction;
    return pattern(p.x(), p.y());
  };
  return finished(camera, sampled(camera, grey_of, [](const Eigen::Vector3d&) { return true; }), appearance);
}

}  // namespace vrda::test
