#include "job/thesis_files.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <functional>
#include <limits>

#include "core/document.hpp"
#include "core/text.hpp"
#include "job/clean_mesh.hpp"
#include "job/job.hpp"

namespace vrda::job {
namespace {

constexpr std::string_view separators = " \t\r,";

bool is_letter(char c)
{
  return (c >= 'A' && c <= 'Z') || (c >= 'a' && c <= 'z');
}

}  // namespace

bool TextLines::next()
{
  const std::string_view text = source_.text;
  words_.clear();
  while (words_.empty() && at_ < text.size()) {
    const std::size_t end = std::min(text.find('\n', at_), text.size());
    std::string_view line = text.substr(at_, end - at_);
    line = line.substr(0, std::min(line.find('#'), line.size()));
    at_ = end + 1;
    ++line_;
    std::size_t begin = line.find_first_not_of(separators);
    while (begin != std::string_view::npos) {
      const std::size_t stop = std::min(line.find_first_of(separators, begin), line.size());
      words_.push_back(line.substr(begin, stop - begin));
      begin = line.find_first_not_of(separators, stop);
    }
  }
  return !words_.empty();
}

double TextLines::real(std::size_t k, const std::string& wanted) const
{
  const std::optional<double> number = k < words_.size() ? parse_real(words_[k]) : std::nullopt;
  if (!number || !std::isfinite(*number)) refuse(shown_word(k), wanted);
  return *number;
}

std::int64_t TextLines::whole(std::size_t k, const std::string& wanted) const
{
  const std::optional<std::int64_t> number = k < words_.size() ? parse_integer(words_[k]) : std::nullopt;
  if (!number) refuse(shown_word(k), wanted);
  return *number;
}

std::string TextLines::shown_word(std::size_t k) const
{
  return k < words_.size() ? quoted_word(words_[k]) : "the end of the line";
}

void TextLines::refuse(const std::string& found, const std::string& wanted) const
{
  refuse_at(line_, found, wanted);
}

void TextLines::refuse_at(std::size_t line, const std::string& found, const std::string& wanted) const
{
  throw InputError({source_.file, "line " + std::to_string(std::max<std::size_t>(line, 1)), found, wanted});
}

bool is_component_name(std::string_view word)
{
  constexpr std::size_t longest = 100;
  if (word.empty() || word.size() > longest || !is_letter(word.front())) return false;
  return std::all_of(word.begin(), word.end(), [](char c) {
    return is_letter(c) || (c >= '0' && c <= '9') || c == '_' || c == '-' || c == '.';
  });
}

namespace {

constexpr std::uintmax_t largest_configuration_bytes = 1U << 20U;  // the thesis's example has about 15 lines
constexpr double longest_mm = 1e6;                                 // 1 km: more is probably a mistake
constexpr double longest_step_mm = 1000.0;                         // limit of a job
constexpr double largest_step_deg = 90.0;                          // limit of a job
constexpr double whole_turn_deg = 360.0;
constexpr double largest_zoom = 1e6;
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
    std::size_t min_values, max_values;
    bool is_numbered;  // of a body, view or angle: permitted once for each
    void (*read)(Reader&);
  };

