// Tables of a motion: CSV over flexion and of all attitudes, OpenSim's .sto.
#include "tables/tables.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <optional>
#include <utility>

#include "core/text.hpp"
#include "core/units.hpp"
#include "model/frames.hpp"
#include "model/step_record.hpp"
#include "store/solved_cells.hpp"
#include "tables/formats.hpp"
#include "tables/motion_table.hpp"

namespace vrda::tables {
namespace {

struct Column {
  std::string name;
  std::function<std::string(Eigen::Index cell)> text;
};

using Columns = std::vector<Column>;

void add(Columns& columns, const std::string& name, const store::GridD& grid)
{
  columns.push_back({name, [&grid](Eigen::Index cell) { return csv_number(grid.data()[cell]); }});
}

template <typename Integer>
void add_integers(Columns& columns, const std::string& name, const store::Grid<Integer>& grid)
{
  columns.push_back({name, [&grid](Eigen::Index cell) { return std::to_string(int{grid.data()[cell]}); }});
}

template <typename Code>
void add_names(Columns& columns, const std::string& name, const store::GridB& grid)
{
  columns.push_back({name, [&grid](Eigen::Index cell) {
                       return std::string(name_of(static_cast<Code>(grid.data()[cell])));
                     }});
}

void add_points(Columns& columns, const std::string& name, const std::vector<double>& points)
{
  constexpr std::array<char, 3> axes{'x', 'y', 'z'};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    columns.push_back({name + '_' + axes[axis], [&points, axis](Eigen::Index cell) {
                         return csv_number(points[3 * static_cast<std::size_t>(cell) + axis]);
                       }});
  }
}

/// A key named as another column gets a prefix, since names are unique.
std::string key_column(const std::string& key_name, const std::vector<std::string>& others)
{
  const bool is_taken = std::find(others.begin(), others.end(), key_name) != others.end();
  return (is_taken ? "key_" : "") + key_name;
}

void add_attitude(Columns& columns, const store::MotionModel& model)
{
  const auto n_varus = static_cast<Eigen::Index>(model.varus_deg.size());
  columns.push_back({"flexion_deg", [&model, n_varus](Eigen::Index cell) {
                       return csv_number(model.flexion_deg[static_cast<std::size_t>(cell / n_varus)]);
                     }});
  columns.push_back({"varus_deg", [&model, n_varus](Eigen::Index cell) {
                       return csv_number(model.varus_deg[static_cast<std::size_t>(cell % n_varus)]);
                     }});
  add_names<StepStatus>(columns, "status", model.status);
  add_names<Plausibility>(columns, "plausibility", model.plausibility);
}

void add_followers(Columns& columns, const store::MotionModel& model)
{
  for (const store::FollowerRows* follower : store::in_order(model.followers)) {
    const std::string prefix = "follower_" + follower->name + "_";
    add_names<StepStatus>(columns, prefix + "status", follower->status);
    if (follower->plausibility.size() > 0)
      add_names<Plausibility>(columns, prefix + "plausibility", follower->plausibility);
    for (std::size_t k = 0; k < n_joint_coordinates; ++k)
      add(columns, prefix + follower_coordinate_names[k] + unit_suffix(k), follower->coordinates[k]);
  }
}

void add_raw(Columns& columns, const store::MotionModel& model, const store::ClinicalSurfaces& clinical)
{
  add(columns, "varus_solved_deg", model.varus_solved_deg);
  add(columns, "tx_mm", model.tx_mm);
  add(columns, "ty_mm", model.ty_mm);
  add(columns, "tz_mm", model.tz_mm);
  add(columns, "theta_deg", model.theta_deg);
  for (std::size_t k = 0; k < n_joint_coordinates; ++k)
    add(columns, std::string(clinical_columns[k]) + unit_suffix(k), clinical[k]);
  for (const int axis : {0, 1, 2}) {
    columns.push_back(
        {std::string("centre_") + "xyz"[axis] + "_mm",
         [centre_mm = model.rotation_centre_mm[axis]](Eigen::Index) { return csv_number(centre_mm); }});
  }
  for (const auto& [side, name, meaning] : compartment_names)
    add(columns, std::string("gap_") + name + "_mm", model.gap_mm[side]);
  for (const auto& [side, name, meaning] : compartment_names)
    add_integers(columns, std::string("contact_") + name, model.is_in_contact[side]);
  add_integers(columns, "theta_determined", model.theta_determined);
  add_integers(columns, "is_spine", model.is_spine);
  add_integers(columns, "iterations", model.iterations);
  add_integers(columns, "queries", model.queries);
  add(columns, "residual_mm", model.residual_mm);
}

void add_mechanics(Columns& columns, const store::MotionModel& model)
{
  for (const auto& [side, name, meaning] : compartment_names) {
    if (!model.contact_paths) break;
    const store::ContactPath& path = (*model.contact_paths)[side];
    add_points(columns, std::string(name) + "_reference_mm", path.reference_mm);
    add_points(columns, std::string(name) + "_moving_mm", path.moving_mm);
  }
  if (!model.equilibrium) return;
  const store::EquilibriumSurfaces& e = *model.equilibrium;
  add(columns, "energy_nmm", e.energy_nmm);
  add(columns, "balance_residual_n", e.balance_residual_n);
  add(columns, "complementarity_mm", e.complementarity_mm);
  add(columns, "worst_gap_mm", e.worst_gap_mm);
  add(columns, "flexion_moment_nmm", e.flexion_moment_nmm);
  add(columns, "varus_moment_nmm", e.varus_moment_nmm);
  if (!model.has_compartments) return;
  for (const auto& [side, name, meaning] : compartment_names)
    add_points(columns, std::string("force_") + name + "_n", e.force_n[side]);
}

std::string with_unit(const std::string& surface)
{
  return surface + (surface == "theta" || surface == "varus" ? "_deg" : "_mm");
}

void add_smoothed(Columns& columns, const store::MotionModel& model)
{
  for (const store::SmoothedSet& set : model.smoothed) {
    const std::string prefix = "degree_" + std::to_string(set.degree) + "_";
    for (const store::SmoothedSurface& surface : set.surfaces) {
      add(columns, prefix + with_unit(surface.name), surface.values);
    }
    if (set.recontact_mm) add(columns, prefix + "recontact_mm", *set.recontact_mm);
    for (const store::SmoothedFollower& follower : set.followers) {
      const std::string of_follower = prefix + follower.name + "_";
      for (std::size_t k = 0; k < follower.surfaces.size(); ++k)
        add(columns, of_follower + follower_coordinate_names[k] + unit_suffix(k),
            follower.surfaces[k].values);
      if (follower.recontact_mm) add(columns, of_follower + "recontact_mm", *follower.recontact_mm);
    }
  }
}

using Value = std::pair<const char*, double>;

// The last three name the point of the translations, so that a plain CSV reader needs no header.
std::array<Value, 15> values_of(const FlexionMotion& motion, const FlexionFrame& frame)
{
  const auto c = in_files(frame.clinical);
  const store::JointPose& pose = frame.pose;
  const Eigen::Vector3d& centre_mm = motion.rotation_centre_mm;
  const Eigen::Vector3d moved_mm = pose.X_world_moving * centre_mm;
  return {{{"flexion_deg", c[0]},
           {"varus_deg", c[1]},
           {"internal_deg", c[2]},
           {"anterior_mm", c[3]},
           {"proximal_mm", c[4]},
           {"lateral_mm", c[5]},
           {"attitude_flexion_deg", frame.flexion_deg},
           {"attitude_varus_deg", deg_from_rad(pose.attitude.varus_rad)},
           {"tx_mm", moved_mm.x()},
           {"ty_mm", moved_mm.y()},
           {"tz_mm", moved_mm.z()},
           {"theta_deg", deg_from_rad(pose.theta_rad)},
           {"centre_x_mm", centre_mm.x()},
           {"centre_y_mm", centre_mm.y()},
           {"centre_z_mm", centre_mm.z()}}};
}

}  // namespace

