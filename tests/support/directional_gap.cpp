#include "support/directional_gap.hpp"

#include <algorithm>

#include "geometry/rounded_kernel.hpp"

namespace vrda::test {
namespace {

using namespace geometry;

using gap_rules::infinity;

// Keeps the smallest travel that counts.
struct Least {
  GapKind kind = GapKind::non_negative;
  double travel_mm = infinity;
  void offer(double travel)
  {
    if (kind == GapKind::non_negative && travel < 0.0) return;
    travel_mm = std::min(travel_mm, travel);
  }
};

}  // namespace

double pair_travel_mm(const Corners& reference, const Corners& moving, GapKind kind, double offset_mm)
{
  const GapFace r = gap_face(reference), m = gap_face(moving);
  // Only a moving face directed up can be the first to touch a reference face directed down.
  if (kind == GapKind::signed_facing && !(r.faces_down() && m.faces_up())) return infinity;
  if (offset_mm > 0.0) {
    const RoundedPassage passage = rounded_passage(reference, moving, offset_mm);
    if (kind == GapKind::signed_facing) return passage.enter_mm;
    return passage.ahead_mm();
  }
  Least least{kind};
  visit_contact_candidates(r, m, [&least](const ContactCandidate& at) { least.offer(at.travel_mm); });
  return least.travel_mm;
}

namespace {

// Dual-tree branch and bound.
class Query {
 public:
  Query(const TreeMesh& reference, const Mesh& moving_mesh, const BoxTree& moving, const MovingPose& pose,
        GapKind kind)
      : reference_(reference),
        moving_mesh_(moving_mesh),
        moving_(moving),
        place_(pose),
        kind_(kind),
        offset_mm_(rounding_mm(reference.mesh, moving_mesh))
  {
  }

  Gap run()
  {
    push({0, 0});
    while (!tasks_.empty()) {
      const Task task = tasks_.back();
      tasks_.pop_back();
      // Equal bounds are visited too, so that ties give the smallest pair.
      if (task.bound > best_.travel_mm) continue;
      descend(task);
    }
    return best_;
  }

 private:
  struct Task {
    std::int32_t reference = 0;
    std::int32_t moving = 0;
    double bound = 0.0;
  };

  void push(Task task)
  {
    const BoxTree::Node& r = reference_.tree.nodes()[static_cast<std::size_t>(task.reference)];
    const BoxTree::Node m = place_(moving_.nodes()[static_cast<std::size_t>(task.moving)]);
    for (const std::size_t across : {0U, 2U}) {
      if (r.min_mm[across] - m.max_mm[across] > offset_mm_) return;
      if (m.min_mm[across] - r.max_mm[across] > offset_mm_) return;
    }
    task.bound = r.min_mm[1] - m.max_mm[1] - offset_mm_;
    if (kind_ == GapKind::non_negative) {
      if (m.min_mm[1] - r.max_mm[1] > offset_mm_) return;
      task.bound = std::max(task.bound, 0.0);
    }
    if (task.bound <= best_.travel_mm) tasks_.push_back(task);
  }

  void descend(const Task& task)
  {
    const BoxTree::Node& r = reference_.tree.nodes()[static_cast<std::size_t>(task.reference)];
    const BoxTree::Node& m = moving_.nodes()[static_cast<std::size_t>(task.moving)];
    if (r.is_leaf() && m.is_leaf()) {
      for (std::int32_t i = r.first; i < r.first + r.count; ++i) {
        for (std::int32_t k = m.first; k < m.first + m.count; ++k) {
          offer({reference_.tree.order()[static_cast<std::size_t>(i)],
                 moving_.order()[static_cast<std::size_t>(k)]});
        }
      }
      return;
    }
    const double size_r = r.max_mm[0] - r.min_mm[0] + r.max_mm[2] - r.min_mm[2];
    const double size_m = m.max_mm[0] - m.min_mm[0] + m.max_mm[2] - m.min_mm[2];
    const std::size_t before = tasks_.size();
    if (m.is_leaf() || (!r.is_leaf() && size_r >= size_m)) {
      push({task.reference + 1, task.moving});
      push({r.first, task.moving});
    } else {
      push({task.reference, task.moving + 1});
      push({task.reference, m.first});
    }
    // The nearer child is visited first.
    if (tasks_.size() == before + 2 && tasks_[before].bound < tasks_[before + 1].bound) {
      std::swap(tasks_[before], tasks_[before + 1]);
    }
  }

  void offer(const TrianglePair& pair)
  {
    const double travel = pair_travel_mm(
        corners(reference_.mesh, pair.reference), place_(corners(moving_mesh_, pair.moving)), kind_,
        offset_mm(reference_.mesh, pair.reference) + offset_mm(moving_mesh_, pair.moving));
    if (travel < best_.travel_mm || (travel == best_.travel_mm && travel < infinity && pair < best_.pair)) {
      best_ = {travel, pair};
    }
  }

  const TreeMesh& reference_;
  const Mesh& moving_mesh_;
  const BoxTree& moving_;
  Placement place_;
  GapKind kind_;
  double offset_mm_;  // largest sum of a pair
  Gap best_;
  std::vector<Task> tasks_;
};

}  // namespace

Gap directional_gap(const TreeMesh& reference, const Mesh& moving_mesh, const BoxTree& moving,
                    const MovingPose& pose, GapKind kind)
{
  if (reference.tree.is_empty() || moving.is_empty()) return {};
  return Query(reference, moving_mesh, moving, pose, kind).run();
}

}  // namespace vrda::test
