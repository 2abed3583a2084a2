/// Dual-tree traversal of a directional gap query: block against block in float, each block rotated or placed
/// on first visit; remaining pairs of triangles are passed on for evaluation in double.
#pragma once

#include <bit>
#include <cstdint>
#include <vector>

#include "geometry/directional_gap.hpp"
#include "geometry/gap_block_tree.hpp"

namespace vrda::geometry {

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

}  // namespace vrda::geometry
