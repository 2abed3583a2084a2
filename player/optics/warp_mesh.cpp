#include "optics/warp_mesh.hpp"

#include <algorithm>
#include <cmath>

#include "core/error.hpp"

namespace vrda {
namespace {

struct Cells {
  int across = 1, down = 1;
};

Eigen::Vector2d node_px(const Viewport& visible, const Cells& cells, double i, double j)
{
  return {visible.x + visible.width * (i / cells.across), visible.y + visible.height * (j / cells.down)};
}

/// Largest distance between the place shown in the middle of a cell's edge or diagonal and the mean of its
/// ends.
double largest_error_px(const Eye& eye, const Cells& cells)
{
  const auto shown = [&](double i, double j) {
    return shown_px(eye.distortion, node_px(eye.visible, cells, i, j));
  };
  double largest = 0.0;
  for (int j = 0; j < cells.down; ++j) {
    for (int i = 0; i < cells.across; ++i) {
      const Eigen::Vector2d a = shown(i, j), b = shown(i + 1, j), c = shown(i, j + 1),
                            d = shown(i + 1, j + 1);
      largest = std::max({largest, (shown(i + 0.5, j) - 0.5 * (a + b)).norm(),
                          (shown(i, j + 0.5) - 0.5 * (a + c)).norm(),
                          (shown(i + 0.5, j + 0.5) - 0.5 * (a + d)).norm()});
    }
  }
  return largest;
}

Cells cells_for(const Eye& eye, double error_px)
{
  constexpr int most = 512;  // a pixel or two a cell
  const double shape = static_cast<double>(eye.visible.height) / eye.visible.width;
  const auto cells = [shape](int across) {
    return Cells{across, std::max(1, static_cast<int>(std::ceil(across * shape)))};
  };
  int across = 1;
  while (across < most && largest_error_px(eye, cells(across)) > error_px) across *= 2;
  return cells(across);
}

}  // namespace

WarpMesh warp_mesh(const Eye& eye, const ShownBox& box, double error_px)
{
  const Cells cells = cells_for(eye, error_px);
  const Eigen::Vector2d size_px = box.high_px - box.low_px;
  WarpMesh mesh;
  for (int j = 0; j <= cells.down; ++j) {
    for (int i = 0; i <= cells.across; ++i) {
      const Eigen::Vector2d drawn = node_px(eye.visible, cells, i, j);
      const Eigen::Vector2d uv = (shown_px(eye.distortion, drawn) - box.low_px).cwiseQuotient(size_px);
      mesh.vertices.push_back({static_cast<float>(drawn.x()), static_cast<float>(drawn.y()),
                               static_cast<float>(uv.x()), static_cast<float>(uv.y())});
    }
  }
  const auto n = static_cast<std::uint32_t>(cells.across + 1);
  for (std::uint32_t j = 0; j < static_cast<std::uint32_t>(cells.down); ++j) {
    for (std::uint32_t i = 0; i < static_cast<std::uint32_t>(cells.across); ++i) {
      const std::uint32_t a = j * n + i;
      // The diagonal runs from a to d, as largest_error_px looks at it.
      mesh.triangles.insert(mesh.triangles.end(), {a, a + n, a + n + 1, a, a + n + 1, a + 1});
    }
  }
  return mesh;
}

Eigen::Vector2d looked_up_px(const WarpMesh& mesh, const ShownBox& box, const Eigen::Vector2d& drawn_px)
{
  const auto at = [&](std::uint32_t k) {
    return Eigen::Vector2d(mesh.vertices[k].x_px, mesh.vertices[k].y_px);
  };
  for (std::size_t t = 0; t < mesh.triangles.size(); t += 3) {
    const std::uint32_t a = mesh.triangles[t], b = mesh.triangles[t + 1], c = mesh.triangles[t + 2];
    Eigen::Matrix2d edges;
    edges << at(b) - at(a), at(c) - at(a);
    const Eigen::Vector2d weight = edges.inverse() * (drawn_px - at(a));
    constexpr double rounding = 1e-9;
    if (weight.minCoeff() < -rounding || weight.sum() > 1.0 + rounding) continue;
    const auto uv = [&](std::uint32_t k) { return Eigen::Vector2d(mesh.vertices[k].u, mesh.vertices[k].v); };
    const Eigen::Vector2d found = uv(a) + weight.x() * (uv(b) - uv(a)) + weight.y() * (uv(c) - uv(a));
    return box.low_px + found.cwiseProduct(box.high_px - box.low_px);
  }
  throw InternalError("a place that is looked up lies in the visible part");
}

}  // namespace vrda
