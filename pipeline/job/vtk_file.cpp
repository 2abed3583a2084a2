// Parsers for VTK PolyData: XML (.vtp) and the legacy format (.vtk). VTK itself is a dependency of 100 MB.
#include <zlib.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <limits>
#include <optional>
#include <pugixml.hpp>
#include <utility>

#include "core/text.hpp"
#include "job/job.hpp"
#include "job/mesh_file.hpp"

namespace vrda::job {
namespace {

using Numbers = std::vector<double>;

constexpr std::size_t most_points = 3 * largest_face_count;  // unshared vertices of triangles
constexpr std::size_t most_values = 3 * most_points;         // of one array: 360 MB
constexpr std::size_t largest_factor = 1032;                 // of zlib (its documentation)

enum class NumberKind { whole, not_negative, real };

struct NumberType {
  std::string_view xml, legacy;
  std::size_t n_bytes;
  NumberKind kind;
};
constexpr std::array<NumberType, 15> vtk_types{{{"Int8", "char", 1, NumberKind::whole},
                                                {"", "signed_char", 1, NumberKind::whole},
                                                {"UInt8", "unsigned_char", 1, NumberKind::not_negative},
                                                {"Int16", "short", 2, NumberKind::whole},
                                                {"UInt16", "unsigned_short", 2, NumberKind::not_negative},
                                                {"Int32", "int", 4, NumberKind::whole},
                                                {"", "vtkidtype", 4, NumberKind::whole},
                                                {"UInt32", "unsigned_int", 4, NumberKind::not_negative},
                                                {"Int64", "long", 8, NumberKind::whole},
                                                {"", "vtktypeint64", 8, NumberKind::whole},
                                                {"UInt64", "unsigned_long", 8, NumberKind::not_negative},
                                                {"", "vtktypeuint64", 8, NumberKind::not_negative},
                                                {"Float32", "float", 4, NumberKind::real},
                                                {"Float64", "double", 8, NumberKind::real},
                                                {"", "bit", 0, NumberKind::not_negative}}};

const NumberType* type_named(std::string_view name, std::string_view NumberType::*column)
{
  const auto* const found = std::ranges::find(vtk_types, name, column);
  return name.empty() || found == vtk_types.end() ? nullptr : found;
}

std::uint64_t bits_at(std::string_view bytes, std::size_t at, std::size_t n_bytes, bool is_big_endian)
{
  std::uint64_t bits = 0;
  for (std::size_t k = 0; k < n_bytes; ++k)
    bits = bits << 8U | static_cast<unsigned char>(bytes[at + (is_big_endian ? k : n_bytes - 1 - k)]);
  return bits;
}

double number_of(const NumberType& type, std::uint64_t bits)
{
  if (type.kind == NumberKind::not_negative) return static_cast<double>(bits);
  if (type.kind == NumberKind::real)
    return type.n_bytes == 4 ? static_cast<double>(std::bit_cast<float>(static_cast<std::uint32_t>(bits)))
                             : std::bit_cast<double>(bits);
  const std::size_t unused = 64 - 8 * type.n_bytes;  // shifted out and in with the sign
  return static_cast<double>(static_cast<std::int64_t>(bits << unused) >> unused);
}

Numbers numbers_of(const NumberType& type, std::string_view bytes, bool is_big_endian)
{
  Numbers numbers(bytes.size() / type.n_bytes);
  for (std::size_t k = 0; k < numbers.size(); ++k)
    numbers[k] = number_of(type, bits_at(bytes, k * type.n_bytes, type.n_bytes, is_big_endian));
  return numbers;
}

std::optional<double> number_in(std::string_view word, const NumberType& type)
{
  if (type.kind == NumberKind::real) return parse_real(word);
  const std::optional<std::int64_t> whole = parse_integer(word);
  return whole ? std::optional(static_cast<double>(*whole)) : std::nullopt;
}

// White space separates the words of a text that may also have binary parts.
std::string_view word_at(std::string_view text, std::size_t& at)
{
  while (at < text.size() && is_space(text[at])) ++at;
  const std::size_t begin = at;
  while (at < text.size() && !is_space(text[at])) ++at;
  return text.substr(begin, at - begin);
}

// A place in the file and its errors.
struct Section {
  const std::string& file;
  std::string name;

