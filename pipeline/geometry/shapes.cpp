#include "geometry/shapes.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdio>

#include "core/text.hpp"
#include "core/units.hpp"
#include "geometry/catalogue.hpp"
#include "geometry/level_set.hpp"
#include "model/frames.hpp"

namespace vrda::geometry {
namespace {

using Entry = CatalogueEntry;
using Values = ShapeValues;

// "one of a, b, c; the nearest is b"
std::string one_of(const std::string& word, const std::vector<std::string>& known)
{
  if (known.empty()) return "no parameter";
  return "one of " + joined(known) + "; the nearest is " + nearest_word(word, known);
}

const Entry& entry(const std::string& shape)
{
  for (const Entry& candidate : shape_catalogue()) {
    if (candidate.name == shape) return candidate;
  }
  throw InputError({"shape", "name", "\"" + shape + "\"", one_of(shape, shape_names())});
}

const ShapeParameter& parameter(const Entry& chosen, const std::string& name)
{
  std::vector<std::string> known;
  for (const ShapeParameter& candidate : chosen.parameters) {
    if (candidate.name == name) return candidate;
    known.push_back(candidate.name);
  }
  throw InputError({"shape " + chosen.name, "parameters", "\"" + name + "\"", one_of(name, known)});
}

void set_number(Values& values, const Entry& chosen, const std::string& name, double value)
{
  const ShapeParameter& wanted = parameter(chosen, name);
  if (!wanted.choices.empty()) {
    throw InputError({"shape " + chosen.name, name, rounded_text(value), one_of("", wanted.choices)});
  }
  const bool is_in_range = value >= wanted.lowest && value <= wanted.highest;  // false for NaN
  const bool is_allowed = is_in_range && (!wanted.is_integer || value == std::floor(value));
  if (!is_allowed) {
    throw InputError({"shape " + chosen.name, name, rounded_text(value),
                      std::string(wanted.is_integer ? "a whole number" : "a number") + " from " +
                          rounded_text(wanted.lowest) + " to " + rounded_text(wanted.highest) +
                          (wanted.unit.empty() ? "" : " " + wanted.unit)});
  }
  values.set(name, value);
}

void set_word(Values& values, const Entry& chosen, const std::string& name, const std::string& value)
{
  const ShapeParameter& wanted = parameter(chosen, name);
  if (wanted.choices.empty()) {
    throw InputError({"shape " + chosen.name, name, "\"" + value + "\"", "a number"});
  }
  if (std::find(wanted.choices.begin(), wanted.choices.end(), value) == wanted.choices.end()) {
    throw InputError({"shape " + chosen.name, name, "\"" + value + "\"", one_of(value, wanted.choices)});
  }
  values.set(name, value);
}

// In the fewest digits that read back as the same double.
std::string exact_text(double number)
{
  char buffer[32];
  const auto [end, error] = std::to_chars(buffer, buffer + sizeof buffer, number);
  check(error == std::errc(), "a number longer than any double");
  return {buffer, end};
}

const Entry& entry_with_fibres(const std::string& shape)
{
  const Entry& chosen = entry(shape);
  if (chosen.fibres != nullptr) return chosen;
  std::vector<std::string> able;
  for (const Entry& each : shape_catalogue()) {
    if (each.fibres != nullptr) able.push_back(each.name);
  }
  throw InputError({"shape", "name", "\"" + shape + "\", which has no ligaments", one_of(shape, able)});
}

Values values_of(const ShapeRequest& request, const Entry& chosen)
{
  Values values;
  for (const ShapeParameter& each : chosen.parameters) {
    if (each.choices.empty()) values.set(each.name, each.default_number);
    if (!each.choices.empty()) values.set(each.name, each.choices.front());
  }
  for (const auto& [name, value] : request.numbers) set_number(values, chosen, name, value);
  for (const auto& [name, value] : request.words) set_word(values, chosen, name, value);
  return values;
}

}  // namespace

std::vector<std::string> shape_names()
{
  std::vector<std::string> names;
  for (const Entry& each : shape_catalogue()) names.push_back(each.name);
  return names;
}

std::string shape_summary(const std::string& shape)
{
  return entry(shape).summary;
}

std::vector<ShapeParameter> shape_parameters(const std::string& shape)
{
  return entry(shape).parameters;
}

Shape generate_shape(const ShapeRequest& request)
{
  const Entry& chosen = entry(request.shape);
  return chosen.build(values_of(request, chosen));
}

std::vector<ShapeFibre> generate_fibres(const ShapeRequest& request)
{
  const Entry& chosen = entry_with_fibres(request.shape);
  return chosen.fibres(values_of(request, chosen));
}

std::string fibre_table(const ShapeRequest& request)
{
  std::string table = entry_with_fibres(request.shape).fibre_sources;
  table +=
      "name,bundle,reference_x_mm,reference_y_mm,reference_z_mm,moving_x_mm,moving_y_mm,moving_z_mm,"
      "stiffness_n_per_strain,slack_length_mm\n";
  for (const ShapeFibre& fibre : generate_fibres(request)) {
    table += fibre.name + "," + fibre.bundle;
    for (const Eigen::Vector3d& p_mm : {fibre.reference_mm, fibre.moving_mm}) {
      for (const double x_mm : p_mm) table += "," + exact_text(x_mm);
    }
    table += "," + exact_text(fibre.stiffness_n) + "," + exact_text(fibre.slack_length_mm) + "\n";
  }
  return table;
}

FollowerTexts follower_texts(const ShapeRequest& request)
{
  const Entry& chosen = entry(request.shape);
  if (chosen.follower != nullptr) return chosen.follower(values_of(request, chosen));
  std::vector<std::string> able;
  for (const Entry& each : shape_catalogue()) {
    if (each.follower != nullptr) able.push_back(each.name);
  }
  throw InputError(
      {"shape", "name", "\"" + request.shape + "\", which has no follower", one_of(request.shape, able)});
}

namespace {

constexpr double rim_rounding_mm = 1.5;
// Edges of a tenth of the radius: about 3,500 triangles on the socket at resolution 1.
constexpr double cells_a_radius = 10.0;

LevelSetOptions options_for(const HipParameters& plan)
{
  LevelSetOptions options;
  options.cell_mm = plan.radius_mm / (cells_a_radius * plan.resolution);
  options.cell_mm = std::min(options.cell_mm, 0.6 * plan.wall_mm);
  return options;
}

// Meshed with its opening at -Y: not every direction gives a manifold net.
Mesh socket(const HipParameters& plan)
{
  const double inner_mm = plan.radius_mm + plan.clearance_mm;
  const Field field = [=](const Eigen::Vector3d& p) {
    const double from_centre = p.norm();
    const double wall = std::max(inner_mm - from_centre, from_centre - inner_mm - plan.wall_mm);
    return smooth_max(wall, -plan.depth_mm - p.y(), rim_rounding_mm);
  };
  const double reach_mm = inner_mm + 2.0 * plan.wall_mm;
  const Mesh mesh = level_set_mesh(
      field, {Eigen::Vector3d::Constant(-reach_mm), Eigen::Vector3d::Constant(reach_mm)}, options_for(plan));
  Pose X_canonical_socket = Pose::Identity();
  X_canonical_socket.linear() =
      rotation_x(-rad_from_deg(plan.inclination_deg)) * rotation_z(rad_from_deg(plan.anteversion_deg));
  return transformed(mesh, X_canonical_socket);
}

Mesh head(const HipParameters& plan)
{
  const SinCos lean = sin_cos(rad_from_deg(plan.neck_deg));
  const Eigen::Vector3d axis(0.0, -lean.cos, lean.sin);
  const double length_mm = 2.0 * plan.radius_mm;
  const double neck_mm = plan.radius_mm / plan.neck_ratio;
  const Field field = [=](const Eigen::Vector3d& p) {
    const double along = std::clamp(p.dot(axis), 0.0, length_mm);
    const double neck = (p - along * axis).norm() - neck_mm;
    return smooth_min(p.norm() - plan.radius_mm, neck, 0.15 * plan.radius_mm);
  };
  const double reach_mm = length_mm + 1.5 * neck_mm;
  return level_set_mesh(field, {Eigen::Vector3d::Constant(-reach_mm), Eigen::Vector3d::Constant(reach_mm)},
                        options_for(plan));
}

}  // namespace

Shape hip(const HipParameters& plan)
{
  const double inner_mm = plan.radius_mm + plan.clearance_mm;
  // A rim below the centre must leave an opening for the head; a rim above it must leave a cap.
  const double deepest_mm = std::sqrt(inner_mm * inner_mm - plan.radius_mm * plan.radius_mm);
  const double shallowest_mm = -0.8 * inner_mm;
  if (plan.depth_mm > deepest_mm || plan.depth_mm < shallowest_mm) {
    throw InputError({"shape hip", "depth", std::to_string(plan.depth_mm),
                      "from " + std::to_string(shallowest_mm) + " to " + std::to_string(deepest_mm) +
                          " mm for this radius and clearance, so that the head can enter and is retained"});
  }
  return {{{"socket", "bone", true, socket(plan)}}, {{"head", "bone", true, head(plan)}}};
}

namespace {

constexpr double ankle_rounding_mm = 2.0;
// Edges of a tenth of the trochlea's radius.
constexpr double ankle_cells_a_radius = 10.0;
constexpr double tibia_wall_mm = 14.0;      // above the top of the trochlea
constexpr double malleolus_mm = 8.0;        // its thickness
constexpr double malleolus_space_mm = 1.5;  // between it and the trochlea

LevelSetOptions ankle_options(const AnkleParameters& plan)
{
  LevelSetOptions options;
  options.cell_mm = plan.radius_mm / (ankle_cells_a_radius * plan.resolution);
  return options;
}

// Radius of the trochlea at z: smallest in the middle.
double profile_mm(const AnkleParameters& plan, double z_mm)
{
  return plan.radius_mm + plan.groove_mm -
         std::sqrt(std::max(plan.groove_mm * plan.groove_mm - z_mm * z_mm, 0.0));
}

double from_axis_mm(const Eigen::Vector3d& p)
{
  return std::sqrt(p.x() * p.x() + p.y() * p.y());
}

// Inside a block with rounded edges.
double block(const Eigen::Vector3d& p, const Eigen::Vector3d& min_mm, const Eigen::Vector3d& max_mm)
{
  const Eigen::Vector3d off = (min_mm - p).cwiseMax(p - max_mm);
  return smooth_max(smooth_max(off.x(), off.y(), ankle_rounding_mm), off.z(), ankle_rounding_mm);
}

Mesh talus(const AnkleParameters& plan)
{
  const double half_mm = 0.5 * plan.width_mm;
  const Field field = [=](const Eigen::Vector3d& p) {
    const double ends =
        smooth_max(std::abs(p.z()) - half_mm, -0.7 * plan.radius_mm - p.y(), ankle_rounding_mm);
    return smooth_max(from_axis_mm(p) - profile_mm(plan, p.z()), ends, ankle_rounding_mm);
  };
  const double reach_mm = 1.5 * plan.radius_mm + half_mm;
  return level_set_mesh(field, {Eigen::Vector3d::Constant(-reach_mm), Eigen::Vector3d::Constant(reach_mm)},
                        ankle_options(plan));
}

Mesh tibia_of_ankle(const AnkleParameters& plan)
{
  const double half_mm = 0.5 * plan.width_mm, wall_mm = half_mm + malleolus_space_mm;
  const double top_mm = plan.radius_mm + plan.clearance_mm + tibia_wall_mm;
  const Field field = [=](const Eigen::Vector3d& p) {
    // The roof covers 60 degrees to the front and to the back.
    const double roof = block(p, {-plan.radius_mm, 0.5 * plan.radius_mm, -wall_mm - malleolus_mm},
                              {plan.radius_mm, top_mm, wall_mm});
    const double cavity = profile_mm(plan, p.z()) + plan.clearance_mm - from_axis_mm(p);
    const double malleolus = block(p, {-0.5 * plan.radius_mm, -0.6 * plan.radius_mm, -wall_mm - malleolus_mm},
                                   {0.5 * plan.radius_mm, top_mm - 0.5 * tibia_wall_mm, -wall_mm});
    return smooth_min(smooth_max(roof, cavity, ankle_rounding_mm), malleolus, ankle_rounding_mm);
  };
  const double reach_mm = top_mm + plan.width_mm;
  return level_set_mesh(field, {Eigen::Vector3d::Constant(-reach_mm), Eigen::Vector3d::Constant(reach_mm)},
                        ankle_options(plan));
}

}  // namespace

Shape ankle(const AnkleParameters& plan)
{
  return {{{"tibia", "bone", true, tibia_of_ankle(plan)}}, {{"talus", "bone", true, talus(plan)}}};
}

void require_moderate_size(double n_triangles, const std::string& parameter)
{
  constexpr double most_millions = 2.0;
  if (n_triangles <= 1e6 * most_millions) return;
  char found[64];
  std::snprintf(found, sizeof found, "a mesh of up to %.3g million triangles", 1e-6 * n_triangles);
  throw InputError({"shape", parameter, found, "a value for at most 2 million"});
}

}  // namespace vrda::geometry
