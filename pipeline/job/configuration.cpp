#include "job/configuration.hpp"

#include <algorithm>
#include <cmath>

#include "core/error.hpp"
#include "core/text.hpp"
#include "job/input_file.hpp"

namespace vrda::job {
namespace {

constexpr std::uintmax_t largest_configuration_bytes = 1U << 20U;  // the thesis's example has about 15 lines
constexpr double longest_mm = 1e6;                                 // 1 km: more is probably a mistake
constexpr double longest_step_mm = 1000.0;                         // limit of a job
constexpr double largest_step_deg = 90.0;                          // limit of a job
constexpr double whole_turn_deg = 360.0;
constexpr double max_attitudes = 1e6;  // limit of a job

// A product rounded to short decimals: 0.0003 m gives 0.3 mm.
double in_mm(double length, double unit_mm)
{
  constexpr double digits = 1e9;
  const double mm = length * unit_mm;
  const double rounded = std::round(mm * digits) / digits;
  return std::abs(mm) < longest_mm && rounded != 0.0 ? rounded : mm;
}

class Reader {
 public:
  Reader(const NamedText& source, double unit_mm) : lines_(source), unit_mm_(unit_mm) {}

  KeywordConfiguration read()
  {
    while (lines_.next()) read_line();
    check_models();
    check_orientation();
    check_steps();
    check_attitudes();
    return std::move(out_);
  }

 private:
  struct Keyword {
    const char* name;
    const char* values;  // as messages show them
    std::size_t min_values;
    std::size_t max_values;
    void (Reader::*read)();
  };

  static const std::vector<Keyword>& keywords()
  {
    static const std::vector<Keyword> all{
        {"MODEL", "body name", 2, 2, &Reader::read_model},
        {"INITIAL_POSITION", "body x y z", 4, 4, &Reader::read_position},
        {"INITIAL_MOTION", "body x y z", 4, 4, &Reader::read_motion},
        {"INITIAL_ORIENTATION", "body rx ry rz", 4, 4, &Reader::read_orientation},
        {"SHIFT_MODEL", "view x y z", 4, 4, &Reader::read_shift},
        {"ORIENTATION_MODEL", "view rx ry rz", 4, 4, &Reader::read_view_orientation},
        {"DISPLAY", "width height", 2, 2, &Reader::read_display},
        {"ZOOM", "factor", 1, 1, &Reader::read_zoom},
        {"CONTACT_RESOLUTION", "length", 1, 1, &Reader::read_contact_resolution},
        {"MODELING_RESOLUTION", "length", 1, 1, &Reader::read_modelling_step},
        {"ORIENTATION_RESOLUTION", "degrees", 1, 1, &Reader::read_orientation_resolution},
        {"ORIENTATION_STEP", "degrees", 1, 1, &Reader::read_orientation_step},
        {"ANGLE_RANGE", "angle from to [step]", 3, 4, &Reader::read_range},
        {"RENDER", "fill|wire", 1, 1, &Reader::read_render},
    };
    return all;
  }

  void read_line()
  {
    const std::string name(lines_.words().front());
    const auto keyword = std::find_if(keywords().begin(), keywords().end(),
                                      [&](const Keyword& known) { return name == known.name; });
    if (keyword == keywords().end()) {
      std::vector<std::string> names;
      for (const Keyword& known : keywords()) names.emplace_back(known.name);
      // Bounds the cost of the comparison.
      const std::string nearest = nearest_word(name.substr(0, 40), names);
      lines_.refuse("the unknown keyword " + quoted(name), "a keyword; the nearest is \"" + nearest + "\"");
    }
    const std::size_t n = lines_.words().size() - 1;
    if (n < keyword->min_values || n > keyword->max_values) {
      lines_.refuse(name + " with " + (n == 0 ? "no values" : std::to_string(n) + " value(s)"),
                    name + " " + keyword->values);
    }
    (this->*keyword->read)();
  }

  // Each keyword is permitted once, or once for each number. Records its line.
  void note_once(const std::string& key)
  {
    const auto [at, is_new] = line_of_.emplace(key, lines_.line());
    if (!is_new)
      lines_.refuse("a second " + key + " (first in line " + std::to_string(at->second) + ")", "one");
  }

  // The keyword followed by the number of a body, view or angle.
  std::string numbered(std::int64_t number) const
  {
    return std::string(lines_.words().front()) + " " + std::to_string(number);
  }

  std::int64_t number_up_to(std::int64_t largest, const std::string& wanted)
  {
    const std::int64_t number = lines_.whole(1, wanted);
    if (number < 0 || number > largest) lines_.refuse(std::to_string(number), wanted);
    return number;
  }

  std::int64_t body() { return number_up_to(1, "body 0 (reference) or 1 (moving)"); }