  [[noreturn]] void refuse(const std::string& found, const std::string& wanted) const
  {
    throw InputError({file, name, found, wanted});
  }

  // At most `n` numbers from the words of `text`.
  Numbers words(std::string_view text, std::size_t& at, std::size_t n, const NumberType& type) const
  {
    Numbers numbers;
    while (numbers.size() < n) {
      const std::string_view word = word_at(text, at);
      if (word.empty()) break;
      const std::optional<double> number = number_in(word, type);
      if (!number) refuse(quoted_word(word), type.kind == NumberKind::real ? "a number" : "a whole number");
      numbers.push_back(*number);
    }
    return numbers;
  }

  std::size_t count(std::string_view word, std::size_t most) const
  {
    const std::optional<std::int64_t> given = parse_integer(trimmed(word));
    if (!given || *given < 0 || static_cast<std::uint64_t>(*given) > most)
      refuse(quoted_word(word), "a number from 0 to " + std::to_string(most));
    return static_cast<std::size_t>(*given);
  }

  void require_count(std::size_t found, std::size_t wanted) const
  {
    if (found != wanted) refuse(std::to_string(found) + " numbers", std::to_string(wanted));
  }
};

struct Cells {
  Numbers corners;
  Numbers ends;  // of each cell in `corners`
  bool are_strips = false;
};

// Adds cells whose corners are rows from `first` of `n_points` points.
void add_cells(RawMesh& mesh, const Cells& cells, std::size_t first, std::size_t n_points,
               const Section& section)
{
  std::vector<std::int32_t> corners;
  std::size_t at = 0;
  for (std::size_t c = 0; c < cells.ends.size(); ++c) {
    const double end = cells.ends[c];
    const std::string cell = "cell " + std::to_string(c);
    if (!(end >= static_cast<double>(at) && end <= static_cast<double>(cells.corners.size())))
      section.refuse(cell + " that ends at " + shortest_decimal(end),
                     "an end from " + std::to_string(at) + " to " + std::to_string(cells.corners.size()));
    corners.clear();
    for (; at < static_cast<std::size_t>(end); ++at) {
      const double index = cells.corners[at];
      if (!(index >= 0.0 && index < static_cast<double>(n_points)))
        section.refuse(cell + " with point " + shortest_decimal(index),
                       "an index of " + std::to_string(n_points) + " points");
      corners.push_back(static_cast<std::int32_t>(first + static_cast<std::size_t>(index)));
    }
    if (cells.are_strips) {
      add_strips(mesh, corners);
    } else {
      add_face(mesh, corners);
    }
    if (mesh.size.size() > largest_face_count)
      section.refuse("more faces", "at most " + std::to_string(largest_face_count));
  }
}

void add_points(RawMesh& mesh, const Numbers& coordinates)
{
  const Eigen::Index first = mesh.vertices.rows(), n = static_cast<Eigen::Index>(coordinates.size() / 3);
  mesh.vertices.conservativeResize(first + n, 3);
  mesh.vertices.bottomRows(n) = Eigen::Map<const Points>(coordinates.data(), n, 3);
}

// Bytes of an array, as they are or in base64, of which each part may end with padding.
class ByteSource {
 public:
  ByteSource(std::string_view text, bool is_base64) : text_(text), is_base64_(is_base64) {}

  // The next `n` bytes; fewer where the data end or are not base64.
  std::string take(std::size_t n)
  {
    if (!is_base64_) {
      const std::string_view bytes = text_.substr(0, n);
      text_.remove_prefix(bytes.size());
      return std::string(bytes);
    }
    while (decoded_.size() < n && decode_group()) {
    }
    std::string bytes = decoded_.substr(0, n);
    decoded_.erase(0, bytes.size());
    return bytes;
  }

 private:
  // Four characters are three bytes, or fewer with padding.
  bool decode_group()
  {
    std::uint32_t bits = 0;
    std::size_t n = 0, n_padding = 0, at = 0;
    for (; at < text_.size() && n < 4; ++at) {
      if (is_space(text_[at])) continue;
      const bool is_padding = text_[at] == '=';
      const int value = is_padding ? 0 : value_of(text_[at]);
      if (value < 0) return false;
      bits = bits << 6U | static_cast<std::uint32_t>(value);
      n_padding += is_padding ? 1 : 0;
      ++n;
    }
    text_.remove_prefix(at);
    if (n < 4 || n_padding > 2) return false;
    for (std::size_t k = 0; k < 3 - n_padding; ++k)
      decoded_ += static_cast<char>(bits >> (16 - 8 * k) & 0xffU);
    return true;
  }