  static const std::vector<Keyword>& keywords()
  {
    static const std::vector<Keyword> all{
        {"MODEL", "body name", 2, 2, true, [](Reader& r) { r.read_model(); }},
        {"INITIAL_POSITION", "body x y z", 4, 4, true, [](Reader& r) { r.read_position(); }},
        {"INITIAL_MOTION", "body x y z", 4, 4, true, [](Reader& r) { r.read_motion(); }},
        {"INITIAL_ORIENTATION", "body rx ry rz", 4, 4, true, [](Reader& r) { r.read_orientation(); }},
        {"SHIFT_MODEL", "view x y z", 4, 4, true, [](Reader& r) { r.view().shift_mm = r.lengths_mm(); }},
        {"ORIENTATION_MODEL", "view rx ry rz", 4, 4, true,
         [](Reader& r) { r.view().orientation_deg = r.angles_deg(); }},
        {"DISPLAY", "width height", 2, 2, false,
         [](Reader& r) {
           r.out_.display_px = {r.pixels(1), r.pixels(2)};
         }},
        {"ZOOM", "factor", 1, 1, false,
         [](Reader& r) { r.out_.zoom = r.positive(r.lines_.real(1, "a factor above 0"), largest_zoom, ""); }},
        {"CONTACT_RESOLUTION", "length", 1, 1, false,
         [](Reader& r) { r.out_.contact_resolution_mm = r.step_mm(); }},
        {"MODELING_RESOLUTION", "length", 1, 1, false,
         [](Reader& r) { r.out_.modelling_step_mm = r.step_mm(); }},
        {"ORIENTATION_RESOLUTION", "degrees", 1, 1, false,
         [](Reader& r) { r.out_.orientation_resolution_deg = r.step_deg(); }},
        {"ORIENTATION_STEP", "degrees", 1, 1, false,
         [](Reader& r) { r.out_.orientation_step_deg = r.step_deg(); }},
        {"ANGLE_RANGE", "angle from to [step]", 3, 4, true, [](Reader& r) { r.read_range(); }},
        {"RENDER", "fill|wire", 1, 1, false, [](Reader& r) { r.read_render(); }},
    };
    return all;
  }

