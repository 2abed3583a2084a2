/// The exact kernel for triangles rounded by an offset: the moving triangle touches where its distance from
/// the reference becomes the sum r of both offsets. Seen from one object the set of contact positions is the
/// Minkowski difference of the triangles rounded by r, a convex body of shifted faces and parallelograms
/// (r along their normals), cylinders (a vertex and an edge) and spheres (two vertices). The travel is the
/// entry of the line along +Y into the first of them.
#pragma once

#include <algorithm>
#include <cmath>

#include "geometry/gap_kernel.hpp"

namespace vrda::geometry {

namespace rounded_rules {
/// Sine between edges below which they are parallel: their cylinders leave less than (1e-6 of an edge)^2 / r.
inline constexpr double parallel_sine = 1e-6;
/// Distance by which a triangle may be beyond the plane of a cylinder's or sphere's normal, mm: rounding.
inline constexpr double support_mm = 1e-9;
}  // namespace rounded_rules

struct Entry {
  double radius_mm = 0.0;
  Eigen::Vector3d direction = Eigen::Vector3d::UnitY();  ///< unit
};

/// Travel of the point `apart_mm` (moving minus reference) along a direction to the sphere about the origin,
/// or, with a unit `axis`, to the cylinder about it; infinite if it passes.
inline double entry_travel_mm(const Eigen::Vector3d& apart_mm, const Eigen::Vector3d& axis,
                              const Entry& entry)
{
  const double radius_mm = entry.radius_mm;
  const Eigen::Vector3d w = apart_mm - axis.dot(apart_mm) * axis;
  const Eigen::Vector3d y = entry.direction - axis.dot(entry.direction) * axis;
  const double yy = y.squaredNorm();
  if (yy < gap_rules::vertical_normal * gap_rules::vertical_normal) return gap_rules::infinity;
  const double to_nearest = -w.dot(y) / yy;
  // The nearest approach is computed as a vector: a difference of squares would lose half the digits.
  const double nearest_mm = (w + to_nearest * y).norm();
  if (nearest_mm > radius_mm) return gap_rules::infinity;
  return to_nearest - std::sqrt((radius_mm - nearest_mm) * (radius_mm + nearest_mm) / yy);
}

/// Unit normal of the plane spanned by two edges, directed down; zero where they are parallel or the plane is
/// vertical.
inline Eigen::Vector3d downward_normal(const Eigen::Vector3d& d, const Eigen::Vector3d& e)
{
  const Eigen::Vector3d n = d.cross(e);
  const double length = n.norm();
  if (!(length > rounded_rules::parallel_sine * d.norm() * e.norm())) return Eigen::Vector3d::Zero();
  if (std::abs(n.y()) < gap_rules::vertical_normal * length) return Eigen::Vector3d::Zero();
  return n / (n.y() < 0.0 ? length : -length);
}

/// Finds the candidates of a rounded pair. Parts that touch later than the limit are skipped.
class RoundedPair {
 public:
  RoundedPair(const GapFace& r, const GapFace& m, double offset_mm, double limit_mm = gap_rules::infinity)
      : r_(r), m_(m), offset_mm_(offset_mm), limit_mm_(limit_mm), has_limit_(std::isfinite(limit_mm))
  {
    for (unsigned k = 0; k < 3; ++k) {
      reference_edge_[k] = edge(r, k);
      moving_edge_[k] = edge(m, k);
    }
  }

  /// Calls `offer(candidate)` for every candidate from below, in any orientation; masked edges are skipped,
  /// and cylinders and spheres where another part of the pair touches first.
  template <typename Offer>
  void visit(const Offer& offer) const
  {
    visit_faces(offer);
    for (unsigned i = 0; i < 3; ++i) {
      for (unsigned k = 0; k < 3; ++k) {
        Eigen::Vector3d w = m_.corner[k] - r_.corner[i];
        if (has_limit_) w.y() += limit_mm_;
        if (has_edge(r_, i) && has_edge(m_, k) && !crosses_later(w, i, k)) visit_edges(i, k, offer);
        if (has_edge(r_, i) && has_vertex(m_, k) && !enters_later(w, reference_edge_[i]))
          visit_reference_edge(i, k, offer);
        if (has_edge(m_, k) && has_vertex(r_, i) && !enters_later(w, moving_edge_[k]))
          visit_moving_edge(i, k, offer);
        if (has_vertex(r_, i) && has_vertex(m_, k) && !enters_later(w)) visit_vertices(i, k, offer);
      }
    }
  }