  static int value_of(char c)
  {
    if (c >= 'A' && c <= 'Z') return c - 'A';
    if (c >= 'a' && c <= 'z') return 26 + c - 'a';
    if (c >= '0' && c <= '9') return 52 + c - '0';
    return c == '+' ? 62 : c == '/' ? 63 : -1;
  }

  std::string_view text_;
  bool is_base64_;
  std::string decoded_;  // not yet taken
};

// A file of VTK's XML format, parsed without its appended data, which are not XML.
class XmlReader {
 public:
  XmlReader(const std::string& file, const std::string& bytes) : file_(file)
  {
    const std::string_view all = bytes;
    const std::size_t element = all.find("<AppendedData");
    const std::size_t end = element == all.npos ? all.npos : all.find('>', element);
    std::string xml = bytes.substr(0, end == all.npos ? end : end + 1);
    if (end != all.npos) {
      appended_ = all.substr(end + 1);
      appended_.remove_prefix(std::min(appended_.find('_'), appended_.size() - 1) + 1);
      xml += "</AppendedData></VTKFile>";
    }
    const pugi::xml_parse_result result = document_.load_buffer(xml.data(), xml.size());
    if (!result) {
      const auto n_read =
          std::min(static_cast<std::size_t>(std::max<std::ptrdiff_t>(result.offset, 0)), xml.size());
      const auto n_ends = std::count(xml.begin(), xml.begin() + static_cast<std::ptrdiff_t>(n_read), '\n');
      Section{file_, "line " + std::to_string(1 + n_ends)}.refuse(
          std::string("truncated or damaged XML (") + result.description() + ")", "a complete VTK XML file");
    }
  }

  RawMesh read()
  {
    const pugi::xml_node root = document_.child("VTKFile");
    const auto is_one_of = [&](const char* attribute, std::initializer_list<std::string_view> words,
                               const std::string& wanted) {
      const std::string_view word = root.attribute(attribute).as_string();
      if (std::ranges::find(words, word) == words.end())
        Section{file_, std::string("VTKFile, ") + attribute}.refuse(quoted_word(word), wanted);
      return word;
    };
    is_one_of("type", {"PolyData"}, "\"PolyData\": extract the surface of other data");
    is_big_endian_ = is_one_of("byte_order", {"", "LittleEndian", "BigEndian"},
                               "LittleEndian or BigEndian") == "BigEndian";
    n_header_bytes_ =
        is_one_of("header_type", {"", "UInt32", "UInt64"}, "UInt32 or UInt64") == "UInt64" ? 8 : 4;
    is_compressed_ = !is_one_of("compressor", {"", "vtkZLibDataCompressor"},
                                "vtkZLibDataCompressor or none: save the file without compression")
                          .empty();
    const std::string_view encoding = root.child("AppendedData").attribute("encoding").as_string("base64");
    if (encoding != "raw" && encoding != "base64")
      Section{file_, "AppendedData, encoding"}.refuse(quoted_word(encoding), "raw or base64");
    is_appended_base64_ = encoding == "base64";
    RawMesh mesh;
    std::size_t n = 0;
    for (const pugi::xml_node piece : root.child("PolyData").children("Piece"))
      read_piece(piece, "piece " + std::to_string(n++), mesh);
    return mesh;
  }

