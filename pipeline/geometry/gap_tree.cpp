#include "geometry/gap_tree.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <span>
#include <tuple>
#include <utility>

#include "core/bucket_sort.hpp"

namespace vrda::geometry {
namespace {

// Largest distance of a face from its neighbour's plane, relative to the largest coordinate, at which both
// are coplanar: a few roundings of transformed vertices.
constexpr double flat_share = 1e-13;

struct EdgeUse {
  std::int32_t low = 0, high = 0;
  bool is_forward = true;
  std::int32_t triangle = 0;
  int slot = 0;
};

std::vector<EdgeUse> sorted_uses(const GapSurface& surface)
{
  std::vector<EdgeUse> uses;
  uses.reserve(3 * surface.triangles.size());
  for (const std::int32_t t : surface.triangles) {
    for (int k = 0; k < 3; ++k) {
      const std::int32_t from = surface.mesh.triangles(t, k), to = surface.mesh.triangles(t, (k + 1) % 3);
      uses.push_back({std::min(from, to), std::max(from, to), from < to, t, k});
    }
  }
  core::sort_by_row(
      uses, static_cast<std::size_t>(surface.mesh.vertices_mm.rows()),
      [](const EdgeUse& use) { return use.low; },
      [](const EdgeUse& l, const EdgeUse& r) {
        return std::tuple(l.high, l.triangle, l.slot) < std::tuple(r.high, r.triangle, r.slot);
      });
  return uses;
}

// The edge is convex if face g's opposite corner is below the plane of f by more than rounding.
bool is_convex(const GapSurface& surface, const EdgeUse& f, const EdgeUse& g, double flat_mm)
{
  const Eigen::Vector3d normal = surface.face_normals.row(f.triangle);
  const std::int32_t far = surface.mesh.triangles(g.triangle, (g.slot + 2) % 3);
  const Eigen::Vector3d across = surface.mesh.vertices_mm.row(far) - surface.mesh.vertices_mm.row(f.low);
  return normal.dot(across) < -flat_mm;
}

bool is_degenerate(const GapSurface& surface, const EdgeUse& use)
{
  return surface.face_normals.row(use.triangle).isZero(0.0);
}

}  // namespace

GapSurface gap_surface(const Mesh& mesh, std::vector<std::int32_t> triangles)
{
  GapSurface surface;
  surface.mesh = mesh;
  std::sort(triangles.begin(), triangles.end());
  surface.triangles = std::move(triangles);
  surface.face_normals.resize(mesh.triangles.rows(), 3);
  for (Eigen::Index t = 0; t < mesh.triangles.rows(); ++t) {
    surface.face_normals.row(t) = face_normal(mesh, t).transpose();
  }
  surface.neighbours.assign(static_cast<std::size_t>(mesh.triangles.rows()), {-1, -1, -1});
  const double flat_mm =
      mesh.vertices_mm.rows() > 0 ? flat_share * mesh.vertices_mm.cwiseAbs().maxCoeff() : 0.0;
  const std::vector<EdgeUse> uses = sorted_uses(surface);
  for (std::size_t i = 0; i + 1 < uses.size(); ++i) {
    const EdgeUse &f = uses[i], &g = uses[i + 1];
    const auto same = [&uses, &f](std::size_t k) {
      return k < uses.size() && uses[k].low == f.low && uses[k].high == f.high;
    };
    if (!same(i + 1)) continue;
    const bool is_pair = !same(i + 2) && (i == 0 || !same(i - 1));
    if (!is_pair || f.is_forward == g.is_forward || is_degenerate(surface, f) || is_degenerate(surface, g)) {
      continue;
    }
    if (is_convex(surface, f, g, flat_mm) || is_convex(surface, g, f, flat_mm)) continue;
    surface.neighbours[static_cast<std::size_t>(f.triangle)][static_cast<std::size_t>(f.slot)] = g.triangle;
    surface.neighbours[static_cast<std::size_t>(g.triangle)][static_cast<std::size_t>(g.slot)] = f.triangle;
  }
  return surface;
}

unsigned first_contact_edges(const GapSurface& surface, std::int32_t triangle,
                             const std::vector<bool>& counts)
{
  unsigned edges = 0;
  for (unsigned k = 0; k < 3; ++k) {
    const std::int32_t across = surface.neighbours[static_cast<std::size_t>(triangle)][k];
    if (across < 0 || !counts[static_cast<std::size_t>(across)]) edges |= 1U << k;
  }
  return edges;
}

namespace {

constexpr float absent = 1e30F;
using Rows = std::span<std::int32_t>;

// Arranges rows into blocks; the bounds are filled in for the role by a callback.
class BlockArranger {
 public:
  BlockArranger(const GapSurface& surface, const std::vector<std::int32_t>& triangles) : rows_(triangles)
  {
    centres_.resize(surface.mesh.triangles.rows(), 3);
    for (const std::int32_t t : triangles) {
      const Corners c = corners(surface.mesh, t);
      centres_.row(t) = (c[0] + c[1] + c[2]).transpose() / 3.0;
    }
  }