  double length_mm(std::size_t k)
  {
    const double mm = in_mm(lines_.real(k, "a length"), unit_mm_);
    if (std::abs(mm) > longest_mm)
      lines_.refuse(shortest_decimal(mm) + " mm", "at most " + shortest_decimal(longest_mm) + " mm");
    return mm + 0.0;
  }

  double angle_deg(std::size_t k)
  {
    const std::string wanted = "an angle from -180 to 180 degrees";
    const double deg = lines_.real(k, wanted);
    if (std::abs(deg) > 180.0) lines_.refuse(shortest_decimal(deg), wanted);
    return deg + 0.0;
  }

  // A step or resolution above 0.
  double positive(double value, double largest, const char* unit)
  {
    if (!(value > 0.0) || value > largest)
      lines_.refuse(shortest_decimal(value) + unit,
                    std::string("above 0") + unit + ", at most " + shortest_decimal(largest) + unit);
    return value;
  }

  Eigen::Vector3d lengths_mm() { return {length_mm(2), length_mm(3), length_mm(4)}; }
  Eigen::Vector3d angles_deg() { return {angle_deg(2), angle_deg(3), angle_deg(4)}; }

  void read_model()
  {
    const std::int64_t id = body();
    const std::string name(lines_.words()[2]);
    if (!is_component_name(name)) lines_.refuse(quoted(name), component_name_rule);
    note_once(numbered(id) + " " + name);
    (id == 0 ? out_.reference : out_.moving).push_back(name);
  }

  // Returns whether the value is for body 1. Values for body 0 must be zero: the reference does not move.
  bool is_of_moving(const Eigen::Vector3d& value)
  {
    const std::int64_t id = body();
    note_once(numbered(id));
    if (id == 0 && !value.isZero(0.0)) {
      lines_.refuse("a value for body 0 that is not zero",
                    "zeros: the reference does not move; move body 1 instead");
    }
    return id == 1;
  }

  void read_position()
  {
    const Eigen::Vector3d position_mm = lengths_mm();
    if (is_of_moving(position_mm)) out_.position_mm = position_mm;
  }

  void read_motion()
  {
    const Eigen::Vector3d motion_mm = lengths_mm();
    if (!is_of_moving(motion_mm)) return;
    out_.motion_mm = motion_mm;
    const double step_mm = motion_mm.norm();
    if (!(step_mm > 0.0) || step_mm > longest_step_mm) {
      lines_.refuse("a motion of " + shortest_decimal(step_mm) + " mm",
                    "one above 0 mm, at most " + shortest_decimal(longest_step_mm) + " mm");
    }
  }

  void read_orientation()
  {
    const Eigen::Vector3d turns_deg = angles_deg();
    if (is_of_moving(turns_deg)) orientation_deg_ = turns_deg;
  }

  ConfiguredView& view()
  {
    constexpr std::int64_t max_views = 100;
    const std::int64_t number = number_up_to(max_views - 1, "a view from 0 to 99");
    note_once(numbered(number));
    return out_.views[static_cast<int>(number)];
  }

  void read_shift() { view().shift_mm = lengths_mm(); }
  void read_view_orientation() { view().orientation_deg = angles_deg(); }

  int pixels(std::size_t k)
  {
    constexpr std::int64_t largest = 16384;
    const std::string wanted = "a whole number of pixels from 1 to " + std::to_string(largest);
    const std::int64_t n = lines_.whole(k, wanted);
    if (n < 1 || n > largest) lines_.refuse(std::to_string(n), wanted);
    return static_cast<int>(n);
  }

  void read_display()
  {
    note_once("DISPLAY");
    out_.display_px = {pixels(1), pixels(2)};
  }

  void read_zoom()
  {
    constexpr double largest = 1e6;
    note_once("ZOOM");
    out_.zoom = positive(lines_.real(1, "a factor above 0"), largest, "");
  }

  void read_contact_resolution()
  {
    note_once("CONTACT_RESOLUTION");
    out_.contact_resolution_mm = positive(length_mm(1), longest_step_mm, " mm");
  }

  void read_modelling_step()
  {
    note_once("MODELING_RESOLUTION");
    out_.modelling_step_mm = positive(length_mm(1), longest_step_mm, " mm");
  }

  void read_orientation_resolution()
  {
    note_once("ORIENTATION_RESOLUTION");
    out_.orientation_resolution_deg = positive(lines_.real(1, "an angle"), largest_step_deg, " degrees");
  }

  void read_orientation_step()
  {
    note_once("ORIENTATION_STEP");
    out_.orientation_step_deg = positive(lines_.real(1, "an angle"), largest_step_deg, " degrees");
  }

