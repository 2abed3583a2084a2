#include <algorithm>
#include <cctype>
#include <string_view>

#include "core/error.hpp"
#include "load/mesh_sizes.hpp"
#include "load/raw_mesh.hpp"

namespace vrda {
namespace {

constexpr std::size_t header_bytes = 80;
constexpr std::size_t facet_bytes = 50;  // normal, three vertices, attribute

bool is_space(char c)
{
  return c == ' ' || (c >= '\t' && c <= '\r');
}

// Begins with "solid" and holds nothing a text file does not: binary headers may begin with it too.
bool is_ascii(const std::string& bytes)
{
  const std::size_t begin = std::min(bytes.find_first_not_of(" \t\r\n"), bytes.size());
  const auto is_text = [](char c) { return is_space(c) || static_cast<unsigned char>(c) >= 0x20; };
  return bytes.compare(begin, 5, "solid") == 0 &&
         std::all_of(bytes.begin(),
                     bytes.begin() + static_cast<std::ptrdiff_t>(std::min<std::size_t>(bytes.size(), 1024)),
                     is_text);
}

std::string lower(std::string_view word)
{
  std::string out(word);
  for (char& c : out) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return out;
}

struct FacetCount {
  std::size_t n_begun = 0;
  std::size_t n_ended = 0;
  std::size_t n_vertices = 0;
  bool is_solid_open = false;
};

void count_word(const std::string& word, FacetCount& count)
{
  if (word == "facet") ++count.n_begun;
  if (word == "endfacet") ++count.n_ended;
  if (word == "vertex") ++count.n_vertices;
  if (word == "solid") count.is_solid_open = true;
  if (word == "endsolid") count.is_solid_open = false;
}

// Counts the first word of each line: the name after "solid" is free text.
FacetCount facets_of(const std::string& file, const std::string& bytes)
{
  FacetCount count;
  std::size_t line = 1;
  for (std::size_t begin = 0; begin < bytes.size(); ++line) {
    const std::size_t end = std::min(bytes.find('\n', begin), bytes.size());
    std::size_t first = begin;
    while (first < end && is_space(bytes[first])) ++first;
    std::size_t last = first;
    while (last < end && !is_space(bytes[last])) ++last;
    const std::size_t facets_before = count.n_ended;
    count_word(lower(std::string_view(bytes).substr(first, last - first)), count);
    if (count.n_ended != facets_before && count.n_vertices != 3 * count.n_ended) {
      throw InputError(
          {file, "line " + std::to_string(line), "a facet without exactly three vertices", "three"});
    }
    begin = end + 1;
  }
  return count;
}

void check_count(const std::string& file, const std::string& field, std::size_t n_facets)
{
  if (n_facets == 0) throw InputError({file, field, "an empty mesh of 0 triangles", "a mesh with faces"});
  if (n_facets > largest_face_count) {
    throw InputError({file, field, std::to_string(n_facets) + " triangles",
                      "at most " + std::to_string(largest_face_count)});
  }
}

void check_ascii(const std::string& file, const std::string& bytes)
{
  const FacetCount count = facets_of(file, bytes);
  if (count.n_begun != count.n_ended || count.n_vertices != 3 * count.n_ended || count.is_solid_open) {
    throw InputError({file, "",
                      "an STL file cut short after " + std::to_string(count.n_ended) + " whole facets",
                      "\"endsolid\" at its end"});
  }
  check_count(file, "", count.n_ended);
}

void check_binary(const std::string& file, std::size_t n_facets, std::size_t n_bytes,
                  std::size_t wanted_bytes)
{
  if (n_bytes < header_bytes + 4) {
    throw InputError({file, "", std::to_string(n_bytes) + " bytes", "an STL file: its header alone has 84"});
  }
  if (n_bytes != wanted_bytes) {
    throw InputError(
        {file, "header",
         std::to_string(n_facets) + " triangles in a file of " + std::to_string(n_bytes) + " bytes",
         std::to_string(wanted_bytes) + " bytes for so many"});
  }
  check_count(file, "header", n_facets);
}

}  // namespace

void check_stl_size(const std::string& file, const std::string& bytes)
{
  std::size_t n_facets = 0;
  if (bytes.size() >= header_bytes + 4) {
    for (std::size_t k = 0; k < 4; ++k) {
      n_facets |= static_cast<std::size_t>(static_cast<unsigned char>(bytes[header_bytes + k])) << (8 * k);
    }
  }
  const std::size_t wanted_bytes = header_bytes + 4 + facet_bytes * n_facets;
  // The size decides before the first word does: a binary header may begin with "solid".
  if (bytes.size() != wanted_bytes && is_ascii(bytes)) return check_ascii(file, bytes);
  check_binary(file, n_facets, bytes.size(), wanted_bytes);
}

}  // namespace vrda