  // Calls `add(block, rows, groups)` for every block before its children.
  template <typename Add>
  std::vector<Block> arrange(const Add& add)
  {
    blocks_.clear();
    if (!rows_.empty()) build(Rows(rows_), add);
    return std::move(blocks_);
  }

 private:
  template <typename Add>
  std::int32_t build(Rows rows, const Add& add)
  {
    const auto index = static_cast<std::int32_t>(blocks_.size());
    Block block;
    block.child.fill(-1);
    for (std::size_t held = block_lanes; held < rows.size(); held *= block_lanes) ++block.height;
    std::vector<Rows> groups;
    if (block.is_leaf()) {
      std::sort(rows.begin(), rows.end());
      std::copy(rows.begin(), rows.end(), block.child.begin());
    } else {
      std::size_t unit = block_lanes;
      while (unit * block_lanes < rows.size()) unit *= block_lanes;
      split(rows, unit, groups);
    }
    add(block, rows, groups);
    blocks_.push_back(block);
    for (std::size_t k = 0; k < groups.size(); ++k) {
      const std::int32_t child = build(groups[k], add);
      blocks_[static_cast<std::size_t>(index)].child[k] = child;
      blocks_[static_cast<std::size_t>(child)].parent = index;
      blocks_[static_cast<std::size_t>(child)].lane = static_cast<std::int32_t>(k);
    }
    return index;
  }

  // Splits at multiples of `unit`, so that all blocks except the last are full.
  void split(Rows rows, std::size_t unit, std::vector<Rows>& groups)
  {
    if (rows.size() <= unit) {
      groups.push_back(rows);
      return;
    }
    const std::size_t n_units = (rows.size() + unit - 1) / unit;
    const std::size_t middle = n_units / 2 * unit;
    const Eigen::Index axis = widest(rows);
    std::nth_element(rows.begin(), rows.begin() + static_cast<std::ptrdiff_t>(middle), rows.end(),
                     [this, axis](std::int32_t l, std::int32_t r) {
                       const double a = centres_(l, axis), b = centres_(r, axis);
                       return a != b ? a < b : l < r;
                     });
    split(rows.first(middle), unit, groups);
    split(rows.subspan(middle), unit, groups);
  }

  // In space, not only across Delta, so that layers (bone, cartilage, menisci) are separated early.
  Eigen::Index widest(Rows rows) const
  {
    Eigen::RowVector3d low = centres_.row(rows.front()), high = low;
    for (const std::int32_t t : rows) {
      low = low.cwiseMin(centres_.row(t));
      high = high.cwiseMax(centres_.row(t));
    }
    Eigen::Index axis = 0;
    (high - low).maxCoeff(&axis);
    return axis;
  }

