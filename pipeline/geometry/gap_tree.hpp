/// Precomputed data of a mesh for directional gap queries: neighbours of its faces across flat or reflex
/// edges, and trees of eight-lane blocks over its triangles (one triangle a lane in a leaf) for either role.
#pragma once

#include <array>
#include <bit>
#include <cstdint>
#include <mutex>
#include <vector>

#include "geometry/gap_blocks.hpp"
#include "geometry/gap_kernel.hpp"
#include "geometry/gap_query.hpp"
#include "model/mesh.hpp"

namespace vrda::geometry {

/// An edge can touch first if it is convex by more than rounding, a boundary, or not shared by exactly two
/// consistently wound faces. Across a flat or reflex edge between two included faces the height difference is
/// concave: it is never smaller on the edge than around it.
struct GapSurface {
  Mesh mesh;
  std::vector<std::int32_t> triangles;  ///< rows included, ascending
  /// [n_triangles of mesh] face across the edge from corner i to the next, where that edge is flat or reflex;
  /// -1 where it can touch first.
  std::vector<std::array<std::int32_t, 3>> neighbours;
  Points face_normals;  ///< [n_triangles, 3] unit; zero for a degenerate face
};

/// The surface consists of the listed faces: an edge to any other face is a boundary.
GapSurface gap_surface(const Mesh& mesh, std::vector<std::int32_t> triangles);

/// Bit i: the edge from corner i of `triangle` can touch first if only faces with `counts[row]` are included.
unsigned first_contact_edges(const GapSurface& surface, std::int32_t triangle,
                             const std::vector<bool>& counts);

/// Children of a block: blocks, or rows of triangles in a leaf; -1 for an unused lane. Blocks are in
/// depth-first order, the root first.
struct Block {
  std::array<std::int32_t, block_lanes> child{};
  std::int32_t height = 0;   ///< levels below
  std::int32_t slot = 0;     ///< into the inner or the leaf bounds
  std::int32_t parent = -1;  ///< -1: the root
  std::int32_t lane = 0;     ///< of the parent
  bool is_leaf() const { return height == 0; }
};

struct ReferenceTree {
  std::vector<Block> blocks;
  std::vector<ReferenceInner> inner;
  std::vector<ReferenceLeaf> leaves;
};

struct MovingTree {
  std::vector<Block> blocks;
  std::vector<MovingInner> inner;
  std::vector<MovingLeaf> leaves;
};

/// Over every triangle of the surface.
ReferenceTree reference_tree(const GapSurface& surface);

/// Over the listed triangles.
MovingTree moving_tree(const GapSurface& surface, const std::vector<std::int32_t>& triangles);

// Dual-tree traversal of a directional gap query: block against block in float, each block rotated or placed
// on first visit; remaining pairs of triangles are passed on for evaluation in double.

/// Error bound of the float bounds, mm, for vertices of either object up to `reach_mm` from the origin of S.
double gap_slack_mm(double reach_mm);

class DualTreeTraversal {
 public:
  /// Keeps references to the trees. Uses the current instruction_set(). `signed_facing` skips reference faces
  /// directed up, `non_negative` skips pairs that the moving object has passed.
  DualTreeTraversal(const ReferenceTree& reference, const MovingTree& moving, GapKind kind);

  void turn(const Eigen::Matrix3d& R);
  /// `any_mm`: margin by which pairs may be apart in any direction. `rounding_mm`: largest sum of the offsets
  /// of a pair; the trees' bounds include the offsets.
  struct Margins {
    double any_mm = 0.0, rounding_mm = 0.0;
  };
  void place(const MovingPose& pose, double reach_mm, const Margins& margins);

  /// Of the instruction set.
  const BlockFunctions& functions() const { return *functions_; }

