#include "tables/osim_model.hpp"

#include <Eigen/Core>
#include <pugixml.hpp>

#include <algorithm>
#include <cmath>
#include <functional>
#include <set>
#include <sstream>
#include <tuple>

#include "core/text.hpp"
#include "core/units.hpp"
#include "model/frames.hpp"
#include "model/mesh.hpp"
#include "store/motion.hpp"
#include "tables/motion_table.hpp"

namespace vrda::tables {
namespace {

// More points than the largest order: the terms between show whether the series has ended.
constexpr int n_nodes = largest_osim_order + 6;
using Terms = Eigen::Matrix<double, n_nodes, n_nodes>;  // (degree in flexion, degree in varus)

struct Range {
  double first_rad, last_rad;
  double middle() const { return 0.5 * (first_rad + last_rad); }
  double half() const { return 0.5 * (last_rad - first_rad); }
};

/// cos(degree * angle of the k-th Chebyshev point).
double chebyshev(int degree, int k)
{
  return cosine(pi * degree * (2 * k + 1) / (2.0 * n_nodes));
}

/// Internal rotation (rad) and translation of the rotation centre (m).
using Values = std::array<double, 4>;

Values values_at(const store::MotionModel& model, const store::Motion& motion, const std::string& file,
                 const Attitude& attitude)
{
  const store::JointPose pose = motion.at(attitude);
  if (pose.status != store::PoseStatus::solved) {
    throw InputError({file, "status",
                      std::string("no pose at flexion ") +
                          shortest_decimal(deg_from_rad(attitude.flexion_rad)) + ", varus " +
                          shortest_decimal(deg_from_rad(attitude.varus_rad)) + " degrees",
                      "a pose at every attitude for --varus driven; a smoothed set has one"});
  }
  const Eigen::Vector3d& centre_mm = model.rotation_centre_mm;
  const Pose& X = pose.X_reference_moving;
  const Eigen::Vector3d t_m = metres_per_mm * (X * centre_mm - centre_mm);
  // About Delta = +Y theta is the internal rotation, without its wraps.
  const double internal_rad =
      clinical_coordinates(X, side_named(model.side), centre_mm).internal_rotation_rad;
  return {nearest_turn(internal_rad, pose.theta_rad), t_m.x(), t_m.y(), t_m.z()};
}

/// Discrete Chebyshev transform of the values at all pairs of points.
Terms terms_of(const Terms& values)
{
  Terms basis;  // (degree, point)
  for (int degree = 0; degree < n_nodes; ++degree)
    for (int k = 0; k < n_nodes; ++k)
      basis(degree, k) = (degree == 0 ? 1.0 : 2.0) / n_nodes * chebyshev(degree, k);
  return basis * values * basis.transpose();
}

/// The least order whose neglected terms sum to at most the error; largest_osim_order + 1 if all are larger.
int order_of(const Terms& terms)
{
  std::array<double, 2 * n_nodes> of_order{};
  for (int i = 0; i < n_nodes; ++i)
    for (int j = 0; j < n_nodes; ++j) of_order[static_cast<std::size_t>(i + j)] += std::abs(terms(i, j));
  double neglected = 0.0;
  int order = 2 * n_nodes - 2;
  while (order > 0 && neglected + of_order[static_cast<std::size_t>(order)] <= osim_surface_error)
    neglected += of_order[static_cast<std::size_t>(order--)];
  // OpenSim's derivative of a constant fails.
  return std::clamp(order, 1, largest_osim_order + 1);
}

/// Coefficients by power of T_degree((x - middle) / half), a row each.
Terms powers_of(const Range& range)
{
  const double scale = 1.0 / range.half(), shift = -range.middle() / range.half();
  Terms powers = Terms::Zero();
  powers(0, 0) = 1.0;
  powers(1, 0) = shift;
  powers(1, 1) = scale;
  for (int degree = 2; degree < n_nodes; ++degree) {
    for (int k = 0; k < n_nodes; ++k) {
      const double times_x = k > 0 ? powers(degree - 1, k - 1) : 0.0;
      powers(degree, k) = 2.0 * (scale * times_x + shift * powers(degree - 1, k)) - powers(degree - 2, k);
    }
  }
  return powers;
}

BivariatePolynomial polynomial_of(Terms terms, const Range& flexion, const Range& varus)
{
  BivariatePolynomial result;
  result.order = order_of(terms);
  for (int i = 0; i < n_nodes; ++i)
    for (int j = 0; j < n_nodes; ++j)
      if (i + j > result.order) terms(i, j) = 0.0;
  const Terms coefficients = powers_of(flexion).transpose() * terms * powers_of(varus);
  for (int i = 0; i <= result.order; ++i)
    for (int j = 0; i + j <= result.order; ++j) result.coefficients.push_back(coefficients(i, j));
  return result;
}

void require_surfaces(const store::MotionModel& model, const store::Motion& motion, const std::string& file,
                      const std::string& set)
{
  constexpr const char* wanted = "a smoothed set (degree_N) over a range of varus";
  if (model.frames || motion.is_varus_free() || model.varus_deg.size() < 2 || model.flexion_deg.size() < 2)
    throw InputError({file, "--varus", "driven, of a model over flexion only", wanted});
  if (set == "two_sided" || set == "zero_varus")
    throw InputError(
        {file, "--varus", "driven, of the set " + set + ", which depends on flexion only", wanted});
  if (store::has_turned_axes(model))
    throw InputError({file, "--varus", "driven, with a Delta other than proximal",
                      "Delta = +Y: the joint's angles are then those of the grid"});
}

}  // namespace

OsimSurfaces osim_surfaces(const store::MotionModel& model, const std::string& file, const std::string& set)
{
  const store::Motion motion(model, set);
  require_surfaces(model, motion, file, set);
  const Range flexion{motion.first_flexion_rad(), motion.last_flexion_rad()};
  const Range varus{motion.first_varus_rad(), motion.last_varus_rad()};
  std::array<Terms, 4> values;
  for (int i = 0; i < n_nodes; ++i) {
    for (int j = 0; j < n_nodes; ++j) {
      const Attitude attitude{flexion.middle() + flexion.half() * chebyshev(1, i),
                              varus.middle() + varus.half() * chebyshev(1, j)};
      const Values at = values_at(model, motion, file, attitude);
      for (std::size_t k = 0; k < at.size(); ++k) values[k](i, j) = at[k];
    }
  }
  OsimSurfaces result;
  result.flexion_rad = {flexion.first_rad, flexion.last_rad};
  result.varus_rad = {varus.first_rad, varus.last_rad};
  for (std::size_t k = 0; k < values.size(); ++k) {
    BivariatePolynomial polynomial = polynomial_of(terms_of(values[k]), flexion, varus);
    if (polynomial.order > largest_osim_order) {
      throw InputError({file, "--set", set + ", which is not smooth enough",
                        "a smoothed set: polynomials of order " + std::to_string(largest_osim_order) +
                            " must describe it within 1e-7 m and rad"});
    }
    (k == 0 ? result.internal_rad : result.translation_m[k - 1]) = std::move(polynomial);
  }
  return result;
}

namespace {

using Node = pugi::xml_node;

constexpr const char* document_version = "40000";  // of OpenSim 4.0: read by every later one
// Knots become denser towards the flexions of the model, where the motion or its varus has kinks; the
// two-sided motion has none.
constexpr double smallest_knot_step_deg = 0.002, smallest_smooth_step_deg = 0.05;
constexpr std::size_t most_knot_shares = 16;

Node add_text(Node parent, const char* name, const std::string& text)
{
  Node node = parent.append_child(name);
  node.text().set(text.c_str());
  return node;
}

Node add_named(Node parent, const char* type, const std::string& name)
{
  Node node = parent.append_child(type);
  node.append_attribute("name") = name.c_str();
  return node;
}

/// The list of an OpenSim set, `type` with its usual name.
Node add_set(Node parent, const char* type, const char* name)
{
  return add_named(parent, type, name).append_child("objects");
}

std::string numbers(std::initializer_list<double> values)
{
  std::string text;
  for (const double value : values) text += (text.empty() ? "" : " ") + shortest_decimal(value);
  return text;
}

std::string vector_text(const Eigen::Vector3d& v)
{
  return numbers({v.x(), v.y(), v.z()});
}

std::string metres_text(const Eigen::Vector3d& v_mm)
{
  return vector_text(metres_per_mm * v_mm);
}

/// Names that are unique within one set.
class UniqueNames {
 public:
  std::string operator()(const std::string& text)
  {
    const std::string name = opensim_name(text);
    std::string unique = name;
    for (int k = 2; !used_.insert(unique).second; ++k) unique = name + "_" + std::to_string(k);
    return unique;
  }

