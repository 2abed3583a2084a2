/// The data of a GapTree: exact triangles and the trees of either role.
#pragma once

#include <mutex>
#include <vector>

#include "geometry/gap_query.hpp"
#include "geometry/gap_walk.hpp"

namespace vrda::geometry {

/// Input of the exact kernel for one triangle.
struct ExactFace {
  Corners corner;
  double doubled_area = 0.0;
  double least_projected = 0.0;  // of PairBatch
  double offset_mm = 0.0;
};

/// Trees are built on first use of a role, because most meshes have one role only.
struct GapTree::Data {
  GapSurface surface;
  std::vector<ExactFace> faces;
  std::vector<std::int32_t> up;    // rows of the faces directed up
  std::vector<unsigned> up_edges;  // [n_triangles] edges that can touch first, of faces directed up
  double radius_mm = 0.0;          // largest distance of a vertex from the origin
  double offset_mm = 0.0;          // largest of a triangle

  const ReferenceTree& as_reference() const
  {
    std::call_once(reference_once_, [this] { reference_ = reference_tree(surface); });
    return reference_;
  }
  const MovingTree& as_moving(GapKind kind) const
  {
    if (kind == GapKind::signed_facing) {
      std::call_once(up_once_, [this] { up_tree_ = moving_tree(surface, up); });
      return up_tree_;
    }
    std::call_once(all_once_, [this] { all_tree_ = moving_tree(surface, surface.triangles); });
    return all_tree_;
  }

 private:
  mutable std::once_flag reference_once_, up_once_, all_once_;
  mutable ReferenceTree reference_;
  mutable MovingTree up_tree_, all_tree_;
};

}  // namespace vrda::geometry