  void read_range()
  {
    const std::int64_t angle = number_up_to(1, "angle 0 (flexion) or 1 (varus)");
    note_once(numbered(angle));
    AngleRange& range = angle == 0 ? out_.flexion : out_.varus;
    range.from_deg = lines_.real(2, "an angle");
    range.to_deg = lines_.real(3, "an angle");
    const double lowest = std::min(range.from_deg, range.to_deg);
    const double highest = std::max(range.from_deg, range.to_deg);
    if (angle == 0 && (lowest < -30.0 || highest > 180.0)) {
      lines_.refuse(shortest_decimal(lowest < -30.0 ? lowest : highest),
                    "flexion from -30 to 180 degrees; positive angles bend the knee");
    }
    if (angle == 1 && (lowest < -85.0 || highest > 85.0))
      lines_.refuse(shortest_decimal(lowest < -85.0 ? lowest : highest), "varus from -85 to 85 degrees");
    const bool is_falling = range.to_deg < range.from_deg;
    range.step_deg = lines_.words().size() > 4 ? lines_.real(4, "a step in degrees")
                     : is_falling              ? -1.0
                                               : 1.0;
    if (std::abs(range.step_deg) > whole_turn_deg)
      lines_.refuse("a step of " + shortest_decimal(range.step_deg), "one of at most 360 degrees");
    if (range.step_deg == 0.0 || (range.from_deg != range.to_deg && (range.step_deg < 0.0) != is_falling)) {
      lines_.refuse("a step of " + shortest_decimal(range.step_deg),
                    "a step that goes from " + shortest_decimal(range.from_deg) + " to " +
                        shortest_decimal(range.to_deg));
    }
  }

  void read_render()
  {
    note_once("RENDER");
    out_.render = std::string(lines_.words()[1]);
    if (out_.render != "fill" && out_.render != "wire") lines_.refuse(quoted(out_.render), "fill or wire");
  }

  // Line of a keyword; 0 if it is missing.
  std::size_t line_of(const std::string& key) const
  {
    const auto found = line_of_.find(key);
    return found == line_of_.end() ? 0 : found->second;
  }

  void check_models() const
  {
    if (out_.reference.empty()) lines_.refuse("no model of body 0", "MODEL 0 name: the reference");
    if (out_.moving.empty()) lines_.refuse("no model of body 1", "MODEL 1 name: the moving body");
  }

  // A job can express only a rotation about the direction of motion.
  void check_orientation()
  {
    if (orientation_deg_.isZero(0.0)) return;
    Eigen::Index axis = 0;
    orientation_deg_.cwiseAbs().maxCoeff(&axis);
    Eigen::Vector3d other_turns_deg = orientation_deg_, across_mm = out_.motion_mm;
    other_turns_deg[axis] = across_mm[axis] = 0.0;
    if (!other_turns_deg.isZero(0.0) || !across_mm.isZero(0.0)) {
      lines_.refuse_at(line_of("INITIAL_ORIENTATION 1"),
                       "rotations " + shortest_decimal(orientation_deg_.x()) + ", " +
                           shortest_decimal(orientation_deg_.y()) + " and " +
                           shortest_decimal(orientation_deg_.z()) + " degrees about X, Y and Z",
                       "a rotation about the direction of motion only");
    }
    out_.turn_deg = out_.motion_mm[axis] < 0.0 ? -orientation_deg_[axis] : orientation_deg_[axis];
  }

  void check_steps() const
  {
    const auto compare = [&](std::size_t line, double resolution, double step, const char* unit) {
      if (resolution <= step) return;
      lines_.refuse_at(line, "a resolution of " + shortest_decimal(resolution) + unit,
                       "at most the step, " + shortest_decimal(step) + unit);
    };
    compare(std::max(line_of("CONTACT_RESOLUTION"), line_of("MODELING_RESOLUTION")),
            out_.contact_resolution_mm, out_.modelling_step_mm, " mm");
    compare(std::max(line_of("ORIENTATION_RESOLUTION"), line_of("ORIENTATION_STEP")),
            out_.orientation_resolution_deg, out_.orientation_step_deg, " degrees");
  }

  void check_attitudes() const
  {
    const auto count = [](const AngleRange& r) { return (r.to_deg - r.from_deg) / r.step_deg + 1.0; };
    const double n = count(out_.flexion) * count(out_.varus);
    if (n < max_attitudes) return;
    lines_.refuse_at(std::max(line_of("ANGLE_RANGE 0"), line_of("ANGLE_RANGE 1")),
                     "more than a million attitudes", "at most 1000000: larger steps");
  }

  TextLines lines_;
  double unit_mm_;
  Eigen::Vector3d orientation_deg_{0.0, 0.0, 0.0};
  std::map<std::string, std::size_t> line_of_;
  KeywordConfiguration out_;
};

}  // namespace

KeywordConfiguration parse_configuration(const NamedText& source, double unit_mm)
{
  return Reader(source, unit_mm).read();
}

NamedText read_configuration(const std::string& file)
{
  return {file, job::file_bytes(file, {file, "", "", "a configuration file"}, largest_configuration_bytes)};
}

}  // namespace vrda::job
