#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "core/trig.hpp"
#include "core/units.hpp"
#include "shapes/knee.hpp"
#include "shapes/smooth_ops.hpp"

namespace vrda {
namespace {

// A C around the place where a condyle rests, open towards the eminence.
// Its upper side follows the condyle in extension, its lower side the plateau.
struct MeniscusPlan {
  Condyle condyle;
  Eigen::Vector2d middle_mm;  // (x, z) the rays of the sections start from
  double towards_eminence;    // sign of z
  double half_opening_rad;    // between the ray to the eminence and the first (last) section
  Eigen::Vector2d outer_mm;   // half axes of the outer rim, along x and z
  double rim_height_mm;       // of the outer rim above the plateau
  double inner_height_mm;     // thickness at the inner rim: thin, not sharp
  double clearance_mm;        // below the condyle, in extension
  int n_sections;             // at resolution 1
  int n_across;
};

// Room for the facets of the plateau, whose chords rise above it where it is hollow.
constexpr double above_plateau_mm = 0.2;

MeniscusPlan medial_plan()
{
  const Eigen::Vector3d rest = medial_rest_mm();
  return {medial_condyle(),
          {rest.x() - 2.5, rest.z()},
          1.0,
          rad_from_deg(62.0),
          {20.0, 17.0},
          5.5,
          0.8,
          0.15,
          31,
          4};
}

MeniscusPlan lateral_plan()
{
  const Eigen::Vector3d rest = lateral_rest_mm();
  return {
      lateral_condyle(), {rest.x(), rest.z()}, -1.0, rad_from_deg(45.0), {17.5, 16.0}, 5.5, 0.8, 0.1, 34, 4};
}

// One ray of the C, seen from above.
struct Ray {
  Eigen::Vector2d direction;  // (x, z)
  double outer_mm = 0.0;      // distance of the outer rim
  double fullness = 1.0;      // 1 along the body, smaller towards the horns
};

Ray ray_at(const MeniscusPlan& plan, double t)
{
  // t in [0, 1] runs from the anterior horn around the outside to the posterior horn.
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
  double floor_mm = 0.0;  // height of the plateau, plus the room left above it
  double roof_mm = 0.0;   // height of the condyle's underside, less the clearance
};

Column column_at(const MeniscusPlan& plan, const Ray& ray, double distance_mm)
{
  const Eigen::Vector2d p = plan.middle_mm + distance_mm * ray.direction;
  return {plateau_height_mm(p.x(), p.y()) + above_plateau_mm,
          underside_mm(plan.condyle, p.x(), p.y()) - plan.clearance_mm};
}

// Where the wedge between condyle and plateau becomes high enough for the inner rim.
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

Mesh meniscus_mesh(const MeniscusPlan& plan, double resolution)
{
  const auto scaled = [&](int n) { return std::max(1, static_cast<int>(std::lround(n * resolution))); };
  const int n_sections = std::max(4, scaled(plan.n_sections)), n_across = scaled(plan.n_across),
            n_wall = scaled(2);
  std::vector<Eigen::Vector3d> points;
  for (int i = 0; i <= n_sections; ++i) {
    const std::vector<Eigen::Vector3d> ring =
        section(plan, static_cast<double>(i) / n_sections, n_across, n_wall);
    points.insert(points.end(), ring.begin(), ring.end());
  }
  const int n_ring = static_cast<int>(points.size()) / (n_sections + 1);
  LoftBuilder builder(plan.towards_eminence < 0.0);
  const auto squared_mm2 = [&](int a, int b) {
    return (points[static_cast<std::size_t>(a)] - points[static_cast<std::size_t>(b)]).squaredNorm();
  };
  for (int i = 0; i < n_sections; ++i) {
    for (int k = 0; k < n_ring; ++k) {
      const int a = i * n_ring + k, b = i * n_ring + (k + 1) % n_ring, c = a + n_ring, d = b + n_ring;
      if (squared_mm2(a, d) <= squared_mm2(b, c)) {
        builder.add(a, b, d), builder.add(a, d, c);
      } else {
        builder.add(a, b, c), builder.add(b, d, c);
      }
    }
  }
  for (const int first : {0, n_sections * n_ring}) {
    const bool is_start = first == 0;
    const auto face = [&](int a, int b, int c) {
      is_start ? builder.add(first + a, first + c, first + b) : builder.add(first + a, first + b, first + c);
    };
    for (int k = 0; k + 1 < n_across; ++k) {
      face(k, k + 1, n_ring - 1 - k);
      face(k + 1, n_ring - 2 - k, n_ring - 1 - k);
    }
    const int pivot = n_ring - n_across;
    for (int k = n_across - 1; k < pivot - 1; ++k) face(pivot, k, k + 1);
  }
  Mesh mesh;
  mesh.vertices_mm.resize(static_cast<Eigen::Index>(points.size()), 3);
  for (std::size_t v = 0; v < points.size(); ++v)
    mesh.vertices_mm.row(static_cast<Eigen::Index>(v)) = points[v];
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

}  // namespace vrda
