// Parser for PLY: ASCII or binary of either byte order. assimp is not used because it hangs on some valid
// files (lists of texture coordinates) and reduces doubles to floats.
#include "job/mesh_file.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <limits>
#include <sstream>
#include <utility>

#include "core/text.hpp"
#include "job/job.hpp"

namespace vrda::job {
namespace {

enum class Type { none, int8, uint8, int16, uint16, int32, uint32, float32, float64 };

struct Property {
  std::string name;
  Type count = Type::none;  // type of a list's length; none for a scalar property
  Type item = Type::none;
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

struct TypeName {
  std::string_view name, sized_name;
  Type type;
  std::size_t n_bytes;
};
constexpr std::array<TypeName, 8> type_names{{{"char", "int8", Type::int8, 1},
                                              {"uchar", "uint8", Type::uint8, 1},
                                              {"short", "int16", Type::int16, 2},
                                              {"ushort", "uint16", Type::uint16, 2},
                                              {"int", "int32", Type::int32, 4},
                                              {"uint", "uint32", Type::uint32, 4},
                                              {"float", "float32", Type::float32, 4},
                                              {"double", "float64", Type::float64, 8}}};

Type type_of(const std::string& word)
{
  for (const TypeName& known : type_names) {
    if (word == known.name || word == known.sized_name) return known.type;
  }
  return Type::none;
}

std::size_t bytes_of(Type type)
{
  return std::ranges::find(type_names, type, &TypeName::type)->n_bytes;
}

bool is_whole(Type type)
{
  return type != Type::none && type != Type::float32 && type != Type::float64;
}

// Both names occur in practice.
bool is_corners(std::string_view name)
{
  return name == "vertex_indices" || name == "vertex_index";
}

// Surfaces that are read: polygons, and strips of triangles that a negative index ends.
bool is_surface(std::string_view element)
{
  return element == "face" || element == "tristrips";
}

class HeaderReader {
 public:
  HeaderReader(const std::string& file, const std::string& bytes) : file_(file), bytes_(bytes) {}

  Header read()
  {
    if (next_line() != "ply") refuse("not a PLY file", "\"ply\" in the first line");
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
    while (!text.empty() && is_space(text.back())) text.pop_back();
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
      const Property property{is_list ? d : b, is_list ? type_of(b) : Type::none, type_of(is_list ? c : a)};
      const bool is_known = property.item != Type::none && (!is_list || is_whole(property.count));
      if (!is_known || header_.elements.empty()) refuse("\"" + text + "\"", "a PLY type, after an element");
      header_.elements.back().properties.push_back(property);
    } else if (!keyword.empty() && keyword != "comment" && keyword != "obj_info") {
      refuse("\"" + keyword.substr(0, 40) + "\"", "a keyword of a PLY header");
    }
  }

  void read_format(const std::string& word)
  {
    constexpr std::array<std::string_view, 3> formats{"ascii", "binary_little_endian", "binary_big_endian"};
    const auto* const found = std::find(formats.begin(), formats.end(), word);
    if (found == formats.end())
      refuse("\"" + word + "\"", "ascii, binary_little_endian or binary_big_endian");
    header_.format = static_cast<Format>(found - formats.begin());
  }

  void read_element(const std::string& name, const std::string& count)
  {
    const std::optional<std::int64_t> given = parse_integer(count);
    if (!given || *given < 0) refuse("\"" + count + "\"", "the number of elements");
    const auto n = static_cast<std::size_t>(*given);
    // At most three unshared vertices for each face.
    const std::size_t largest = is_surface(name) ? largest_face_count : 3 * largest_face_count;
    if (n > largest) refuse(count + " of " + name, "at most " + std::to_string(largest));
    for (const Element& earlier : header_.elements) {
      if (earlier.name == name) refuse("\"" + name + "\" a second time", "each element once");
    }
    header_.elements.push_back({name, n, {}});
  }

  const std::string& file_;
  const std::string& bytes_;
  Header header_;
  std::size_t at_ = 0;
  std::size_t line_ = 0;
  bool is_done_ = false;
};

// Reads the values of the body in sequence.
class Values {
 public:
  Values(const std::string& bytes, const Header& header)
      : bytes_(bytes), format_(header.format), at_(header.body)
  {
  }