 private:
  using Kind = ContactCandidate::Kind;

  static bool has_edge(const GapFace& face, unsigned k) { return (face.edges >> k & 1U) != 0; }
  // A vertex between edges that never touch first does not either.
  static bool has_vertex(const GapFace& face, unsigned k)
  {
    return has_edge(face, k) || has_edge(face, (k + 2) % 3);
  }
  static Eigen::Vector3d edge(const GapFace& face, unsigned k)
  {
    return face.corner[(k + 1) % 3] - face.corner[k];
  }

  // `w` is moving minus reference at the limit: whether the sphere, the cylinder about an edge or the plane
  // of two edges is still ahead.
  bool enters_later(const Eigen::Vector3d& w) const
  {
    return has_limit_ && w.y() < 0.0 && w.squaredNorm() > offset_mm_ * offset_mm_;
  }
  bool enters_later(const Eigen::Vector3d& w, const Eigen::Vector3d& axis) const
  {
    if (!has_limit_) return false;
    const double along = axis.dot(w), size_sq = axis.squaredNorm();
    return w.y() * size_sq < axis.y() * along &&
           w.squaredNorm() * size_sq - along * along > offset_mm_ * offset_mm_ * size_sq;
  }
  bool crosses_later(const Eigen::Vector3d& w, unsigned i, unsigned k) const
  {
    if (!has_limit_) return false;
    const Eigen::Vector3d n = reference_edge_[i].cross(moving_edge_[k]);
    const double apart = n.y() < 0.0 ? n.dot(w) : -n.dot(w);
    return apart > 0.0 && apart * apart > offset_mm_ * offset_mm_ * n.squaredNorm();
  }

  static GapFace shifted(GapFace face, double mm)
  {
    const Eigen::Vector3d n = downward_normal(edge(face, 0), face.corner[2] - face.corner[0]);
    for (Eigen::Vector3d& p : face.corner) p += mm * n;
    return face;
  }

  template <typename Offer>
  void visit_faces(const Offer& offer) const
  {
    double height = 0.0;
    if (!r_.is_vertical) {
      const GapFace r = shifted(r_, offset_mm_);
      for (unsigned k = 0; k < 3; ++k) {
        if (height_over(r, m_.corner[k], height))
          offer(ContactCandidate{Kind::moving_vertex, 0, k, 0.0, height - m_.corner[k].y()});
      }
    }
    if (!m_.is_vertical) {
      const GapFace m = shifted(m_, -offset_mm_);
      for (unsigned i = 0; i < 3; ++i) {
        if (height_over(m, r_.corner[i], height))
          offer(ContactCandidate{Kind::reference_vertex, i, 0, 0.0, r_.corner[i].y() - height});
      }
    }
  }

  template <typename Offer>
  void visit_edges(unsigned i, unsigned k, const Offer& offer) const
  {
    const Eigen::Vector3d n = downward_normal(reference_edge_[i], moving_edge_[k]);
    if (n.isZero(0.0)) return;
    GapFace r = r_;
    r.corner[i] += offset_mm_ * n;
    r.corner[(i + 1) % 3] += offset_mm_ * n;
    ContactCandidate candidate;
    if (edges_cross(r, i, m_, k, candidate)) offer(candidate);
  }

  template <typename Offer>
  void visit_reference_edge(unsigned i, unsigned k, const Offer& offer) const
  {
    const Eigen::Vector3d& d = reference_edge_[i];
    const double length = d.norm();
    if (!(length > 0.0)) return;
    const Eigen::Vector3d axis = d / length;
    const Eigen::Vector3d apart = m_.corner[k] - r_.corner[i];
    const double travel = entry_travel_mm(apart, axis, {offset_mm_});
    if (!std::isfinite(travel)) return;
    const Eigen::Vector3d w = apart + travel * Eigen::Vector3d::UnitY();
    const double along = axis.dot(w);
    if (along < 0.0 || along > length) return;
    if (is_first(w - along * axis, r_.corner[i], m_.corner[k]))
      offer(ContactCandidate{Kind::reference_edge, i, k, 0.0, travel});
  }

