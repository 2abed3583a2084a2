// The generic menisci: wedges between femur and plateau; canonical axes, mm.
#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "core/trig.hpp"
#include "core/units.hpp"
#include "geometry/knee.hpp"
#include "geometry/level_set.hpp"

namespace vrda::geometry {
namespace {

// A C-shaped wedge around a condyle's contact point, open towards the eminence. Its upper side follows the
// condyle in extension, its lower side the plateau.
struct MeniscusPlan {
  CondyleSurface condyle;
  Eigen::Vector2d middle_mm;  // (x, z) origin of the rays of the sections
  double towards_eminence;    // sign of z
  double half_opening_rad;    // between the ray to the eminence and the first (last) section
  Eigen::Vector2d outer_mm;   // half axes of the outer rim, along x and z
  double rim_height_mm;       // of the outer rim above the plateau
  double inner_height_mm;     // thickness at the inner rim: thin, not sharp
  double clearance_mm;        // below the condyle, in extension
  int n_sections;             // at resolution 1
  int n_across;
};

// Clearance for the facets of the plateau, whose chords are above the surface where it is concave.
constexpr double above_plateau_mm = 0.2;

MeniscusPlan medial_plan()
{
  const Eigen::Vector3d rest = medial_contact_point_mm();
  return {.condyle = CondyleSurface(medial_condyle()),
          .middle_mm = {rest.x() - 0.5, rest.z()},
          .towards_eminence = 1.0,
          .half_opening_rad = rad_from_deg(62.0),
          .outer_mm = {21.5, 17.0},
          .rim_height_mm = 5.5,
          .inner_height_mm = 0.8,
          .clearance_mm = 0.15,
          .n_sections = 30,
          .n_across = 4};
}

MeniscusPlan lateral_plan()
{
  const Eigen::Vector3d rest = lateral_contact_point_mm();
  return {.condyle = CondyleSurface(lateral_condyle()),
          .middle_mm = {rest.x(), rest.z()},
          .towards_eminence = -1.0,
          .half_opening_rad = rad_from_deg(45.0),
          .outer_mm = {17.5, 16.0},
          .rim_height_mm = 5.5,
          .inner_height_mm = 0.8,
          .clearance_mm = 0.1,
          .n_sections = 33,
          .n_across = 4};
}

// One ray of the C in the horizontal plane.
struct Ray {
  Eigen::Vector2d direction;  // (x, z)
  double outer_mm = 0.0;      // distance of the outer rim
  double fullness = 1.0;      // 1 along the body, smaller towards the horns
};

Ray ray_at(const MeniscusPlan& plan, double t)
{
  // t in [0, 1]: from the anterior horn around the outside to the posterior horn.
  const double turn = plan.half_opening_rad + t * 2.0 * (pi - plan.half_opening_rad);
  const SinCos a = sin_cos(turn);
  Ray ray;
  ray.direction = {a.sin, plan.towards_eminence * a.cos};
  ray.fullness = 0.45 + 0.55 * smooth_step(0.0, 0.22, std::min(t, 1.0 - t));
  const Eigen::Vector2d scaled = ray.direction.cwiseQuotient(plan.outer_mm);
  ray.outer_mm = 1.0 / scaled.norm();
  return ray;
}

struct Column {
  double floor_mm = 0.0;  // height of the plateau plus above_plateau_mm
  double roof_mm = 0.0;   // height of the condyle's underside minus the clearance
};

Column column_at(const MeniscusPlan& plan, const Ray& ray, double distance_mm)
{
  const Eigen::Vector2d p = plan.middle_mm + distance_mm * ray.direction;
  return {plateau_height_mm(p.x(), p.y()) + above_plateau_mm,
          plan.condyle.underside_mm(p.x(), p.y()) - plan.clearance_mm};
}

// Distance at which the wedge between condyle and plateau reaches the height of the inner rim.
double inner_distance_mm(const MeniscusPlan& plan, const Ray& ray)
{
  double low = 5.0, high = ray.outer_mm - 4.0;
  constexpr int n_halvings = 40;
  for (int step = 0; step < n_halvings; ++step) {
    const double middle = 0.5 * (low + high);
    const Column column = column_at(plan, ray, middle);
    (column.roof_mm - column.floor_mm < plan.inner_height_mm ? low : high) = middle;
  }
  return high;
}

// Points of one section: the upper side from the inner rim outward, down the outer wall, the lower side
// inward.
std::vector<Eigen::Vector3d> section(const MeniscusPlan& plan, double t, int n_across, int n_wall)
{
  const Ray ray = ray_at(plan, t);
  const double inner_mm = inner_distance_mm(plan, ray);
  const double outer_mm = inner_mm + ray.fullness * (ray.outer_mm - inner_mm);
  std::vector<Eigen::Vector3d> upper, lower;
  for (int k = 0; k <= n_across; ++k) {
    const double s = static_cast<double>(k) / n_across;
    const double distance_mm = inner_mm + s * (outer_mm - inner_mm);
    const Column column = column_at(plan, ray, distance_mm);
    const Eigen::Vector2d p = plan.middle_mm + distance_mm * ray.direction;
    const double rim_mm = column.floor_mm + plan.rim_height_mm * (0.4 + 0.6 * ray.fullness);
    const double top_mm = smooth_min(column.roof_mm, rim_mm, 1.5);
    upper.emplace_back(p.x(), std::max(top_mm, column.floor_mm + 0.5 * plan.inner_height_mm), p.y());
    lower.emplace_back(p.x(), column.floor_mm, p.y());
  }
  std::vector<Eigen::Vector3d> points = upper;
  for (int k = 1; k < n_wall; ++k) {
    const double s = static_cast<double>(k) / n_wall;
    points.push_back((1.0 - s) * upper.back() + s * lower.back());
  }
  points.insert(points.end(), lower.rbegin(), lower.rend());
  return points;
}

// Triangles of the loft: quads between sections along their shorter diagonal, both ends closed.
class LoftBuilder {
 public:
  explicit LoftBuilder(bool is_reversed) : is_reversed_(is_reversed) {}

