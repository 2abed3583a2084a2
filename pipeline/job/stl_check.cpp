// STL files that assimp would read wrongly or partly: refused with line or size, before it reads them.
#include <algorithm>
#include <cctype>
#include <string_view>

#include "core/error.hpp"
#include "job/raw_mesh.hpp"
#include "job/words.hpp"

namespace vrda::job {
namespace {

constexpr std::size_t header_bytes = 80;
constexpr std::size_t facet_bytes = 50;  // normal, three vertices, attribute

std::string lower(std::string_view word)
{
  std::string out(word);
  for (char& c : out) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return out;
}

// Whether the file begins with "solid" and is text: binary headers may also begin with "solid".
bool is_ascii(const std::string& bytes)
{
  const std::size_t begin = std::min(bytes.find_first_not_of(" \t\r\n"), bytes.size());
  const auto is_text = [](char c) { return is_space(c) || static_cast<unsigned char>(c) >= 0x20; };
  return lower(std::string_view(bytes).substr(begin, 5)) == "solid" &&
         std::all_of(bytes.begin(),
                     bytes.begin() + static_cast<std::ptrdiff_t>(std::min<std::size_t>(bytes.size(), 1024)),
                     is_text);
}

bool has_three_numbers(const std::vector<std::string_view>& words, std::size_t first)
{
  return words.size() == first + 3 && parse_real(words[first]) && parse_real(words[first + 1]) &&
         parse_real(words[first + 2]);
}

class AsciiReader {
 public:
  AsciiReader(const std::string& file, const std::string& bytes) : file_(file), bytes_(bytes) {}

  std::string reduced()
  {
    std::size_t line = 1;
    for (std::size_t begin = 0; begin < bytes_.size(); ++line) {
      const std::size_t end = std::min(bytes_.find('\n', begin), bytes_.size());
      const std::vector<std::string_view> words =
          split_words(std::string_view(bytes_).substr(begin, end - begin));
      begin = end + 1;
      const std::string found = words.empty() ? "" : read(words);
      if (found.empty()) continue;
      if (end == bytes_.size()) break;  // truncated last line: is_complete() reports it
      throw InputError({file_, "line " + std::to_string(line), found,
                        "a line of an ASCII STL file: facets of three vertices, each of three numbers"});
    }
    return std::move(out_);
  }

  std::size_t n_facets() const { return n_ended_; }
  bool is_complete() const { return n_begun_ == n_ended_ && n_vertices_ == 3 * n_ended_ && !is_solid_open_; }

 private:
  // The error of a line, or an empty text.
  std::string read(const std::vector<std::string_view>& words)
  {
    const std::string keyword = lower(words[0]);
    const bool is_solid_keyword = keyword == "solid" || keyword == "endsolid";
    if (is_solid_keyword || keyword == "facet") {
      if (n_begun_ != n_ended_) return "\"" + keyword + "\" within a facet";
      if ((keyword == "solid") == is_solid_open_)
        return "\"" + keyword + "\" " + (is_solid_open_ ? "within" : "without") + " a solid";
    } else if (n_begun_ == n_ended_) {
      return "\"" + keyword.substr(0, 40) + "\" without a facet";
    }
    return is_solid_keyword ? read_solid(keyword) : read_facet(keyword, words);
  }

  std::string read_solid(const std::string& keyword)
  {
    is_solid_open_ = keyword == "solid";
    out_ += keyword + " part\n";  // without the name
    return "";
  }

  std::string read_facet(const std::string& keyword, const std::vector<std::string_view>& words)
  {
    if (keyword == "facet") {
      ++n_begun_;
      if (!has_three_numbers(words, 2)) return "a facet without the three numbers of its normal";
      out_ += "facet normal 0 0 0\nouter loop\n";
    } else if (keyword == "vertex") {
      ++n_vertices_;
      if (!has_three_numbers(words, 1)) return "a vertex without three numbers";
      for (const std::string_view word : {std::string_view("vertex"), words[1], words[2], words[3]})
        (out_ += word) += " ";
      out_ += "\n";
    } else if (keyword == "endfacet") {
      if (n_vertices_ != 3 * ++n_ended_) return "a facet without exactly three vertices";
      out_ += "endloop\nendfacet\n";
    } else if (keyword != "outer" && keyword != "endloop") {
      return "\"" + keyword.substr(0, 40) + "\"";
    }
    return "";
  }

  const std::string& file_;
  const std::string& bytes_;
  std::string out_;
  std::size_t n_begun_ = 0, n_ended_ = 0, n_vertices_ = 0;
  bool is_solid_open_ = false;
};

void check_count(const std::string& file, const std::string& field, std::size_t n_facets)
{
  if (n_facets == 0) throw InputError({file, field, "an empty mesh of 0 triangles", "a mesh with faces"});
  if (n_facets > largest_face_count) {
    throw InputError({file, field, std::to_string(n_facets) + " triangles",
                      "at most " + std::to_string(largest_face_count)});
  }
}

std::string checked_ascii(const std::string& file, const std::string& bytes)
{
  AsciiReader reader(file, bytes);
  std::string reduced = reader.reduced();
  if (!reader.is_complete()) {
    throw InputError({file, "",
                      "an STL file truncated after " + std::to_string(reader.n_facets()) + " complete facets",
                      "\"endsolid\" at its end"});
  }
  check_count(file, "", reader.n_facets());
  return reduced;
}

void check_binary(const std::string& file, std::size_t n_facets, std::size_t n_bytes,
                  std::size_t wanted_bytes)
{
  if (n_bytes < header_bytes + 4) {
    throw InputError({file, "", std::to_string(n_bytes) + " bytes", "an STL file of at least 84 bytes"});
  }
  if (n_bytes != wanted_bytes) {
    throw InputError(
        {file, "header",
         std::to_string(n_facets) + " triangles in a file of " + std::to_string(n_bytes) + " bytes",
         std::to_string(wanted_bytes) + " bytes for this number"});
  }
  check_count(file, "header", n_facets);
}

}  // namespace

std::string checked_stl(const std::string& file, std::string bytes)
{
  std::size_t n_facets = 0;
  if (bytes.size() >= header_bytes + 4) {
    for (std::size_t k = 0; k < 4; ++k) {
      n_facets |= static_cast<std::size_t>(static_cast<unsigned char>(bytes[header_bytes + k])) << (8 * k);
    }
  }
  const std::size_t wanted_bytes = header_bytes + 4 + facet_bytes * n_facets;
  // The size is tested before the first word: a binary header may begin with "solid".
  if (bytes.size() != wanted_bytes && is_ascii(bytes)) return checked_ascii(file, bytes);
  check_binary(file, n_facets, bytes.size(), wanted_bytes);
  return bytes;
}

}  // namespace vrda::job
