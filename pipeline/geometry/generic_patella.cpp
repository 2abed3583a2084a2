// The patella of the generated knees as a level set, with its tendon, retinacula and quadriceps.
#include <algorithm>
#include <cmath>

#include "core/text.hpp"
#include "core/units.hpp"
#include "geometry/generic_knee.hpp"
#include "geometry/level_set.hpp"

namespace vrda::geometry {
namespace {

const Eigen::Vector3d middle_mm(37.0, 24.0, 1.0);
// Half axes of the body; the facets meet in a ridge this far behind its middle.
const Eigen::Vector3d patella_half_axes_mm(11.0, 21.0, 21.5);
constexpr double ridge_mm = 8.4;
constexpr double medial_slope_rad = rad_from_deg(30.0), lateral_slope_rad = rad_from_deg(30.0);
constexpr double patella_cell_mm = 2.6;

// Behind a facet that rises from the ridge to one side.
double behind(const Eigen::Vector3d& p, double slope_rad, double side)
{
  const SinCos slope = sin_cos(slope_rad);
  return -slope.cos * (p.x() + ridge_mm) + slope.sin * side * p.z();
}

struct Strand {
  const char* name;
  const char* bundle;
  const char* from;  ///< "reference" or "moving"
  Eigen::Vector3d from_mm, patella_mm;
  double stiffness_n, strain, share;
  const char* wrap;
};

// Stiffness and forces: Smith et al. 2019, J Biomech 82:124 (smith2019.osim): six fibres of 3000 N per unit
// strain for the tendon, 150 N for each of the retinacula, and maximal forces of the four muscles as shares
// of the pull. The attachments follow the generic knee's bones; strains in extension: tendon 0.02, retinacula
// 0.03.
std::vector<Strand> strands()
{
  return {{"PT1", "PT", "moving", {28, -38, -6}, {37, 3, -8}, 3000, 0.02, 0, ""},
          {"PT2", "PT", "moving", {29, -39, -2}, {39, 3, -4}, 3000, 0.02, 0, ""},
          {"PT3", "PT", "moving", {29, -39, 1}, {39, 3, 1}, 3000, 0.02, 0, ""},
          {"PT4", "PT", "moving", {29, -39, 4}, {39, 3, 6}, 3000, 0.02, 0, ""},
          {"PT5", "PT", "moving", {28, -38, 8}, {37, 3, 10}, 3000, 0.02, 0, ""},
          {"PT6", "PT", "moving", {28, -43, 1}, {38, 3, 3}, 3000, 0.02, 0, ""},
          {"MPFL1", "MPFL", "reference", {-1, 7, -42}, {36, 36, -18}, 600, 0.03, 0, ""},
          {"MPFL2", "MPFL", "reference", {-1, 5, -42}, {36, 31, -20}, 600, 0.03, 0, ""},
          {"MPFL3", "MPFL", "reference", {-1, 3, -42}, {36, 25, -20}, 600, 0.03, 0, ""},
          {"LPFL1", "LPFL", "reference", {4, 8, 39}, {36, 35, 20}, 600, 0.03, 0, ""},
          {"LPFL2", "LPFL", "reference", {4, 4, 40}, {36, 28, 22}, 600, 0.03, 0, ""},
          {"LPFL3", "LPFL", "reference", {4, 0, 40}, {36, 20, 22}, 600, 0.03, 0, ""},
          {"rectus_femoris", "QUAD", "reference", {40, 400, 8}, {40, 44, 1}, 0, 0, 848.8, "quadriceps"},
          {"vastus_intermedius",
           "QUAD",
           "reference",
           {32, 180, 22},
           {36, 45, 1},
           0,
           0,
           1024.2,
           "quadriceps_deep"},
          {"vastus_lateralis", "QUAD", "reference", {26, 135, 30}, {36, 38, 15}, 0, 0, 2255.4, "quadriceps"},
          {"vastus_medialis", "QUAD", "reference", {32, 118, -6}, {36, 37, -15}, 0, 0, 1443.7, "quadriceps"}};
}

std::string cylinder(const PatellaPlace& place, const char* name, double radius_mm, bool is_left)
{
  const Eigen::Vector3d& p_mm = place.cylinder_mm;
  std::string text =
      std::string("{\"name\": \"") + name +
      "\", \"type\": \"WrapCylinder\", \"body\": \"reference\", \"xyz_body_rotation\": [0, 0, 0], "
      "\"translation\": [";
  for (const double x_mm : {p_mm.x(), p_mm.y(), is_left ? -p_mm.z() : p_mm.z()})
    text += (text.back() == '[' ? "" : ", ") + shortest_decimal(x_mm / 1e3);
  return text + "], \"radius\": " + shortest_decimal(radius_mm / 1e3) + ", \"length\": 0.18}";
}

}  // namespace

double patella_field(const Eigen::Vector3d& p_mm)
{
  const Eigen::Vector3d p = p_mm - middle_mm, scaled = p.cwiseQuotient(patella_half_axes_mm);
  // Narrower towards the apex.
  const double width = 1.0 - 0.28 * smooth_step(2.0, -21.0, p.y());
  const double body =
      (Eigen::Vector3d(scaled.x(), scaled.y(), scaled.z() / width).norm() - 1.0) * patella_half_axes_mm.x();
  return smooth_max(smooth_max(body, behind(p, medial_slope_rad, -1.0), 2.0),
                    behind(p, lateral_slope_rad, 1.0), 2.0);
}

Mesh patella_mesh(double resolution, const PatellaPlace& place)
{
  LevelSetOptions options;
  options.cell_mm = patella_cell_mm / resolution;
  const Eigen::Vector3d reach = patella_half_axes_mm + Eigen::Vector3d::Constant(6.0);
  Mesh mesh = level_set_mesh([](const Eigen::Vector3d& p) { return patella_field(p); },
                             {middle_mm - reach, middle_mm + reach}, options);
  mesh.vertices_mm.rowwise() += place.shift_mm.transpose();
  return mesh;
}

FollowerTexts patella_texts(const PatellaPlace& place, bool is_left)
{
  std::string table =
      "# Patella of the generated knee; mm in canonical axes. Stiffness and shares: Smith et al. 2019, J "
      "Biomech 82:124.\n"
      "name,bundle,from_body,from_x_mm,from_y_mm,from_z_mm,to_x_mm,to_y_mm,to_z_mm,stiffness_n_per_strain,"
      "slack_length_mm,tension_share,wrap\n";
  for (const Strand& strand : strands()) {
    const bool is_line = strand.share > 0.0, is_moving = strand.from == std::string("moving");
    const Eigen::Vector3d patella_mm = on_surface(patella_field, strand.patella_mm) + place.shift_mm;
    Eigen::Vector3d from_mm = is_line ? Eigen::Vector3d(strand.from_mm + place.shift_mm)
                              : is_moving
                                  ? on_surface(place.tibia, strand.from_mm + place.tuberosity_shift_mm)
                                  : on_surface(place.femur, strand.from_mm);
    const Eigen::Vector3d design_mm =
        from_mm + (is_moving ? place.tendon_mm : 0.0) * Eigen::Vector3d::UnitX();
    const double slack_mm = (design_mm - patella_mm).norm() / (1.0 + strand.strain);
    if (is_moving) from_mm += Eigen::Vector3d(place.tendon_mm, -place.clearance_mm, 0.0);
    table += std::string(strand.name) + "," + strand.bundle + "," + strand.from;
    for (const Eigen::Vector3d& p_mm : {from_mm, patella_mm}) {
      for (const double x_mm : {p_mm.x(), p_mm.y(), is_left ? -p_mm.z() : p_mm.z()})
        table += "," + shortest_decimal(x_mm);
    }
    table += is_line ? ",,," + shortest_decimal(strand.share) + "," + strand.wrap
                     : "," + shortest_decimal(strand.stiffness_n) + "," + shortest_decimal(slack_mm) + ",,";
    table += "\n";
  }
  return {table, "[" + cylinder(place, "quadriceps", place.cylinder_radius_mm, is_left) + ",\n " +
                     cylinder(place, "quadriceps_deep", place.cylinder_radius_mm - 2.0, is_left) + "]\n"};
}

}  // namespace vrda::geometry