bool is_flexion_csv_column(std::string_view name)
{
  return std::ranges::any_of(values_of({}, {}), [&](const Value& value) { return name == value.first; }) ||
         analysis::is_flexion_curve(name);
}

std::string flexion_csv(const FlexionMotion& motion, const std::vector<analysis::CurveGroup>& groups)
{
  std::vector<std::string> names;
  for (const auto& [name, value] : values_of({}, {})) names.emplace_back(name);
  std::vector<const analysis::Curve*> curves;
  for (const analysis::CurveGroup& group : groups) {
    for (const analysis::Curve& curve : group.curves) {
      curves.push_back(&curve);
      names.push_back(curve.name);
    }
  }
  const bool has_key = !motion.key_name.empty();
  if (has_key) names.insert(names.begin(), key_column(motion.key_name, names));
  std::string text = joined(names, ",") + '\n';
  for (std::size_t k = 0; k < motion.frames.size(); ++k) {
    std::vector<std::string> cells;
    if (has_key) cells.push_back(csv_number(motion.frames[k].pose.key));
    for (const auto& [name, value] : values_of(motion, motion.frames[k])) cells.push_back(csv_number(value));
    for (const analysis::Curve* curve : curves) cells.push_back(csv_number(curve->values[k]));
    text += joined(cells, ",") + '\n';
  }
  return text;
}

