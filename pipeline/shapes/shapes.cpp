#include "shapes/shapes.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <numeric>
#include <utility>

#include "core/error.hpp"
#include "shapes/hip.hpp"
#include "shapes/knee.hpp"

namespace vrda {
namespace {

// A request whose parameters are all known, in range and present.
class Values {
 public:
  double number(const std::string& name) const { return numbers_.at(name); }
  int whole(const std::string& name) const { return static_cast<int>(std::lround(numbers_.at(name))); }
  const std::string& word(const std::string& name) const { return words_.at(name); }
  void set(const std::string& name, double value) { numbers_[name] = value; }
  void set(const std::string& name, const std::string& value) { words_[name] = value; }

 private:
  std::map<std::string, double> numbers_;
  std::map<std::string, std::string> words_;
};

using Build = Shape (*)(const Values&);

struct Entry {
  std::string name;
  std::string summary;
  std::vector<ShapeParameter> parameters;
  Build build;
};

// Insertions, deletions and substitutions between two words.
std::size_t edit_distance(const std::string& a, const std::string& b)
{
  std::vector<std::size_t> row(b.size() + 1);
  std::iota(row.begin(), row.end(), std::size_t{0});
  for (std::size_t i = 0; i < a.size(); ++i) {
    std::size_t diagonal = row[0];
    row[0] = i + 1;
    for (std::size_t k = 0; k < b.size(); ++k) {
      const std::size_t substituted = diagonal + (a[i] == b[k] ? 0 : 1);
      diagonal = row[k + 1];
      row[k + 1] = std::min({substituted, row[k] + 1, diagonal + 1});
    }
  }
  return row.back();
}

std::string nearest(const std::string& word, const std::vector<std::string>& known)
{
  const auto closer = [&](const std::string& l, const std::string& r) {
    return edit_distance(word, l) < edit_distance(word, r);
  };
  return known.empty() ? std::string() : *std::min_element(known.begin(), known.end(), closer);
}

// "one of a, b, c; did you mean b?"
std::string one_of(const std::string& word, const std::vector<std::string>& known)
{
  if (known.empty()) return "no parameter";
  std::string list;
  for (const std::string& name : known) list += (list.empty() ? "" : ", ") + name;
  return "one of " + list + "; the nearest is " + nearest(word, known);
}

std::string text(double number)
{
  char buffer[32];
  std::snprintf(buffer, sizeof buffer, "%g", number);
  return buffer;
}

ShapeParameter number(std::string name, std::string meaning, std::string unit, double value, double lowest,
                      double highest)
{
  return {std::move(name), std::move(meaning), std::move(unit), value, lowest, highest, false, {}};
}

ShapeParameter word(std::string name, std::string meaning, std::vector<std::string> choices)
{
  return {std::move(name), std::move(meaning), "", 0.0, 0.0, 0.0, false, std::move(choices)};
}

// A million triangles in all at the upper end of the knee's range.
Entry knee_entry()
{
  return {"knee",
          "a right or left knee: femur, tibia, both menisci; shafts and fibula drawn only",
          {number("resolution", "multiplies the edges along any line; triangles grow with its square", "",
                  1.0, 0.6, 12.0),
           word("side", "which knee", {"right", "left"})},
          [](const Values& values) {
            Shape shape = right_knee(values.number("resolution"));
            if (values.word("side") == "right") return shape;
            for (std::vector<ShapePart>* parts : {&shape.reference, &shape.moving}) {
              for (ShapePart& part : *parts) part.mesh = mirrored_z(part.mesh);
            }
            return shape;
          }};
}

Entry hip_entry()
{
  const HipPlan plan;
  return {
      "hip",
      "a ball on a neck in a deep socket",
      {number("resolution", "multiplies the edges along any line", "", plan.resolution, 0.5, 12.0),
       number("radius", "of the head", "mm", plan.radius_mm, 5.0, 100.0),
       number("clearance", "the socket's inner radius less the head's", "mm", plan.clearance_mm, 0.0, 20.0),
       number("wall", "the socket's thickness", "mm", plan.wall_mm, 2.0, 50.0),
       number("depth", "how far the socket's rim reaches below its centre", "mm", plan.depth_mm, -20.0, 20.0),
       number("neck", "lean of the neck from straight down", "deg", plan.neck_deg, 0.0, 80.0)},
      [](const Values& values) {
        HipPlan chosen;
        chosen.resolution = values.number("resolution");
        chosen.radius_mm = values.number("radius");
        chosen.clearance_mm = values.number("clearance");
        chosen.wall_mm = values.number("wall");
        chosen.depth_mm = values.number("depth");
        chosen.neck_deg = values.number("neck");
        return hip(chosen);
      }};
}

const std::vector<Entry>& entries()
{
  static const std::vector<Entry> all = {knee_entry(), hip_entry()};
  return all;
}

const Entry& entry(const std::string& shape)
{
  for (const Entry& candidate : entries()) {
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
    throw InputError({"shape " + chosen.name, name, text(value), one_of("", wanted.choices)});
  }
  const bool is_in_range = value >= wanted.lowest && value <= wanted.highest;  // false for NaN
  const bool is_allowed = is_in_range && (!wanted.is_whole || value == std::floor(value));
  if (!is_allowed) {
    throw InputError({"shape " + chosen.name, name, text(value),
                      std::string(wanted.is_whole ? "a whole number" : "a number") + " from " +
                          text(wanted.lowest) + " to " + text(wanted.highest) +
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

}  // namespace

std::vector<std::string> shape_names()
{
  std::vector<std::string> names;
  for (const Entry& each : entries()) names.push_back(each.name);
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
  Values values;
  for (const ShapeParameter& each : chosen.parameters) {
    if (each.choices.empty()) values.set(each.name, each.default_number);
    if (!each.choices.empty()) values.set(each.name, each.choices.front());
  }
  for (const auto& [name, value] : request.numbers) set_number(values, chosen, name, value);
  for (const auto& [name, value] : request.words) set_word(values, chosen, name, value);
  return chosen.build(values);
}

}  // namespace vrda
