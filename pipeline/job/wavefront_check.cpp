// OBJ files that assimp would read wrongly: refused with the line, before it reads them.
#include <algorithm>
#include <array>

#include "core/error.hpp"
#include "job/raw_mesh.hpp"
#include "job/words.hpp"

namespace vrda::job {
namespace {

using WordList = std::vector<std::string_view>;

// Keywords without influence on vertices and faces.
bool is_ignored(std::string_view keyword)
{
  constexpr std::array<std::string_view, 15> others{"g",      "o",      "s",      "mg",       "usemtl",
                                                    "mtllib", "usemap", "maplib", "lod",      "vp",
                                                    "l",      "p",      "bevel",  "c_interp", "d_interp"};
  return std::find(others.begin(), others.end(), keyword) != others.end();
}

std::string quoted(std::string_view word)
{
  return "\"" + std::string(word.substr(0, 40)) + "\"";
}

class Checker {
 public:
  Checker(const std::string& file, const std::string& bytes) : file_(file), bytes_(bytes) {}

  std::string reduced()
  {
    std::string joined;
    for (std::size_t begin = 0; begin < bytes_.size();) {
      const std::size_t end = std::min(bytes_.find('\n', begin), bytes_.size());
      std::string_view text = std::string_view(bytes_).substr(begin, end - begin);
      begin = end + 1;
      ++line_;
      text = text.substr(0, std::min(text.find('#'), text.size()));
      if (!text.empty() && text.back() == '\r') text.remove_suffix(1);
      // A backslash at the end continues the line.
      const bool is_continued = !text.empty() && text.back() == '\\';
      if (is_continued) text.remove_suffix(1);
      joined += text;
      if (is_continued) joined += ' ';  // it ends a word, too
      if (is_continued && begin < bytes_.size()) continue;
      if (is_continued) refuse("a backslash at the end of the file", "the rest of the line");
      const WordList words = split_words(joined);
      if (!words.empty()) read(words);
      joined.clear();
    }
    // A face may refer to a vertex of a later line, so indices are checked at the end.
    if (highest_vertex_ > n_vertices_)
      refuse_at(highest_line_, "index " + std::to_string(highest_vertex_), valid_vertices());
    if (highest_normal_ > n_normals_) {
      refuse_at(highest_line_, "normal " + std::to_string(highest_normal_),
                "one of " + std::to_string(n_normals_) + " normals");
    }
    if (n_faces_ == 0) {
      throw InputError({file_, "", "an empty mesh: " + std::to_string(n_vertices_) + " vertices and no face",
                        "a mesh with faces"});
    }
    return std::move(out_);
  }

 private:
  void read(const WordList& words)
  {
    const std::string_view keyword = words[0];
    if (keyword == "v") {
      read_numbers(words, 3, 7);  // a weight or a colour may follow
      ++n_vertices_;
    } else if (keyword == "vn") {
      read_numbers(words, 3, 3);
      ++n_normals_;
    } else if (keyword == "f") {
      read_face(words);
    } else if (keyword != "vt" && !is_ignored(keyword)) {
      refuse(quoted(keyword), "a keyword of a polygon mesh, such as v, vn, vt or f");
    }
  }

  void read_numbers(const WordList& words, std::size_t fewest, std::size_t most)
  {
    if (words.size() < 1 + fewest || words.size() > 1 + most) {
      refuse(std::to_string(words.size() - 1) + " numbers",
             "from " + std::to_string(fewest) + " to " + std::to_string(most));
    }
    out_ += words[0];
    for (std::size_t k = 1; k < words.size(); ++k) {
      if (!parse_real(words[k])) refuse(quoted(words[k]), "a number");
      if (k <= fewest) (out_ += " ") += words[k];
    }
    out_ += "\n";
  }

  void read_face(const WordList& words)
  {
    if (words.size() < 4) refuse(std::to_string(words.size() - 1) + " corners", "at least 3");
    if (++n_faces_ > largest_face_count)
      refuse("more faces", "at most " + std::to_string(largest_face_count));
    out_ += "f";
    for (std::size_t k = 1; k < words.size(); ++k) read_corner(words[k]);
    out_ += "\n";
  }

  // v, v/t, v//n or v/t/n; texture indices are dropped.
  void read_corner(std::string_view corner)
  {
    const std::size_t slash = std::min(corner.find('/'), corner.size());
    const std::size_t second = std::min(corner.find('/', slash + 1), corner.size());
    const std::int64_t vertex = absolute(corner, corner.substr(0, slash), n_vertices_);
    note(vertex, highest_vertex_);
    (out_ += " ") += std::to_string(vertex);
    if (second == corner.size()) return;
    const std::int64_t normal = absolute(corner, corner.substr(second + 1), n_normals_);
    note(normal, highest_normal_);
    (out_ += "//") += std::to_string(normal);
  }

  // Negative indices count back from the last one so far.
  std::int64_t absolute(std::string_view corner, std::string_view word, std::int64_t n_so_far) const
  {
    const std::optional<std::int64_t> index = parse_integer(word);
    const std::int64_t value = index && *index < 0 ? n_so_far + 1 + *index : index.value_or(0);
    if (value < 1) refuse(quoted(corner), "an index from 1 or a negative one: " + valid_vertices());
    return value;
  }

  void note(std::int64_t index, std::int64_t& highest)
  {
    if (index <= highest) return;
    highest = index;
    highest_line_ = line_;
  }

  std::string valid_vertices() const { return "one of " + std::to_string(n_vertices_) + " vertices"; }

  [[noreturn]] void refuse(const std::string& found, const std::string& wanted) const
  {
    refuse_at(line_, found, wanted);
  }
  [[noreturn]] void refuse_at(std::size_t line, const std::string& found, const std::string& wanted) const
  {
    throw InputError({file_, "line " + std::to_string(line), found, wanted});
  }

  const std::string& file_;
  const std::string& bytes_;
  std::string out_;
  std::size_t line_ = 0, highest_line_ = 0, n_faces_ = 0;
  std::int64_t n_vertices_ = 0, n_normals_ = 0, highest_vertex_ = 0, highest_normal_ = 0;
};

}  // namespace

std::string checked_wavefront(const std::string& file, const std::string& bytes)
{
  return Checker(file, bytes).reduced();
}

}  // namespace vrda::job
