// Bytes of a mesh file to vertices and triangles, by assimp; checks of what assimp accepts silently.
#include "job/mesh_file.hpp"

#include <assimp/BaseImporter.h>
#include <assimp/scene.h>
#include <openssl/evp.h>
#include <assimp/IOSystem.hpp>
#include <assimp/Importer.hpp>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <map>
#include <memory>
#include <numeric>
#include <utility>

#include "core/document.hpp"
#include "core/text.hpp"
#include "job/clean_mesh.hpp"
#include "job/job.hpp"

namespace vrda::job {
namespace {

// Prevents importers from opening other files.
class NoOtherFiles : public Assimp::IOSystem {
 public:
  bool Exists(const char* /*name*/) const override { return false; }
  char getOsSeparator() const override { return '/'; }
  Assimp::IOStream* Open(const char* /*name*/, const char* /*mode*/) override { return nullptr; }
  void Close(Assimp::IOStream* /*stream*/) override {}
};

// assimp registers about fifty importers: removes all except the one for this extension.
void keep_only(Assimp::Importer& importer, const std::string& extension)
{
  for (std::size_t i = importer.GetImporterCount(); i-- > 0;) {
    Assimp::BaseImporter* loader = importer.GetImporter(i);
    if (loader->GetInfo()->mFileExtensions == extension) continue;
    importer.UnregisterLoader(loader);
    delete loader;  // unregistering transfers ownership
  }
  check(importer.GetImporterCount() == 1, "assimp must have exactly one importer for this extension");
}

void append_mesh(RawMesh& mesh, const aiMesh& part, bool& has_normals)
{
  const Eigen::Index first = mesh.vertices.rows();
  const auto n = static_cast<Eigen::Index>(part.mNumVertices);
  mesh.vertices.conservativeResize(first + n, 3);
  mesh.normals.conservativeResize(first + n, 3);
  has_normals = has_normals && part.mNormals != nullptr;
  for (Eigen::Index v = 0; v < n; ++v) {
    const aiVector3D& p = part.mVertices[v];
    const aiVector3D normal = part.mNormals == nullptr ? aiVector3D() : part.mNormals[v];
    mesh.vertices.row(first + v) << static_cast<double>(p.x), static_cast<double>(p.y),
        static_cast<double>(p.z);
    mesh.normals.row(first + v) << static_cast<double>(normal.x), static_cast<double>(normal.y),
        static_cast<double>(normal.z);
  }
  for (unsigned int f = 0; f < part.mNumFaces; ++f) {
    const aiFace& face = part.mFaces[f];
    if (face.mNumIndices < 3) continue;  // points and lines
    mesh.size.push_back(static_cast<std::int32_t>(face.mNumIndices));
    for (unsigned int k = 0; k < face.mNumIndices; ++k) {
      mesh.corner.push_back(static_cast<std::int32_t>(first) + static_cast<std::int32_t>(face.mIndices[k]));
    }
  }
}

RawMesh read_with_assimp(const std::string& file, const std::string& bytes, const std::string& extension)
{
  Assimp::Importer importer;
  importer.SetIOHandler(new NoOtherFiles);  // the importer owns it
  keep_only(importer, extension);
  const aiScene* scene = importer.ReadFileFromMemory(bytes.data(), bytes.size(), 0, extension.c_str());
  if (scene == nullptr) {
    throw InputError({file, "",
                      "a file that cannot be parsed (" + std::string(importer.GetErrorString()) + ")",
                      "a complete " + extension + " file"});
  }
  RawMesh mesh;
  bool has_normals = extension != "stl";  // STL normals belong to facets, not to vertices
  for (unsigned int m = 0; m < scene->mNumMeshes; ++m) append_mesh(mesh, *scene->mMeshes[m], has_normals);
  if (!has_normals) mesh.normals.resize(0, 3);
  return mesh;
}

RawMesh read_checked(const std::string& file, const CheckedText& checked, const std::string& extension)
{
  RawMesh mesh = read_with_assimp(file, checked.bytes, extension);
  mesh.notes = checked.notes;
  return mesh;
}

void check_mesh(const std::string& file, const RawMesh& mesh)
{
  if (mesh.size.empty()) {
    throw InputError({file, "",
                      "an empty mesh: " + std::to_string(mesh.vertices.rows()) + " vertices and no face",
                      "a mesh with faces"});
  }
  for (Eigen::Index v = 0; v < mesh.vertices.rows(); ++v) {
    const bool is_far = !(mesh.vertices.row(v).cwiseAbs().maxCoeff() <= largest_coordinate);
    if (mesh.vertices.row(v).allFinite() && !is_far) continue;
    throw InputError({file, "vertex " + std::to_string(v),
                      "(" + core::numbers_text(mesh.vertices.row(v)) + ")",
                      "three finite numbers of at most 1e9 in size"});
  }
  std::size_t corner = 0;
  for (std::size_t f = 0; f < mesh.size.size(); ++f) {
    if (mesh.size[f] > static_cast<std::int32_t>(largest_face_size)) {
      throw InputError({file, "face " + std::to_string(f), std::to_string(mesh.size[f]) + " corners",
                        "at most " + std::to_string(largest_face_size)});
    }
    for (std::int32_t k = 0; k < mesh.size[f]; ++k, ++corner) {
      if (mesh.corner[corner] >= 0 && mesh.corner[corner] < mesh.vertices.rows()) continue;
      throw InputError({file, "face " + std::to_string(f),
                        "vertex index " + std::to_string(mesh.corner[corner]),
                        "an index of " + std::to_string(mesh.vertices.rows()) + " vertices"});
    }
  }
}

std::string lower_extension(const std::string& file)
{
  return lower_case(std::filesystem::path(file).extension().string());
}

RawMesh read_by_extension(const std::string& file, const std::string& bytes)
{
  const std::string extension = lower_extension(file);
  if (extension == ".stl") return read_checked(file, checked_stl(file, bytes), "stl");
  if (extension == ".ply") return read_ply(file, bytes);
  if (extension == ".vf" || (extension == ".obj" && is_vertices_faces(bytes)))
    return read_vertices_faces(file, bytes);
  if (extension == ".obj") return read_checked(file, checked_wavefront(file, bytes), "obj");
  if (extension == ".vtp") return read_vtp(file, bytes);
  if (extension == ".vtk") return read_legacy_vtk(file, bytes);
  throw InputError(
      {file, "", "the extension \"" + extension + "\"", "a mesh file: .stl, .ply, .obj, .vf, .vtp or .vtk"});
}

}  // namespace

std::string quoted_word(std::string_view word)
{
  constexpr std::size_t longest = 40;
  return "\"" + std::string(word.substr(0, longest)) + "\"";
}

RawMesh read_mesh(const std::string& file, std::string bytes)
{
  if (bytes.empty()) throw InputError({file, "", "an empty file", "a mesh"});
  const std::string extension = lower_extension(file);
  const bool has_mark = bytes.starts_with(byte_order_mark);
  if (extension != ".stl" || (!is_binary_stl(bytes) && (has_mark || is_ascii_stl(bytes))))
    normalise_text(bytes);
  try {
    RawMesh mesh = read_by_extension(file, bytes);
    check_mesh(file, mesh);
    return mesh;
  } catch (const InputError&) {
    // Only of a refused file: bytes that look like another format may begin a valid one.
    const FileContent content = content_of(bytes);
    const bool is_as_named = content.extension == extension ||
                             (content.extension == ".vf" && extension == ".obj");  // of the thesis
    if (content.name.empty() || is_as_named) throw;
    throw InputError({file, "", content.name, content.remedy});
  }
}

// STL files that assimp would read wrongly or partly: refused with line or size, before it reads them.

namespace {

constexpr std::size_t header_bytes = 80;
constexpr std::size_t facet_bytes = 50;  // normal, three vertices, attribute

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
      const std::string found = words.empty() || is_comment(words[0]) ? "" : read_line(words);
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
  static bool is_word(std::string_view word, std::string_view wanted)
  {
    return word.size() == wanted.size() && lower_case(std::string(word)) == wanted;
  }