 private:
  void read_piece(const pugi::xml_node& piece, const std::string& place, RawMesh& mesh) const
  {
    const auto count = [&](const char* attribute, std::size_t most) {
      return Section{file_, place + ", " + attribute}.count(piece.attribute(attribute).as_string("0"), most);
    };
    const auto first = static_cast<std::size_t>(mesh.vertices.rows());
    const std::size_t n_points = count("NumberOfPoints", most_points - std::min(first, most_points));
    if (n_points > 0) {
      const Section points{file_, place + ", Points"};
      add_points(mesh, array(piece.child("Points").child("DataArray"), points, 3 * n_points));
    }
    for (const auto& [element, attribute, are_strips] :
         {std::tuple("Polys", "NumberOfPolys", false), std::tuple("Strips", "NumberOfStrips", true)}) {
      const std::size_t n_cells = count(attribute, largest_face_count);
      if (n_cells == 0) continue;
      const Section section{file_, place + ", " + element};
      const auto part = [&, element = element](const char* name, std::size_t n) {
        return array(piece.child(element).find_child_by_attribute("DataArray", "Name", name),
                     {file_, section.name + ", " + name}, n);
      };
      Cells cells{{}, part("offsets", n_cells), are_strips};
      const double last = cells.ends.back();
      if (!(last >= 0.0 && last <= static_cast<double>(most_values)))
        section.refuse("offsets up to " + shortest_decimal(last), "at most " + std::to_string(most_values));
      cells.corners = part("connectivity", static_cast<std::size_t>(last));
      add_cells(mesh, cells, first, n_points, section);
    }
  }

  // The `n` numbers of an array.
  Numbers array(const pugi::xml_node& node, const Section& section, std::size_t n) const
  {
    if (!node) section.refuse("no DataArray", std::to_string(n) + " numbers");
    const std::string_view name = node.attribute("type").as_string(), text = node.text().get();
    const NumberType* type = type_named(name, &NumberType::xml);
    if (type == nullptr)
      section.refuse("type " + quoted_word(name), "a number type such as Float32 or Int64");
    const std::string format = lower_case(node.attribute("format").as_string("ascii"));
    if (format == "ascii") {
      std::size_t at = 0;
      Numbers numbers = section.words(text, at, n + 1, *type);
      section.require_count(numbers.size(), n);
      return numbers;
    }
    if (format != "binary" && format != "appended")
      section.refuse("format " + quoted_word(format), "ascii, binary or appended");
    ByteSource source(text, true);
    if (format == "appended") {
      const std::size_t offset = section.count(node.attribute("offset").as_string(), largest_mesh_bytes);
      if (offset >= appended_.size())
        section.refuse("offset " + std::to_string(offset),
                       "one within the " + std::to_string(appended_.size()) + " bytes of appended data");
      source = ByteSource(appended_.substr(offset), is_appended_base64_);
    }
    const std::string bytes = data_of(source, n * type->n_bytes, section);
    return numbers_of(*type, bytes, is_big_endian_);
  }

  std::uint64_t header_number(ByteSource& source, const Section& section) const
  {
    const std::string bytes = source.take(n_header_bytes_);
    if (bytes.size() < n_header_bytes_) section.refuse("no complete header", "the size of the array");
    return bits_at(bytes, 0, n_header_bytes_, is_big_endian_);
  }

  // The `n_bytes` bytes that follow their size; compressed ones are blocks that follow a table of sizes.
  std::string data_of(ByteSource& source, std::size_t n_bytes, const Section& section) const
  {
    const auto require = [&](std::uint64_t found, std::uint64_t wanted, const char* what) {
      if (found != wanted) section.refuse(std::to_string(found) + what, std::to_string(wanted));
    };
    const std::uint64_t first = header_number(source, section);
    if (!is_compressed_) {
      require(first, n_bytes, " bytes of data");
      std::string bytes = source.take(n_bytes);
      require(bytes.size(), n_bytes, " bytes before the end of the file");
      return bytes;
    }
    const std::uint64_t block = header_number(source, section), last = header_number(source, section);
    if (n_bytes == 0) return "";
    // Before any memory is allocated: as many blocks as these bytes need.
    if (block == 0 || first != (n_bytes + block - 1) / block ||
        (last == 0 ? block : last) != n_bytes - (first - 1) * block)
      section.refuse(std::to_string(first) + " blocks of " + std::to_string(block) + " bytes, the last of " +
                         std::to_string(last),
                     std::to_string(n_bytes) + " bytes in all");
    std::vector<std::uint64_t> sizes;
    for (std::uint64_t k = 0; k < first; ++k) sizes.push_back(header_number(source, section));
    std::string bytes;
    for (std::uint64_t k = 0; k < first; ++k) {
      const std::string packed = source.take(sizes[k]);
      require(packed.size(), sizes[k], " bytes before the end of the file");
      const std::size_t n_plain = std::min<std::size_t>(block, n_bytes - bytes.size());
      if (n_plain / largest_factor > packed.size())
        section.refuse(std::to_string(packed.size()) + " bytes of block " + std::to_string(k),
                       "as many as " + std::to_string(n_plain) + " bytes compress to");
      std::string plain(n_plain, '\0');
      uLongf length = plain.size();
      const int code = uncompress(reinterpret_cast<Bytef*>(plain.data()), &length,
                                  reinterpret_cast<const Bytef*>(packed.data()), packed.size());
      if (code != Z_OK || length != plain.size())
        section.refuse("damaged compressed data in block " + std::to_string(k), "data of zlib");
      bytes += plain;
    }
    return bytes;
  }