 private:
  std::set<std::string> used_;
};

/// [BodyIndex] of the joint's bodies, then the followers.
std::vector<std::string> body_names(const store::MotionModel& model)
{
  UniqueNames unique;
  std::vector<std::string> names{unique(model.reference.name)};
  names.push_back(unique(model.moving.name));
  for (const store::FollowerRows* follower : store::in_order(model.followers))
    names.push_back(unique(follower->name));
  return names;
}

std::string body_path(const std::string& name)
{
  return "/bodyset/" + name;
}

void require_rising_flexion(const FlexionMotion& motion, const OsimOptions& options)
{
  if (motion.frames.size() < 2)
    throw InputError({options.file, "flexion", "one pose", "at least two, for a spline"});
  for (std::size_t k = 1; k < motion.frames.size(); ++k) {
    if (motion.frames[k - 1].clinical.flexion_rad < motion.frames[k].clinical.flexion_rad) continue;
    throw InputError({options.file, "flexion",
                      "the joint's own flexion does not rise at " +
                          shortest_decimal(motion.frames[k].flexion_deg) + " degrees",
                      "a motion whose flexion rises, for splines of flexion"});
  }
}

void add_offset_frame(Node frames, const std::string& name, const std::string& body,
                      const Eigen::Vector3d& centre_mm)
{
  Node frame = add_named(frames, "PhysicalOffsetFrame", name);
  add_text(frame, "socket_parent", body_path(body));
  add_text(frame, "translation", metres_text(centre_mm));
  add_text(frame, "orientation", "0 0 0");
}

/// One axis of the SpatialTransform and its value at each knot.
struct AxisFunction {
  const char* name;
  Eigen::Vector3d axis;
  std::function<double(const FlexionFrame&)> value;  ///< rad or m
};

// Body-fixed rotations about Z, X, Y as in schemas/clinical.md; translations of the rotation centre along the
// reference's axes.
std::vector<AxisFunction> axis_functions(const FlexionMotion& motion)
{
  const double sign = motion.side == Side::left ? -1.0 : 1.0;
  const Eigen::Vector3d& centre_mm = motion.rotation_centre_mm;
  const auto translation_m = [&centre_mm](const FlexionFrame& frame, int axis) {
    return metres_per_mm * (frame.pose.X_reference_moving * centre_mm - centre_mm)[axis];
  };
  return {{"rotation1", {0, 0, -1}, {}},
          {"rotation2", {sign, 0, 0}, [](const FlexionFrame& f) { return f.clinical.varus_rad; }},
          {"rotation3", {0, sign, 0}, [](const FlexionFrame& f) { return f.clinical.internal_rotation_rad; }},
          {"translation1", {1, 0, 0}, [=](const FlexionFrame& f) { return translation_m(f, 0); }},
          {"translation2", {0, 1, 0}, [=](const FlexionFrame& f) { return translation_m(f, 1); }},
          {"translation3", {0, 0, 1}, [=](const FlexionFrame& f) { return translation_m(f, 2); }}};
}

/// 0 stays 0.
double signed_value(double value, double sign)
{
  return sign < 0.0 ? 0.0 - value : value;
}

// Of a follower, about and along the axes of the body of its coordinates.
std::vector<AxisFunction> follower_functions(const store::FollowerRows& follower, Side side)
{
  const double sign = side == Side::left ? -1.0 : 1.0;
  const auto coordinate = [&follower, side](Eigen::Index k) {
    return [&follower, side, k](const FlexionFrame& frame) {
      const Pose X = frame.pose.X_of(follower).value();
      return k < 3 ? follower_coordinates(X, side, follower.centre_mm)[k]
                   : metres_per_mm * (X * follower.centre_mm - follower.centre_mm)[k - 3];
    };
  };
  return {{"rotation1", {0, 0, -1}, coordinate(0)},   {"rotation2", {sign, 0, 0}, coordinate(1)},
          {"rotation3", {0, sign, 0}, coordinate(2)}, {"translation1", {1, 0, 0}, coordinate(3)},
          {"translation2", {0, 1, 0}, coordinate(4)}, {"translation3", {0, 0, 1}, coordinate(5)}};
}

void add_spline(Node axis, const FlexionMotion& motion, const AxisFunction& function, double sign)
{
  std::vector<FlexionFrame> frames = motion.frames;
  if (sign < 0.0) std::reverse(frames.begin(), frames.end());  // x must ascend
  std::string x, y;
  for (const FlexionFrame& frame : frames) {
    x += (x.empty() ? "" : " ") + shortest_decimal(signed_value(frame.clinical.flexion_rad, sign));
    y += (y.empty() ? "" : " ") + shortest_decimal(function.value(frame));
  }
  Node spline = add_named(axis, "SimmSpline", "function");
  add_text(spline, "x", x);
  add_text(spline, "y", y);
}

/// Of coordinates with the given signs: odd powers of a negated one change theirs.
void add_polynomial(Node axis, const BivariatePolynomial& polynomial, const OsimOptions& options)
{
  std::string coefficients;
  std::size_t k = 0;
  for (int i = 0; i <= polynomial.order; ++i) {
    for (int j = 0; i + j <= polynomial.order; ++j) {
      const double sign = (i % 2 == 0 ? 1.0 : options.flexion_sign) * (j % 2 == 0 ? 1.0 : options.varus_sign);
      coefficients += (coefficients.empty() ? "" : " ") +
                      shortest_decimal(signed_value(polynomial.coefficients[k++], sign));
    }
  }
  Node function = add_named(axis, "MultivariatePolynomialFunction", "function");
  add_text(function, "coefficients", coefficients);
  add_text(function, "dimension", "2");
  add_text(function, "order", std::to_string(polynomial.order));
}

void add_coordinate(Node coordinates, const std::string& name, double first_rad, double last_rad, double sign)
{
  if (sign < 0.0)
    std::tie(first_rad, last_rad) = std::pair(signed_value(last_rad, sign), signed_value(first_rad, sign));
  Node coordinate = add_named(coordinates, "Coordinate", name);
  add_text(coordinate, "default_value", numbers({std::clamp(0.0, first_rad, last_rad)}));
  add_text(coordinate, "range", numbers({first_rad, last_rad}));
  add_text(coordinate, "clamped", "true");
}

void add_coordinates(Node joint, const FlexionMotion& motion, const OsimOptions& options)
{
  Node coordinates = joint.append_child("coordinates");
  if (!options.surfaces) {
    add_coordinate(coordinates, options.coordinate, motion.frames.front().clinical.flexion_rad,
                   motion.frames.back().clinical.flexion_rad, options.flexion_sign);
    return;
  }
  const auto& [flexion_rad, varus_rad, internal, translation] = *options.surfaces;
  add_coordinate(coordinates, options.coordinate, flexion_rad[0], flexion_rad[1], options.flexion_sign);
  add_coordinate(coordinates, options.varus_coordinate, varus_rad[0], varus_rad[1], options.varus_sign);
}

/// The function of one axis of the SpatialTransform, counted from 0, and the coordinates that it depends on.
void add_function(Node axis, std::size_t index, const AxisFunction& function, const FlexionMotion& motion,
                  const OsimOptions& options)
{
  const bool is_varus = index == 1 && options.surfaces;
  const bool is_coordinate = index == 0 || is_varus;
  const std::string both = options.coordinate + " " + options.varus_coordinate;
  add_text(axis, "coordinates",
           is_varus                             ? options.varus_coordinate
           : is_coordinate || !options.surfaces ? options.coordinate
                                                : both);
  add_text(axis, "axis", vector_text(function.axis));
  if (is_coordinate) {
    const double sign = is_varus ? options.varus_sign : options.flexion_sign;
    add_text(add_named(axis, "LinearFunction", "function"), "coefficients", sign < 0.0 ? "-1 0" : "1 0");
  } else if (options.surfaces) {
    add_polynomial(axis,
                   index == 2 ? options.surfaces->internal_rad : options.surfaces->translation_m[index - 3],
                   options);
  } else {
    add_spline(axis, motion, function, options.flexion_sign);
  }
}

void add_joint(Node joints, const store::MotionModel& model, const FlexionMotion& motion,
               const OsimOptions& options)
{
  if (!options.surfaces) require_rising_flexion(motion, options);
  const std::vector<std::string> bodies = body_names(model);
  Node joint = add_named(joints, "CustomJoint", opensim_name(model.joint));
  add_text(joint, "socket_parent_frame", bodies[0] + "_offset");
  add_text(joint, "socket_child_frame", bodies[1] + "_offset");
  add_coordinates(joint, motion, options);
  Node frames = joint.append_child("frames");
  add_offset_frame(frames, bodies[0] + "_offset", bodies[0], motion.rotation_centre_mm);
  add_offset_frame(frames, bodies[1] + "_offset", bodies[1], motion.rotation_centre_mm);
  Node transform = joint.append_child("SpatialTransform");
  const std::vector<AxisFunction> functions = axis_functions(motion);
  for (std::size_t k = 0; k < functions.size(); ++k)
    add_function(add_named(transform, "TransformAxis", functions[k].name), k, functions[k], motion, options);
}

/// A coordinate of a joint depends on that joint's own only: that of a follower is coupled to the joint's.
std::string follower_coordinate(const OsimOptions& options, const std::string& body)
{
  return options.coordinate + "_" + body;
}

void add_follower_joint(Node joints, const store::FollowerRows& follower, const FlexionMotion& motion,
                        const std::vector<std::string>& bodies, const OsimOptions& options)
{
  const std::string& own = bodies.at(static_cast<std::size_t>(follower.body_index));
  const std::string& of = bodies.at(static_cast<std::size_t>(follower.of));
  const std::string coordinate = follower_coordinate(options, own);
  Node joint = add_named(joints, "CustomJoint", own + "_joint");
  add_text(joint, "socket_parent_frame", of + "_offset");
  add_text(joint, "socket_child_frame", own + "_offset");
  add_coordinate(joint.append_child("coordinates"), coordinate, motion.frames.front().clinical.flexion_rad,
                 motion.frames.back().clinical.flexion_rad, options.flexion_sign);
  Node frames = joint.append_child("frames");
  add_offset_frame(frames, of + "_offset", of, follower.centre_mm);
  add_offset_frame(frames, own + "_offset", own, follower.centre_mm);
  Node transform = joint.append_child("SpatialTransform");
  for (const AxisFunction& function : follower_functions(follower, motion.side)) {
    Node axis = add_named(transform, "TransformAxis", function.name);
    add_text(axis, "coordinates", coordinate);
    add_text(axis, "axis", vector_text(function.axis));
    add_spline(axis, motion, function, options.flexion_sign);
  }
}

void add_coupling(Node constraints, const std::string& coordinate, const std::string& to)
{
  Node coupling = add_named(constraints, "CoordinateCouplerConstraint", coordinate + "_coupling");
  add_text(coupling, "isEnforced", "true");
  add_text(coupling.append_child("coupled_coordinates_function").append_child("LinearFunction"),
           "coefficients", "1 0");
  add_text(coupling, "independent_coordinate_names", to);
  add_text(coupling, "dependent_coordinate_name", coordinate);
}

void add_wrap(Node wraps, const store::LigamentRows& ligaments, std::size_t row, const std::string& name)
{
  const bool is_cylinder = ligaments.wrap_shape[row] == 0;
  const Pose X_body_wrap = store::pose_in(ligaments.X_body_wrap, row);
  const Eigen::Matrix3d R = X_body_wrap.linear();  // Rx Ry Rz
  const Eigen::Vector3d angles(arc_tangent2(-R(1, 2), R(2, 2)),
                               arc_tangent2(R(0, 2), std::sqrt(R(0, 0) * R(0, 0) + R(0, 1) * R(0, 1))),
                               arc_tangent2(-R(0, 1), R(0, 0)));
  const Eigen::Vector3d radii_mm = ligaments.wrap_radii_mm.row(static_cast<Eigen::Index>(row));
  Node wrap = add_named(wraps, is_cylinder ? "WrapCylinder" : "WrapEllipsoid", name);
  add_text(wrap, "active", "true");
  add_text(wrap, "xyz_body_rotation", vector_text(angles));
  add_text(wrap, "translation", metres_text(X_body_wrap.translation()));
  add_text(wrap, "quadrant", "all");
  if (is_cylinder) {
    add_text(wrap, "radius", numbers({metres_per_mm * radii_mm.x()}));
    add_text(wrap, "length", numbers({2.0 * metres_per_mm * radii_mm.z()}));
  } else {
    add_text(wrap, "dimensions", metres_text(radii_mm));
  }
}

void add_component(Node geometry, const Component& component, const std::string& file,
                   const std::string& name)
{
  const Material material = material_of(component.material);
  Node mesh = add_named(geometry, "Mesh", name);
  add_text(mesh, "socket_frame", "..");
  add_text(mesh, "scale_factors", "1 1 1");
  Node appearance = mesh.append_child("Appearance");
  add_text(appearance, "opacity", shortest_decimal(static_cast<double>(material.opacity)));
  add_text(appearance, "color", vector_text(material.colour.cast<double>()));
  add_text(mesh, "mesh_file", file);
}

/// The fibres of the joint or of a follower, with a name for each wrap.
struct NamedFibres {
  const store::LigamentRows* rows;
  std::vector<std::string> wrap_names;
};

std::vector<NamedFibres> named_fibres(const store::MotionModel& model,
                                      const std::vector<const store::FollowerRows*>& followers)
{
  std::vector<NamedFibres> all;
  UniqueNames unique;
  const auto add = [&](const std::optional<store::LigamentRows>& rows) {
    if (!rows) return;
    NamedFibres& named = all.emplace_back(NamedFibres{&*rows, {}});
    for (const std::string& name : rows->wrap_name) named.wrap_names.push_back(unique(name));
  };
  add(model.ligaments);
  for (const store::FollowerRows* follower : followers) add(follower->ligaments);
  return all;
}

/// The bodies of a model while they are written.
struct BodyWriter {
  const std::vector<NamedFibres>& fibres;
  const std::string& mesh_stem;
  std::vector<OsimMesh>& meshes;