  template <typename Offer>
  void visit_moving_edge(unsigned i, unsigned k, const Offer& offer) const
  {
    const Eigen::Vector3d& e = moving_edge_[k];
    const double length = e.norm();
    if (!(length > 0.0)) return;
    const Eigen::Vector3d axis = e / length;
    const Eigen::Vector3d apart = m_.corner[k] - r_.corner[i];
    const double travel = entry_travel_mm(apart, axis, {offset_mm_});
    if (!std::isfinite(travel)) return;
    const Eigen::Vector3d w = apart + travel * Eigen::Vector3d::UnitY();
    const double along = -axis.dot(w);
    if (along < 0.0 || along > length) return;
    if (is_first(w + along * axis, r_.corner[i], m_.corner[k]))
      offer(ContactCandidate{Kind::moving_edge, i, k, along / length, travel});
  }

  template <typename Offer>
  void visit_vertices(unsigned i, unsigned k, const Offer& offer) const
  {
    const Eigen::Vector3d apart = m_.corner[k] - r_.corner[i];
    const double travel = entry_travel_mm(apart, Eigen::Vector3d::Zero(), {offset_mm_});
    if (!std::isfinite(travel)) return;
    if (is_first(apart + travel * Eigen::Vector3d::UnitY(), r_.corner[i], m_.corner[k]))
      offer(ContactCandidate{Kind::vertices, i, k, 0.0, travel});
  }

  // Whether no other part of the pair is nearer along the normal from `of_reference` to `of_moving`.
  bool is_first(const Eigen::Vector3d& normal, const Eigen::Vector3d& of_reference,
                const Eigen::Vector3d& of_moving) const
  {
    const double slack = rounded_rules::support_mm * offset_mm_;
    for (std::size_t k = 0; k < 3; ++k) {
      if (normal.dot(r_.corner[k] - of_reference) > slack) return false;
      if (normal.dot(m_.corner[k] - of_moving) < -slack) return false;
    }
    return true;
  }

  const GapFace &r_, &m_;
  double offset_mm_, limit_mm_;
  bool has_limit_;
  std::array<Eigen::Vector3d, 3> reference_edge_, moving_edge_;
};

/// First travel, signed, at which a pair in any orientation is at the offset, and the travel at which it has
/// passed; infinite and -infinite where it never is.
struct RoundedPassage {
  double enter_mm = gap_rules::infinity;
  double leave_mm = -gap_rules::infinity;
  /// Until it has passed, a pair within the offset has no travel left; infinite after that.
  double ahead_mm() const { return leave_mm < 0.0 ? gap_rules::infinity : std::max(enter_mm, 0.0); }
};

/// A pair that enters after `limit_mm` may count as one that never does.
inline RoundedPassage rounded_passage(const Corners& reference, const Corners& moving, double offset_mm,
                                      double limit_mm = gap_rules::infinity)
{
  const auto first_mm = [offset_mm](const Corners& r, const Corners& m, double limit) {
    const GapFace of_r = gap_face(r), of_m = gap_face(m);
    double least = gap_rules::infinity;
    RoundedPair(of_r, of_m, offset_mm, limit).visit([&least](const ContactCandidate& at) {
      least = std::min(least, at.travel_mm);
    });
    return least;
  };
  const auto upside_down = [](Corners t) {
    for (Eigen::Vector3d& p : t) p.y() = -p.y();
    return t;
  };
  const double enter_mm = first_mm(reference, moving, limit_mm);
  if (enter_mm >= 0.0) return {enter_mm, enter_mm};
  return {enter_mm, -first_mm(upside_down(reference), upside_down(moving), gap_rules::infinity)};
}

}  // namespace vrda::geometry