  static bool is_comment(std::string_view word)
  {
    return word.starts_with('#') || word.starts_with("//") || is_word(word, "color");
  }

  // The error of a line, or an empty text. Some programs write several statements a line, or all.
  std::string read_line(const std::vector<std::string_view>& words)
  {
    constexpr std::array<std::string_view, 6> first_words{"facet",   "outer",    "vertex",
                                                          "endloop", "endfacet", "endsolid"};
    const auto is_first = [&](std::string_view word) {
      return std::ranges::any_of(first_words, [&](std::string_view first) { return is_word(word, first); });
    };
    constexpr std::size_t most_of_one = 5;  // but for names of solids
    if (words.size() <= most_of_one ||
        std::ranges::none_of(words, [](std::string_view word) { return is_word(word, "vertex"); }))
      return read(words);
    std::vector<std::string_view> statement;
    std::string found;
    for (const std::string_view word : words) {
      if (!statement.empty() && is_first(word) && found.empty()) {
        found = read(statement);
        statement.clear();
      }
      statement.push_back(word);
    }
    return found.empty() ? read(statement) : found;
  }

  // The error of a statement, or an empty text.
  std::string read(const std::vector<std::string_view>& words)
  {
    std::string keyword = lower_case(std::string(words[0]));
    if (keyword == "end" && words.size() > 1) keyword += lower_case(std::string(words[1]));
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
      ++n_begun_;  // whatever its normal is: it is not used
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
    } else if (keyword != "outer" && keyword != "outerloop" && keyword != "endloop") {
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

// Three numbers of four bytes, in little-endian order.
Eigen::Vector3f point_at(std::string_view bytes, std::size_t at)
{
  Eigen::Vector3f p;
  for (Eigen::Index k = 0; k < 3; ++k, at += 4) {
    std::uint32_t bits = 0;
    for (std::size_t byte = 4; byte-- > 0;) bits = bits << 8U | static_cast<unsigned char>(bytes[at + byte]);
    p[k] = std::bit_cast<float>(bits);
  }
  return p;
}

// Whether the bytes are facets: three different vertices of a plausible size each.
bool are_facets(std::string_view bytes)
{
  if (bytes.size() % facet_bytes != 0) return false;
  for (std::size_t at = 0; at < bytes.size(); at += facet_bytes) {
    const Eigen::Vector3f a = point_at(bytes, at + 12), b = point_at(bytes, at + 24),
                          c = point_at(bytes, at + 36);
    const auto is_plausible = [](const Eigen::Vector3f& p) {
      return p.allFinite() && p.cwiseAbs().maxCoeff() <= static_cast<float>(largest_coordinate);
    };
    if (!is_plausible(a) || !is_plausible(b) || !is_plausible(c) || a == b || b == c || c == a) return false;
  }
  return true;
}

bool is_text(std::string_view bytes)
{
  // DOS ends a text with the character 1A.
  return std::ranges::all_of(
      bytes, [](char c) { return is_space(c) || c == '\x1a' || static_cast<unsigned char>(c) >= 0x20; });
}

std::size_t facets_of_header(std::string_view bytes)
{
  std::size_t n_facets = 0;
  for (std::size_t k = 0; k < 4 && bytes.size() >= header_bytes + 4; ++k)
    n_facets |= static_cast<std::size_t>(static_cast<unsigned char>(bytes[header_bytes + k])) << (8 * k);
  return n_facets;
}

std::size_t binary_size(std::size_t n_facets)
{
  return header_bytes + 4 + facet_bytes * n_facets;
}

CheckedText checked_binary(const std::string& file, const std::string& bytes)
{
  if (bytes.size() < header_bytes + 4) {
    throw InputError({file, "", std::to_string(bytes.size()) + " bytes", "an STL file of at least 84 bytes"});
  }
  const std::size_t n_facets = facets_of_header(bytes), size = binary_size(n_facets);
  const std::string found =
      std::to_string(n_facets) + " triangles in a file of " + std::to_string(bytes.size()) + " bytes";
  if (bytes.size() < size)
    throw InputError({file, "header", found, std::to_string(size) + " bytes for this number"});
  const std::string_view rest = std::string_view(bytes).substr(size);
  if (!rest.empty() && are_facets(rest))
    throw InputError({file, "header", found,
                      std::to_string(n_facets + rest.size() / facet_bytes) +
                          " triangles, which its bytes hold, or a file of " + std::to_string(size) +
                          " bytes"});
  check_count(file, "header", n_facets);
  if (rest.empty()) return {bytes, {}};
  return {bytes.substr(0, size),
          {std::to_string(rest.size()) + " bytes after the last triangle are ignored"}};
}

}  // namespace

bool is_binary_stl(std::string_view bytes)
{
  const std::size_t n_facets = facets_of_header(bytes);
  return n_facets > 0 && bytes.size() == binary_size(n_facets);
}

bool is_ascii_stl(std::string_view bytes)
{
  if (bytes.starts_with(byte_order_mark)) bytes.remove_prefix(byte_order_mark.size());
  const std::size_t begin = std::min(bytes.find_first_not_of(" \t\r\n"), bytes.size());
  return lower_case(std::string(bytes.substr(begin, 5))) == "solid" && is_text(bytes.substr(0, 1024));
}

CheckedText checked_stl(const std::string& file, const std::string& bytes)
{
  // The size is tested before the first word: a binary header may begin with "solid".
  const bool has_binary_size = bytes.size() == binary_size(facets_of_header(bytes));
  if (!has_binary_size && is_ascii_stl(bytes)) return {checked_ascii(file, bytes), {}};
  const std::string_view text = trimmed(bytes), line = text.substr(0, text.find_first_of("\r\n"));
  if (!has_binary_size && !line.empty() && is_utf8(line) && is_text(text.substr(0, 1024)))
    throw InputError({file, "", "text that begins with " + quoted_word(line),
                      "an STL file: \"solid\" or a binary header at its beginning"});
  return checked_binary(file, bytes);
}

// OBJ files that assimp would read wrongly: refused with the line, before it reads them.

namespace {

using WordList = std::vector<std::string_view>;

// Keywords without influence on vertices and faces.
bool is_ignored(std::string_view keyword)
{
  constexpr std::array<std::string_view, 17> others{
      "g",  "o", "s", "mg",    "usemtl",   "mtllib",   "usemap",     "maplib",   "lod",
      "vp", "l", "p", "bevel", "c_interp", "d_interp", "shadow_obj", "trace_obj"};
  return std::ranges::find(others, keyword) != others.end();
}

// Patches and curves of the format's first versions, beside which faces may be.
bool is_old(std::string_view keyword)
{
  constexpr std::array<std::string_view, 5> old{"bsp", "bzp", "cdc", "cdp", "res"};
  return std::ranges::find(old, keyword) != old.end();
}

class Checker {
 public:
  Checker(const std::string& file, const std::string& bytes) : file_(file), bytes_(bytes) {}