  void add(Node bodies, const Body& body, const std::string& name, std::int8_t index)
  {
    Node node = add_named(bodies, "Body", name);
    Node geometry = node.append_child("attached_geometry");
    UniqueNames unique;
    for (std::size_t k = 0; k < body.components.size(); ++k) {
      Mesh mesh;
      for (const Part* part : {&body.contact, &body.visual})
        append(mesh, select_triangles(part->mesh, triangles_by_component(body, *part)[k]));
      if (mesh.triangles.rows() == 0) continue;
      mesh.vertices_mm *= metres_per_mm;
      const std::string component = unique(body.components[k].name);
      const std::string file = mesh_stem + "_" + name + "_" + component + ".stl";
      add_component(geometry, body.components[k], file, component);
      meshes.push_back({file, std::move(mesh)});
    }
    Node wraps;
    for (const NamedFibres& one : fibres) {
      if (!one.wrap_names.empty() && !wraps) wraps = add_set(node, "WrapObjectSet", "wrapobjectset");
      for (std::size_t row = 0; row < one.wrap_names.size(); ++row) {
        if (one.rows->wrap_body[row] == index) add_wrap(wraps, *one.rows, row, one.wrap_names[row]);
      }
    }
    // A motion model has no masses; OpenSim needs some for a body that moves.
    add_text(node, "mass", "1");
    add_text(node, "mass_center", "0 0 0");
    add_text(node, "inertia", "0.001 0.001 0.001 0 0 0");
  }
};

void add_path_point(Node points, const std::string& name, const std::string& body,
                    const Eigen::Vector3d& at_mm)
{
  Node point = add_named(points, "PathPoint", name);
  add_text(point, "socket_parent_frame", body_path(body));
  add_text(point, "location", metres_text(at_mm));
}

/// Lines of constant tension are actuators whose control is 1 where they pull.
void add_fibres(Node forces, const NamedFibres& fibres, const std::vector<std::string>& bodies,
                UniqueNames& unique)
{
  const store::LigamentRows& rows = *fibres.rows;
  for (std::size_t k = 0; k < rows.name.size(); ++k) {
    const std::string name = unique(rows.name[k]);
    const auto row = static_cast<Eigen::Index>(k);
    const bool is_line = !rows.constant_tension_n.empty() && rows.constant_tension_n[k] > 0.0;
    const std::size_t from = rows.from_body.empty() ? 0 : static_cast<std::size_t>(rows.from_body[k]);
    const std::size_t to = rows.to_body.empty() ? 1 : static_cast<std::size_t>(rows.to_body[k]);
    Node fibre = add_named(forces, is_line ? "PathActuator" : "Blankevoort1991Ligament", name);
    Node path = add_named(fibre, "GeometryPath", "geometrypath");
    Node points = path.append_child("PathPointSet").append_child("objects");
    add_path_point(points, name + "-P1", bodies.at(from), rows.reference_mm.row(row));
    add_path_point(points, name + "-P2", bodies.at(to), rows.moving_mm.row(row));
    if (rows.wrap[k] >= 0) {
      Node wrap = add_named(path.append_child("PathWrapSet").append_child("objects"), "PathWrap", "pathwrap");
      add_text(wrap, "wrap_object", fibres.wrap_names[static_cast<std::size_t>(rows.wrap[k])]);
      add_text(wrap, "method", "hybrid");
    }
    if (is_line) {
      add_text(fibre, "optimal_force", numbers({rows.constant_tension_n[k]}));
      continue;
    }
    add_text(fibre, "linear_stiffness", numbers({rows.stiffness_n[k]}));
    add_text(fibre, "transition_strain", numbers({rows.transition_strain}));
    add_text(fibre, "damping_coefficient", "0");
    add_text(fibre, "slack_length", numbers({metres_per_mm * rows.slack_length_mm[k]}));
  }
}

std::string text_of(const pugi::xml_node& node, unsigned flags)
{
  std::ostringstream text;
  node.print(text, "  ", flags);
  return text.str();
}

}  // namespace

std::vector<double> osim_flexions_deg(const store::MotionModel& model, const std::string& set)
{
  const bool has_own =
      model.two_sided && (set.empty() ? store::default_motion(model).set : set) == "two_sided";
  const std::vector<double>& at_deg = has_own ? model.two_sided->flexion_deg : model.flexion_deg;
  const double smallest_deg = has_own ? smallest_smooth_step_deg : smallest_knot_step_deg;
  std::vector<double> shares;  // from the middle to an end
  for (double share = 0.5; shares.size() < most_knot_shares; share /= 2.0) shares.push_back(share);
  std::vector<double> flexions_deg{at_deg.front()};
  for (std::size_t i = 1; i < at_deg.size(); ++i) {
    const double step_deg = at_deg[i] - at_deg[i - 1];
    const auto is_kept = [&](double share) { return share == 0.5 || share * step_deg > smallest_deg; };
    for (auto share = shares.rbegin(); share != shares.rend(); ++share)
      if (is_kept(*share)) flexions_deg.push_back(at_deg[i - 1] + *share * step_deg);
    for (std::size_t k = 1; k < shares.size(); ++k)
      if (is_kept(shares[k])) flexions_deg.push_back(at_deg[i] - shares[k] * step_deg);
    flexions_deg.push_back(at_deg[i]);
  }
  return flexions_deg;
}

std::string osim_joint(const store::MotionModel& model, const FlexionMotion& motion,
                       const OsimOptions& options)
{
  pugi::xml_document document;
  add_joint(document, model, motion, options);
  return text_of(document.first_child(), pugi::format_indent);
}

OsimModel osim_model(const store::MotionModel& model, const FlexionMotion& motion, const OsimOptions& options)
{
  OsimModel result;
  const std::vector<std::string> bodies = body_names(model);
  std::vector<const store::FollowerRows*> followers = store::in_order(model.followers);
  // Splines over flexion; with --varus driven there is no function of the follower.
  std::erase_if(followers, [&](const auto* follower) {
    return options.surfaces.has_value() || !is_posed(motion, *follower);
  });
  const std::vector<NamedFibres> fibres = named_fibres(model, followers);
  pugi::xml_document document;
  Node declaration = document.append_child(pugi::node_declaration);
  declaration.append_attribute("version") = "1.0";
  declaration.append_attribute("encoding") = "UTF-8";
  Node root = document.append_child("OpenSimDocument");
  root.append_attribute("Version") = document_version;
  Node osim = add_named(root, "Model", opensim_name(model.title));
  add_text(osim, "credits",
           "Exported by vrda, set " + set_text(motion) + ". Masses and inertias are not those of a subject.");
  add_text(osim, "length_units", "meters");
  add_text(osim, "force_units", "N");
  add_named(osim, "Ground", "ground");
  Node set = add_set(osim, "BodySet", "bodyset");
  BodyWriter writer{fibres, options.mesh_stem, result.meshes};
  writer.add(set, model.reference, bodies[0], 0);
  writer.add(set, model.moving, bodies[1], 1);
  for (const store::FollowerRows* follower : followers) {
    const auto index = static_cast<std::int8_t>(follower->body_index);
    writer.add(set, follower->body, bodies.at(static_cast<std::size_t>(index)), index);
  }
  Node joints = add_set(osim, "JointSet", "jointset");
  Node weld = add_named(joints, "WeldJoint", "ground_" + bodies[0]);
  add_text(weld, "socket_parent_frame", "/ground");
  add_text(weld, "socket_child_frame", body_path(bodies[0]));
  add_joint(joints, model, motion, options);
  for (const store::FollowerRows* follower : followers)
    add_follower_joint(joints, *follower, motion, bodies, options);
  if (!followers.empty()) {
    Node constraints = add_set(osim, "ConstraintSet", "constraintset");
    for (const store::FollowerRows* follower : followers)
      add_coupling(constraints,
                   follower_coordinate(options, bodies.at(static_cast<std::size_t>(follower->body_index))),
                   options.coordinate);
  }
  UniqueNames unique;
  Node forces;
  for (const NamedFibres& one : fibres) {
    if (!forces) forces = add_set(osim, "ForceSet", "forceset");
    add_fibres(forces, one, bodies, unique);
  }
  result.xml = text_of(document, pugi::format_indent);
  return result;
}

}  // namespace vrda::tables