  /// Nothing at the end of the bytes or for an invalid number. Integers up to 32 bits are exact.
  std::optional<double> take(Type type)
  {
    if (format_ == Format::ascii) {
      const std::string_view word = next_word();
      const std::optional<double> number = parse_real(word);
      return is_whole(type) && !parse_integer(word) ? std::nullopt : number;
    }
    const std::size_t n = bytes_of(type);
    if (bytes_.size() - at_ < n) return std::nullopt;
    std::uint64_t bits = 0;
    for (std::size_t k = 0; k < n; ++k) {
      const std::size_t place = format_ == Format::little_endian ? n - 1 - k : k;
      bits = (bits << 8U) | static_cast<unsigned char>(bytes_[at_ + place]);
    }
    at_ += n;
    return number_of(type, bits);
  }

  /// Bytes after the last value, without white space and padding.
  std::size_t n_left() const
  {
    const auto is_padding = [](char c) { return is_space(c) || c == '\0'; };
    std::size_t end = bytes_.size();
    while (end > at_ && is_padding(bytes_[end - 1])) --end;
    return end - at_;
  }

 private:
  static double number_of(Type type, std::uint64_t bits)
  {
    switch (type) {
      case Type::int8:
        return static_cast<std::int8_t>(bits);
      case Type::int16:
        return static_cast<std::int16_t>(bits);
      case Type::int32:
        return static_cast<std::int32_t>(bits);
      case Type::float32:
        return static_cast<double>(std::bit_cast<float>(static_cast<std::uint32_t>(bits)));
      case Type::float64:
        return std::bit_cast<double>(bits);
      default:
        return static_cast<double>(bits);
    }
  }

  std::string_view next_word()
  {
    while (at_ < bytes_.size() && is_space(bytes_[at_])) ++at_;
    const std::size_t begin = at_;
    while (at_ < bytes_.size() && !is_space(bytes_[at_])) ++at_;
    return std::string_view(bytes_).substr(begin, at_ - begin);
  }

  const std::string& bytes_;
  Format format_;
  std::size_t at_;
};

class PlyBody {
 public:
  PlyBody(const std::string& file, const std::string& bytes, const Header& header)
      : file_(file), n_bytes_(bytes.size()), values_(bytes, header)
  {
  }

  void read(const Element& element)
  {
    if (element.properties.empty()) return;
    std::vector<Sink> sinks;
    for (const Property& property : element.properties) sinks.push_back(sink_of(element, property));
    for (std::size_t i = 0; i < element.n; ++i) {
      row_.fill(0.0);
      for (std::size_t k = 0; k < sinks.size(); ++k) {
        if (!take(element.properties[k], sinks[k])) refuse(element, i);
      }
      if (element.name != "vertex") continue;
      vertices_.insert(vertices_.end(), row_.begin(), row_.begin() + 3);
      normals_.insert(normals_.end(), row_.begin() + 3, row_.end());
    }
  }

  std::size_t n_left() const { return values_.n_left(); }

  RawMesh mesh(bool has_normals) &&
  {
    const auto n = static_cast<Eigen::Index>(vertices_.size() / 3);
    mesh_.vertices = Eigen::Map<const Points>(vertices_.data(), n, 3);
    if (has_normals) mesh_.normals = Eigen::Map<const Points>(normals_.data(), n, 3);
    return std::move(mesh_);
  }

 private:
  enum class Sink { none, x, y, z, nx, ny, nz, corners, strip };

  static Sink sink_of(const Element& element, const Property& property)
  {
    constexpr std::array<std::string_view, 6> axes{"x", "y", "z", "nx", "ny", "nz"};
    const bool is_list = property.count != Type::none;
    if (is_surface(element.name) && is_list && is_corners(property.name))
      return element.name == "face" ? Sink::corners : Sink::strip;
    if (element.name != "vertex" || is_list) return Sink::none;
    const auto* const found = std::find(axes.begin(), axes.end(), property.name);
    return found == axes.end() ? Sink::none : static_cast<Sink>(1 + (found - axes.begin()));
  }

  bool take(const Property& property, Sink sink)
  {
    if (property.count != Type::none) return take_list(property, sink);
    const std::optional<double> value = values_.take(property.item);
    if (value && sink != Sink::none) row_[static_cast<std::size_t>(sink) - 1] = *value;
    return value.has_value();
  }