  /// Calls `visit(pair)` for every pair of triangles that may touch within `limit()` mm. The limit is
  /// evaluated again after every visit, since it may decrease. Pairs of equal bounds are all visited.
  template <typename Limit, typename Visit>
  void run(const Limit& limit, const Visit& visit)
  {
    if (reference_.blocks.empty() || moving_.blocks.empty()) return;
    tasks_.assign(1, Task{});
    while (!tasks_.empty()) {
      const Task task = tasks_.back();
      tasks_.pop_back();
      const float limit_now = float_limit(limit());
      if (task.bound > limit_now || !test(task, limit_now)) continue;
      const Block& r = reference_.blocks[static_cast<std::size_t>(task.reference)];
      const Block& m = moving_.blocks[static_cast<std::size_t>(task.moving)];
      if (r.is_leaf() && m.is_leaf()) {
        screen(r, m, limit_now);
        visit_pairs(r, m, limit, visit);
      } else {
        push_children(task, r, m);
      }
    }
  }

 private:
  struct Task {
    std::int32_t reference = 0, moving = 0;
    float bound = -1e30F;
  };

  float shift() const { return kind_ == GapKind::signed_facing ? 1.0F : 0.0F; }
  float float_limit(double limit_mm) const { return static_cast<float>(limit_mm + slack_mm_); }
  bool test(const Task& task, float limit);
  void screen(const Block& r, const Block& m, float limit);
  void push_children(const Task& task, const Block& r, const Block& m);

  template <typename Limit, typename Visit>
  void visit_pairs(const Block& r, const Block& m, const Limit& limit, const Visit& visit)
  {
    for (unsigned k = 0; k < block_lanes; ++k) {
      for (unsigned hits = pairs_.hits[k]; hits != 0; hits &= hits - 1) {
        const auto i = static_cast<unsigned>(std::countr_zero(hits));
        if (pairs_.bound[k].lane[i] <= float_limit(limit())) visit(TrianglePair{r.child[i], m.child[k]});
      }
    }
  }

  const ReferenceTree& reference_;
  const MovingTree& moving_;
  GapKind kind_;
  const BlockFunctions* functions_;
  BlockRotation turn_{};
  BlockPlacement placement_{};
  double slack_mm_ = 0.0;
  float rounding_mm_ = 0.0F;
  std::uint32_t turn_stamp_ = 1, place_stamp_ = 1;
  std::vector<PlacedBlock> reference_placed_, moving_placed_;
  std::vector<PlacedCorners> reference_corners_, moving_corners_;  // by leaf
  std::vector<std::uint32_t> reference_stamps_, moving_stamps_;    // of the placed bounds
  std::vector<Task> tasks_;
  BlockPairs pairs_{};
};

// The data of a GapTree: exact triangles and the trees of either role.

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

// Contact candidates of the kernel as features with a point and a normal.

/// A candidate of a pair of triangles that may become a feature.
struct NearCandidate {
  TrianglePair pair;
  ContactCandidate at;
};

/// A vertex and a face, or two edges, of the reference and of the moving mesh.
struct FeatureKey {
  std::uint64_t of_reference, of_moving;
  bool operator==(const FeatureKey&) const = default;
};

/// A feature is found through each of its triangles: the first in the order of merge_features remains.
/// Overwrites `keys`, whose memory is reused.
void keep_one_candidate_per_feature(const Mesh& reference, const Mesh& moving,
                                    std::vector<NearCandidate>& near, std::vector<FeatureKey>& keys);

/// `reference` is directed down, `moving` up. The normal is the face's for a vertex on a face, the cross
/// product of the edges for two edges.
GapFeature gap_feature(const GapFace& reference, const GapFace& moving, const ContactCandidate& candidate,
                       const TrianglePair& pair, double offset_mm = 0.0);

/// Sorts by travel and removes duplicates found through several pairs of triangles (of equal travels the
/// smallest pair stays). Features at one point with different normals stay: each is a one-sided
/// linearisation.
void merge_features(std::vector<GapFeature>& features);

}  // namespace vrda::geometry