  CheckedText reduced()
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
    std::vector<std::string> notes;
    if (n_unusable_ > 0)
      notes.push_back("normals (vn) that are not three numbers: " + std::to_string(n_unusable_) +
                      "; all are computed");
    for (const auto& [keyword, n] : n_old_)
      notes.push_back("lines \"" + keyword + "\" are ignored: " + std::to_string(n));
    return {std::move(out_), notes};
  }

 private:
  void read(const WordList& words)
  {
    const std::string_view keyword = words[0];
    if (keyword == "v") {
      read_vertex(words);
      ++n_vertices_;
    } else if (keyword == "vn") {
      read_normal(words);
      ++n_normals_;
    } else if (keyword == "f" || keyword == "fo") {  // the name in the format's first versions
      read_face(words);
    } else if (is_old(keyword)) {
      ++n_old_[std::string(keyword)];
    } else if (keyword != "vt" && !is_ignored(keyword)) {
      refuse(quoted_word(keyword), "a keyword of a polygon mesh, such as v, vn, vt or f");
    }
  }

  // A weight or a colour may follow.
  void read_vertex(const WordList& words)
  {
    if (words.size() < 4 || words.size() > 8)
      refuse(std::to_string(words.size() - 1) + " numbers", "from 3 to 7");
    for (std::size_t k = 1; k < words.size(); ++k) {
      if (!parse_real(words[k])) refuse(quoted_word(words[k]), "a number");
    }
    add_line(words);
  }

