// What a file is by its first bytes, for messages about refused meshes; byte order marks and line ends.
#include <algorithm>
#include <array>

#include "core/text.hpp"
#include "job/job.hpp"
#include "job/mesh_file.hpp"

namespace vrda::job {
namespace {

using namespace std::literals;

constexpr const char* decompress = "a mesh: decompress the file first";
constexpr const char* unpack = "a mesh: unpack the archive first";
constexpr const char* save_utf8 = "a mesh: save the file as plain text in UTF-8 or ASCII";
constexpr const char* download = "a mesh: download the file itself, not the page that shows it";
constexpr const char* convert = "a mesh: convert the file, for example to STL or PLY";
constexpr const char* segment = "a mesh: export the surface of a segmentation, for example as STL";

struct Signature {
  std::size_t offset;      // 0: also after white space
  std::string_view bytes;  // letters in lower case, for either case
  const char* name;
  const char* remedy;
  const char* extension = "";  // of a format that is read
};

// The first that matches counts.
constexpr Signature signatures[] = {
    {0, "\x1f\x8b"sv, "gzip-compressed data", decompress},
    {0, "bzh"sv, "bzip2-compressed data", decompress},
    {0, "\xfd\x37zxz"sv, "xz-compressed data", decompress},
    {0, "\x28\xb5\x2f\xfd"sv, "zstd-compressed data", decompress},
    {0, "pk\x03\x04"sv, "a zip archive", unpack},
    {0, "7z\xbc\xaf"sv, "a 7z archive", unpack},
    {0, "rar!"sv, "a RAR archive", unpack},
    {257, "ustar"sv, "a tar archive", unpack},
    {0, "\xff\xfe\0\0"sv, "text in UTF-32", save_utf8},
    {0, "\0\0\xfe\xff"sv, "text in UTF-32", save_utf8},
    {0, "\xff\xfe"sv, "text in UTF-16", save_utf8},
    {0, "\xfe\xff"sv, "text in UTF-16", save_utf8},
    {0, "version https://"sv, "a Git LFS pointer, not the file itself", "a mesh: get it with git lfs pull"},
    {0, "/annex/objects/"sv, "a git-annex pointer, not the file itself", "a mesh: get it with git annex get"},
    {0, "<!doctype html"sv, "an HTML page", download},
    {0, "# vtk datafile"sv, "a legacy VTK file", "", ".vtk"},
    {0, "ply\n"sv, "a PLY file", "", ".ply"},
    {0, "ply\r"sv, "a PLY file", "", ".ply"},
    {0, "off\n"sv, "an OFF file", convert},
    {0, "off\r"sv, "an OFF file", convert},
    {0, "iso-10303-21"sv, "a STEP file", convert},
    {0, "gltf"sv, "a glTF file", convert},
    {0, "kaydara fbx"sv, "an FBX file", convert},
    {0, "\x89hdf"sv, "an HDF5 file", convert},
    {0, "matlab 5.0 mat"sv, "a MATLAB file", convert},
    {0, "nrrd0"sv, "an NRRD image", segment},
    {0, "objecttype ="sv, "a MetaImage header", segment},
    {128, "dicm"sv, "a DICOM file", segment},
    {344, "n+1\0"sv, "a NIfTI image", segment},
    {0, "%pdf"sv, "a PDF document", "a mesh"},
    {0, "\x89png"sv, "a PNG image", "a mesh"},
    {0, "\xff\xd8\xff"sv, "a JPEG image", "a mesh"},
    {0, "{"sv, "JSON text", convert},
    {0, "<"sv, "an XML file", convert},
};

FileContent mesh_content(const char* name, const std::string& extension)
{
  return {name, extension, "a file in the format of its extension; that of this content is " + extension};
}

// Every second byte is zero, and the others are text.
bool is_utf16(std::string_view bytes)
{
  const std::string_view head = bytes.substr(0, 512);
  if (head.size() < 16) return false;
  for (const std::size_t first : {0U, 1U}) {
    bool is_all = true;
    for (std::size_t k = 0; k + 1 < head.size(); k += 2) {
      const char text = head[k + first], zero = head[k + 1 - first];
      is_all = is_all && zero == '\0' && (text >= ' ' || is_space(text));
    }
    if (is_all) return true;
  }
  return false;
}

// A vertex of three numbers is the first line that is neither a comment nor about groups and materials.
bool is_wavefront(std::string_view text)
{
  constexpr std::array<std::string_view, 9> before{"g",  "o",  "s",  "mtllib", "usemtl",
                                                   "vn", "vt", "mg", "lod"};
  for (const TableLine& line : table_lines(text)) {
    const std::vector<std::string_view> words = split_words(line.text);
    if (words[0] == "v") return words.size() >= 4 && parse_real(words[1]) && parse_real(words[3]);
    if (std::ranges::find(before, words[0]) == before.end()) return false;
  }
  return false;
}

// Two counts, then a vertex of three numbers.
bool has_vertices_faces(std::string_view text)
{
  const std::vector<TableLine> lines = table_lines(text);
  if (lines.size() < 2 || split_words(lines[0].text).size() != 2) return false;
  std::vector<std::string_view> words = split_words(lines[0].text);
  const bool has_counts = parse_integer(words[0]) && parse_integer(words[1]);
  words = split_words(lines[1].text);
  return has_counts && words.size() == 3 && parse_real(words[0]) && parse_real(words[2]);
}

}  // namespace

FileContent content_of(std::string_view bytes)
{
  if (bytes.starts_with(byte_order_mark)) bytes.remove_prefix(byte_order_mark.size());
  if (is_binary_stl(bytes)) return mesh_content("a binary STL file", ".stl");
  const std::string_view head = bytes.substr(0, 4096);
  const std::string text = lower_case(std::string(trimmed(head)));
  // A declaration and comments may be before the first element.
  if (text.starts_with('<') && text.find("<vtkfile") != text.npos)
    return mesh_content("a VTK XML file", ".vtp");
  if (text.starts_with('<') && text.find("<html") != text.npos) return {"an HTML page", "", download};
  for (const Signature& s : signatures) {
    const bool is_found =
        s.offset == 0 ? text.starts_with(s.bytes)
                      : lower_case(std::string(head)).substr(0, s.offset + s.bytes.size()).ends_with(s.bytes);
    if (!is_found) continue;
    return *s.extension == '\0' ? FileContent{s.name, "", s.remedy} : mesh_content(s.name, s.extension);
  }
  if (is_utf16(head)) return {"text in UTF-16", "", save_utf8};
  if (is_ascii_stl(bytes) && text.find("facet") != text.npos)
    return mesh_content("an ASCII STL file", ".stl");
  if (is_wavefront(head)) return mesh_content("a Wavefront OBJ file", ".obj");
  if (has_vertices_faces(head)) return mesh_content("a Vertices-Faces file", ".vf");
  return {};
}

void require_table(const std::string& file, std::string_view bytes)
{
  const FileContent content = content_of(bytes);
  if (!content.name.empty() && content.extension.empty())
    throw InputError({file, "", content.name, "a table as plain text in UTF-8 or ASCII, such as CSV"});
}

void normalise_text(std::string& bytes)
{
  // Texts of some programs are padded; a binary STL file has zeros elsewhere, too.
  const std::size_t n_used = bytes.find_last_not_of('\0') + 1;
  if (lower_case(bytes.substr(0, 5)) == "solid" && bytes.find('\0') >= n_used) bytes.resize(n_used);
  const bool has_mark = bytes.starts_with(byte_order_mark);
  const std::string_view text = std::string_view(bytes).substr(has_mark ? byte_order_mark.size() : 0);
  const bool is_ply = text.starts_with("ply");
  const bool is_binary = !is_ply && text.find('\0') != text.npos;
  std::size_t end = text.size();
  if (is_ply) end = std::min(text.find("end_header\r"), text.size());
  if (is_ply && end < text.size()) end += "end_header\r"sv.size();
  const bool has_returns_only = !is_binary && text.substr(0, end).find('\n') == text.npos;
  if (has_mark) bytes.erase(0, byte_order_mark.size());
  if (!is_ply && !is_binary && bytes.ends_with('\x1a')) bytes.pop_back();
  if (has_returns_only)
    std::replace(bytes.begin(), bytes.begin() + static_cast<std::ptrdiff_t>(end), '\r', '\n');
}

}  // namespace vrda::job