std::string cells_csv(const store::MotionModel& model)
{
  const store::ClinicalCurves curves = store::clinical_curves(model);
  Columns columns;
  add_attitude(columns, model);
  add_raw(columns, model, curves.surfaces);
  add_mechanics(columns, model);
  add_followers(columns, model);
  add_smoothed(columns, model);
  if (model.frames) {
    std::vector<std::string> names;
    for (const Column& column : columns) names.push_back(column.name);
    const std::vector<double>& keys = model.frames->key;
    columns.insert(columns.begin(), {key_column(model.frames->key_name, names), [&keys](Eigen::Index cell) {
                                       return csv_number(keys[static_cast<std::size_t>(cell)]);
                                     }});
  }
  std::string text;
  for (std::size_t k = 0; k < columns.size(); ++k) text += (k > 0 ? "," : "") + columns[k].name;
  text += "\n";
  for (Eigen::Index cell = 0; cell < model.status.size(); ++cell) {
    for (std::size_t k = 0; k < columns.size(); ++k) text += (k > 0 ? "," : "") + columns[k].text(cell);
    text += "\n";
  }
  return text;
}

namespace {

/// First line of the header, sanitized so that it is neither a key=value line nor the end of the header.
std::string name_line(const FlexionMotion& motion)
{
  std::string line = "vrda: ";
  for (const char c : motion.title + ", " + set_text(motion)) {
    const bool is_plain = static_cast<unsigned char>(c) >= 0x20 && c != '=' && c != 0x7f;
    line += is_plain ? c : ' ';
  }
  for (std::size_t at = line.find("endheader"); at != std::string::npos; at = line.find("endheader")) {
    line.insert(at + 3, 1, ' ');
  }
  return line + "\n";
}

/// In the unit of the table: rad or degrees, and m. Without those bodies that have no pose in some frame: a
/// field of these tables is a number.
std::vector<analysis::Curve> in_opensim_units(const std::vector<analysis::CurveGroup>& followers,
                                              bool in_degrees)
{
  std::vector<analysis::Curve> columns;
  for (const analysis::CurveGroup& group : followers) {
    const bool is_angle = group.unit == "degrees";
    for (const analysis::Curve& curve : group.curves) {
      if (std::ranges::any_of(curve.values, [](double value) { return std::isnan(value); })) continue;
      const std::size_t at = curve.name.rfind('_');  // of its unit
      const double factor = !is_angle ? metres_per_mm : in_degrees ? 1.0 : rad_from_deg(1.0);
      analysis::Curve& column = columns.emplace_back(curve);
      column.name = opensim_name(curve.name.substr(0, at)) + (!is_angle    ? "_m"
                                                              : in_degrees ? "_deg"
                                                                           : "_rad");
      for (double& value : column.values) value *= factor;
    }
  }
  return columns;
}

std::string header(const FlexionMotion& motion, const OpenSimOptions& options,
                   const std::vector<analysis::Curve>& followers)
{
  std::string text = name_line(motion);
  text += "version=1\n";
  text += "nRows=" + std::to_string(motion.frames.size()) + "\n";
  text += "nColumns=" + std::to_string(1 + options.columns.size() + followers.size()) + "\n";
  text += std::string("inDegrees=") + (options.in_degrees ? "yes" : "no") + "\n";
  std::string negated;
  for (std::size_t k = 0; k < options.columns.size(); ++k)
    if (options.sign[k] < 0.0) negated += (negated.empty() ? "" : " ") + options.columns[k];
  if (!negated.empty()) text += "negated=" + negated + "\n";
  if (options.has_origin_translations) {
    text += "translations=mesh-origin\n\n";
  } else {
    const Eigen::Vector3d& centre_mm = motion.rotation_centre_mm;
    text += "translations=rotation-centre\nrotation_centre_mm=" + shortest_decimal(centre_mm.x()) + " " +
            shortest_decimal(centre_mm.y()) + " " + shortest_decimal(centre_mm.z()) + "\n\n";
  }
  text += "Units are S.I. units (second, meters, Newtons, ...)\n";
  if (motion.key_name.empty()) {
    text += "Flexion grows by " + shortest_decimal(options.degrees_per_second) + " degrees a second.\n\n";
  } else {
    text += "Time is the key of each frame.\nkey=" + motion.key_name + "\n\n";
  }
  text += "endheader\ntime";
  for (const std::string& column : options.columns) text += "\t" + column;
  for (const analysis::Curve& column : followers) text += "\t" + column.name;
  return text + "\n";
}

std::array<double, 6> numbers_of(const FlexionMotion& motion, const FlexionFrame& frame,
                                 const OpenSimOptions& options)
{
  const ClinicalCoordinates& c = frame.clinical;
  const Pose& X = frame.pose.X_reference_moving;
  const Eigen::Vector3d& centre_mm = motion.rotation_centre_mm;
  const Eigen::Vector3d t_mm =
      options.has_origin_translations ? Eigen::Vector3d(X.translation()) : X * centre_mm - centre_mm;
  const Eigen::Vector3d t_m = metres_per_mm * t_mm;
  std::array<double, 6> numbers{c.flexion_rad, c.varus_rad, c.internal_rotation_rad,
                                t_m.x(),       t_m.y(),     t_m.z()};
  for (std::size_t k = 0; options.in_degrees && k < 3; ++k) numbers[k] = deg_from_rad(numbers[k]);
  for (std::size_t k = 0; k < numbers.size(); ++k)
    if (options.sign[k] < 0.0) numbers[k] = 0.0 - numbers[k];  // 0 stays 0
  return numbers;
}

}  // namespace