  // One that is not three numbers becomes zero, for which clean_mesh() computes the normals.
  void read_normal(const WordList& words)
  {
    if (has_three_numbers(words, 1)) return add_line(words);
    ++n_unusable_;
    out_ += "vn 0 0 0\n";
  }

  void add_line(const WordList& words)
  {
    for (std::size_t k = 0; k < 4; ++k) (out_ += k == 0 ? "" : " ") += words[k];
    out_ += "\n";
  }

  void read_face(const WordList& words)
  {
    if (words.size() < 4) refuse(std::to_string(words.size() - 1) + " corners", "at least 3");
    if (++n_faces_ > largest_face_count)
      refuse("more faces", "at most " + std::to_string(largest_face_count));
    corners_.clear();
    for (std::size_t k = 1; k < words.size(); ++k) read_corner(words[k]);
    // Of a face with and without normals all are dropped: assimp would give them to other corners.
    const bool has_normals = std::ranges::all_of(corners_, [](const Corner& c) { return c.normal > 0; });
    out_ += "f";
    for (const Corner& corner : corners_) {
      (out_ += " ") += std::to_string(corner.vertex);
      if (has_normals) (out_ += "//") += std::to_string(corner.normal);
    }
    out_ += "\n";
  }

  // v, v/t, v//n or v/t/n; texture indices are dropped. A normal 0 counts as absent.
  void read_corner(std::string_view word)
  {
    const std::size_t slash = std::min(word.find('/'), word.size());
    const std::size_t second = std::min(word.find('/', slash + 1), word.size());
    Corner corner{absolute(word, word.substr(0, slash), n_vertices_)};
    note(corner.vertex, highest_vertex_);
    const std::string_view normal = word.substr(std::min(second + 1, word.size()));
    if (!normal.empty() && normal != "0") {
      corner.normal = absolute(word, normal, n_normals_);
      note(corner.normal, highest_normal_);
    }
    corners_.push_back(corner);
  }

