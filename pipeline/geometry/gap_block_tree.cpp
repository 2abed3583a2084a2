#include "geometry/gap_block_tree.hpp"

#include <algorithm>
#include <cmath>
#include <span>
#include <utility>

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
  std::sort(uses.begin(), uses.end(), [](const EdgeUse& l, const EdgeUse& r) {
    return std::pair(l.low, l.high) != std::pair(r.low, r.high)
               ? std::pair(l.low, l.high) < std::pair(r.low, r.high)
               : std::pair(l.triangle, l.slot) < std::pair(r.triangle, r.slot);
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

}  // namespace vrda::geometry
