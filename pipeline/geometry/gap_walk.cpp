#include "geometry/gap_walk.hpp"

#include <algorithm>

#include "geometry/instruction_set.hpp"

namespace vrda::geometry {
namespace {

const BlockFunctions& functions_of(InstructionSet set)
{
  switch (set) {
    case InstructionSet::avx512:
      return block_functions_avx512;
    case InstructionSet::avx2:
      return block_functions_avx2;
    case InstructionSet::baseline:
      break;
  }
  return block_functions_baseline;
}

// Advances to an unused stamp, which invalidates all blocks; on overflow all stamps are cleared.
void advance_stamp(std::uint32_t& stamp, std::vector<std::uint32_t>& stamps)
{
  if (++stamp != 0) return;
  std::fill(stamps.begin(), stamps.end(), 0U);
  stamp = 1;
}

PlacedBound lane_of(const PlacedBlock& block, std::int32_t lane)
{
  return {block.x_low.lane[lane], block.x_high.lane[lane], block.z_low.lane[lane], block.z_high.lane[lane],
          block.flat.lane[lane],  block.a.lane[lane],      block.b.lane[lane],     block.c.lane[lane]};
}

}  // namespace

double gap_slack_mm(double reach_mm)
{
  // Error bounds in units of 2^-24 reach; planes up to 60 degrees (slopes up to 1.8, a up to 4.5). The
  // reference: 12 for the rotated normal, 1 for the offset, both over 0.5; 9 for dividing: 35. The moving
  // object: 2 for a, 10 for the rotated slopes, 25 for the shift: 37. Evaluating the difference: 20. Boxes:
  // below 10.
  return 128.0 / 16777216.0 * reach_mm + 1e-9;
}

DualTreeTraversal::DualTreeTraversal(const ReferenceTree& reference, const MovingTree& moving, GapKind kind)
    : reference_(reference),
      moving_(moving),
      kind_(kind),
      functions_(&functions_of(instruction_set())),
      reference_placed_(reference.blocks.size()),
      moving_placed_(moving.blocks.size()),
      reference_corners_(reference.leaves.size()),
      moving_corners_(moving.leaves.size()),
      reference_stamps_(reference.blocks.size(), 0U),
      moving_stamps_(moving.blocks.size(), 0U)
{
}

void DualTreeTraversal::turn(const Eigen::Matrix3d& R)
{
  for (int i = 0; i < 3; ++i) {
    for (int k = 0; k < 3; ++k) turn_.R[i][k] = static_cast<float>(R(i, k));
  }
  turn_.cull = kind_ == GapKind::signed_facing ? facing_slack : 2.0F;  // beyond any normal
  turn_.shift = shift();
  advance_stamp(turn_stamp_, reference_stamps_);
}

void DualTreeTraversal::place(const MovingPose& pose, double reach_mm, const Margins& margins)
{
  const SinCos turn = sin_cos(pose.theta_rad);
  slack_mm_ = gap_slack_mm(reach_mm) + margins.any_mm;
  rounding_mm_ = static_cast<float>(margins.rounding_mm);
  placement_.cos = static_cast<float>(turn.cos);
  placement_.sin = static_cast<float>(turn.sin);
  placement_.x = static_cast<float>(pose.translation_mm.x());
  placement_.y = static_cast<float>(pose.translation_mm.y());
  placement_.z = static_cast<float>(pose.translation_mm.z());
  placement_.slack = static_cast<float>(slack_mm_);
  placement_.shift = shift();
  advance_stamp(place_stamp_, moving_stamps_);
}

bool DualTreeTraversal::test(const Task& task, float limit)
{
  const auto r = static_cast<std::size_t>(task.reference), m = static_cast<std::size_t>(task.moving);
  const Block &r_block = reference_.blocks[r], &m_block = moving_.blocks[m];
  if (reference_stamps_[r] != turn_stamp_) {
    reference_stamps_[r] = turn_stamp_;
    const auto slot = static_cast<std::size_t>(r_block.slot);
    if (r_block.is_leaf()) {
      functions_->rotate_leaf(reference_.leaves[slot], turn_, reference_placed_[r], reference_corners_[slot]);
    } else {
      functions_->rotate_inner(reference_.inner[slot], turn_, reference_placed_[r]);
    }
  }
  // Each block against the other's own bound, stored in its parent: rejects most pairs of leaves. The moving
  // block's first, since it may then need no placing.
  if (m_block.parent >= 0) {
    const PlacedBlock& parent = moving_placed_[static_cast<std::size_t>(m_block.parent)];
    if (!functions_->reference_near(reference_placed_[r], lane_of(parent, m_block.lane), limit)) return false;
  }
  if (moving_stamps_[m] != place_stamp_) {
    moving_stamps_[m] = place_stamp_;
    const auto slot = static_cast<std::size_t>(m_block.slot);
    if (m_block.is_leaf()) {
      functions_->place_leaf(moving_.leaves[slot], placement_, moving_placed_[m], moving_corners_[slot]);
    } else {
      functions_->place_inner(moving_.inner[slot], placement_, moving_placed_[m]);
    }
  }
  if (r_block.parent >= 0) {
    const PlacedBlock& parent = reference_placed_[static_cast<std::size_t>(r_block.parent)];
    if (!functions_->moving_near(moving_placed_[m], lane_of(parent, r_block.lane), limit)) return false;
  }
  if (kind_ == GapKind::signed_facing) {
    return functions_->test(reference_placed_[r], moving_placed_[m], limit, pairs_);
  }
  return functions_->test_ahead(reference_placed_[r], moving_placed_[m], {-placement_.slack, limit}, pairs_);
}

void DualTreeTraversal::screen(const Block& r, const Block& m, float limit)
{
  const auto r_index = static_cast<std::size_t>(&r - reference_.blocks.data());
  const auto m_index = static_cast<std::size_t>(&m - moving_.blocks.data());
  functions_->screen({reference_placed_[r_index], moving_placed_[m_index],
                      reference_corners_[static_cast<std::size_t>(r.slot)],
                      moving_corners_[static_cast<std::size_t>(m.slot)], limit, static_cast<float>(slack_mm_),
                      rounding_mm_, shift()},
                     pairs_);
}

void DualTreeTraversal::push_children(const Task& task, const Block& r, const Block& m)
{
  // Only the taller subtree descends, so that leaves are paired with leaves: a block paired with much finer
  // ones is visited too often.
  const bool is_reference_whole = r.height < m.height, is_moving_whole = m.height < r.height;
  const std::size_t first = tasks_.size();
  for (unsigned k = 0; k < block_lanes; ++k) {
    for (unsigned hits = pairs_.hits[k]; hits != 0; hits &= hits - 1) {
      const auto i = static_cast<unsigned>(std::countr_zero(hits));
      const Task child{is_reference_whole ? task.reference : r.child[i],
                       is_moving_whole ? task.moving : m.child[k], pairs_.bound[k].lane[i]};
      // The lanes of a block that does not descend share one task with the smallest bound.
      const auto same = [&child](const Task& t) {
        return t.reference == child.reference && t.moving == child.moving;
      };
      const auto known =
          is_reference_whole || is_moving_whole
              ? std::find_if(tasks_.begin() + static_cast<std::ptrdiff_t>(first), tasks_.end(), same)
              : tasks_.end();
      if (known == tasks_.end()) {
        tasks_.push_back(child);
      } else {
        known->bound = std::min(known->bound, child.bound);
      }
    }
  }
  // The nearest is visited first, because it reduces the limit most.
  const auto nearest = std::min_element(tasks_.begin() + static_cast<std::ptrdiff_t>(first), tasks_.end(),
                                        [](const Task& a, const Task& b) { return a.bound < b.bound; });
  std::iter_swap(nearest, tasks_.end() - 1);
}

}  // namespace vrda::geometry
