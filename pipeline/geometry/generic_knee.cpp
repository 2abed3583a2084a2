// The generic femur, two condyles on a shaft, as a signed distance field and its mesh; canonical axes, mm.
#include "geometry/generic_knee.hpp"

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "core/units.hpp"
#include "geometry/level_set.hpp"

namespace vrda::geometry {
namespace {

// Above this height the femur is only drawn.
constexpr double femur_cut_mm = 16.0;
// Overlap of the drawn shaft with the condylar part: three triangles beyond its rounded end.
constexpr double femur_overlap_mm = 20.0;
constexpr double shaft_top_mm = 115.0;

double chain_of_hulls(const std::array<Hull, 2>& hulls, const Eigen::Vector3d& p)
{
  return smooth_min(hulls[0].signed_distance_mm(p), hulls[1].signed_distance_mm(p), 6.0);
}

std::array<Hull, 2> chain(const Ball& a, const Ball& b, const Ball& c)
{
  return {Hull(a, b), Hull(b, c)};
}

// The two ridges of the trochlea, from the front of each condyle up and towards the middle; the lateral one
// is further anterior. Their fillet is the floor of the groove.
double trochlea(const Eigen::Vector3d& p)
{
  static const std::array<Hull, 2> lateral =
      chain({{4.0, -4.0, 20.0}, 14.5}, {{17.0, 8.0, 15.0}, 15.0}, {{17.5, 32.0, 9.0}, 9.5});
  static const std::array<Hull, 2> medial =
      chain({{5.0, -4.0, -20.0}, 14.5}, {{16.5, 7.0, -14.0}, 13.5}, {{16.5, 29.0, -8.0}, 9.5});
  return smooth_min(chain_of_hulls(lateral, p), chain_of_hulls(medial, p), 7.0);
}

// Shaft and metaphysis above the condyles: elliptic sections that vary with height.
double shaft_and_flare(const Eigen::Vector3d& p)
{
  const double low = smooth_step(2.0, 48.0, p.y());
  const double high = smooth_step(35.0, 85.0, p.y());
  const double middle_x = 4.0 + 5.0 * low;
  const double half_depth = 23.0 - 7.0 * low - 2.0 * high;
  const double half_width = 36.0 - 16.0 * low - 5.5 * high;
  const double u = (p.x() - middle_x) / half_depth, w = p.z() / half_width;
  const double side = (std::sqrt(u * u + w * w) - 1.0) * std::min(half_depth, half_width);
  return smooth_max(side, -4.0 - p.y(), 16.0);
}

double epicondyles(const Eigen::Vector3d& p)
{
  const double medial = (p - Eigen::Vector3d(-1.0, 4.0, -32.0)).norm() - 10.5;
  const double lateral = (p - Eigen::Vector3d(-2.0, 3.0, 31.0)).norm() - 10.0;
  return std::min(medial, lateral);
}

// The notch between the condyles: a vault below and behind a roof at about 50 degrees.
double notch(const Eigen::Vector3d& p)
{
  const double roof = 7.5 - (-0.756 * p.x() - 0.655 * p.y());
  return smooth_max(std::abs(p.z()) - 9.5, roof, 9.0);
}

double condyles(const Eigen::Vector3d& p)
{
  static const CondyleSurface medial(medial_condyle());
  static const CondyleSurface lateral(lateral_condyle());
  const double flat_m = smooth_max(medial.signed_distance_mm(p), -p.z() - 40.5, 6.0);
  const double flat_l = smooth_max(lateral.signed_distance_mm(p), p.z() - 39.5, 6.0);
  return std::min(flat_m, flat_l);
}

constexpr double femur_cell_mm = 5.05;  // gives about 1,516 triangles below the cut

LevelSetOptions femur_options(double resolution)
{
  LevelSetOptions chosen;
  chosen.cell_mm = femur_cell_mm / resolution;
  return chosen;
}

LevelSet condylar_part()
{
  const Field lower = [](const Eigen::Vector3d& p) {
    return smooth_max(femur_field(p), p.y() - femur_cut_mm, 2.0);
  };
  return {lower, {{-45, -48, -60}, {55, femur_cut_mm + 10, 60}}};
}

}  // namespace

Condyle medial_condyle()
{
  Condyle c;
  c.posterior_radius_mm = 23.0;
  c.extra_radius_mm = 17.0;
  c.spiral_end_rad = rad_from_deg(110.0);
  c.shift_mm = {26.196, -12.884};
  c.coronal_radius_mm = 20.0;
  c.z_mm = -22.0;
  c.first_rad = rad_from_deg(-15.0);
  c.last_rad = rad_from_deg(140.0);
  return c;
}

Condyle lateral_condyle()
{
  Condyle c;
  c.posterior_radius_mm = 20.5;
  c.extra_radius_mm = 4.0;
  c.spiral_end_rad = rad_from_deg(110.0);
  c.shift_mm = {3.196, -7.884};
  c.coronal_radius_mm = 19.0;
  c.z_mm = 22.0;
  c.first_rad = rad_from_deg(-30.0);
  c.last_rad = rad_from_deg(140.0);
  return c;
}

double femur_field(const Eigen::Vector3d& p)
{
  const double front = smooth_min(trochlea(p), shaft_and_flare(p), 12.0);
  const double body = smooth_min(front, epicondyles(p), 10.0);
  const double whole = smooth_min(condyles(p), body, 7.0);
  return smooth_max(whole, -notch(p), 4.0);
}

BoneMeshes femur_meshes(double resolution, double drawn_resolution)
{
  const LevelSet lower = condylar_part();
  const Field upper = [](const Eigen::Vector3d& p) {
    const double above_cut = smooth_max(femur_field(p), femur_cut_mm - femur_overlap_mm - p.y(), 2.0);
    return smooth_max(above_cut, p.y() - shaft_top_mm, 2.0);
  };
  const Box box_mm{{-45, femur_cut_mm - femur_overlap_mm - 10, -60}, {55, shaft_top_mm + 10, 60}};
  const LevelSetOptions drawn = femur_options(drawn_resolution);
  auto [contact, shaft] = adjoining_level_set_meshes(lower, {upper, box_mm}, drawn);
  if (resolution != drawn_resolution) {
    contact = level_set_mesh(lower.field, lower.box_mm, femur_options(resolution));
  }
  hide_shaft_end(
      shaft, [](const Eigen::Vector3d& p) { return femur_cut_mm - p.y(); }, drawn.cell_mm);
  return {std::move(contact), std::move(shaft)};
}

// The generic menisci: wedges between femur and plateau; canonical axes, mm.

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
struct SagittalRay {
  Eigen::Vector2d direction;  // (x, z)
  double outer_mm = 0.0;      // distance of the outer rim
  double fullness = 1.0;      // 1 along the body, smaller towards the horns
};

SagittalRay ray_at(const MeniscusPlan& plan, double t)
{
  // t in [0, 1]: from the anterior horn around the outside to the posterior horn.
  const double turn = plan.half_opening_rad + t * 2.0 * (pi - plan.half_opening_rad);
  const SinCos a = sin_cos(turn);
  SagittalRay ray;
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

Column column_at(const MeniscusPlan& plan, const SagittalRay& ray, double distance_mm)
{
  const Eigen::Vector2d p = plan.middle_mm + distance_mm * ray.direction;
  return {plateau_height_mm(p.x(), p.y()) + above_plateau_mm,
          plan.condyle.underside_mm(p.x(), p.y()) - plan.clearance_mm};
}

// Distance at which the wedge between condyle and plateau reaches the height of the inner rim.
double inner_distance_mm(const MeniscusPlan& plan, const SagittalRay& ray)
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
  const SagittalRay ray = ray_at(plan, t);
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

// The generic tibia with plateaus and fibula, as signed distance fields and their meshes; canonical axes, mm.

namespace {

constexpr double tibia_cut_mm = -50.0;     // below it the tibia is only drawn
constexpr double tibia_overlap_mm = 17.0;  // of the drawn shaft with the contact part
constexpr double shaft_end_mm = -145.0;
constexpr double tibia_cell_mm = 3.95;

// A dish along one axis: curvature rise / reach^2 at the bottom, slope rise / reach far out.
double dish(double offset_mm, double rise_mm, double reach_mm)
{
  const double u = offset_mm / reach_mm;
  return rise_mm * (std::sqrt(1.0 + u * u) - 1.0);
}

// Compact bump of height 1: (1 - q)^3, twice continuously differentiable.
double bump(double dx, double dz)
{
  const double rest = std::max(0.0, 1.0 - dx * dx - dz * dz);
  return rest * rest * rest;
}

// Concave in both directions; posterior slope of about 3 degrees from rim to rim, level at the contact point.
double medial_plateau_mm(double x, double z)
{
  static const Eigen::Vector3d rest = medial_contact_point_mm();
  constexpr double slope = 0.08;
  // dish'(rest) = -slope makes the surface level at the contact point.
  constexpr double rise = 1.7, reach = 10.0;
  const double u = slope * reach / rise;
  const double ahead = reach * u / std::sqrt(1.0 - u * u);
  const double sagittal =
      dish(x - rest.x() - ahead, rise, reach) - dish(ahead, rise, reach) + slope * (x - rest.x());
  return rest.y() + sagittal + dish(z - rest.z(), 2.0, 10.0);
}

// Slightly convex from front to back, slightly concave from side to side, posterior slope of 4 degrees.
double lateral_plateau_mm(double x, double z)
{
  static const Eigen::Vector3d rest = lateral_contact_point_mm();
  const double dx = x - rest.x();
  constexpr double slope = 0.07, convex_radius_mm = 140.0;
  return rest.y() + slope * dx - dx * dx / (2.0 * convex_radius_mm) + dish(z - rest.z(), 1.6, 9.0);
}

double eminence_mm(double x, double z)
{
  const double medial = 8.0 * bump((x + 1.0) / 16.0, (z + 5.0) / 9.5);
  const double lateral = 6.5 * bump((x + 3.0) / 14.0, (z - 5.0) / 9.0);
  return smooth_max(medial, lateral, 3.0) - 0.5;
}

// Approximate signed distance from an ellipse.
double ellipse(double dx, double dz, double half_x, double half_z)
{
  const double u = dx / half_x, w = dz / half_z;
  return (std::sqrt(u * u + w * w) - 1.0) * std::min(half_x, half_z);
}

// Outline of the tibial head from above: two lobes and the front between them.
double head_outline(double x, double z)
{
  const double medial = ellipse(x - 3.0, z + 20.0, 25.0, 20.5);
  const double lateral = ellipse(x - 1.0, z - 20.0, 22.5, 20.0);
  const double front = ellipse(x - 7.0, z, 22.0, 24.0);
  return smooth_min(smooth_min(medial, lateral, 6.0), front, 10.0);
}

// Rounded triangular section of the shaft with its edge in front.
double shaft_outline(double x, double z)
{
  return smooth_max(ellipse(x - 4.0, z, 15.0, 13.0), 0.45 * (x - 4.0) + 0.9 * std::abs(z) - 12.0, 8.0);
}

double tuberosity(const Eigen::Vector3d& p)
{
  const Eigen::Vector3d d =
      (p - Eigen::Vector3d(15.5, -64.0, 1.0)).cwiseQuotient(Eigen::Vector3d(1.0, 1.7, 1.0));
  return d.norm() - 8.5;
}

LevelSetOptions tibia_options(double resolution)
{
  LevelSetOptions chosen;
  chosen.cell_mm = tibia_cell_mm / resolution;
  return chosen;
}

LevelSet plateau_part()
{
  const Field upper = [](const Eigen::Vector3d& p) {
    return smooth_max(tibia_field(p), tibia_cut_mm - p.y(), 2.0);
  };
  return {upper, {{-40, tibia_cut_mm - 10, -60}, {50, 0, 60}}};
}

}  // namespace

Eigen::Vector3d medial_contact_point_mm()
{
  const Support p = support(medial_condyle(), 0.0);
  return {-p.slope_mm, -p.value_mm, medial_condyle().z_mm};
}

Eigen::Vector3d lateral_contact_point_mm()
{
  const Support p = support(lateral_condyle(), 0.0);
  return {-p.slope_mm, -p.value_mm, lateral_condyle().z_mm};
}

double plateau_height_mm(double x, double z)
{
  const double w = smooth_step(-10.0, 10.0, z);
  return (1.0 - w) * medial_plateau_mm(x, z) + w * lateral_plateau_mm(x, z) + eminence_mm(x, z);
}

double tibia_field(const Eigen::Vector3d& p)
{
  const double narrowing = smooth_step(30.0, 78.0, -p.y());
  const double backward = 6.0 * smooth_step(30.0, 60.0, -p.y());
  const double side = (1.0 - narrowing) * head_outline(p.x(), p.z()) +
                      narrowing * shaft_outline(p.x() + backward - 6.0, p.z());
  const double with_tuberosity = smooth_min(side, tuberosity(p), 10.0);
  return smooth_max(with_tuberosity, p.y() - plateau_height_mm(p.x(), p.z()), 5.0);
}

double fibula_field(const Eigen::Vector3d& p)
{
  const double narrowing = smooth_step(48.0, 80.0, -p.y());
  const Eigen::Vector3d head = (p - Eigen::Vector3d(-15.0, -50.0, 37.0));
  const double shaft = ellipse(p.x() + 15.0 - 3.0 * narrowing, p.z() - 37.0 + 5.0 * narrowing,
                               7.0 - narrowing, 7.0 - narrowing);
  const double below = smooth_max(shaft, p.y() + 52.0, 3.0);
  return smooth_min(head.cwiseQuotient(Eigen::Vector3d(1.0, 1.25, 1.0)).norm() - 9.5, below, 6.0);
}

BoneMeshes tibia_meshes(double resolution, double drawn_resolution)
{
  const LevelSet upper = plateau_part();
  const Field lower = [](const Eigen::Vector3d& p) {
    const double below_cut = smooth_max(tibia_field(p), p.y() - tibia_cut_mm - tibia_overlap_mm, 2.0);
    return smooth_max(below_cut, shaft_end_mm - p.y(), 2.0);
  };
  const Box box_mm{{-40, shaft_end_mm - 10, -60}, {50, tibia_cut_mm + tibia_overlap_mm + 10, 60}};
  const LevelSetOptions drawn = tibia_options(drawn_resolution);
  auto [contact, shaft] = adjoining_level_set_meshes(upper, {lower, box_mm}, drawn);
  if (resolution != drawn_resolution) {
    contact = level_set_mesh(upper.field, upper.box_mm, tibia_options(resolution));
  }
  hide_shaft_end(
      shaft, [](const Eigen::Vector3d& p) { return p.y() - tibia_cut_mm; }, drawn.cell_mm);
  return {std::move(contact), std::move(shaft)};
}

Mesh fibula_mesh(double resolution)
{
  LevelSetOptions options;
  options.cell_mm = 3.5 / resolution;
  const Field whole = [](const Eigen::Vector3d& p) {
    return smooth_max(fibula_field(p), shaft_end_mm - p.y(), 2.0);
  };
  return level_set_mesh(whole, {{-40, shaft_end_mm - 10, 15}, {10, -30, 60}}, options);
}

Eigen::Vector3d on_surface(double (*field)(const Eigen::Vector3d&), const Eigen::Vector3d& near_mm)
{
  constexpr int most_steps = 20;
  constexpr double step_mm = 1e-4;
  Eigen::Vector3d p = near_mm;
  for (int i = 0; i < most_steps; ++i) {
    Eigen::Vector3d slope;
    for (Eigen::Index k = 0; k < 3; ++k) {
      const Eigen::Vector3d h = step_mm * Eigen::Vector3d::Unit(k);
      slope[k] = (field(p + h) - field(p - h)) / (2.0 * step_mm);
    }
    p -= field(p) / slope.squaredNorm() * slope;
  }
  return p;
}

std::vector<ShapeFibre> fibres_of(const std::vector<Bundle>& bundles,
                                  double (*femur_field)(const Eigen::Vector3d&), double clearance_mm)
{
  std::vector<ShapeFibre> fibres;
  for (const Bundle& bundle : bundles) {
    for (int i = 0; i < bundle.n_fibres; ++i) {
      const double t = static_cast<double>(i) / (bundle.n_fibres - 1);
      const Eigen::Vector3d femur_mm =
          on_surface(femur_field, (1.0 - t) * bundle.first_femur_mm + t * bundle.last_femur_mm);
      const Eigen::Vector3d tibia_mm =
          on_surface(bundle.moving_field, (1.0 - t) * bundle.first_tibia_mm + t * bundle.last_tibia_mm);
      const double length_mm = (tibia_mm - femur_mm).norm();
      fibres.push_back({bundle.name + std::to_string(i + 1), bundle.name, femur_mm,
                        tibia_mm - clearance_mm * Eigen::Vector3d::UnitY(),
                        bundle.stiffness_n / bundle.n_fibres, length_mm / (1.0 + bundle.reference_strain)});
    }
  }
  return fibres;
}

namespace {

struct Spiral {
  double value = 0.0;  // q(a)
  double slope = 0.0;  // q'(a)
};

Spiral spiral(double angle_rad, double end_rad)
{
  const double e2 = end_rad * end_rad;
  const double amplitude = 24.0 / (e2 * e2);
  if (angle_rad >= end_rad) {
    const SinCos beyond = sin_cos(angle_rad - end_rad);
    return {amplitude * beyond.cos, -amplitude * beyond.sin};
  }
  const double u = 1.0 - angle_rad / end_rad;
  return {u * u * u * u - 12.0 / e2 * u * u + amplitude, -(4.0 * u * u * u - 24.0 / e2 * u) / end_rad};
}

// Tangential offset of p from the ball centre at angle a, and its derivative over a:
// -(height above the curve + the curve's radius).
struct Lead {
  double value_mm = 0.0;
  double slope_mm = 0.0;
};

Support support_at(const Condyle& condyle, double angle_rad, const SinCos& a)
{
  const Spiral q = spiral(angle_rad, condyle.spiral_end_rad);
  const Eigen::Vector2d& shift = condyle.shift_mm;
  return {condyle.posterior_radius_mm + condyle.extra_radius_mm * q.value -
              (shift.x() * a.sin + shift.y() * a.cos),
          condyle.extra_radius_mm * q.slope - (shift.x() * a.cos - shift.y() * a.sin)};
}

Lead lead(const Condyle& condyle, const Eigen::Vector3d& p, double angle_rad)
{
  const SinCos a = sin_cos(angle_rad);
  const Support s = support_at(condyle, angle_rad, a);
  return {-a.cos * p.x() + a.sin * p.y() - s.slope_mm,
          a.sin * p.x() + a.cos * p.y() + s.value_mm - radius_mm(condyle, angle_rad)};
}

}  // namespace

Support support(const Condyle& condyle, double angle_rad)
{
  return support_at(condyle, angle_rad, sin_cos(angle_rad));
}

double radius_mm(const Condyle& condyle, double angle_rad)
{
  const double u = std::max(0.0, 1.0 - angle_rad / condyle.spiral_end_rad);
  return condyle.posterior_radius_mm + condyle.extra_radius_mm * u * u * u * u;
}

Eigen::Vector3d ball_centre_mm(const Condyle& condyle, double angle_rad)
{
  const SinCos a = sin_cos(angle_rad);
  const Support p = support_at(condyle, angle_rad, a);
  const double reach_mm = p.value_mm - condyle.coronal_radius_mm;
  return {-reach_mm * a.sin - p.slope_mm * a.cos, -reach_mm * a.cos + p.slope_mm * a.sin, condyle.z_mm};
}

CondyleSurface::CondyleSurface(const Condyle& condyle) : condyle_(condyle)
{
  const double last = static_cast<double>(n_samples - 1);
  std::array<Eigen::Vector3d, n_samples> centre_mm;
  for (std::size_t k = 0; k < n_samples; ++k) {
    const double t = static_cast<double>(k) / last;
    angle_rad_[k] = (1.0 - t) * condyle.first_rad + t * condyle.last_rad;
    centre_mm[k] = ball_centre_mm(condyle, angle_rad_[k]);
    centre_x_mm_[k] = centre_mm[k].x();
    centre_y_mm_[k] = centre_mm[k].y();
  }
  middle_mm_ = 0.5 * (centre_mm.front() + centre_mm.back());
  for (const Eigen::Vector3d& centre : centre_mm) {
    reach_mm_ = std::max(reach_mm_, (centre - middle_mm_).norm());
  }
  constexpr double between_samples_mm = 0.5;  // upper bound of the sagitta of a step
  reach_mm_ += condyle.coronal_radius_mm + between_samples_mm;
}

Eigen::Vector3d CondyleSurface::nearest_ball_centre_mm(const Eigen::Vector3d& p) const
{
  std::array<double, n_samples> distance_sq_mm2{};
  const double dz = p.z() - condyle_.z_mm;
  for (std::size_t k = 0; k < n_samples; ++k) {
    const double dx = p.x() - centre_x_mm_[k], dy = p.y() - centre_y_mm_[k];
    distance_sq_mm2[k] = dx * dx + (dy * dy + dz * dz);
  }
  const auto nearest = std::min_element(distance_sq_mm2.begin(), distance_sq_mm2.end());
  const auto at = static_cast<std::size_t>(nearest - distance_sq_mm2.begin());
  double low = angle_rad_[at == 0 ? 0 : at - 1];
  double high = angle_rad_[at + 1 == angle_rad_.size() ? at : at + 1];
  double angle_rad = angle_rad_[at];
  // Newton with bisection as fallback; the foot may be an end of the outline.
  constexpr int most_steps = 60;
  constexpr double resolution_mm = 1e-12, resolution_rad = 1e-14;
  for (int step = 0; step < most_steps && high - low > resolution_rad; ++step) {
    const Lead ahead = lead(condyle_, p, angle_rad);
    if (std::abs(ahead.value_mm) < resolution_mm) break;
    (ahead.value_mm > 0.0 ? low : high) = angle_rad;
    const double next = angle_rad - ahead.value_mm / ahead.slope_mm;
    const bool is_usable = ahead.slope_mm < 0.0 && next > low && next < high;
    angle_rad = is_usable ? next : 0.5 * (low + high);
  }
  return ball_centre_mm(condyle_, angle_rad);
}

double CondyleSurface::signed_distance_mm(const Eigen::Vector3d& p) const
{
  constexpr double far_mm = 12.0;  // more than the width of every fillet
  const double bound_mm = (p - middle_mm_).norm() - reach_mm_;
  if (bound_mm > far_mm) return bound_mm;
  return (p - nearest_ball_centre_mm(p)).norm() - condyle_.coronal_radius_mm;
}

double CondyleSurface::underside_mm(double x_mm, double z_mm) const
{
  // Newton from below, where the distance is decreasing and convex: iterates stay below the surface.
  Eigen::Vector3d p(x_mm, middle_mm_.y() - reach_mm_, z_mm);
  constexpr int most_steps = 60;
  constexpr double resolution_mm = 1e-12;
  for (int step = 0; step < most_steps; ++step) {
    const Eigen::Vector3d from_centre = p - nearest_ball_centre_mm(p);
    const double distance_mm = from_centre.norm() - condyle_.coronal_radius_mm;
    if (from_centre.y() >= 0.0) return p.y() + distance_mm;
    if (distance_mm < resolution_mm) break;
    p.y() -= distance_mm * from_centre.norm() / from_centre.y();
  }
  return p.y();
}

namespace {

// Drawn-only parts do not benefit from a higher resolution.
constexpr double finest_drawn_resolution = 3.0;

}  // namespace

double initial_clearance_mm()
{
  return 0.5;  // more than the chord errors of two concave surfaces
}

void hide_shaft_end(Mesh& shaft, const std::function<double(const Eigen::Vector3d&)>& depth_mm,
                    double cell_mm)
{
  // The rim is rounded over 2 mm; adjacent triangles and their shading are curved too.
  const double covered_mm = 2.0 + cell_mm;
  const double lift_mm = 0.02 * cell_mm;  // chords of the two parts over the flare differ by less
  // A small slope makes the crossing of the surfaces invisible; it increases once hidden.
  constexpr double slope = 0.03, bend_per_mm = 0.02, deepest_mm = 1.0;
  const double hidden_mm = covered_mm + 1.5 * cell_mm;
  for (Eigen::Index v = 0; v < shaft.vertices_mm.rows(); ++v) {
    const double depth = depth_mm(shaft.vertices_mm.row(v));
    const double further_mm = std::max(0.0, depth - hidden_mm);
    const double sink_mm = slope * std::max(0.0, depth - covered_mm) + bend_per_mm * further_mm * further_mm;
    const double lift = lift_mm * smooth_step(-3.0 * cell_mm, 0.0, depth);
    const double out_mm = lift - std::min(sink_mm, deepest_mm);
    shaft.vertices_mm.row(v) += out_mm * shaft.normals.row(v);
  }
}

PatellaPlace generic_patella()
{
  return {
      .femur = femur_field, .tibia = tibia_field, .clearance_mm = initial_clearance_mm(), .tendon_mm = 4.0};
}

Shape right_knee(double resolution)
{
  const double drawn = std::min(resolution, finest_drawn_resolution);
  BoneMeshes femur = femur_meshes(resolution, drawn), tibia = tibia_meshes(resolution, drawn);
  Shape shape;
  shape.reference = {{"femur", "bone", true, std::move(femur.contact)},
                     {"femur_shaft", "bone", false, std::move(femur.shaft)}};
  shape.moving = {{"tibia", "bone", true, std::move(tibia.contact)},
                  {"meniscus_medial", "meniscus", true, meniscus_medial_mesh(resolution)},
                  {"meniscus_lateral", "meniscus", true, meniscus_lateral_mesh(resolution)},
                  {"tibia_shaft", "bone", false, std::move(tibia.shaft)},
                  {"fibula", "bone", false, fibula_mesh(drawn)}};
  shape.followers = {{"patella", "bone", true, patella_mesh(resolution, generic_patella())}};
  for (ShapePart& part : shape.moving) part.mesh.vertices_mm.col(1).array() -= initial_clearance_mm();
  return shape;
}

namespace {

// The bundles follow the anatomy where this model allows; its notch has a lower roof than a real one, so the
// cruciates start from the edge of roof and wall nearest to the flexion axis. In the motion by contact alone
// no strain then exceeds 0.1 from 0 to 90 degrees: PCLal tightens with flexion, ACLpl and the collaterals
// slacken, ACLam and PCLpm change by about a tenth.
std::vector<Bundle> bundles()
{
  return {
      {"ACLam", 3, 4920, -0.112, {-1, -7, 2.3}, {1, -7, 2}, {16, -24, -4}, {16, -24, 0}, tibia_field},
      {"ACLpl", 3, 4920, -0.030, {-4, -7, 5}, {-5, -5.5, 4.5}, {12, -24, 0}, {12, -24, 4}, tibia_field},
      {"PCLal", 3, 4500, -0.020, {-7, -5.5, -7.5}, {-6, -5, -5}, {-14, -27, 1}, {-14, -27, 5}, tibia_field},
      {"PCLpm", 3, 1500, -0.094, {-10, -4, -9}, {-9, -6, -9}, {-14, -31, -5}, {-14, -31, -1}, tibia_field},
      {"MCLs", 4, 3000, 0.047, {0, 6, -42}, {2, 8, -41}, {6, -62, -15}, {12, -66, -12}, tibia_field},
      {"MCLd", 3, 2500, 0.016, {0, 3.5, -42}, {1.5, 3, -42}, {0, -34, -38}, {4, -34, -38}, tibia_field},
      {"MCLp", 3, 2500, 0.030, {-6, 0, -41}, {-5, 1, -41}, {-14, -34, -32}, {-10, -34, -34}, tibia_field},
      {"LCL", 4, 2400, 0.060, {-2, 0, 41}, {0, 4, 41}, {-15, -42, 44}, {-12, -44, 45}, fibula_field},
  };
}

}  // namespace

const char* const knee_fibre_sources =
    "# Ligaments of the generic knee; mm in canonical axes: X anterior, Y proximal, Z to the subject's "
    "right.\n"
    "# Stiffness and reference strain of each bundle, in extension with the condyles on the plateaus, are\n"
    "# those of Lenhart et al. 2015, Ann Biomed Eng 43:2675-2685 (OpenSim-JAM's lenhart2015.osim, means "
    "over\n"
    "# the bundle): ACLam 4920 N -0.112, ACLpl 4920 N -0.030, PCLal 4500 N -0.020, PCLpm 1500 N -0.094,\n"
    "# MCLs 3000 N 0.047, MCLd 2500 N 0.016, MCLp 2500 N 0.030, LCL 2400 N 0.060.\n"
    "# Tension: Blankevoort et al. 1991, J Biomech 24:1019-1031, transition strain 0.06.\n";

std::vector<ShapeFibre> right_knee_fibres()
{
  return fibres_of(bundles(), femur_field, initial_clearance_mm());
}

}  // namespace vrda::geometry