  const std::string& file_;
  pugi::xml_document document_;
  std::string_view appended_;  // after its mark "_"
  bool is_big_endian_ = false, is_compressed_ = false, is_appended_base64_ = false;
  std::size_t n_header_bytes_ = 4;
};

// The legacy format: keywords, each followed by numbers as text or big-endian.
class LegacyReader {
 public:
  LegacyReader(const std::string& file, const std::string& bytes) : file_(file), bytes_(bytes) {}

  RawMesh read()
  {
    if (!lower_case(std::string(line())).starts_with("# vtk datafile"))
      Section{file_, "line 1"}.refuse("no VTK file", "\"# vtk DataFile Version ...\"");
    line();  // a title
    const std::string format = lower_case(std::string(word()));
    if (format != "ascii" && format != "binary")
      Section{file_, "line 3"}.refuse(quoted_word(format), "ASCII or BINARY");
    is_binary_ = format == "binary";
    for (std::string keyword = next_keyword();
         !keyword.empty() && keyword != "point_data" && keyword != "cell_data"; keyword = next_keyword())
      read_section(keyword);
    return std::move(mesh_);
  }

 private:
  std::string_view line()
  {
    const std::size_t end = std::min(bytes_.find('\n', at_), bytes_.size());
    const std::string_view text = bytes_.substr(at_, end - at_);
    at_ = std::min(end + 1, bytes_.size());
    return trimmed(text);
  }

  std::string_view word() { return word_at(bytes_, at_); }
  std::string next_keyword() { return lower_case(std::string(word().substr(0, 40))); }

  void read_section(const std::string& keyword)
  {
    const Section section{file_, "section " + keyword};
    if (keyword == "dataset") {
      const std::string_view kind = word();
      if (lower_case(std::string(kind.substr(0, 40))) != "polydata")
        section.refuse(quoted_word(kind), "POLYDATA: extract the surface of other data");
    } else if (keyword == "points") {
      const std::size_t n = section.count(word(), most_points);
      mesh_.vertices.resize(0, 3);
      add_points(mesh_, array(section, 3 * n));
    } else if (keyword == "polygons" || keyword == "triangle_strips" || keyword == "lines" ||
               keyword == "vertices") {
      Cells cells = cells_of(section);
      cells.are_strips = keyword == "triangle_strips";
      // Where points follow, read_mesh() checks the indices.
      const auto n_points = static_cast<std::size_t>(mesh_.vertices.rows());
      constexpr std::size_t any = std::numeric_limits<std::int32_t>::max();
      if (keyword == "polygons" || cells.are_strips)
        add_cells(mesh_, cells, 0, n_points > 0 ? n_points : any, section);
    } else if (keyword == "field") {
      word();  // its name
      for (std::size_t n = section.count(word(), most_points); n > 0; --n) skip_field(section);
    } else if (keyword == "metadata") {
      line();
      while (at_ < bytes_.size() && !line().empty()) {
      }
    } else {
      Section{file_, "line " + std::to_string(line_number())}.refuse(
          quoted_word(keyword), "POINTS, POLYGONS or another section of PolyData");
    }
  }

  std::size_t line_number() const
  {
    return 1 + static_cast<std::size_t>(
                   std::count(bytes_.begin(), bytes_.begin() + static_cast<std::ptrdiff_t>(at_), '\n'));
  }

  const NumberType& next_type(const Section& section)
  {
    const std::string_view name = word();
    const NumberType* type = type_named(lower_case(std::string(name.substr(0, 40))), &NumberType::legacy);
    if (type == nullptr) section.refuse(quoted_word(name), "a number type such as float or int");
    return *type;
  }