  // Negative indices count back from the last one so far.
  std::int64_t absolute(std::string_view corner, std::string_view word, std::int64_t n_so_far) const
  {
    const std::optional<std::int64_t> index = parse_integer(word);
    const std::int64_t value = index && *index < 0 ? n_so_far + 1 + *index : index.value_or(0);
    if (value < 1) refuse(quoted_word(corner), "an index from 1 or a negative one: " + valid_vertices());
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

  struct Corner {
    std::int64_t vertex = 0, normal = 0;  // from 1; 0: absent
  };

  const std::string& file_;
  const std::string& bytes_;
  std::string out_;
  std::vector<Corner> corners_;               // of the current face
  std::map<std::string, std::size_t> n_old_;  // lines of each old keyword
  std::size_t line_ = 0, highest_line_ = 0, n_faces_ = 0, n_unusable_ = 0;
  std::int64_t n_vertices_ = 0, n_normals_ = 0, highest_vertex_ = 0, highest_normal_ = 0;
};

}  // namespace

CheckedText checked_wavefront(const std::string& file, const std::string& bytes)
{
  return Checker(file, bytes).reduced();
}

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

  /// Refuses anything after `last`, such as "12 faces".
  void require_end(const std::string& last)
  {
    if (const std::string_view rest = next(); !rest.empty())
      refuse(quoted_word(rest), "the end of the file after " + last);
  }