  void read_line()
  {
    const std::string name(lines_.words().front());
    const auto keyword = std::ranges::find(keywords(), name, &Keyword::name);
    if (keyword == keywords().end()) {
      std::vector<std::string> names;
      for (const Keyword& known : keywords()) names.emplace_back(known.name);
      // Bounds the cost of the comparison.
      const std::string nearest = nearest_word(name.substr(0, 40), names);
      lines_.refuse("the unknown keyword " + quoted_word(name),
                    "a keyword; the nearest is \"" + nearest + "\"");
    }
    const std::size_t n = lines_.words().size() - 1;
    if (n < keyword->min_values || n > keyword->max_values) {
      lines_.refuse(name + " with " + (n == 0 ? "no values" : std::to_string(n) + " value(s)"),
                    name + " " + keyword->values);
    }
    if (!keyword->is_numbered) note_once(name);
    keyword->read(*this);
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

  double step_mm() { return positive(length_mm(1), longest_step_mm, " mm"); }
  double step_deg() { return positive(lines_.real(1, "an angle"), largest_step_deg, " degrees"); }

  Eigen::Vector3d lengths_mm() { return {length_mm(2), length_mm(3), length_mm(4)}; }
  Eigen::Vector3d angles_deg() { return {angle_deg(2), angle_deg(3), angle_deg(4)}; }

  void read_model()
  {
    const std::int64_t id = body();
    const std::string name(lines_.words()[2]);
    if (!is_component_name(name)) lines_.refuse(quoted_word(name), component_name_rule);
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

  int pixels(std::size_t k)
  {
    constexpr std::int64_t largest = 16384;
    const std::string wanted = "a whole number of pixels from 1 to " + std::to_string(largest);
    const std::int64_t n = lines_.whole(k, wanted);
    if (n < 1 || n > largest) lines_.refuse(std::to_string(n), wanted);
    return static_cast<int>(n);
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
    out_.render = std::string(lines_.words()[1]);
    if (out_.render != "fill" && out_.render != "wire")
      lines_.refuse(quoted_word(out_.render), "fill or wire");
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
  return {file, file_bytes(file, {file, "", "", "a configuration file"}, largest_configuration_bytes)};
}

namespace {

// Rows of three numbers, numbered without gaps from `first`.
struct Rows {
  Points values;
  std::int64_t first = 1;
};

// The optional row count: a first line of one whole number.
struct RowCount {
  std::optional<std::int64_t> n_rows;
  std::size_t line = 0;
};

RowCount row_count_in(const TextLines& lines)
{
  if (lines.words().size() != 1) return {};
  return {parse_integer(lines.words().front()), lines.line()};
}

void check_row_count(const TextLines& lines, const RowCount& count, std::size_t n_rows)
{
  if (!count.n_rows || *count.n_rows == static_cast<std::int64_t>(n_rows)) return;
  lines.refuse_at(count.line, "a count of " + std::to_string(*count.n_rows),
                  std::to_string(n_rows) + ", the number of rows that follow");
}

std::string numbers_from(std::int64_t first, Eigen::Index n)
{
  return "from " + std::to_string(first) + " to " + std::to_string(first + n - 1);
}

// For normals `vertices` is given: the rows must have the same numbers.
Rows read_rows(const NamedText& source, const std::string& what, const Rows* vertices)
{
  TextLines lines(source);
  bool has_line = lines.next();
  const RowCount count = has_line ? row_count_in(lines) : RowCount{};
  if (count.n_rows) has_line = lines.next();
  std::int64_t first = vertices == nullptr ? 1 : vertices->first;
  std::vector<double> values;
  for (; has_line; has_line = lines.next()) {
    if (lines.words().size() != 4) {
      lines.refuse(std::to_string(lines.words().size()) + " words",
                   "the number of a " + what + " and its three coordinates");
    }
    if (vertices != nullptr && values.size() == static_cast<std::size_t>(vertices->values.size())) {
      lines.refuse("more normals", std::to_string(vertices->values.rows()) + ", one for each vertex");
    }
    const std::int64_t number = lines.whole(0, "the number of the row");
    if (values.empty() && vertices == nullptr && number == 0) first = 0;
    const std::int64_t expected = first + static_cast<std::int64_t>(values.size() / 3);
    if (number != expected) {
      const std::string row = "row " + std::to_string(expected);
      lines.refuse("row " + std::to_string(number), !values.empty()       ? row
                                                    : vertices == nullptr ? "row 1 (or 0) first"
                                                                          : row + " first");
    }
    for (std::size_t k = 1; k <= 3; ++k) {
      values.push_back(lines.real(k, "a finite coordinate"));
      if (std::abs(values.back()) > largest_coordinate)
        lines.refuse("a coordinate of " + shortest_decimal(values.back()), "at most 1e9 in size");
    }
  }
  const auto n = static_cast<Eigen::Index>(values.size() / 3);
  check_row_count(lines, count, static_cast<std::size_t>(n));
  if (n == 0) lines.refuse("no " + what, "a row for each " + what);
  if (vertices != nullptr && n != vertices->values.rows()) {
    lines.refuse(std::to_string(n) + " normals",
                 std::to_string(vertices->values.rows()) + ", one for each vertex");
  }
  return {Eigen::Map<const Points>(values.data(), n, 3), first};
}

// Polygons of one component; corners are row indices of the whole set.
struct Polygons {
  std::string name;
  std::size_t line = 0;  // of its first polygon
  std::vector<std::int32_t> corner;
  std::vector<std::int32_t> size;
};

class ElementReader {
 public:
  ElementReader(const NamedText& source, const Rows& vertices) : lines_(source), vertices_(vertices) {}

  std::vector<Polygons> read()
  {
    bool has_line = lines_.next();
    const RowCount count = has_line ? row_count_in(lines_) : RowCount{};
    if (count.n_rows) has_line = lines_.next();
    std::size_t n_faces = 0;
    for (; has_line; has_line = lines_.next()) {
      if (++n_faces > largest_face_count)
        lines_.refuse("more faces", "at most " + std::to_string(largest_face_count));
      read_face();
    }
    check_row_count(lines_, count, n_faces);
    if (n_faces == 0) lines_.refuse("no element", "the faces of at least one component");
    return std::move(components_);
  }

 private:
  void read_face()
  {
    const auto& words = lines_.words();
    Polygons& component = component_named(words.front());
    const std::size_t n_corners = words.size() - 1;
    if (n_corners < 3 || n_corners > largest_face_size) {
      lines_.refuse(std::to_string(n_corners) + " vertices after the component's name",
                    "from 3 to " + std::to_string(largest_face_size));
    }
    const Eigen::Index n_vertices = vertices_.values.rows();
    for (std::size_t k = 1; k <= n_corners; ++k) {
      const std::int64_t number = lines_.whole(k, "the number of a vertex");
      if (number < vertices_.first || number >= vertices_.first + n_vertices) {
        lines_.refuse("vertex " + std::to_string(number),
                      "a vertex " + numbers_from(vertices_.first, n_vertices));
      }
      component.corner.push_back(static_cast<std::int32_t>(number - vertices_.first));
    }
    component.size.push_back(static_cast<std::int32_t>(n_corners));
  }

  Polygons& component_named(std::string_view name)
  {
    if (const auto found = index_of_.find(name); found != index_of_.end()) return components_[found->second];
    if (parse_real(name)) {
      lines_.refuse("an element without a component name: its first word is " + quoted_word(name),
                    "the name of its component, then the numbers of its vertices");
    }
    if (!is_component_name(name)) lines_.refuse(quoted_word(name), component_name_rule);
    if (components_.size() == max_object_components)
      lines_.refuse("more components", "at most " + std::to_string(max_object_components));
    index_of_.emplace(name, components_.size());
    components_.push_back({std::string(name), lines_.line(), {}, {}});
    return components_.back();
  }

  TextLines lines_;
  const Rows& vertices_;
  std::vector<Polygons> components_;
  std::map<std::string, std::size_t, std::less<>> index_of_;  // index in components_ by name
};

// Sorted row indices of the vertices that the polygons use.
std::vector<std::int32_t> used_by(const Polygons& polygons, const std::string& file)
{
  std::vector<std::int32_t> used = polygons.corner;
  std::sort(used.begin(), used.end());
  used.erase(std::unique(used.begin(), used.end()), used.end());
  if (used.size() >= 3) return used;
  throw InputError({file, "line " + std::to_string(polygons.line),
                    "\"" + polygons.name + "\" of " + std::to_string(used.size()) + " vertices",
                    "at least 3"});
}

ObjectComponent component_of(Polygons polygons, const std::vector<std::int32_t>& used, const Rows& vertices,
                             const Rows& normals)
{
  ObjectComponent component{std::move(polygons.name), {}};
  RawMesh& mesh = component.mesh;
  mesh.vertices.resize(static_cast<Eigen::Index>(used.size()), 3);
  mesh.normals.resize(static_cast<Eigen::Index>(used.size()), 3);
  for (std::size_t v = 0; v < used.size(); ++v) {
    mesh.vertices.row(static_cast<Eigen::Index>(v)) = vertices.values.row(used[v]);
    mesh.normals.row(static_cast<Eigen::Index>(v)) = normals.values.row(used[v]);
  }
  mesh.size = std::move(polygons.size);
  mesh.corner = std::move(polygons.corner);
  for (std::int32_t& corner : mesh.corner) {
    corner = static_cast<std::int32_t>(std::lower_bound(used.begin(), used.end(), corner) - used.begin());
  }
  return component;
}

NamedText text_of(const std::string& prefix, const char* extension, const char* holds)
{
  const std::string file = prefix + extension;
  return {file, file_bytes(file, {file, "", "", std::string("the ") + holds + " of an Object set"},
                           largest_mesh_bytes)};
}

}  // namespace

std::vector<ObjectComponent> parse_object_set(const ObjectSetTexts& texts)
{
  const Rows vertices = read_rows(texts.coordinates, "vertex", nullptr);
  const Rows normals = read_rows(texts.normals, "normal", &vertices);
  std::vector<ObjectComponent> components;
  for (Polygons& polygons : ElementReader(texts.elements, vertices).read()) {
    const std::vector<std::int32_t> used = used_by(polygons, texts.elements.file);
    components.push_back(component_of(std::move(polygons), used, vertices, normals));
  }
  return components;
}

ObjectSetTexts read_object_set(const std::string& prefix)
{
  return {text_of(prefix, ".coor", "coordinates"), text_of(prefix, ".norm", "normals"),
          text_of(prefix, ".elem", "elements")};
}

namespace {

std::string point_text(const Points& points, Eigen::Index row)
{
  return core::numbers_text(points.row(row), " ");
}

// Calls `act` with the number of corners of each face and a pointer to the first.
template <typename Act>
void for_each_face(const RawMesh& mesh, const Act& act)
{
  const std::int32_t* corner = mesh.corner.data();
  for (const std::int32_t n : mesh.size) {
    act(n, corner);
    corner += n;
  }
}

std::string counted_face(std::int32_t n, const std::int32_t* corner)
{
  std::string line = std::to_string(n);
  for (std::int32_t k = 0; k < n; ++k) line += ' ' + std::to_string(corner[k]);
  return line + '\n';
}

void put_vector(std::array<char, 50>& record, std::size_t slot, const Eigen::Vector3d& v)
{
  for (std::size_t k = 0; k < 3; ++k) {
    const auto value = static_cast<float>(v[static_cast<Eigen::Index>(k)]);
    std::memcpy(record.data() + 12 * slot + 4 * k, &value, sizeof value);
  }
}

Mesh triangle_mesh(const RawMesh& raw)
{
  std::vector<std::int32_t> corners;
  for_each_face(raw, [&](std::int32_t n, const std::int32_t* corner) {
    Points points(n, 3);
    for (std::int32_t k = 0; k < n; ++k) points.row(k) = raw.vertices.row(corner[k]);
    for (const std::array<std::int32_t, 3>& triangle : triangulate(points)) {
      for (const std::int32_t k : triangle) corners.push_back(corner[k]);
    }
  });
  Mesh mesh;
  mesh.vertices_mm = raw.vertices;
  mesh.triangles =
      Eigen::Map<const Triangles>(corners.data(), static_cast<Eigen::Index>(corners.size() / 3), 3);
  return mesh;
}

void check_single_precision(const std::string& file, const RawMesh& mesh)
{
  constexpr double largest = std::numeric_limits<float>::max();
  for (Eigen::Index v = 0; v < mesh.vertices.rows(); ++v) {
    if (mesh.vertices.row(v).cwiseAbs().maxCoeff() <= largest) continue;
    throw InputError({file, "vertex " + std::to_string(v), "(" + point_text(mesh.vertices, v) + ")",
                      "coordinates within single precision, up to " + shortest_decimal(largest)});
  }
}

}  // namespace

std::string vertices_faces_bytes(const RawMesh& mesh)
{
  std::string bytes = std::to_string(mesh.vertices.rows()) + ' ' + std::to_string(mesh.size.size()) + '\n';
  for (Eigen::Index v = 0; v < mesh.vertices.rows(); ++v) bytes += point_text(mesh.vertices, v) + '\n';
  for_each_face(mesh, [&](std::int32_t n, const std::int32_t* corner) { bytes += counted_face(n, corner); });
  return bytes;
}

std::string vertex_normals_bytes(const RawMesh& mesh)
{
  std::string bytes = std::to_string(mesh.normals.rows()) + '\n';
  for (Eigen::Index v = 0; v < mesh.normals.rows(); ++v) bytes += point_text(mesh.normals, v) + '\n';
  return bytes;
}

std::string wavefront_bytes(const RawMesh& mesh)
{
  const bool has_normals = mesh.normals.rows() > 0;
  std::string bytes;
  for (Eigen::Index v = 0; v < mesh.vertices.rows(); ++v) bytes += "v " + point_text(mesh.vertices, v) + '\n';
  for (Eigen::Index v = 0; v < mesh.normals.rows(); ++v) bytes += "vn " + point_text(mesh.normals, v) + '\n';
  for_each_face(mesh, [&](std::int32_t n, const std::int32_t* corner) {
    bytes += 'f';
    for (std::int32_t k = 0; k < n; ++k) {
      const std::string index = std::to_string(corner[k] + 1);
      bytes += ' ' + index + (has_normals ? "//" + index : "");
    }
    bytes += '\n';
  });
  return bytes;
}

std::string ply_bytes(const RawMesh& mesh)
{
  constexpr std::int32_t largest_uchar = 255;
  const bool has_normals = mesh.normals.rows() > 0;
  const bool is_short =
      std::all_of(mesh.size.begin(), mesh.size.end(), [](std::int32_t n) { return n <= largest_uchar; });
  std::string bytes = "ply\nformat ascii 1.0\nelement vertex " + std::to_string(mesh.vertices.rows()) +
                      "\nproperty double x\nproperty double y\nproperty double z\n";
  if (has_normals) bytes += "property double nx\nproperty double ny\nproperty double nz\n";
  bytes += "element face " + std::to_string(mesh.size.size()) + "\nproperty list " +
           (is_short ? "uchar" : "int") + " int vertex_indices\nend_header\n";
  for (Eigen::Index v = 0; v < mesh.vertices.rows(); ++v) {
    bytes += point_text(mesh.vertices, v) + (has_normals ? ' ' + point_text(mesh.normals, v) : "") + '\n';
  }
  for_each_face(mesh, [&](std::int32_t n, const std::int32_t* corner) { bytes += counted_face(n, corner); });
  return bytes;
}

// 80 bytes of header, a count, 50 bytes for each triangle; little-endian, like all supported machines.
std::string stl_bytes(const Mesh& mesh, const std::string& header)
{
  constexpr std::size_t header_bytes = 80;
  std::string bytes = header.substr(0, header_bytes);
  bytes.resize(header_bytes, '\0');
  const auto n = static_cast<std::uint32_t>(mesh.triangles.rows());
  bytes.append(reinterpret_cast<const char*>(&n), sizeof n);
  for (Eigen::Index t = 0; t < mesh.triangles.rows(); ++t) {
    std::array<char, 50> record{};
    put_vector(record, 0, face_normal(mesh, t));
    const auto corner = corners(mesh, t);
    for (std::size_t k = 0; k < 3; ++k) put_vector(record, k + 1, corner[k]);
    bytes.append(record.data(), record.size());
  }
  return bytes;
}

std::string mesh_bytes(const std::string& file, const RawMesh& mesh)
{
  const std::string extension = std::filesystem::path(file).extension().string();
  if (extension == ".vf") return vertices_faces_bytes(mesh);
  if (extension == ".obj") return wavefront_bytes(mesh);
  if (extension == ".ply") return ply_bytes(mesh);
  if (extension == ".stl") {
    check_single_precision(file, mesh);
    return stl_bytes(triangle_mesh(mesh), "vrda convert");
  }
  throw InputError({file, "", "the extension \"" + extension + "\"", "an output .vf, .stl, .ply or .obj"});
}

RawMesh merge_equal_vertices(const RawMesh& mesh)
{
  WeldedVertices welded = weld_vertices(mesh);
  RawMesh out;
  out.size = mesh.size;
  out.corner.reserve(mesh.corner.size());
  for (const std::int32_t corner : mesh.corner)
    out.corner.push_back(welded.index_of_raw[static_cast<std::size_t>(corner)]);
  out.vertices = std::move(welded.vertices);
  out.normals = std::move(welded.normal_sums);
  for (Eigen::Index v = 0; v < out.normals.rows(); ++v) {
    const double length = out.normals.row(v).norm();
    if (!std::isfinite(length) || length == 0.0) {
      out.normals.resize(0, 3);
      break;
    }
    out.normals.row(v) /= length;
  }
  return out;
}

namespace {

// anterior = "+Z", proximal = "+Y", right = "-X"
Eigen::Vector3d canonical(const Eigen::Vector3d& native)
{
  return {native.z(), native.y(), -native.x()};
}

std::string list_of(const Eigen::Vector3d& v)
{
  return "[" + core::numbers_text(v) + "]";
}

std::string components_text(const std::string& body, const std::vector<std::string>& models,
                            const std::string& folder)
{
  std::string text;
  for (const std::string& model : models) {
    const std::string file = (folder.empty() ? "" : folder + "/") + model + ".obj";
    text += "\n[[" + body + ".component]]\nname = " + core::value_text(model) +
            "\nfile = " + core::value_text(file) + '\n';
  }
  return text;
}

std::string range_text(const AngleRange& range)
{
  return "{ from = " + shortest_decimal(range.from_deg) + ", to = " + shortest_decimal(range.to_deg) +
         ", step = " + shortest_decimal(range.step_deg) + " }";
}

// A line with its comment, aligned in one column.
std::string remarked(const std::string& text, const char* comment)
{
  return printed("%-37s # %s\n", text.c_str(), comment);
}

std::string solving_text(const KeywordConfiguration& c)
{
  const Eigen::Vector3d delta = canonical(c.motion_mm) / c.motion_mm.cwiseAbs().maxCoeff();
  const auto number = shortest_decimal;
  return "\n[push]\n" + remarked("delta = " + list_of(delta), "the direction of the initial motion") +
         "\n[grid]\nflexion = " + range_text(c.flexion) + "\nvarus = " + range_text(c.varus) +
         "\n\n[solver]\nmethod = \"stability-search\"\n\n[solver.search]\n" +
         remarked("approach_step_mm = " + number(c.motion_mm.norm()), "the length of the initial motion") +
         remarked("translation_step_mm = " + number(c.modelling_step_mm), "the modelling resolution") +
         remarked("translation_resolution_mm = " + number(c.contact_resolution_mm),
                  "the contact resolution") +
         "rotation_step_deg = " + number(c.orientation_step_deg) +
         "\nrotation_resolution_deg = " + number(c.orientation_resolution_deg) + '\n';
}

std::string player_text(const KeywordConfiguration& c)
{
  std::string text;
  if (c.display_px) text += printed("display_px = [%d, %d]\n", (*c.display_px)[0], (*c.display_px)[1]);
  if (c.zoom) text += "zoom = " + shortest_decimal(*c.zoom) + '\n';
  if (!c.render.empty()) text += "render = " + core::value_text(c.render) + '\n';
  for (const auto& [number, view] : c.views) {
    text += printed("\n[[player.view]]\nnumber = %d\nshift_mm = %s\norientation_deg = %s\n", number,
                    list_of(view.shift_mm).c_str(), list_of(view.orientation_deg).c_str());
  }
  return text.empty() ? text : "\n[player]\n" + text;
}

}  // namespace

std::string job_text(const KeywordConfiguration& c, const JobTextOptions& places)
{
  // theta has the right-knee sign, which is reversed on a left knee.
  const std::string theta_deg = shortest_decimal(-c.turn_deg);
  return "# From the keyword configuration " + core::value_text(places.source) +
         "; conversion: schemas/legacy-formats.md.\ntitle = " + core::value_text(places.title) + R"(
joint = "knee"
side = "left"

# Thesis 5.2: X from medial to lateral of a left knee, Y up, Z forward (OpenGL view).
[frame]
unit = )" +
         core::value_text(places.unit) + R"(
anterior = "+Z"
proximal = "+Y"
right = "-X"

[reference]
name = )" +
         core::value_text(c.reference.front()) + '\n' +
         components_text("reference", c.reference, places.models_folder) +
         "\n[moving]\nname = " + core::value_text(c.moving.front()) +
         "\n# anterior, proximal, right\ninitial = { translation_mm = " + list_of(canonical(c.position_mm)) +
         ", theta_deg = " + theta_deg + " }\n" + components_text("moving", c.moving, places.models_folder) +
         solving_text(c) + player_text(c);
}

}  // namespace vrda::job