  bool take_list(const Property& property, Sink sink)
  {
    const std::optional<double> given = values_.take(property.count);
    if (!given || *given < 0.0 || *given > static_cast<double>(n_bytes_)) return false;
    const auto n = static_cast<std::size_t>(*given);
    std::vector<std::int32_t> corners;
    for (std::size_t k = 0; k < n; ++k) {
      const std::optional<double> value = values_.take(property.item);
      if (!value || (sink != Sink::none && std::abs(*value) > largest_index)) return false;
      if (sink != Sink::none) corners.push_back(static_cast<std::int32_t>(*value));
    }
    if (sink == Sink::strip) add_strips(mesh_, corners);
    if (sink == Sink::corners) add_face(mesh_, corners);
    return true;
  }

  [[noreturn]] void refuse(const Element& element, std::size_t i) const
  {
    throw InputError({file_, element.name + " " + std::to_string(i), "a truncated or damaged PLY file",
                      std::to_string(element.n) + " of " + element.name + ", as in the header"});
  }

  // Only the integer range is checked here; read_mesh() checks indices against the vertex count.
  static constexpr double largest_index = std::numeric_limits<std::int32_t>::max();

  const std::string& file_;
  std::size_t n_bytes_;
  Values values_;
  std::array<double, 6> row_{};  // position and normal of one vertex
  std::vector<double> vertices_;
  std::vector<double> normals_;
  RawMesh mesh_;
};

const Property* property_named(const Header& header, const std::string& element, std::string_view name)
{
  for (const Element& e : header.elements) {
    if (e.name != element) continue;
    for (const Property& property : e.properties) {
      if (property.name == name || (is_surface(element) && is_corners(name) && is_corners(property.name)))
        return &property;
    }
  }
  return nullptr;
}

void check_properties(const std::string& file, const Header& header)
{
  for (const char* axis : {"x", "y", "z"}) {
    const Property* property = property_named(header, "vertex", axis);
    if (property != nullptr && property->count == Type::none) continue;
    throw InputError({file, "header", std::string("no property ") + axis + " of a vertex", "x, y and z"});
  }
  bool has_surface = false;
  for (const Element& element : header.elements) {
    const Property* corners = property_named(header, element.name, "vertex_indices");
    const auto n_lists = std::count_if(element.properties.begin(), element.properties.end(),
                                       [](const Property& p) { return is_corners(p.name); });
    const auto refuse = [&](const std::string& found, const std::string& wanted) {
      throw InputError({file, "header", found, wanted});
    };
    if (is_surface(element.name)) {
      if (corners == nullptr || corners->count == Type::none || !is_whole(corners->item))
        refuse("no list vertex_indices of a " + element.name, "a list of whole numbers");
      if (n_lists > 1) refuse("two lists of vertices in " + element.name, "one list vertex_indices");
      has_surface = true;
    } else if (n_lists > 0 && element.n > 0) {
      refuse("vertices of \"" + element.name + "\", which is not read",
             "surfaces as face or tristrips: export the mesh as polygons");
    }
  }
  if (!has_surface)
    throw InputError({file, "header", "no list vertex_indices of a face", "a list of whole numbers"});
}

}  // namespace

void add_face(RawMesh& mesh, std::span<const std::int32_t> corners)
{
  if (corners.size() < 3) return;
  mesh.corner.insert(mesh.corner.end(), corners.begin(), corners.end());
  mesh.size.push_back(static_cast<std::int32_t>(corners.size()));
}

// Each corner from the third on makes a triangle with the two before it; every second one is turned.
void add_strips(RawMesh& mesh, std::span<const std::int32_t> corners)
{
  std::size_t first = 0;
  for (std::size_t k = 0; k < corners.size(); ++k) {
    if (corners[k] < 0) first = k + 1;
    if (k < first + 2) continue;
    const std::size_t odd = (k - first) % 2;
    add_face(mesh, std::array{corners[k - 2 + odd], corners[k - 1 - odd], corners[k]});
  }
}

RawMesh read_ply(const std::string& file, const std::string& bytes)
{
  const Header header = HeaderReader(file, bytes).read();
  check_properties(file, header);
  PlyBody body(file, bytes, header);
  for (const Element& element : header.elements) body.read(element);
  if (body.n_left() > 0)
    throw InputError({file, "header", std::to_string(body.n_left()) + " bytes after the last element",
                      "counts of all elements of the file"});
  bool has_normals = true;
  for (const char* axis : {"nx", "ny", "nz"}) {
    const Property* property = property_named(header, "vertex", axis);
    has_normals = has_normals && property != nullptr && property->count == Type::none;
  }
  return std::move(body).mesh(has_normals);
}

}  // namespace vrda::job