  void skip_byte_order_mark() { at_ = bytes_.starts_with(byte_order_mark) ? byte_order_mark.size() : 0; }

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
    if (!number) refuse(quoted_word(word_), wanted);
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
  words.skip_byte_order_mark();
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
  words.require_end(count_of(n_faces, "faces"));
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
  words.require_end(count_of(n, "normals"));
  return normals;
}

// Triangulation of polygons.

namespace {

using Outline = std::vector<Eigen::Vector2d>;  // corners in the plane of the polygon

// Newell's normal: the sum of the areas projected on the coordinate planes.
Eigen::Vector3d newell_normal(const Points& corners)
{
  // Relative to the first corner, for precision far from the origin.
  Eigen::Vector3d normal = Eigen::Vector3d::Zero();
  for (Eigen::Index k = 1; k + 1 < corners.rows(); ++k) {
    const Eigen::Vector3d a = (corners.row(k) - corners.row(0)).transpose();
    const Eigen::Vector3d b = (corners.row(k + 1) - corners.row(0)).transpose();
    normal += a.cross(b);
  }
  return normal;
}

Outline projected(const Points& corners, const Eigen::Vector3d& normal)
{
  const Eigen::Vector3d n = normal.normalized();
  Eigen::Index least = 0;
  n.cwiseAbs().minCoeff(&least);
  const Eigen::Vector3d u = n.cross(Eigen::Vector3d::Unit(least)).normalized();
  const Eigen::Vector3d v = n.cross(u);
  Outline flat;
  for (Eigen::Index k = 0; k < corners.rows(); ++k) {
    const Eigen::Vector3d p = (corners.row(k) - corners.row(0)).transpose();
    flat.emplace_back(p.dot(u), p.dot(v));
  }
  return flat;
}

double turn(const Eigen::Vector2d& a, const Eigen::Vector2d& b, const Eigen::Vector2d& c)
{
  return (b.x() - a.x()) * (c.y() - a.y()) - (b.y() - a.y()) * (c.x() - a.x());
}

bool covers(const Outline& flat, const std::array<std::int32_t, 3>& ear, std::int32_t corner)
{
  const auto at = [&](std::int32_t k) -> const Eigen::Vector2d& { return flat[static_cast<std::size_t>(k)]; };
  const Eigen::Vector2d& p = at(corner);
  if (p == at(ear[0]) || p == at(ear[1]) || p == at(ear[2])) return false;
  return turn(at(ear[0]), at(ear[1]), p) >= 0.0 && turn(at(ear[1]), at(ear[2]), p) >= 0.0 &&
         turn(at(ear[2]), at(ear[0]), p) >= 0.0;
}

std::array<std::int32_t, 3> ear_at(const std::vector<std::int32_t>& remaining, std::size_t k)
{
  const std::size_t n = remaining.size();
  return {remaining[(k + n - 1) % n], remaining[k], remaining[(k + 1) % n]};
}

bool is_ear(const Outline& flat, const std::vector<std::int32_t>& remaining, std::size_t k, double least_area)
{
  const std::array<std::int32_t, 3> ear = ear_at(remaining, k);
  const auto at = [&](std::int32_t i) -> const Eigen::Vector2d& { return flat[static_cast<std::size_t>(i)]; };
  if (turn(at(ear[0]), at(ear[1]), at(ear[2])) <= least_area) return false;
  for (const std::int32_t other : remaining) {
    if (other != ear[0] && other != ear[1] && other != ear[2] && covers(flat, ear, other)) return false;
  }
  return true;
}

// The position of the next ear; the number of remaining corners if none exists.
std::size_t next_ear(const Outline& flat, const std::vector<std::int32_t>& remaining, double least_area)
{
  std::size_t k = 0;
  while (k < remaining.size() && !is_ear(flat, remaining, k, least_area)) ++k;
  return k;
}

}  // namespace

std::vector<std::array<std::int32_t, 3>> triangulate(const Points& corners_mm)
{
  std::vector<std::array<std::int32_t, 3>> triangles;
  if (corners_mm.rows() == 3) return {{0, 1, 2}};
  const Eigen::Vector3d normal = newell_normal(corners_mm);
  if (!(normal.norm() > 0.0)) return triangles;
  const Outline flat = projected(corners_mm, normal);
  // Ears below rounding would be slivers along an edge; they are postponed.
  const double least_area = 1e-12 * normal.norm();
  std::vector<std::int32_t> remaining(flat.size());
  std::iota(remaining.begin(), remaining.end(), 0);
  while (remaining.size() > 3) {
    const std::size_t k = next_ear(flat, remaining, least_area);
    if (k == remaining.size()) break;
    triangles.push_back(ear_at(remaining, k));
    remaining.erase(remaining.begin() + static_cast<std::ptrdiff_t>(k));
  }
  for (std::size_t k = 1; k + 1 < remaining.size(); ++k)
    triangles.push_back({remaining[0], remaining[k], remaining[k + 1]});
  return triangles;
}

// Reads whole files with a size limit, and computes SHA-256.

std::string file_bytes(const std::string& file, const InputError::Facts& facts, std::uintmax_t largest_bytes)
{
  namespace fs = std::filesystem;
  const auto refuse = [&](const std::string& found) {
    throw InputError({facts.file, facts.field, found, facts.wanted});
  };
  std::error_code error;
  const fs::file_status status = fs::status(file, error);
  if (status.type() == fs::file_type::not_found) refuse("no file \"" + file + "\"");
  if (status.type() == fs::file_type::directory) refuse("the folder \"" + file + "\"");
  if (status.type() != fs::file_type::regular) refuse("\"" + file + "\", which is not a regular file");
  const std::uintmax_t size = fs::file_size(file, error);
  if (error) refuse("\"" + file + "\", which cannot be read (" + error.message() + ")");
  if (size > largest_bytes) {
    throw InputError({facts.file, facts.field, "\"" + file + "\" of " + std::to_string(size) + " bytes",
                      "at most " + std::to_string(largest_bytes)});
  }
  std::ifstream stream(file, std::ios::binary);
  std::string bytes(static_cast<std::size_t>(size), '\0');
  stream.read(bytes.data(), static_cast<std::streamsize>(size));
  if (!stream) refuse("\"" + file + "\", which cannot be read");
  return bytes;
}

std::string sha256_of(std::string_view bytes)
{
  const std::unique_ptr<EVP_MD_CTX, decltype(&EVP_MD_CTX_free)> context(EVP_MD_CTX_new(), &EVP_MD_CTX_free);
  std::array<unsigned char, EVP_MAX_MD_SIZE> digest{};
  unsigned int length = 0;
  const bool is_done = context != nullptr && EVP_DigestInit_ex(context.get(), EVP_sha256(), nullptr) == 1 &&
                       EVP_DigestUpdate(context.get(), bytes.data(), bytes.size()) == 1 &&
                       EVP_DigestFinal_ex(context.get(), digest.data(), &length) == 1;
  check(is_done, "OpenSSL failed to compute a SHA-256");
  constexpr std::string_view hex = "0123456789abcdef";
  std::string out;
  for (unsigned int i = 0; i < length; ++i) {
    out += hex[digest[i] >> 4U];
    out += hex[digest[i] & 15U];
  }
  return out;
}

}  // namespace vrda::job
