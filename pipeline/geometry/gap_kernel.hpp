/// The exact kernel of the directional gap: every point where two triangles can touch as one travels along
/// +Y. Over the overlap of their projections the height difference is linear, so its minimum is at a vertex
/// of one over the face of the other or where two projected edges cross. All queries that
/// must agree to the last bit use this arithmetic.
#pragma once

#include <algorithm>
#include <cmath>
#include <limits>

#include "geometry/gap_blocks.hpp"
#include "geometry/placement.hpp"

namespace vrda::geometry {

namespace gap_rules {
inline constexpr double infinity = std::numeric_limits<double>::infinity();
/// |n_y| of the unit normal below which a face is vertical: its projection is a sliver without a height.
inline constexpr double vertical_normal = 1e-6;
/// Barycentric slack: a vertex over a shared edge must belong to at least one of the two faces.
inline constexpr double edge_slack = 1e-12;
/// Sine between projected edges below which their crossing is ignored: vertices over faces cover it.
inline constexpr double parallel_sine = 1e-12;
/// Below this sine both heights are taken at one common point: the crossing has an error of rounding / sine.
inline constexpr double oblique_sine = 1e-6;
}  // namespace gap_rules

/// y component of (b - a) x (c - a): twice the signed area of the projection.
inline double projected_area(const Eigen::Vector3d& a, const Eigen::Vector3d& b, const Eigen::Vector3d& c)
{
  return (b.z() - a.z()) * (c.x() - a.x()) - (b.x() - a.x()) * (c.z() - a.z());
}

/// Input of the kernel: a triangle in S.
struct GapFace {
  Corners corner;
  double projected = 0.0;  ///< twice the projected area, signed as the normal's y
  bool is_vertical = true;
  unsigned edges = 7;  ///< bit i: the edge from corner i to the next can touch first

  bool faces_up() const { return !is_vertical && projected > 0.0; }
  bool faces_down() const { return !is_vertical && projected < 0.0; }
};

inline double doubled_area(const Corners& t)
{
  return (t[1] - t[0]).cross(t[2] - t[0]).norm();
}

/// Doubled projected area below which a triangle is too steep or too narrow for PairBatch, where the rounding
/// of its heights or of points over it could exceed the slack.
inline double least_screened_area(const Corners& t)
{
  constexpr double steep = 1e-3, narrow = 1e-6;
  const double edge_sq =
      std::max({(t[1] - t[0]).squaredNorm(), (t[2] - t[1]).squaredNorm(), (t[0] - t[2]).squaredNorm()});
  return std::max(steep * doubled_area(t), narrow * edge_sq);
}

inline GapFace gap_face(const Corners& t, double doubled)
{
  GapFace face{t};
  face.projected = projected_area(t[0], t[1], t[2]);
  face.is_vertical = !(std::abs(face.projected) >= gap_rules::vertical_normal * doubled) || doubled == 0.0;
  return face;
}

inline GapFace gap_face(const Corners& t)
{
  return gap_face(t, doubled_area(t));
}

/// Height of the face over p's projection; false if p is not over the face.
inline bool height_over(const GapFace& face, const Eigen::Vector3d& p, double& height)
{
  const Corners& c = face.corner;
  // Most points fail at the first or second edge, so divisions come last.
  const double sign = face.projected < 0.0 ? -1.0 : 1.0;
  const double least = -gap_rules::edge_slack * std::abs(face.projected);
  const double u = projected_area(p, c[1], c[2]);
  if (sign * u < least) return false;
  const double v = projected_area(c[0], p, c[2]);
  if (sign * v < least) return false;
  const double w = projected_area(c[0], c[1], p);
  if (sign * w < least) return false;
  height = u / face.projected * c[0].y() + v / face.projected * c[1].y() + w / face.projected * c[2].y();
  return true;
}

/// A point where the pair can touch.
struct ContactCandidate {
  using Kind = ContactKind;
  Kind kind = Kind::moving_vertex;
  unsigned reference = 0;     ///< corner, or first corner of the edge
  unsigned moving = 0;        ///< likewise
  double along_moving = 0.0;  ///< edges, moving_edge: parameter 0 to 1 on the moving edge
  double travel_mm = 0.0;     ///< signed
};

/// Crossing of the projected edges from corner i of r and k of m; false if they do not cross.
inline bool edges_cross(const GapFace& r, unsigned i, const GapFace& m, unsigned k,
                        ContactCandidate& candidate)
{
  const Eigen::Vector3d& a = r.corner[i];
  const Eigen::Vector3d d = r.corner[(i + 1) % 3] - a;
  const Eigen::Vector3d& b = m.corner[k];
  const Eigen::Vector3d e = m.corner[(k + 1) % 3] - b;
  const double cross = d.x() * e.z() - d.z() * e.x();
  const double scale = (std::abs(d.x()) + std::abs(d.z())) * (std::abs(e.x()) + std::abs(e.z()));
  if (std::abs(cross) <= gap_rules::parallel_sine * scale) return false;
  const double wx = b.x() - a.x(), wz = b.z() - a.z();
  constexpr double low = -gap_rules::edge_slack, high = 1.0 + gap_rules::edge_slack;
  // Most edges do not cross, so divisions come last.
  const double sign = cross < 0.0 ? -1.0 : 1.0, size = std::abs(cross);
  const double across = wx * e.z() - wz * e.x();
  if (sign * across < low * size || sign * across > high * size) return false;
  const double along = wx * d.z() - wz * d.x();
  if (sign * along < low * size || sign * along > high * size) return false;
  const double s = across / cross;
  double t = along / cross;
  if (std::abs(cross) <= gap_rules::oblique_sine * scale) {
    t = ((s * d.x() - wx) * e.x() + (s * d.z() - wz) * e.z()) / (e.x() * e.x() + e.z() * e.z());
    if (t < low || t > high) return false;
  }
  candidate = {ContactCandidate::Kind::edges, i, k, t, (a.y() + s * d.y()) - (b.y() + t * e.y())};
  return true;
}

/// Calls `offer(candidate)` for every candidate of the pair in any orientation; masked edges are skipped.
/// `wanted`: bits as of PlacedPairs::candidates.
template <typename Offer>
void visit_contact_candidates(const GapFace& r, const GapFace& m, const Offer& offer,
                              unsigned wanted = all_candidates)
{
  const auto is_wanted = [wanted](unsigned bit) { return (wanted >> bit & 1U) != 0; };
  double height = 0.0;
  for (unsigned k = 0; k < 3 && !r.is_vertical; ++k) {
    if (is_wanted(k) && height_over(r, m.corner[k], height)) {
      offer(ContactCandidate{ContactCandidate::Kind::moving_vertex, 0, k, 0.0, height - m.corner[k].y()});
    }
  }
  for (unsigned i = 0; i < 3 && !m.is_vertical; ++i) {
    if (is_wanted(3 + i) && height_over(m, r.corner[i], height)) {
      offer(ContactCandidate{ContactCandidate::Kind::reference_vertex, i, 0, 0.0, r.corner[i].y() - height});
    }
  }
  for (unsigned i = 0; i < 3; ++i) {
    if ((r.edges >> i & 1U) == 0) continue;
    for (unsigned k = 0; k < 3; ++k) {
      ContactCandidate candidate;
      if (is_wanted(6 + 3 * i + k) && (m.edges >> k & 1U) != 0 && edges_cross(r, i, m, k, candidate))
        offer(candidate);
    }
  }
}

}  // namespace vrda::geometry
