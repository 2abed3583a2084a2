#include "job/object_set.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <map>
#include <optional>

#include "core/error.hpp"
#include "core/text.hpp"
#include "job/input_file.hpp"
#include "job/words.hpp"

namespace vrda::job {
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
  return {job::parse_integer(lines.words().front()), lines.line()};
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

// Checks row numbers: consecutive, from 0 or 1, or from the first number of `vertices`.
class RowNumbers {
 public:
  explicit RowNumbers(const Rows* vertices) : vertices_(vertices) {}

  std::int64_t first() const { return first_; }

  void read(const TextLines& lines)
  {
    const std::int64_t number = lines.whole(0, "the number of the row");
    const bool may_be_first = vertices_ == nullptr ? number == 0 || number == 1 : number == vertices_->first;
    if (n_ == 0 && !may_be_first) {
      lines.refuse(
          "row " + std::to_string(number),
          vertices_ == nullptr ? "row 1 (or 0) first" : "row " + std::to_string(vertices_->first) + " first");
    }
    if (n_ == 0) first_ = number;
    if (number != first_ + n_)
      lines.refuse("row " + std::to_string(number), "row " + std::to_string(first_ + n_));
    ++n_;
  }

 private:
  const Rows* vertices_;
  std::int64_t first_ = 1;
  std::int64_t n_ = 0;
};

// For normals `vertices` is given: the rows must have the same numbers.
Rows read_rows(const NamedText& source, const std::string& what, const Rows* vertices)
{
  TextLines lines(source);
  bool has_line = lines.next();
  const RowCount count = has_line ? row_count_in(lines) : RowCount{};
  if (count.n_rows) has_line = lines.next();
  RowNumbers numbers(vertices);
  std::vector<double> values;
  for (; has_line; has_line = lines.next()) {
    if (lines.words().size() != 4) {
      lines.refuse(std::to_string(lines.words().size()) + " words",
                   "the number of a " + what + " and its three coordinates");
    }
    if (vertices != nullptr && values.size() == static_cast<std::size_t>(vertices->values.size())) {
      lines.refuse("more normals", std::to_string(vertices->values.rows()) + ", one for each vertex");
    }
    numbers.read(lines);
    for (std::size_t k = 1; k <= 3; ++k) {
      values.push_back(lines.real(k, "a finite coordinate"));
      if (std::abs(values.back()) > job::largest_coordinate)
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
  return {Eigen::Map<const Points>(values.data(), n, 3), numbers.first()};
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
      if (++n_faces > job::largest_face_count)
        lines_.refuse("more faces", "at most " + std::to_string(job::largest_face_count));
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
    if (n_corners < 3 || n_corners > job::largest_face_size) {
      lines_.refuse(std::to_string(n_corners) + " vertices after the component's name",
                    "from 3 to " + std::to_string(job::largest_face_size));
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
    if (job::parse_real(name)) {
      lines_.refuse("an element without a component name: its first word is " + quoted(name),
                    "the name of its component, then the numbers of its vertices");
    }
    if (!is_component_name(name)) lines_.refuse(quoted(name), component_name_rule);
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
  job::RawMesh& mesh = component.mesh;
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
  return {file, job::file_bytes(file, {file, "", "", std::string("the ") + holds + " of an Object set"},
                                 job::largest_mesh_bytes)};
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

}  // namespace vrda::job
