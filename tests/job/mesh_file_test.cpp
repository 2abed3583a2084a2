#include <gmock/gmock.h>

#include <algorithm>
#include <bit>
#include <cctype>
#include <cstring>
#include <random>
#include <sstream>

#include "job/clean_mesh.hpp"
#include "job/mesh_file.hpp"
#include "job/mesh_text.hpp"
#include "job/thesis_files.hpp"
#include "model/frames.hpp"
#include "support/meshes.hpp"
#include "support/refusal.hpp"

namespace vrda::mesh_file_test {

Mesh read(const std::string& file, const std::string& bytes)
{
  return job::clean_mesh(job::read_mesh(file, bytes), job::Winding::outward, Side::right).mesh;
}

// Coordinates that floats hold exactly.
Mesh odd_box()
{
  return test::box({0.5, -2.25, 3}, {2, 4, 8});
}

void expect_is_odd_box(const Mesh& mesh)
{
  EXPECT_EQ(mesh.vertices_mm.rows(), 8);
  EXPECT_EQ(mesh.triangles.rows(), 12);
  EXPECT_EQ(bounding_box(mesh).min_mm, Eigen::Vector3d(-0.5, -4.25, -1));
  EXPECT_EQ(bounding_box(mesh).max_mm, Eigen::Vector3d(1.5, -0.25, 7));
  EXPECT_DOUBLE_EQ(signed_volume_mm3(mesh), 64.0);
  EXPECT_EQ(edge_counts(mesh).boundary, 0);
}

std::string edited(std::string text, const std::vector<std::pair<std::string, std::string>>& edits)
{
  for (const auto& [from, to] : edits) {
    EXPECT_NE(text.find(from), std::string::npos) << from;
    for (std::size_t at = text.find(from); at != std::string::npos; at = text.find(from, at + to.size()))
      text.replace(at, from.size(), to);
  }
  return text;
}

std::string upper_case(std::string text)
{
  for (char& c : text) c = static_cast<char>(std::toupper(static_cast<unsigned char>(c)));
  return text;
}

const std::string byte_order_mark = "\xEF\xBB\xBF";

// The box with `form` after every index of a face, such as "//".
std::string wavefront_with_corners(const Mesh& mesh, const std::string& form)
{
  std::string text = test::wavefront(mesh);
  text.resize(text.find("f "));
  for (Eigen::Index t = 0; t < mesh.triangles.rows(); ++t) {
    text += "f";
    for (int k = 0; k < 3; ++k) text += " " + std::to_string(mesh.triangles(t, k) + 1) + form;
    text += "\n";
  }
  return text;
}

// The formats' other forms are in tests/job/vtk_test.py, which writes them by VTK.
std::string vtp_of(const Mesh& box)
{
  std::ostringstream text;
  text << "<?xml version=\"1.0\"?>\n<VTKFile type=\"PolyData\" version=\"0.1\">\n<PolyData>\n<Piece "
          "NumberOfPoints=\"8\" NumberOfPolys=\"12\">\n<Points>\n<DataArray type=\"Float32\" "
          "NumberOfComponents=\"3\" format=\"ascii\">\n"
       << box.vertices_mm
       << "\n</DataArray></Points>\n<Polys><DataArray type=\"Int64\" "
          "Name=\"connectivity\" format=\"ascii\">\n"
       << box.triangles << "\n</DataArray><DataArray type=\"Int32\" Name=\"offsets\" format=\"ascii\">";
  for (int k = 1; k <= 12; ++k) text << 3 * k << ' ';
  text << "</DataArray></Polys>\n</Piece>\n</PolyData>\n</VTKFile>\n";
  return text.str();
}

std::string legacy_vtk_of(const Mesh& box, bool has_offsets)
{
  std::ostringstream text;
  text
      << "# vtk DataFile Version 3.0\nbox\nASCII\nDATASET POLYDATA\nFIELD FieldData 1\nnote 1 1 string\nfree "
         "text\nPOINTS 8 double\n"
      << box.vertices_mm << "\nMETADATA\nINFORMATION 0\n\nLINES 1 3\n2 0 1\nPOLYGONS ";
  if (has_offsets) {
    text << "13 36\nOFFSETS vtktypeint64\n0";
    for (int k = 1; k <= 12; ++k) text << ' ' << 3 * k;
    text << "\nCONNECTIVITY vtktypeint64\n" << box.triangles;
  } else {
    text << "12 48\n";
    for (Eigen::Index t = 0; t < 12; ++t) text << "3 " << box.triangles.row(t) << '\n';
  }
  text << "\nPOINT_DATA 8\nSCALARS s float\nLOOKUP_TABLE default\n0 0 0 0 0 0 0 0\n";
  return text.str();
}

// Each as other programs write it. `note`: a part of the only one of the file; empty: none.
TEST(MeshFile, EveryFormatGivesTheSameBox)
{
  const Mesh box = odd_box();
  const std::string stl = test::ascii_stl(box), obj = test::wavefront(box), ply = test::ascii_ply(box),
                    binary = test::binary_stl(box);
  const std::string no_newline = stl.substr(0, stl.size() - 1);
  struct Row {
    const char* file;
    std::string bytes;
    const char* note = "";
  };
  const std::vector<Row> rows{
      {"a.stl", binary},
      {"solid_header.stl", "solid" + binary.substr(5)},
      {"tail.stl", binary + std::string(92, '\0'), "92 bytes after the last triangle"},
      {"tail_of_facets_size.stl", binary + std::string(100, ' '), "100 bytes after the last triangle"},
      {"solid_tail.stl", "solid" + binary.substr(5) + "xy", "2 bytes after the last triangle"},
      {"b.STL", stl},
      {"upper.stl", upper_case(stl)},
      {"end_solid.stl", edited(stl, {{"endsolid", "end solid"}})},
      {"two_words.stl",
       edited(stl, {{"endsolid", "end solid"}, {"endfacet", "end facet"}, {"endloop", "end loop"}})},
      {"no_newline.stl", edited(no_newline, {{"endsolid", "End Solid"}})},
      {"mark.stl", byte_order_mark + stl},
      {"returns.stl", edited(stl, {{"\n", "\r"}})},
      {"ind.stl", edited(stl, {{"normal -1  0  0", "normal -1.#IND -1.#IND -1.#IND"}})},
      {"qnan.stl", edited(stl, {{"normal -1  0  0", "normal 1.#QNAN 1.#QNAN 1.#QNAN"}})},
      {"comma.stl", edited(stl, {{"normal -1  0  0", "normal -1,5 0 0"}})},
      {"empty_normal.stl", edited(stl, {{"normal -1  0  0", "normal"}})},
      {"no_normal.stl", edited(stl, {{"facet normal -1  0  0", "facet"}})},
      {"mark_binary.stl", byte_order_mark + binary},
      {"dos_end.stl", stl + "\x1a"},
      {"padded.stl", stl + std::string(300, '\0')},
      {"one_line.stl", edited(stl, {{"\n", " "}})},
      {"loop_in_line.stl", edited(stl, {{"outer loop\n", "outer loop "}})},
      {"comments.stl", edited(stl, {{"endloop\n", "endloop\n# a comment\n// another\ncolor 1 0 0\n"}})},
      {"c.ply", ply},
      {"blanks.ply", edited(ply, {{"ply\n", "ply \n"}, {"end_header", "end_header "}})},
      {"ind.ply",
       edited(ply, {{"end_header\n", "element extra 1\nproperty float x\nend_header\n"}}) + "-1.#IND00\n"},
      {"d.ply", test::binary_ply(box)},
      {"mark.ply", byte_order_mark + ply},
      {"binary_mark.ply", byte_order_mark + test::binary_ply(box)},
      {"returns.ply", edited(ply, {{"\n", "\r"}})},
      {"e.obj", obj},
      {"mark.obj", byte_order_mark + obj},
      {"mark_without_comment.obj", byte_order_mark + obj.substr(obj.find('\n') + 1)},
      {"returns.obj", edited(obj, {{"\n", "\r"}})},
      {"slashes.obj", wavefront_with_corners(box, "//")},
      {"texture_slash.obj", "vt 0 0\n" + wavefront_with_corners(box, "/1/")},
      {"zeros.obj", wavefront_with_corners(box, "/0/0")},
      {"mixed.obj", edited("vn 0 0 1\n" + obj, {{"f 1 ", "f 1//1 "}, {" 2\n", " 2//\n"}})},
      {"fo.obj", edited(obj, {{"f ", "fo "}})},
      {"old.obj", "bsp 1 2 3 4\nbsp 1 2 3 4\n" + obj, "\"bsp\" are ignored: 2"},
      {"ind.obj", "vn -1.#IND -1.#IND -1.#IND\n" + wavefront_with_corners(box, "//1"), "normals (vn)"},
      {"f.obj", test::vertices_faces(box, 0)},
      {"g.obj", test::vertices_faces(box, 1)},
      {"h.vf", test::vertices_faces(box, 0)},
      {"i.vtp", vtp_of(box)},
      {"comments.vtp", edited(vtp_of(box), {{"<PolyData>", "<!-- made by code -->\n<PolyData>"}})},
      {"j.vtk", legacy_vtk_of(box, false)},
      {"k.vtk", legacy_vtk_of(box, true)},
      {"returns_and_feeds.vtk", edited(legacy_vtk_of(box, false), {{"\n", "\r\n"}})},
      {"mark.vf", byte_order_mark + test::vertices_faces(box, 0)}};
  for (const Row& row : rows) {
    SCOPED_TRACE(row.file);
    const job::RawMesh raw = job::read_mesh(row.file, row.bytes);
    expect_is_odd_box(job::clean_mesh(raw, job::Winding::outward, Side::right).mesh);
    EXPECT_EQ(raw.notes.empty(), *row.note == '\0');
    for (const std::string& note : raw.notes) EXPECT_THAT(note, testing::HasSubstr(row.note));
  }
}

// Numbers below the least double are 0; a face without all its normals has none.
TEST(MeshFile, TinyNumbersAndMixedNormals)
{
  const job::RawMesh tiny = job::read_mesh("a.obj", "v 1e-400 1e-310 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
  EXPECT_EQ(tiny.vertices.row(0), Eigen::RowVector3d(0, 0, 0));
  const job::RawMesh mixed = job::read_mesh(
      "a.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nvn 1 0 0\nvn 0 1 0\nf 1// 2//1 3//2\nf 1//2 3//2 2//2\n");
  EXPECT_EQ(mixed.normals.topRows(3), Points(Points::Zero(3, 3)));
  EXPECT_EQ(mixed.normals.row(3), Eigen::RowVector3d(0, 1, 0));
}

TEST(MeshFile, PlyNormalsAreRead)
{
  Mesh sheet = test::sheet(4, 1);
  sheet.normals.rowwise() = Eigen::RowVector3d(0.6, 0.8, 0);
  const Mesh mesh = read("a.ply", test::ascii_ply(sheet, true));
  constexpr double float_rounding = 1e-7;
  EXPECT_NEAR(mesh.normals(0, 0), 0.6, float_rounding);
  EXPECT_NEAR(mesh.normals(0, 1), 0.8, float_rounding);
}

TEST(MeshFile, ConcavePolygonsOfBothObjFormatsComeOutRight)
{
  // An L of area 7; a fan from its first corner would exceed its outline.
  const std::string outline = "4 1 0\n1 1 0\n1 4 0\n0 4 0\n0 0 0\n4 0 0\n";
  std::string wavefront;
  for (std::size_t at = 0; at < outline.size(); at = outline.find('\n', at) + 1) {
    wavefront += "v " + outline.substr(at, outline.find('\n', at) + 1 - at);
  }
  for (const std::string& bytes : {wavefront + "f 1 2 3 4 5 6\n", "6 1\n" + outline + "6 0 1 2 3 4 5\n"}) {
    const Mesh mesh = read("l.obj", bytes);
    EXPECT_EQ(mesh.triangles.rows(), 4);
    EXPECT_DOUBLE_EQ(area_mm2(mesh), 7.0);
    for (Eigen::Index t = 0; t < 4; ++t) EXPECT_EQ(face_normal(mesh, t), Eigen::Vector3d(0, 0, 1));
  }
}

TEST(MeshFile, VerticesFacesTakesCommentsAndAnyLayout)
{
  const Mesh mesh = read("v.obj", "# thesis 4.1\n4 2 0 0 0 1 0 0 # two\n1 1 0\n+0 1e0 0\n\n3 0 1 2 3\n0 2 3");
  EXPECT_EQ(mesh.triangles.rows(), 2);
  EXPECT_DOUBLE_EQ(area_mm2(mesh), 1.0);
}

TEST(MeshFile, VerticesFacesCountsFromZeroWhereNeitherEndOccurs)
{
  // Only vertices 1 to 3 of 5 are used, which is ambiguous: the default is 0.
  const job::RawMesh raw = job::read_mesh("v.obj", "5 1\n9 9 9\n0 0 0\n1 0 0\n0 1 0\n8 8 8\n3 1 2 3\n");
  EXPECT_EQ(raw.corner, (std::vector<std::int32_t>{1, 2, 3}));
}

TEST(MeshFileErrors, EveryCutOfEveryFormatIsNoticed)
{
  // Wavefront has no counts: a cut is detectable only if an index or a number is lost.
  const Mesh box = odd_box();
  const std::vector<std::pair<const char*, std::string>> files{{"a.stl", test::binary_stl(box)},
                                                               {"b.stl", test::ascii_stl(box)},
                                                               {"c.ply", test::binary_ply(box)},
                                                               {"f.obj", test::vertices_faces(box, 0)}};
  for (const auto& [file, bytes] : files) {
    for (std::size_t n = 0; n + 22 < bytes.size(); n += 13) {
      SCOPED_TRACE(std::string(file) + " cut to " + std::to_string(n));
      EXPECT_THROW(job::read_mesh(file, bytes.substr(0, n)), InputError);
    }
  }
}

TEST(MeshFile, WavefrontTakesWhatTheFormatAllows)
{
  // Comments, continued lines, weights, textures, normals, negative indices, groups, Windows line ends.
  const std::string bytes =
      "# quad\r\nmtllib none.mtl\r\ng one\r\nv 0 0 0 1.0 # weight\r\nv 1 0 0\r\nvt 0.5\r\nvn 0 0 1\r\n"
      "v 1 1 \\\r\n0\r\nf 1//1 2/1/1 -1//-1\r\nusemtl x\r\ng two\r\nv 0 1 0\r\nf 1/1/1 3//1 4//1\r\nl 1 "
      "2\r\n";
  const Mesh mesh = read("a.obj", bytes);
  EXPECT_EQ(mesh.vertices_mm.rows(), 4);
  EXPECT_EQ(mesh.triangles.rows(), 2);
  EXPECT_DOUBLE_EQ(area_mm2(mesh), 1.0);
  EXPECT_EQ(mesh.normals.row(3), Eigen::RowVector3d(0, 0, 1));
}

// A backslash ends a word: "1 2\" and "3 4" are the corners 1, 2, 3 and 4, not 1, 23 and 4.
TEST(MeshFile, AContinuedWavefrontLineKeepsItsWordsApart)
{
  std::string bytes;
  for (int k = 0; k < 24; ++k)
    bytes += "v " + std::to_string(k) + " " + std::to_string(k * k) + "\\\n" + std::to_string(k % 3) + "\n";
  const Mesh mesh = read("a.obj", bytes + "f 1 2\\\n3 4\nf 5\\\r\n6\\\n7\n");
  EXPECT_EQ(mesh.triangles.rows(), 3);
  EXPECT_EQ(mesh.vertices_mm.rows(), 7);
}

// Two triangles with other elements and properties, in any of the formats.
struct Ply {
  std::string format = "ascii";
  std::string text;

  Ply& header(const std::string& lines)
  {
    text += lines + "\n";
    return *this;
  }
  Ply& put(const std::string& type, double value)
  {
    const bool is_big = format == "binary_big_endian";
    const bool is_real = type == "double" || type == "float";
    if (format == "ascii") {
      text += (is_real ? std::to_string(value) : std::to_string(static_cast<int>(value))) + " ";
    } else if (type == "double") {
      append(std::bit_cast<std::uint64_t>(value), 8, is_big);
    } else if (type == "float") {
      append(std::bit_cast<std::uint32_t>(static_cast<float>(value)), 4, is_big);
    } else {
      append(static_cast<std::uint64_t>(static_cast<std::int64_t>(value)), type == "uchar" ? 1 : 2, is_big);
    }
    return *this;
  }

 private:
  void append(std::uint64_t bits, int n_bytes, bool is_big)
  {
    for (int k = 0; k < n_bytes; ++k)
      text += static_cast<char>(bits >> (8 * (is_big ? n_bytes - 1 - k : k)) & 0xffU);
  }
};

std::string ply_of_a_sheet(const std::string& format)
{
  Ply ply{format, ""};
  ply.header("ply\nformat " + format + " 1.0\ncomment two triangles\nobj_info none");
  ply.header("element camera 1\nproperty list uchar short view");
  ply.header("element vertex 4\nproperty double x\nproperty double y\nproperty double z\nproperty uchar red");
  ply.header("property float nx\nproperty float ny\nproperty float nz");
  ply.header(
      "element face 3\nproperty list uchar float texcoord\nproperty list uchar short "
      "vertex_index\nend_header");
  ply.put("uchar", 2).put("short", -1).put("short", 9);
  for (const double x : {0.0, 1.0}) {
    for (const double y : {0.0, 0.015625}) {
      ply.put("double", x).put("double", y).put("double", -2.5).put("uchar", 99);
      ply.put("float", 0).put("float", 0).put("float", 1);
    }
  }
  for (const auto& face : {std::array{0, 2, 1}, std::array{1, 2, 3}}) {
    ply.put("uchar", 2).put("float", 0).put("float", 1).put("uchar", 3);
    for (const int corner : face) ply.put("short", corner);
  }
  // An edge, which is not a face.
  ply.put("uchar", 0).put("uchar", 2).put("short", 0).put("short", 1);
  return ply.text;
}

TEST(PlyFile, TakesVerticesNormalsAndFacesOutOfWhatIsThere)
{
  for (const char* format : {"ascii", "binary_little_endian", "binary_big_endian"}) {
    SCOPED_TRACE(format);
    const job::RawMesh mesh = job::read_ply("a.ply", ply_of_a_sheet(format));
    Points wanted(4, 3);
    wanted << 0, 0, -2.5, 0, 0.015625, -2.5, 1, 0, -2.5, 1, 0.015625, -2.5;
    EXPECT_EQ(mesh.vertices, wanted);
    EXPECT_EQ(mesh.normals, Points(Eigen::RowVector3d(0, 0, 1).replicate(4, 1)));
    EXPECT_EQ(mesh.corner, (std::vector<std::int32_t>{0, 2, 1, 1, 2, 3}));
    EXPECT_EQ(mesh.size, (std::vector<std::int32_t>{3, 3}));
  }
}

// A strip turns every second triangle; a negative index begins another one.
TEST(PlyFile, StripsOfTrianglesAreReadBesideFaces)
{
  const std::string bytes =
      "ply\nformat ascii 1.0\nelement vertex 7\nproperty float x\nproperty float y\nproperty float z\n"
      "element face 1\nproperty list uchar int vertex_indices\n"
      "element tristrips 1\nproperty list int int vertex_indices\nend_header\n"
      "0 0 0\n1 0 0\n0 1 0\n1 1 0\n0 2 0\n1 2 0\n2 2 0\n3 4 5 6\n9 0 1 2 3 -1 1 3 2 5\n";
  const job::RawMesh mesh = job::read_ply("a.ply", bytes);
  EXPECT_EQ(mesh.size, std::vector<std::int32_t>(5, 3));
  EXPECT_EQ(mesh.corner, (std::vector<std::int32_t>{4, 5, 6, 0, 1, 2, 2, 1, 3, 1, 3, 2, 2, 3, 5}));
}

TEST(PlyFile, elements_come_in_any_order)
{
  const std::string bytes =
      "ply\ncomment knee\nformat ascii 1.0\nelement face 1\nproperty list uchar int vertex_indices\n"
      "element vertex 3\nproperty float x\nproperty float y\nproperty float z\nend_header\n"
      "3 0 1 2\n0 0 0\n1 0 0\n0 1 0\n";
  EXPECT_EQ(job::read_ply("a.ply", bytes).corner, (std::vector<std::int32_t>{0, 1, 2}));
}

TEST(PlyFile, AnElementWithoutPropertiesTakesNoTime)
{
  // 1000 elements with 15,000,000 empty rows each: a loop over the rows would take a minute.
  std::string bytes = "ply\nformat ascii 1.0\n";
  for (int k = 0; k < 1000; ++k) bytes += "element e" + std::to_string(k) + " 15000000\n";
  bytes += "element vertex 0\nproperty float x\nproperty float y\nproperty float z\n";
  bytes += "element face 0\nproperty list uchar int vertex_indices\nend_header\n";
  EXPECT_EQ(job::read_ply("a.ply", bytes).vertices.rows(), 0);
}

// Rounding of a few products of coordinates up to 10.
constexpr double rounding = 1e-12;

Points flat(const std::vector<Eigen::Vector2d>& outline)
{
  Points corners(static_cast<Eigen::Index>(outline.size()), 3);
  for (std::size_t k = 0; k < outline.size(); ++k) {
    corners.row(static_cast<Eigen::Index>(k)) << outline[k].x(), outline[k].y(), 0.0;
  }
  return corners;
}

double outline_area(const std::vector<Eigen::Vector2d>& outline)
{
  double doubled = 0.0;
  for (std::size_t k = 0; k < outline.size(); ++k) {
    const Eigen::Vector2d &a = outline[k], &b = outline[(k + 1) % outline.size()];
    doubled += a.x() * b.y() - a.y() * b.x();
  }
  return 0.5 * doubled;
}

// Crossing number; `p` must not be on the outline.
bool is_inside(const std::vector<Eigen::Vector2d>& outline, const Eigen::Vector2d& p)
{
  bool inside = false;
  for (std::size_t k = 0; k < outline.size(); ++k) {
    const Eigen::Vector2d &a = outline[k], &b = outline[(k + 1) % outline.size()];
    const bool spans = (a.y() > p.y()) != (b.y() > p.y());
    if (spans && p.x() < a.x() + (p.y() - a.y()) / (b.y() - a.y()) * (b.x() - a.x())) inside = !inside;
  }
  return inside;
}

// The triangles have the winding of the outline, are inside it, and their areas add up to its area.
void expect_covers(const std::vector<Eigen::Vector2d>& outline, const Eigen::Matrix3d& R)
{
  const Points corners = flat(outline) * R.transpose();
  const auto triangles = job::triangulate(corners);
  EXPECT_EQ(triangles.size(), outline.size() - 2);
  double area = 0.0;
  for (const auto& t : triangles) {
    const Eigen::Vector2d &a = outline[static_cast<std::size_t>(t[0])],
                          &b = outline[static_cast<std::size_t>(t[1])],
                          &c = outline[static_cast<std::size_t>(t[2])];
    const double doubled = (b - a).x() * (c - a).y() - (b - a).y() * (c - a).x();
    EXPECT_GT(doubled, 0.0);
    EXPECT_TRUE(is_inside(outline, (a + b + c) / 3.0));
    area += 0.5 * doubled;
  }
  EXPECT_NEAR(area, outline_area(outline), rounding);
}

const std::vector<Eigen::Vector2d> l_shape{{0, 0}, {4, 0}, {4, 1}, {1, 1}, {1, 4}, {0, 4}};
const std::vector<Eigen::Vector2d> arrow{{0, 0}, {4, 2}, {0, 4}, {1, 2}};

TEST(Polygon, concave_outlines)
{
  // Also a comb, and a square with extra collinear corners.
  const std::vector<Eigen::Vector2d> comb{{0, 0}, {7, 0}, {7, 3}, {6, 3}, {6, 1},
                                          {5, 1}, {5, 3}, {4, 3}, {4, 1}, {0, 1}};
  const std::vector<Eigen::Vector2d> dotted{{0, 0}, {1, 0}, {2, 0}, {2, 1}, {2, 2}, {1, 2}, {0, 2}, {0, 1}};
  for (std::vector<Eigen::Vector2d> outline : {l_shape, arrow, comb, dotted}) {
    for (std::size_t first = 0; first < outline.size(); ++first) {
      SCOPED_TRACE(first);
      expect_covers(outline, Eigen::Matrix3d::Identity());
      std::rotate(outline.begin(), outline.begin() + 1, outline.end());
    }
  }
}

TEST(Polygon, random_stars)
{
  std::mt19937 random(7);
  int n_concave = 0;
  for (int trial = 0; trial < 50; ++trial) {
    std::vector<Eigen::Vector2d> star;
    for (int k = 0; k < 24; ++k) {
      const Eigen::Vector3d arm =
          rotation_z(0.26 * k) * Eigen::Vector3d(1.0 + static_cast<double>(random() % 1000) / 200.0, 0, 0);
      star.emplace_back(arm.x(), arm.y());
    }
    // 23 x 0.26 = 5.98 rad in all: the outline makes one turn and does not cross itself.
    expect_covers(star, rotation_x(0.1 * trial));
    n_concave += star[1].norm() < 0.5 * (star[0].norm() + star[2].norm()) ? 1 : 0;
  }
  EXPECT_GT(n_concave, 10);
}

TEST(Polygon, triangle_and_line)
{
  EXPECT_EQ(job::triangulate(flat({{0, 0}, {1, 0}, {0, 1}})),
            (std::vector<std::array<std::int32_t, 3>>{{0, 1, 2}}));
  EXPECT_TRUE(job::triangulate(flat({{0, 0}, {1, 0}, {2, 0}, {3, 0}})).empty());
}

// A square and a concave pentagon in one plane, with vertex normals.
job::RawMesh two_polygons()
{
  job::RawMesh mesh;
  mesh.vertices =
      (Points(7, 3) << 0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0, 3, 0, 0, 3, 1, 0, 1.5, 0.5, 0).finished();
  mesh.normals = Points::Zero(7, 3);
  mesh.normals.col(2).setOnes();
  mesh.corner = {0, 1, 2, 3, 1, 4, 5, 2, 6};
  mesh.size = {4, 5};
  return mesh;
}

// Sorted faces; each as the coordinates of its corners, rotated so that the smallest corner is first.
std::vector<std::vector<double>> faces_of(const job::RawMesh& mesh)
{
  std::vector<std::vector<double>> faces;
  std::size_t at = 0;
  for (const std::int32_t n : mesh.size) {
    std::vector<std::array<double, 3>> corners;
    for (std::int32_t k = 0; k < n; ++k, ++at) {
      const auto p = mesh.vertices.row(mesh.corner[at]);
      corners.push_back({p.x(), p.y(), p.z()});
    }
    std::rotate(corners.begin(), std::min_element(corners.begin(), corners.end()), corners.end());
    faces.emplace_back();
    for (const auto& corner : corners) faces.back().insert(faces.back().end(), corner.begin(), corner.end());
  }
  std::sort(faces.begin(), faces.end());
  return faces;
}

job::RawMesh through(const std::string& file, const job::RawMesh& mesh)
{
  return job::merge_equal_vertices(job::read_mesh(file, job::mesh_bytes(file, mesh)));
}

TEST(MeshWriter, two_polygons)
{
  const job::RawMesh mesh = two_polygons();
  EXPECT_EQ(job::vertices_faces_bytes(mesh),
            "7 2\n0 0 0\n1 0 0\n1 1 0\n0 1 0\n3 0 0\n3 1 0\n1.5 0.5 0\n4 0 1 2 3\n5 1 4 5 2 6\n");
  EXPECT_EQ(job::vertex_normals_bytes(mesh), "7\n0 0 1\n0 0 1\n0 0 1\n0 0 1\n0 0 1\n0 0 1\n0 0 1\n");
  for (const std::string file : {"a.vf", "a.obj", "a.ply"}) {
    SCOPED_TRACE(file);
    EXPECT_EQ(faces_of(through(file, mesh)), faces_of(mesh));
  }
}

TEST(MeshWriter, triangles_of_an_stl)
{
  // n - 2 triangles for each polygon; the concave one is inside its outline: area 1 + 1.75.
  const std::string bytes = job::mesh_bytes("a.stl", two_polygons());
  EXPECT_EQ(bytes.size(), 84u + 50u * 5u);
  const job::RawMesh mesh = through("a.stl", two_polygons());
  EXPECT_EQ(mesh.vertices.rows(), 7);
  double area = 0.0;
  for (std::size_t t = 0; t < mesh.size.size(); ++t) {
    const Eigen::Vector3d a = mesh.vertices.row(mesh.corner[3 * t]),
                          b = mesh.vertices.row(mesh.corner[3 * t + 1]),
                          c = mesh.vertices.row(mesh.corner[3 * t + 2]);
    area += 0.5 * (b - a).cross(c - a).z();
  }
  EXPECT_DOUBLE_EQ(area, 1.0 + 1.75);
}

TEST(MeshWriter, normals)
{
  for (const std::string file : {"a.obj", "a.ply"}) {
    const job::RawMesh mesh = through(file, two_polygons());
    ASSERT_EQ(mesh.normals.rows(), 7);
    EXPECT_EQ(mesh.normals.row(6), Eigen::RowVector3d(0, 0, 1));
  }
}

TEST(MeshWriter, doubles)
{
  std::mt19937 random(5);
  job::RawMesh mesh = test::raw_of(test::ball(40, 6, 9));
  for (Eigen::Index v = 0; v < mesh.vertices.rows(); ++v) {
    for (int k = 0; k < 3; ++k) mesh.vertices(v, k) += static_cast<double>(random()) * 1e-11;
  }
  for (const std::string file : {"a.vf", "a.ply"}) EXPECT_EQ(faces_of(through(file, mesh)), faces_of(mesh));
  // The other readers round to float, texts in more than one step: two spacings of a float from 32 to 64.
  constexpr double float_rounding = 2.0 * 64.0 / (1 << 24);
  for (const std::string file : {"a.stl", "a.obj"}) {
    SCOPED_TRACE(file);
    const job::RawMesh back = through(file, mesh);
    ASSERT_EQ(back.vertices.rows(), mesh.vertices.rows());
    Points expected(static_cast<Eigen::Index>(mesh.corner.size()), 3), found = expected;
    for (std::size_t k = 0; k < mesh.corner.size(); ++k) {
      expected.row(static_cast<Eigen::Index>(k)) = mesh.vertices.row(mesh.corner[k]);
      found.row(static_cast<Eigen::Index>(k)) = back.vertices.row(back.corner[k]);
    }
    EXPECT_LE((expected - found).cwiseAbs().maxCoeff(), float_rounding);
  }
}

TEST(MeshWriter, merged_normals)
{
  job::RawMesh mesh = two_polygons();
  mesh.vertices.row(3) = mesh.vertices.row(0);
  mesh.normals.row(3) << 0, 2, 1;
  const job::RawMesh merged = job::merge_equal_vertices(mesh);
  EXPECT_EQ(merged.vertices.rows(), 6);
  EXPECT_EQ(merged.corner, (std::vector<std::int32_t>{0, 1, 2, 0, 1, 3, 4, 2, 5}));
  EXPECT_DOUBLE_EQ(merged.normals(0, 1), std::sqrt(0.5));
  mesh.normals.row(3) << 0, 0, -1;
  EXPECT_EQ(job::merge_equal_vertices(mesh).normals.rows(), 0);
}

TEST(MeshWriter, many_corners)
{
  job::RawMesh mesh;
  constexpr std::int32_t n = 300;
  mesh.vertices.resize(n, 3);
  for (std::int32_t k = 0; k < n; ++k) {
    mesh.vertices.row(k) << k, k * k, 0;  // a convex arc
    mesh.corner.push_back(k);
  }
  mesh.size = {n};
  EXPECT_EQ(faces_of(through("a.ply", mesh)), faces_of(mesh));
}

}  // namespace vrda::mesh_file_test
