#include <algorithm>
#include <sstream>
#include <vector>

#include "core/error.hpp"
#include "load/mesh_checks.hpp"
#include "load/raw_mesh.hpp"
#include "load/words.hpp"

namespace vrda {
namespace {

struct Property {
  std::string name;
  std::size_t count_bytes = 0;  // of a list's length; 0 for a plain property
  std::size_t item_bytes = 0;
};

struct Element {
  std::string name;
  std::size_t n = 0;
  std::vector<Property> properties;
};

enum class Format { ascii, little_endian, big_endian };

struct Header {
  Format format = Format::ascii;
  std::vector<Element> elements;
  std::size_t body = 0;  // offset of the first byte after the header
};

std::size_t bytes_of_type(const std::string& type)
{
  if (type == "char" || type == "uchar" || type == "int8" || type == "uint8") return 1;
  if (type == "short" || type == "ushort" || type == "int16" || type == "uint16") return 2;
  if (type == "int" || type == "uint" || type == "float" || type == "int32" || type == "uint32" ||
      type == "float32")
    return 4;
  if (type == "double" || type == "float64") return 8;
  return 0;
}

class HeaderReader {
 public:
  HeaderReader(const std::string& file, const std::string& bytes) : file_(file), bytes_(bytes) {}

  Header read()
  {
    if (next_line() != "ply") refuse("no PLY file", "\"ply\" in the first line");
    while (!is_done_) read_line(next_line());
    header_.body = at_;
    return header_;
  }

 private:
  [[noreturn]] void refuse(const std::string& found, const std::string& wanted) const
  {
    throw InputError({file_, "line " + std::to_string(line_), found, wanted});
  }

  std::string next_line()
  {
    if (at_ >= bytes_.size()) refuse("the end of the file", "\"end_header\"");
    const std::size_t end = std::min(bytes_.find('\n', at_), bytes_.size());
    std::string text = bytes_.substr(at_, std::min<std::size_t>(end - at_, 1000));
    if (!text.empty() && text.back() == '\r') text.pop_back();
    at_ = std::min(end + 1, bytes_.size());
    ++line_;
    return text;
  }

  void read_line(const std::string& text)
  {
    std::istringstream words(text);
    std::string keyword, a, b, c, d;
    words >> keyword >> a >> b >> c >> d;
    if (keyword == "end_header") {
      is_done_ = true;
    } else if (keyword == "format") {
      read_format(a);
    } else if (keyword == "element") {
      read_element(a, b);
    } else if (keyword == "property") {
      const bool is_list = a == "list";
      const Property property{is_list ? d : b, is_list ? bytes_of_type(b) : 0,
                              bytes_of_type(is_list ? c : a)};
      const bool is_known = property.item_bytes > 0 && (!is_list || property.count_bytes > 0);
      if (!is_known || header_.elements.empty()) refuse("\"" + text + "\"", "a PLY type, after an element");
      header_.elements.back().properties.push_back(property);
    } else if (!keyword.empty() && keyword != "comment" && keyword != "obj_info") {
      refuse("\"" + keyword.substr(0, 40) + "\"", "a keyword of a PLY header");
    }
  }

  void read_format(const std::string& word)
  {
    if (word == "ascii") {
      header_.format = Format::ascii;
    } else if (word == "binary_little_endian") {
      header_.format = Format::little_endian;
    } else if (word == "binary_big_endian") {
      header_.format = Format::big_endian;
    } else {
      refuse("\"" + word + "\"", "ascii, binary_little_endian or binary_big_endian");
    }
  }

  void read_element(const std::string& name, const std::string& count)
  {
    const std::optional<std::int64_t> given = whole_in(count);
    if (!given || *given < 0) refuse("\"" + count + "\"", "the number of elements");
    const auto n = static_cast<std::size_t>(*given);
    // At most three vertices a face of their own.
    const std::size_t largest = name == "face" ? largest_face_count : 3 * largest_face_count;
    if (n > largest) refuse(count + " of " + name, "at most " + std::to_string(largest));
    header_.elements.push_back({name, n, {}});
  }