  void add(std::int32_t a, std::int32_t b, std::int32_t c)
  {
    triangles_.push_back(is_reversed_ ? std::array{a, c, b} : std::array{a, b, c});
  }
  Triangles triangles() const
  {
    Triangles result(static_cast<Eigen::Index>(triangles_.size()), 3);
    for (std::size_t t = 0; t < triangles_.size(); ++t) {
      result.row(static_cast<Eigen::Index>(t)) << triangles_[t][0], triangles_[t][1], triangles_[t][2];
    }
    return result;
  }

 private:
  bool is_reversed_;
  std::vector<std::array<std::int32_t, 3>> triangles_;
};

// Points of all sections in order; n_ring points per section, n_across cells along the upper side.
struct Loft {
  std::vector<Eigen::Vector3d> points;
  int n_sections = 0;
  int n_ring = 0;
  int n_across = 0;
};

Loft lofted(const MeniscusPlan& plan, double resolution)
{
  const auto scaled = [&](int n) { return std::max(1, static_cast<int>(std::lround(n * resolution))); };
  constexpr int fewest_sections = 4;
  constexpr int wall_cells = 2;  // the outer wall is about as high as two cells are wide
  Loft loft;
  loft.n_sections = std::max(fewest_sections, scaled(plan.n_sections));
  loft.n_across = scaled(plan.n_across);
  for (int i = 0; i <= loft.n_sections; ++i) {
    const double t = static_cast<double>(i) / loft.n_sections;
    const std::vector<Eigen::Vector3d> ring = section(plan, t, loft.n_across, scaled(wall_cells));
    loft.points.insert(loft.points.end(), ring.begin(), ring.end());
    loft.n_ring = static_cast<int>(ring.size());
  }
  return loft;
}

void add_sides(LoftBuilder& builder, const Loft& loft)
{
  const auto squared_mm2 = [&](int a, int b) {
    return (loft.points[static_cast<std::size_t>(a)] - loft.points[static_cast<std::size_t>(b)])
        .squaredNorm();
  };
  for (int i = 0; i < loft.n_sections; ++i) {
    for (int k = 0; k < loft.n_ring; ++k) {
      const int a = i * loft.n_ring + k, b = i * loft.n_ring + (k + 1) % loft.n_ring;
      const int c = a + loft.n_ring, d = b + loft.n_ring;
      const bool is_first = squared_mm2(a, d) <= squared_mm2(b, c);
      builder.add(a, b, is_first ? d : c);
      builder.add(is_first ? a : b, d, c);
    }
  }
}

// Closes the section that starts at point `first`: strips between the upper and the lower side, a fan at the
// wall.
void add_end(LoftBuilder& builder, const Loft& loft, int first)
{
  const bool is_start = first == 0;
  const auto face = [&](int a, int b, int c) {
    builder.add(first + a, first + (is_start ? c : b), first + (is_start ? b : c));
  };
  for (int k = 0; k + 1 < loft.n_across; ++k) {
    face(k, k + 1, loft.n_ring - 1 - k);
    face(k + 1, loft.n_ring - 2 - k, loft.n_ring - 1 - k);
  }
  const int pivot = loft.n_ring - loft.n_across;
  for (int k = loft.n_across - 1; k < pivot - 1; ++k) face(pivot, k, k + 1);
}

Mesh meniscus_mesh(const MeniscusPlan& plan, double resolution)
{
  const Loft loft = lofted(plan, resolution);
  LoftBuilder builder(plan.towards_eminence < 0.0);
  add_sides(builder, loft);
  add_end(builder, loft, 0);
  add_end(builder, loft, loft.n_sections * loft.n_ring);
  Mesh mesh;
  mesh.vertices_mm.resize(static_cast<Eigen::Index>(loft.points.size()), 3);
  for (std::size_t v = 0; v < loft.points.size(); ++v) {
    mesh.vertices_mm.row(static_cast<Eigen::Index>(v)) = loft.points[v].transpose();
  }
  mesh.triangles = builder.triangles();
  mesh.normals = vertex_normals(mesh);
  return mesh;
}

}  // namespace

Mesh meniscus_medial_mesh(double resolution)
{
  return meniscus_mesh(medial_plan(), resolution);
}
Mesh meniscus_lateral_mesh(double resolution)
{
  return meniscus_mesh(lateral_plan(), resolution);
}

}  // namespace vrda::geometry
