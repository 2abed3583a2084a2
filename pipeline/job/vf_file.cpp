#include "job/vf_file.hpp"

#include <algorithm>

#include "core/error.hpp"
#include "job/words.hpp"

namespace vrda::job {
namespace {

class Words {
 public:
  Words(const std::string& file, const std::string& bytes) : file_(file), bytes_(bytes) {}

  /// The next word; empty at the end.
  std::string_view next()
  {
    skip();
    const std::size_t begin = at_;
    while (at_ < bytes_.size() && !is_space(bytes_[at_]) && bytes_[at_] != '#') ++at_;
    return std::string_view(bytes_).substr(begin, at_ - begin);
  }

  double real(const std::string& wanted) { return known(parse_real(advance()), wanted); }
  std::int64_t whole(const std::string& wanted) { return known(parse_integer(advance()), wanted); }

  [[noreturn]] void refuse(const std::string& found, const std::string& wanted) const
  {
    throw InputError({file_, "line " + std::to_string(line_), found, wanted});
  }

  std::size_t n_left() const { return bytes_.size() - at_; }
  std::size_t line() const { return line_; }

 private:
  void skip()
  {
    bool is_comment = false;
    for (; at_ < bytes_.size(); ++at_) {
      const char c = bytes_[at_];
      if (c == '#') is_comment = true;
      if (c == '\n') {
        is_comment = false;
        ++line_;
      }
      if (!is_comment && !is_space(c)) return;
    }
  }

  std::string_view advance() { return word_ = next(); }

  template <class Number>
  Number known(const std::optional<Number>& number, const std::string& wanted) const
  {
    if (word_.empty()) refuse("the end of the file", wanted);
    if (!number) refuse("\"" + std::string(word_.substr(0, 40)) + "\"", wanted);
    return *number;
  }

  const std::string& file_;
  const std::string& bytes_;
  std::string_view word_;
  std::size_t at_ = 0;
  std::size_t line_ = 1;
};

std::string count_of(std::int64_t n, const char* things)
{
  return std::to_string(n) + " " + things;
}

struct IndexRange {
  std::int64_t lowest = 1;
  std::int64_t highest = 0;
  std::size_t lowest_line = 0;
  std::size_t highest_line = 0;
};

std::int32_t first_index(const std::string& file, const IndexRange& range, std::int64_t n_vertices)
{
  const bool has_zero = range.lowest == 0;
  const bool has_count = range.highest == n_vertices;
  if (has_zero && has_count) {
    throw InputError({file, "line " + std::to_string(std::max(range.lowest_line, range.highest_line)),
                      "both index 0 (line " + std::to_string(range.lowest_line) + ") and index " +
                          std::to_string(n_vertices) + " (line " + std::to_string(range.highest_line) + ")",
                      "indices of " + count_of(n_vertices, "vertices")});
  }
  return has_count ? 1 : 0;
}

}  // namespace

bool is_vertices_faces(const std::string& bytes)
{
  Words words("", bytes);
  const std::string_view first = words.next();
  return !first.empty() && first.find_first_not_of("0123456789+-") == std::string_view::npos;
}

RawMesh read_vertices_faces(const std::string& file, const std::string& bytes)
{
  constexpr std::size_t shortest_vertex = 6;  // bytes: "0 0 0\n"
  constexpr std::size_t shortest_face = 7;    // bytes: "3 0 1 2" at the end of the file
  Words words(file, bytes);
  const auto n_vertices = words.whole("the number of vertices");
  const auto n_faces = words.whole("the number of faces");
  if (n_vertices < 3) words.refuse(count_of(n_vertices, "vertices"), "at least 3");
  if (n_faces < 1) words.refuse(count_of(n_faces, "faces"), "at least 1");
  // Rejects counts too large for the file before memory is allocated.
  const std::size_t most_vertices = words.n_left() / shortest_vertex;
  if (static_cast<std::size_t>(n_vertices) > most_vertices) {
    words.refuse(count_of(n_vertices, "vertices"),
                 "at most " + std::to_string(most_vertices) + " in a file of this size");
  }
  const std::size_t most_faces = std::min(largest_face_count, words.n_left() / shortest_face);
  if (static_cast<std::size_t>(n_faces) > most_faces) {
    words.refuse(count_of(n_faces, "faces"),
                 "at most " + std::to_string(most_faces) + " in a file of this size");
  }
  RawMesh mesh;
  mesh.vertices.resize(static_cast<Eigen::Index>(n_vertices), 3);
  for (Eigen::Index v = 0; v < n_vertices; ++v) {
    for (int k = 0; k < 3; ++k)
      mesh.vertices(v, k) = words.real("a coordinate of vertex " + std::to_string(v));
  }
  IndexRange range{n_vertices, -1, 0, 0};
  for (std::int64_t f = 0; f < n_faces; ++f) {
    const std::string face = "face " + std::to_string(f);
    const auto n_corners = words.whole("the number of corners of " + face);
    if (n_corners < 3 || n_corners > static_cast<std::int64_t>(largest_face_size)) {
      words.refuse(count_of(n_corners, "corners"),
                   "from 3 to " + std::to_string(largest_face_size) + " for " + face);
    }
    mesh.size.push_back(static_cast<std::int32_t>(n_corners));
    for (std::int64_t k = 0; k < n_corners; ++k) {
      const auto index = words.whole("a vertex index of " + face);
      if (index < 0 || index > n_vertices) {
        words.refuse("index " + std::to_string(index), "an index of " + count_of(n_vertices, "vertices"));
      }
      if (index < range.lowest) range.lowest = index, range.lowest_line = words.line();
      if (index > range.highest) range.highest = index, range.highest_line = words.line();
      mesh.corner.push_back(static_cast<std::int32_t>(index));
    }
  }
  if (const std::string_view rest = words.next(); !rest.empty()) {
    words.refuse("\"" + std::string(rest.substr(0, 40)) + "\"",
                 "the end of the file after " + count_of(n_faces, "faces"));
  }
  const std::int32_t first = first_index(file, range, n_vertices);
  for (std::int32_t& corner : mesh.corner) corner -= first;
  return mesh;
}

Points read_vertex_normals(const std::string& file, const std::string& bytes, Eigen::Index n_vertices)
{
  Words words(file, bytes);
  const auto n = words.whole("the number of normals");
  if (n != n_vertices)
    words.refuse(count_of(n, "normals"), std::to_string(n_vertices) + ", one for each vertex of the mesh");
  Points normals(n_vertices, 3);
  for (Eigen::Index v = 0; v < n_vertices; ++v) {
    for (int k = 0; k < 3; ++k) normals(v, k) = words.real("a component of normal " + std::to_string(v));
  }
  if (const std::string_view rest = words.next(); !rest.empty()) {
    words.refuse("\"" + std::string(rest.substr(0, 40)) + "\"",
                 "the end of the file after " + count_of(n, "normals"));
  }
  return normals;
}

}  // namespace vrda::job