  const std::string& file_;
  const std::string& bytes_;
  Header header_;
  std::size_t at_ = 0;
  std::size_t line_ = 0;
  bool is_done_ = false;
};

// Walks over the body element by element; a list has to be read to know its length.
class Body {
 public:
  Body(const std::string& file, const std::string& bytes, const Header& header)
      : file_(file), bytes_(bytes), format_(header.format), at_(header.body)
  {
  }

  void walk(const Element& element)
  {
    for (std::size_t i = 0; i < element.n; ++i) {
      for (const Property& property : element.properties) {
        if (!pass(property)) refuse(element, i);
      }
    }
  }

 private:
  bool pass(const Property& property)
  {
    std::size_t n = 1;
    if (property.count_bytes > 0) {
      if (!read_count(property.count_bytes, n) || n > bytes_.size()) return false;
    }
    if (format_ != Format::ascii) return skip(n * property.item_bytes);
    for (std::size_t k = 0; k < n; ++k) {
      if (!real_in(next_word())) return false;
    }
    return true;
  }

  bool skip(std::size_t n_bytes)
  {
    if (bytes_.size() - at_ < n_bytes) return false;
    at_ += n_bytes;
    return true;
  }

  bool read_count(std::size_t n_bytes, std::size_t& n)
  {
    n = 0;
    if (format_ == Format::ascii) {
      const std::optional<std::int64_t> count = whole_in(next_word());
      n = static_cast<std::size_t>(count.value_or(0));
      return count && *count >= 0;
    }
    if (bytes_.size() - at_ < n_bytes) return false;
    for (std::size_t k = 0; k < n_bytes; ++k) {
      const std::size_t place = format_ == Format::little_endian ? n_bytes - 1 - k : k;
      n = (n << 8U) | static_cast<unsigned char>(bytes_[at_ + place]);
    }
    at_ += n_bytes;
    return true;
  }

  std::string_view next_word()
  {
    while (at_ < bytes_.size() && is_space(bytes_[at_])) ++at_;
    const std::size_t begin = at_;
    while (at_ < bytes_.size() && !is_space(bytes_[at_])) ++at_;
    return std::string_view(bytes_).substr(begin, at_ - begin);
  }

  [[noreturn]] void refuse(const Element& element, std::size_t i) const
  {
    throw InputError({file_, element.name + " " + std::to_string(i), "a PLY file cut short or damaged there",
                      std::to_string(element.n) + " of " + element.name + ", as its header says"});
  }

  const std::string& file_;
  const std::string& bytes_;
  Format format_;
  std::size_t at_;
};

bool has(const Header& header, const std::string& element, const std::vector<std::string>& names,
         bool is_list)
{
  return std::any_of(header.elements.begin(), header.elements.end(), [&](const Element& e) {
    return e.name == element && std::any_of(e.properties.begin(), e.properties.end(), [&](const Property& p) {
             return (p.count_bytes > 0) == is_list &&
                    std::find(names.begin(), names.end(), p.name) != names.end();
           });
  });
}

void check_properties(const std::string& file, const Header& header)
{
  for (const char* axis : {"x", "y", "z"}) {
    if (has(header, "vertex", {axis}, false)) continue;
    throw InputError({file, "header", std::string("no property ") + axis + " of a vertex", "x, y and z"});
  }
  if (!has(header, "face", {"vertex_indices", "vertex_index"}, true)) {
    throw InputError({file, "header", "no list vertex_indices of a face", "one: a mesh has faces"});
  }
}

}  // namespace

void check_ply(const std::string& file, const std::string& bytes)
{
  const Header header = HeaderReader(file, bytes).read();
  check_properties(file, header);
  Body body(file, bytes, header);
  for (const Element& element : header.elements) body.walk(element);
}

}  // namespace vrda
