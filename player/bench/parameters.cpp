#include "bench/parameters.hpp"

#include <algorithm>
#include <functional>
#include <vector>

#include "core/error.hpp"
#include "core/units.hpp"

namespace vrda::bench {
namespace {

/// The stored value, empty for the distance between the eyes; one unit of the parameter is `scale` units of
/// it.
struct Stored {
  std::function<double&(BenchValues&)> at;
  double scale = 1.0;
};

struct List {
  std::vector<Parameter> parameters;
  std::vector<Stored> stored;

  void add(Parameter parameter, std::function<double&(BenchValues&)> at, double scale = 1.0)
  {
    parameters.push_back(std::move(parameter));
    stored.push_back({std::move(at), scale});
  }
};

double& eye_position(BenchValues& values, view::Eye view::EyePair::*side, Eigen::Index axis)
{
  return (values.calibration.eyes.*side).position_head_mm[axis];
}

/// "left.sight_x"
std::string with_axis(const std::string& name, const char* what, Eigen::Index axis)
{
  return name + what + "xyz"[axis];
}

void add_eye(List& list, const std::string& name, view::Eye view::EyePair::*side)
{
  const auto eye = [side](BenchValues& v) -> view::Eye& { return v.calibration.eyes.*side; };
  constexpr double px = 20000.0;
  list.add({name + ".distance", "px", 10.0, 100000.0, 1.0},
           [eye](BenchValues& v) -> double& { return eye(v).distance_px; });
  list.add({name + ".pixel_aspect", "", 0.1, 10.0, 0.001},
           [eye](BenchValues& v) -> double& { return eye(v).pixel_aspect; });
  for (const Eigen::Index axis : {0, 1}) {
    list.add({with_axis(name, ".sight_", axis), "px", -px, px, 0.5},
             [eye, axis](BenchValues& v) -> double& { return eye(v).sight_px[axis]; });
    list.add({with_axis(name, ".centre_", axis), "px", -px, px, 0.5},
             [eye, axis](BenchValues& v) -> double& { return eye(v).distortion.centre_px[axis]; });
  }
  list.add({name + ".k1", "", -1.0, 1.0, 0.001},
           [eye](BenchValues& v) -> double& { return eye(v).distortion.k1; });
  list.add({name + ".k2", "", -1.0, 1.0, 0.001},
           [eye](BenchValues& v) -> double& { return eye(v).distortion.k2; });
  for (const Eigen::Index axis : {1, 2}) {
    list.add({name + (axis == 1 ? ".eye_up" : ".eye_back"), "mm", -200.0, 200.0, 0.5},
             [side, axis](BenchValues& v) -> double& { return eye_position(v, side, axis); });
  }
}

template <typename At>
void add_six(List& list, const std::string& name, At at)
{
  constexpr double most_mm = 10000.0, most_deg = 180.0;
  for (const Eigen::Index axis : {0, 1, 2}) {
    list.add({with_axis(name, ".shift_", axis), "mm", -most_mm, most_mm, 0.5},
             [at, axis](BenchValues& v) -> double& { return at(v).shift_mm[axis]; });
  }
  for (const Eigen::Index axis : {0, 1, 2}) {
    list.add(
        {with_axis(name, ".turn_", axis), "deg", -most_deg, most_deg, 0.1},
        [at, axis](BenchValues& v) -> double& { return at(v).turn_rad[axis]; }, rad_from_deg(1.0));
  }
}

void add_model(List& list, BodyRole role)
{
  add_six(list, name_of(role), [role](BenchValues& v) -> bench::PoseParameters& {
    return v.calibration.X_body_model[static_cast<std::size_t>(role)];
  });
}

double pupillary_distance_mm(const view::EyePair& eyes)
{
  return eyes.right.position_head_mm.x() - eyes.left.position_head_mm.x();
}

/// Moves both eyes symmetrically: their midpoint does not change.
void set_pupillary_distance(BenchValues& values, double distance_mm)
{
  double &left = eye_position(values, &view::EyePair::left, 0),
         &right = eye_position(values, &view::EyePair::right, 0);
  const double middle = 0.5 * (left + right);
  left = middle - 0.5 * distance_mm;
  right = middle + 0.5 * distance_mm;
}

List build_list()
{
  List list;
  list.add(
      {"flexion", "deg", -30.0, 180.0, 1.0, false}, [](BenchValues& v) -> double& { return v.flexion_rad; },
      rad_from_deg(1.0));
  list.add(
      {"varus", "deg", -30.0, 30.0, 0.5, false}, [](BenchValues& v) -> double& { return v.varus_rad; },
      rad_from_deg(1.0));
  list.add({"prediction", "ms", 0.0, 200.0, 1.0, false},
           [](BenchValues& v) -> double& { return v.prediction_ms; });
  list.add({"eyes.distance_apart", "mm", 40.0, 90.0, 0.25}, nullptr);
  list.add({"image_distance", "mm", 100.0, 10000.0, 10.0},
           [](BenchValues& v) -> double& { return v.calibration.image_distance_mm; });
  add_model(list, BodyRole::leg);
  add_model(list, BodyRole::femur);
  add_model(list, BodyRole::tibia);
  add_six(list, "eyes",
          [](BenchValues& v) -> bench::PoseParameters& { return v.calibration.X_table_eyes; });
  add_six(list, "head",
          [](BenchValues& v) -> bench::PoseParameters& { return v.calibration.X_headbody_eyes; });
  add_six(list, "table",
          [](BenchValues& v) -> bench::PoseParameters& { return v.calibration.X_tracker_table; });
  add_eye(list, "left", &view::EyePair::left);
  add_eye(list, "right", &view::EyePair::right);
  return list;
}

const List& list()
{
  static const List built = build_list();
  return built;
}

}  // namespace

std::span<const Parameter> parameters()
{
  return list().parameters;
}

std::optional<std::size_t> find_parameter(const std::string& name)
{
  const std::vector<Parameter>& all = list().parameters;
  const auto found = std::ranges::find(all, name, &Parameter::name);
  if (found == all.end()) return std::nullopt;
  return static_cast<std::size_t>(found - all.begin());
}

bool is_used(std::size_t parameter, const BenchFile& bench)
{
  const std::string& name = parameters()[parameter].name;
  const std::string kind = name.substr(0, name.find('.'));
  const bool is_rigid = bench.leg == LegKind::rigid;
  if (kind == "flexion" || kind == "varus" || kind == "leg") return is_rigid;
  if (kind == "femur" || kind == "tibia") return !is_rigid;
  if (kind == "head") return bench.head == HeadKind::tracker;
  if (name == "eyes.distance_apart") return true;
  if (kind == "table" || kind == "eyes") return bench.head == HeadKind::stage;
  return true;
}

double value_of(const BenchValues& values, std::size_t parameter)
{
  const Stored& stored = list().stored.at(parameter);
  if (!stored.at) return pupillary_distance_mm(values.calibration.eyes);
  // The const_cast is safe: the value is only read.
  return stored.at(const_cast<BenchValues&>(values)) / stored.scale;
}

void set_value(BenchValues& values, std::size_t parameter, double value)
{
  const Parameter& limits = list().parameters.at(parameter);
  const Stored& stored = list().stored.at(parameter);
  const double clamped = std::clamp(value, limits.minimum, limits.maximum);
  if (!stored.at) return set_pupillary_distance(values, clamped);
  stored.at(values) = clamped * stored.scale;
  // The file has one aspect ratio for both projection and distortion.
  for (view::Eye* eye : {&values.calibration.eyes.left, &values.calibration.eyes.right})
    eye->distortion.pixel_aspect = eye->pixel_aspect;
}

}  // namespace vrda::bench