  std::vector<std::int32_t> rows_;
  Points centres_;
  std::vector<Block> blocks_;
};

void set(BlockRow& row, std::size_t lane, double value)
{
  row.lane[lane] = static_cast<float>(value);
}

void set(BlockRow rows[3], std::size_t lane, const Eigen::Vector3d& value)
{
  for (int k = 0; k < 3; ++k) set(rows[k], lane, value[k]);
}

// Of the rounded triangles.
Box box_of(const GapSurface& surface, Rows rows)
{
  Eigen::Vector3d low = Eigen::Vector3d::Constant(gap_rules::infinity), high = -low;
  for (const std::int32_t t : rows) {
    const Eigen::Vector3d offset = Eigen::Vector3d::Constant(offset_mm(surface.mesh, t));
    for (const Eigen::Vector3d& p : corners(surface.mesh, t)) {
      low = low.cwiseMin(p - offset);
      high = high.cwiseMax(p + offset);
    }
  }
  return {low, high};
}

// Area-weighted mean outward normal, rounded to float; zero where the faces cancel out.
Eigen::Vector3d mean_normal(const GapSurface& surface, Rows rows)
{
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  double total = 0.0;
  for (const std::int32_t t : rows) {
    const Corners c = corners(surface.mesh, t);
    const Eigen::Vector3d doubled = (c[1] - c[0]).cross(c[2] - c[0]);
    sum += doubled;
    total += doubled.norm();
  }
  const double length = sum.norm();
  if (!(length > 1e-3 * total)) return Eigen::Vector3d::Zero();
  return (sum / length).cast<float>().cast<double>();
}

double least_along(const GapSurface& surface, Rows rows, const Eigen::Vector3d& n)
{
  double least = gap_rules::infinity;
  const double length = surface.mesh.offset_mm.empty() ? 0.0 : n.norm();
  for (const std::int32_t t : rows) {
    const double offset = length * offset_mm(surface.mesh, t);
    for (const Eigen::Vector3d& p : corners(surface.mesh, t)) least = std::min(least, n.dot(p) - offset);
  }
  return least;
}

// Sine of the largest angle between the faces' normals and `axis`; 1 from a right angle on.
double spread_around(const GapSurface& surface, Rows rows, const Eigen::Vector3d& axis)
{
  double least_cos = 1.0;
  for (const std::int32_t t : rows) {
    const Eigen::Vector3d n = surface.face_normals.row(t);
    if (!n.isZero(0.0)) least_cos = std::min(least_cos, n.dot(axis));
  }
  return least_cos <= 0.0 ? 1.0 : std::sqrt(std::max(0.0, 1.0 - least_cos * least_cos));
}

void fill_inner(const GapSurface& surface, Rows rows, std::size_t lane, ReferenceInner& inner)
{
  const Box box = box_of(surface, rows);
  const Eigen::Vector3d centre = 0.5 * (box.min_mm + box.max_mm);
  set(inner.centre, lane, centre);
  set(inner.half, lane, 0.5 * (box.max_mm - box.min_mm));
  const Eigen::Vector3d inward = -mean_normal(surface, rows);
  set(inner.normal, lane, inward);
  set(inner.offset, lane, least_along(surface, rows, inward));
  set(inner.spread, lane, spread_around(surface, rows, -inward));
}

void fill_leaf(const GapSurface& surface, std::int32_t t, std::size_t lane, ReferenceLeaf& leaf)
{
  const Corners c = corners(surface.mesh, t);
  for (int k = 0; k < 3; ++k) {
    set(leaf.x[k], lane, c[static_cast<std::size_t>(k)].x());
    set(leaf.y[k], lane, c[static_cast<std::size_t>(k)].y());
    set(leaf.z[k], lane, c[static_cast<std::size_t>(k)].z());
  }
  std::array<std::int32_t, 1> row{t};
  const Eigen::Vector3d outward = surface.face_normals.row(t);
  const Eigen::Vector3d inward = -outward.cast<float>().cast<double>();
  set(leaf.normal, lane, inward);
  set(leaf.offset, lane, least_along(surface, row, inward));
  set(leaf.rounding, lane, offset_mm(surface.mesh, t));
}

// The plane above every vertex with the slope of the faces' mean normal; horizontal where that is steep.
void fill_plane(const GapSurface& surface, Rows rows, std::size_t lane, BlockRow* const abc[3])
{
  const Eigen::Vector3d n = mean_normal(surface, rows);
  const bool is_flat_enough = n.y() >= static_cast<double>(steep_normal);
  const auto b = static_cast<float>(is_flat_enough ? -n.x() / n.y() : 0.0);
  const auto c = static_cast<float>(is_flat_enough ? -n.z() / n.y() : 0.0);
  const Eigen::Vector3d above(static_cast<double>(b), -1.0, static_cast<double>(c));
  abc[0]->lane[lane] = static_cast<float>(-least_along(surface, rows, above));
  abc[1]->lane[lane] = b;
  abc[2]->lane[lane] = c;
}

void fill_inner(const GapSurface& surface, Rows rows, std::size_t lane, MovingInner& inner)
{
  const Box box = box_of(surface, rows);
  set(inner.centre_x, lane, 0.5 * (box.min_mm.x() + box.max_mm.x()));
  set(inner.centre_z, lane, 0.5 * (box.min_mm.z() + box.max_mm.z()));
  set(inner.half_x, lane, 0.5 * (box.max_mm.x() - box.min_mm.x()));
  set(inner.half_z, lane, 0.5 * (box.max_mm.z() - box.min_mm.z()));
  set(inner.top, lane, box.max_mm.y());
  set(inner.bottom, lane, box.min_mm.y());
  BlockRow* const abc[3] = {&inner.a, &inner.b, &inner.c};
  fill_plane(surface, rows, lane, abc);
}

void fill_leaf(const GapSurface& surface, std::int32_t t, std::size_t lane, MovingLeaf& leaf)
{
  const Corners c = corners(surface.mesh, t);
  for (int k = 0; k < 3; ++k) {
    set(leaf.x[k], lane, c[static_cast<std::size_t>(k)].x());
    set(leaf.z[k], lane, c[static_cast<std::size_t>(k)].z());
  }
  const double offset = offset_mm(surface.mesh, t);
  set(leaf.top, lane, extent(c, 1).most + offset);
  set(leaf.bottom, lane, extent(c, 1).least - offset);
  set(leaf.rounding, lane, offset);
  set(leaf.shift_x, lane, offset * surface.face_normals(t, 0));
  set(leaf.shift_z, lane, offset * surface.face_normals(t, 2));
  std::array<std::int32_t, 1> row{t};
  BlockRow* const abc[3] = {&leaf.a, &leaf.b, &leaf.c};
  fill_plane(surface, row, lane, abc);
}

void clear_lane(std::size_t lane, ReferenceInner& inner)
{
  for (BlockRow& half : inner.half) half.lane[lane] = -absent;
}
void clear_lane(std::size_t lane, MovingInner& inner)
{
  inner.half_x.lane[lane] = inner.half_z.lane[lane] = -absent;
}

template <typename Tree>
Tree tree_over(const GapSurface& surface, const std::vector<std::int32_t>& triangles)
{
  Tree tree;
  const auto add = [&tree, &surface](Block& block, Rows, const std::vector<Rows>& groups) {
    if (block.is_leaf()) {
      block.slot = static_cast<std::int32_t>(tree.leaves.size());
      auto& leaf = tree.leaves.emplace_back();
      for (std::size_t lane = 0; lane < block_lanes; ++lane) {
        if (block.child[lane] >= 0) fill_leaf(surface, block.child[lane], lane, leaf);
        leaf.absent.lane[lane] = block.child[lane] >= 0 ? 0.0F : absent;
      }
    } else {
      block.slot = static_cast<std::int32_t>(tree.inner.size());
      auto& inner = tree.inner.emplace_back();
      for (std::size_t lane = 0; lane < block_lanes; ++lane) {
        if (lane < groups.size()) {
          fill_inner(surface, groups[lane], lane, inner);
        } else {
          clear_lane(lane, inner);
        }
      }
    }
  };
  tree.blocks = BlockArranger(surface, triangles).arrange(add);
  return tree;
}

}  // namespace

ReferenceTree reference_tree(const GapSurface& surface)
{
  return tree_over<ReferenceTree>(surface, surface.triangles);
}

MovingTree moving_tree(const GapSurface& surface, const std::vector<std::int32_t>& triangles)
{
  return tree_over<MovingTree>(surface, triangles);
}

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

namespace {

std::vector<std::int32_t> all_rows(const Mesh& mesh)
{
  std::vector<std::int32_t> rows(static_cast<std::size_t>(mesh.triangles.rows()));
  std::iota(rows.begin(), rows.end(), 0);
  return rows;
}

std::vector<ExactFace> exact_faces(const Mesh& mesh)
{
  std::vector<ExactFace> faces(static_cast<std::size_t>(mesh.triangles.rows()));
  for (std::size_t t = 0; t < faces.size(); ++t) {
    const Corners c = corners(mesh, static_cast<Eigen::Index>(t));
    faces[t] = {c, doubled_area(c), least_screened_area(c), offset_mm(mesh, static_cast<Eigen::Index>(t))};
  }
  return faces;
}

}  // namespace

GapTree::GapTree(const Mesh& mesh) : GapTree(mesh, all_rows(mesh)) {}

GapTree::GapTree(const Mesh& mesh, const std::vector<std::int32_t>& triangles)
{
  auto data = std::make_shared<Data>();
  data->surface = gap_surface(mesh, triangles);
  data->faces = exact_faces(mesh);
  std::vector<bool> looks_up(data->faces.size());
  for (const std::int32_t t : data->surface.triangles) {
    const ExactFace& face = data->faces[static_cast<std::size_t>(t)];
    if (!gap_face(face.corner, face.doubled_area).faces_up()) continue;
    looks_up[static_cast<std::size_t>(t)] = true;
    data->up.push_back(t);
  }
  data->up_edges.assign(data->faces.size(), 0);
  for (const std::int32_t t : data->up) {
    data->up_edges[static_cast<std::size_t>(t)] = first_contact_edges(data->surface, t, looks_up);
  }
  if (mesh.vertices_mm.rows() > 0) data->radius_mm = mesh.vertices_mm.rowwise().norm().maxCoeff();
  data->offset_mm = largest_offset_mm(mesh);
  data_ = std::move(data);
}

void GapTree::prepare_as_reference() const
{
  if (data_ != nullptr) data_->as_reference();
}

void GapTree::prepare_as_moving(GapKind kind) const
{
  if (data_ != nullptr) data_->as_moving(kind);
}

bool GapTree::is_empty() const
{
  return data_ == nullptr || data_->surface.triangles.empty();
}

namespace {

// A point computed from different triangles differs by rounding: coordinates of 100 mm, divided by sines of
// facets down to 1e-3.
constexpr double same_travel_mm = 1e-10;
constexpr double same_point_mm = 1e-9;
constexpr double same_normal = 1e-9;

Eigen::Vector3d unit_normal(const Corners& c)
{
  return (c[1] - c[0]).cross(c[2] - c[0]).normalized();
}

bool is_same(const GapFeature& a, const GapFeature& b)
{
  return (a.point_mm - b.point_mm).cwiseAbs().maxCoeff() <= same_point_mm &&
         (a.normal - b.normal).cwiseAbs().maxCoeff() <= same_normal;
}

// A vertex and a face, or two edges, of the moving and of the reference mesh.
FeatureKey key_of(const Mesh& r, const Mesh& m, const NearCandidate& candidate)
{
  const auto both = [](std::int32_t first, std::int32_t second) {
    return static_cast<std::uint64_t>(static_cast<std::uint32_t>(first)) << 32U |
           static_cast<std::uint32_t>(second);
  };
  const auto vertex = [](const Mesh& mesh, std::int32_t row, unsigned corner) {
    return mesh.triangles(row, static_cast<Eigen::Index>(corner % 3));
  };
  const auto edge = [&](const Mesh& mesh, std::int32_t row, unsigned corner) {
    const auto [low, high] = std::minmax({vertex(mesh, row, corner), vertex(mesh, row, corner + 1)});
    return both(low, high);
  };
  const auto& [pair, at] = candidate;
  switch (at.kind) {
    case ContactKind::moving_vertex:
      return {both(pair.reference, -1), both(vertex(m, pair.moving, at.moving), -1)};
    case ContactKind::reference_vertex:
      return {both(vertex(r, pair.reference, at.reference), -2), both(pair.moving, -2)};
    case ContactKind::reference_edge:
      return {edge(r, pair.reference, at.reference), both(vertex(m, pair.moving, at.moving), -3)};
    case ContactKind::moving_edge:
      return {both(vertex(r, pair.reference, at.reference), -4), edge(m, pair.moving, at.moving)};
    case ContactKind::vertices:
      return {both(vertex(r, pair.reference, at.reference), -5), both(vertex(m, pair.moving, at.moving), -5)};
    case ContactKind::edges:
      break;
  }
  return {edge(r, pair.reference, at.reference), edge(m, pair.moving, at.moving)};
}

}  // namespace

void keep_one_candidate_per_feature(const Mesh& reference, const Mesh& moving,
                                    std::vector<NearCandidate>& near, std::vector<FeatureKey>& keys)
{
  std::size_t n_kept = 0;
  keys.clear();
  for (const NearCandidate& candidate : near) {
    const FeatureKey key = key_of(reference, moving, candidate);
    const auto known = std::find(keys.begin(), keys.end(), key);
    if (known == keys.end()) {
      keys.push_back(key);
      near[n_kept++] = candidate;
      continue;
    }
    NearCandidate& other = near[static_cast<std::size_t>(known - keys.begin())];
    if (std::tie(candidate.at.travel_mm, candidate.pair) < std::tie(other.at.travel_mm, other.pair))
      other = candidate;
  }
  near.resize(n_kept);
}

GapFeature gap_feature(const GapFace& reference, const GapFace& moving, const ContactCandidate& candidate,
                       const TrianglePair& pair, double offset_mm)
{
  GapFeature feature;
  feature.travel_mm = candidate.travel_mm;
  feature.triangles = pair;
  feature.kind = candidate.kind;
  feature.offset_mm = offset_mm;
  const Corners &r = reference.corner, &m = moving.corner;
  // From the reference's point to the moving object's at the end of the travel, across `edge`.
  const auto direction = [&feature, &r, &candidate] {
    const Eigen::Vector3d w =
        feature.point_mm + candidate.travel_mm * Eigen::Vector3d::UnitY() - r[candidate.reference];
    return (w - feature.edge.dot(w) * feature.edge).normalized();
  };
  switch (candidate.kind) {
    case ContactCandidate::Kind::moving_vertex:
      feature.point_mm = m[candidate.moving];
      feature.normal = unit_normal(r);
      break;
    case ContactCandidate::Kind::reference_vertex:
      feature.point_mm = r[candidate.reference] - candidate.travel_mm * Eigen::Vector3d::UnitY();
      feature.normal = -unit_normal(m);
      if (offset_mm > 0.0) feature.point_mm += offset_mm * feature.normal;
      break;
    case ContactCandidate::Kind::edges: {
      const Eigen::Vector3d d = r[(candidate.reference + 1) % 3] - r[candidate.reference];
      const Eigen::Vector3d e = m[(candidate.moving + 1) % 3] - m[candidate.moving];
      feature.point_mm = m[candidate.moving] + candidate.along_moving * e;
      const Eigen::Vector3d n = d.cross(e).normalized();
      feature.normal = n.y() < 0.0 ? n : Eigen::Vector3d(-n);
      break;
    }
    case ContactKind::reference_edge:
      feature.point_mm = m[candidate.moving];
      feature.edge = (r[(candidate.reference + 1) % 3] - r[candidate.reference]).normalized();
      feature.normal = direction();
      break;
    case ContactKind::moving_edge: {
      const Eigen::Vector3d e = m[(candidate.moving + 1) % 3] - m[candidate.moving];
      feature.point_mm = m[candidate.moving] + candidate.along_moving * e;
      feature.edge = e.normalized();
      feature.normal = direction();
      break;
    }
    case ContactKind::vertices:
      feature.point_mm = m[candidate.moving];
      feature.normal = direction();
      break;
  }
  return feature;
}

void merge_features(std::vector<GapFeature>& features)
{
  std::sort(features.begin(), features.end(), [](const GapFeature& a, const GapFeature& b) {
    return std::tie(a.travel_mm, a.triangles, a.point_mm.x(), a.point_mm.z(), a.normal.x(), a.normal.z()) <
           std::tie(b.travel_mm, b.triangles, b.point_mm.x(), b.point_mm.z(), b.normal.x(), b.normal.z());
  });
  std::size_t n_kept = 0;
  for (const GapFeature& feature : features) {
    bool is_new = true;
    for (std::size_t k = n_kept; is_new && k > 0; --k) {
      if (feature.travel_mm - features[k - 1].travel_mm > same_travel_mm) break;
      is_new = !is_same(feature, features[k - 1]);
    }
    if (is_new) features[n_kept++] = feature;
  }
  features.resize(n_kept);
}

}  // namespace vrda::geometry