std::array<std::string, 6> opensim_columns(const std::string& joint, Side side)
{
  std::array<std::string, 6> columns{"flex", "add", "rot", "tx", "ty", "tz"};
  for (std::string& column : columns)
    column = (joint == "other" ? "joint" : joint) + "_" + column + (side == Side::left ? "_l" : "_r");
  return columns;
}

std::string opensim_table(const FlexionMotion& motion, const OpenSimOptions& options,
                          const std::vector<analysis::CurveGroup>& followers)
{
  const std::vector<analysis::Curve> further = in_opensim_units(followers, options.in_degrees);
  std::string text = header(motion, options, further);
  for (std::size_t k = 0; k < motion.frames.size(); ++k) {
    const FlexionFrame& frame = motion.frames[k];
    text += shortest_decimal(motion.key_name.empty() ? time_s(motion, frame, options.degrees_per_second)
                                                     : frame.pose.key);
    for (const double number : numbers_of(motion, frame, options)) text += "\t" + shortest_decimal(number);
    for (const analysis::Curve& column : further) text += "\t" + shortest_decimal(column.values[k]);
    text += "\n";
  }
  return text;
}

namespace {

void require_varus(const store::MotionModel& model, const store::Motion& motion, const std::string& file,
                   const FlexionPlan& plan)
{
  if (plan.varus == VarusRule::zero && !model.zero_varus) {
    throw InputError(
        {file, "--varus", "zero without a zero-varus table", "spine or a number; or run vrda reduce first"});
  }
  if (plan.varus != VarusRule::given) return;
  if (motion.is_varus_free()) {
    throw InputError({file, "--varus", shortest_decimal(plan.varus_deg),
                      model.varus_deg.size() > 1 ? "spine, or another --set: this set has its own varus"
                                                 : "spine: the job left varus free"});
  }
  const double varus_rad = rad_from_deg(plan.varus_deg);
  if (varus_rad >= motion.first_varus_rad() && varus_rad <= motion.last_varus_rad()) return;
  throw InputError(
      {file, "--varus", shortest_decimal(plan.varus_deg) + " degrees",
       shortest_decimal(model.varus_deg.front()) + " to " + shortest_decimal(model.varus_deg.back())});
}

/// NaN between flexions of which one has no zero-varus pose.
double varus_deg_at(const store::MotionModel& model, const store::Motion& motion, const FlexionPlan& plan,
                    double flexion_deg)
{
  switch (plan.varus) {
    case VarusRule::given:
      return plan.varus_deg;
    case VarusRule::spine:
      return deg_from_rad(motion.balanced_varus_rad(rad_from_deg(flexion_deg)));
    case VarusRule::zero:
      return store::value_at({model.flexion_deg, model.zero_varus->varus_deg}, flexion_deg, 0.0);
  }
  throw InternalError("an unknown varus rule");
}

void add_frame(FlexionMotion& result, const store::Motion& motion, double flexion_deg, double varus_deg)
{
  const double flexion_rad = rad_from_deg(flexion_deg);
  if (flexion_rad < motion.first_flexion_rad() || flexion_rad > motion.last_flexion_rad()) {
    result.omitted.push_back({flexion_deg, nan, "beyond the measured range"});
    return;
  }
  if (std::isnan(varus_deg)) {
    result.omitted.push_back({flexion_deg, nan, "no zero-varus pose"});
    return;
  }
  FlexionFrame frame{flexion_deg, motion.at({flexion_rad, rad_from_deg(varus_deg)}), {}};
  if (frame.pose.status != store::PoseStatus::solved) {
    result.omitted.push_back({flexion_deg, nan, core::name_of(frame.pose.status)});
    return;
  }
  result.frames.push_back(frame);
}

void add_frames(FlexionMotion& result, const store::MotionModel& model, const store::Motion& motion)
{
  result.key_name = motion.key_name();
  for (std::size_t i = 0; i < motion.keys().size(); ++i) {
    FlexionFrame frame{model.flexion_deg[i], motion.at_frame(motion.keys()[i]), {}};
    if (frame.pose.status != store::PoseStatus::solved) {
      result.omitted.push_back({frame.flexion_deg, frame.pose.key, "no pose"});
      continue;
    }
    result.frames.push_back(frame);
  }
}

void make_continuous(FlexionMotion& motion)
{
  ContinuousCoordinates along(motion.side, motion.rotation_centre_mm);
  for (FlexionFrame& frame : motion.frames) frame.clinical = along.next(frame.pose.X_reference_moving);
  motion.n_locked = along.n_locked();
  // The attitudes of a sequence have any number of turns.
  for (std::size_t k = 1; k < motion.frames.size() && !motion.key_name.empty(); ++k) {
    const store::JointPose& before = motion.frames[k - 1].pose;
    FlexionFrame& frame = motion.frames[k];
    Attitude& attitude = frame.pose.attitude;
    attitude.flexion_rad = nearest_turn(attitude.flexion_rad, before.attitude.flexion_rad);
    frame.pose.theta_rad = nearest_turn(frame.pose.theta_rad, before.theta_rad);
    constexpr double rounding_deg = 1e-6;
    const double flexion_deg = deg_from_rad(attitude.flexion_rad);
    if (std::abs(flexion_deg - frame.flexion_deg) > rounding_deg) frame.flexion_deg = flexion_deg;
  }
}

}  // namespace

