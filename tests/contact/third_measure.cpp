#include "contact/third_measure.hpp"

#include <limits>
#include <vector>

#include "support/triangle_distance.hpp"

namespace vrda::test {
namespace {

// Boxes further apart than this are irrelevant at nanometre scale.
constexpr double near_mm = 1e-6;

struct Boxed {
  geometry::Corners corner;
  std::array<geometry::Extent, 3> box;
};

bool are_near(const std::array<geometry::Extent, 3>& a, const std::array<geometry::Extent, 3>& b)
{
  for (std::size_t k = 0; k < 3; ++k) {
    if (a[k].least - b[k].most > near_mm || b[k].least - a[k].most > near_mm) return false;
  }
  return true;
}

Boxed boxed(const geometry::Corners& t)
{
  return {t, {geometry::extent(t, 0), geometry::extent(t, 1), geometry::extent(t, 2)}};
}

std::vector<Boxed> all_boxed(const Mesh& mesh, const geometry::Placement& place)
{
  std::vector<Boxed> result;
  for (Eigen::Index t = 0; t < mesh.triangles.rows(); ++t) result.push_back(boxed(place(corners(mesh, t))));
  return result;
}

std::array<geometry::Extent, 3> whole_box(const std::vector<Boxed>& all)
{
  std::array<geometry::Extent, 3> whole = all.front().box;
  for (const Boxed& one : all) {
    for (std::size_t k = 0; k < 3; ++k) {
      whole[k].least = std::min(whole[k].least, one.box[k].least);
      whole[k].most = std::max(whole[k].most, one.box[k].most);
    }
  }
  return whole;
}

}  // namespace

bool textbook_collides(const geometry::TreeMesh& reference, const geometry::TreeMesh& moving,
                       const MovingPose& pose)
{
  const geometry::Placement place(pose);
  return geometry::visit_close_pairs(
      reference.tree, moving.tree, geometry::Placement(pose), 0.0, [&](const geometry::TrianglePair& pair) {
        const Boxed r = boxed(corners(reference.mesh, pair.reference));
        const Boxed m = boxed(place(corners(moving.mesh, pair.moving)));
        return are_near(r.box, m.box) && fine_triangle_distance_mm(r.corner, m.corner) <= 0.0L;
      });
}

ThirdMeasure reference_measure(const Mesh& reference, const Mesh& moving, const MovingPose& pose)
{
  const std::vector<Boxed> fixed = all_boxed(reference, geometry::Placement({}));
  const std::vector<Boxed> placed = all_boxed(moving, geometry::Placement(pose));
  const std::array<geometry::Extent, 3> fixed_box = whole_box(fixed);
  ThirdMeasure result{false, std::numeric_limits<long double>::infinity()};
  for (const Boxed& m : placed) {
    if (!are_near(m.box, fixed_box)) continue;
    for (const Boxed& r : fixed) {
      if (!are_near(m.box, r.box)) continue;
      const long double distance_mm = fine_triangle_distance_mm(r.corner, m.corner);
      if (distance_mm > 0.0L) {
        if (!result.is_overlapping) result.from_touch_mm = std::min(result.from_touch_mm, distance_mm);
        continue;
      }
      const long double depth_mm = fine_triangle_depth_mm(r.corner, m.corner);
      result.from_touch_mm = result.is_overlapping ? std::max(result.from_touch_mm, depth_mm) : depth_mm;
      result.is_overlapping = true;
    }
  }
  return result;
}

}  // namespace vrda::test