  // The name of a type, the end of its line and `n` numbers.
  Numbers array(const Section& section, std::size_t n) { return array(section, n, next_type(section)); }

  Numbers array(const Section& section, std::size_t n, const NumberType& type)
  {
    if (n > most_values)
      section.refuse(std::to_string(n) + " numbers", "at most " + std::to_string(most_values));
    if (!is_binary_) {
      Numbers numbers = section.words(bytes_, at_, n, type);
      section.require_count(numbers.size(), n);
      return numbers;
    }
    line();
    const std::size_t n_bytes = type.n_bytes == 0 ? (n + 7) / 8 : n * type.n_bytes;  // bits are packed
    if (bytes_.size() - at_ < n_bytes)
      section.refuse(std::to_string(bytes_.size() - at_) + " bytes before the end of the file",
                     std::to_string(n_bytes));
    const std::string_view data = bytes_.substr(at_, n_bytes);
    at_ += n_bytes;
    return type.n_bytes == 0 ? Numbers() : numbers_of(type, data, true);
  }

  // Up to version 5.0 each cell is its number of corners and their indices, then offsets and connectivity.
  Cells cells_of(const Section& section)
  {
    const std::size_t n = section.count(word(), most_points), size = section.count(word(), most_values);
    const std::size_t before = at_;
    Cells cells;
    if (next_keyword() == "offsets") {
      const Numbers bounds = array(section, n);
      if (!bounds.empty()) cells.ends.assign(bounds.begin() + 1, bounds.end());
      if (const std::string keyword = next_keyword(); keyword != "connectivity")
        section.refuse(quoted_word(keyword), "CONNECTIVITY");
      cells.corners = array(section, size);
      return cells;
    }
    at_ = before;
    const Numbers values = array(section, size, *type_named("int", &NumberType::legacy));
    std::size_t at = 0;
    for (std::size_t c = 0; c < n; ++c) {
      const double n_corners = at < size ? values[at++] : -1.0;
      if (!(n_corners >= 0.0 && n_corners <= static_cast<double>(size - at)))
        section.refuse("cell " + std::to_string(c) + " beyond the " + std::to_string(size) + " numbers",
                       std::to_string(n) + " cells");
      for (const std::size_t end = at + static_cast<std::size_t>(n_corners); at < end; ++at)
        cells.corners.push_back(values[at]);
      cells.ends.push_back(static_cast<double>(cells.corners.size()));
    }
    return cells;
  }

  void skip_field(const Section& section)
  {
    word();  // its name
    const std::size_t n_components = section.count(word(), most_values),
                      n_rows = section.count(word(), most_values);
    const std::size_t n = n_components * n_rows, before = at_;
    if (lower_case(std::string(word().substr(0, 40))) != "string") {
      at_ = before;
      array(section, n);
      return;
    }
    line();
    for (std::size_t k = 0; k < n && at_ < bytes_.size(); ++k) {
      if (is_binary_) {
        skip_binary_text();
      } else {
        line();
      }
    }
  }

  // The two highest bits of the first byte give the size of the length: 3 one byte, 2 two, 1 four, 0 eight.
  void skip_binary_text()
  {
    constexpr std::array<std::size_t, 4> sizes{8, 4, 2, 1};
    const std::size_t n = sizes[static_cast<unsigned char>(bytes_[at_]) >> 6U];
    if (bytes_.size() - at_ < n) {
      at_ = bytes_.size();
      return;
    }
    const std::uint64_t length = bits_at(bytes_, at_, n, true) & (~std::uint64_t{0} >> (66 - 8 * n));
    at_ += n;
    at_ += std::min<std::uint64_t>(length, bytes_.size() - at_);
  }

  const std::string& file_;
  std::string_view bytes_;
  std::size_t at_ = 0;
  bool is_binary_ = false;
  RawMesh mesh_;
};

}  // namespace

RawMesh read_vtp(const std::string& file, const std::string& bytes)
{
  return XmlReader(file, bytes).read();
}

RawMesh read_legacy_vtk(const std::string& file, const std::string& bytes)
{
  return LegacyReader(file, bytes).read();
}

}  // namespace vrda::job