VarusRule default_varus(const store::MotionModel& model, const std::string& set)
{
  const bool is_raw = (set.empty() ? store::default_motion(model).set : set) == "raw";
  return model.zero_varus && !is_raw ? VarusRule::zero : VarusRule::spine;
}

FlexionMotion flexion_motion(const store::MotionModel& model, const std::string& file,
                             const FlexionPlan& plan)
{
  FlexionMotion result;
  result.title = model.title;
  result.set = store::chosen_set(model, file, plan.set);
  if (plan.set.empty()) {
    const store::DefaultMotion shown = store::default_motion(model);
    result.reason = shown.reason;
    result.statement = shown.statement;
  }
  result.side = side_named(model.side);
  result.rotation_centre_mm = model.rotation_centre_mm;
  const store::Motion motion(model, result.set);
  if (motion.is_sequence()) {
    if (!plan.flexion_deg.empty() || plan.varus != VarusRule::spine)
      store::require_grid(model, file, plan.flexion_deg.empty() ? "--varus" : "--flexion");
    add_frames(result, model, motion);
  } else {
    require_varus(model, motion, file, plan);
    for (const double flexion_deg : plan.flexion_deg.empty() ? model.flexion_deg : plan.flexion_deg)
      add_frame(result, motion, flexion_deg, varus_deg_at(model, motion, plan, flexion_deg));
  }
  make_continuous(result);
  if (result.frames.empty()) {
    throw InputError({file, result.set, "no attitude with a pose", "at least one to export"});
  }
  return result;
}

bool is_posed(const FlexionMotion& motion, const store::FollowerRows& follower)
{
  const std::size_t row = model::follower_row(static_cast<BodyIndex>(follower.body_index));
  return std::ranges::all_of(motion.frames,
                             [&](const FlexionFrame& frame) { return frame.pose.has_follower.at(row); });
}

std::string set_text(const FlexionMotion& motion)
{
  return motion.set + (motion.reason.empty() ? "" : ": " + motion.reason) +
         (motion.statement.empty() ? "" : ". " + motion.statement);
}

double abscissa(const FlexionMotion& motion, const FlexionFrame& frame)
{
  return motion.key_name.empty() ? frame.flexion_deg : frame.pose.key;
}

double time_s(const FlexionMotion& motion, const FlexionFrame& frame, double rate)
{
  const double since_first = abscissa(motion, frame) - abscissa(motion, motion.frames.front());
  return motion.key_name == "time_s" ? since_first : since_first / rate;
}

}  // namespace vrda::tables
