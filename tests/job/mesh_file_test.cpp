#include <gmock/gmock.h>

#include <cctype>
#include <cstring>
#include <random>

#include "job/clean_mesh.hpp"
#include "job/mesh_file.hpp"
#include "job/mesh_text.hpp"
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

TEST(MeshFile, every_format)
{
  const Mesh box = odd_box();
  struct Row {
    const char* file;
    std::string bytes;
  };
  const std::vector<Row> rows{
      {"a.stl", test::binary_stl(box)},        {"b.STL", test::ascii_stl(box)},
      {"c.ply", test::ascii_ply(box)},         {"d.ply", test::binary_ply(box)},
      {"e.obj", test::wavefront(box)},         {"f.obj", test::vertices_faces(box, 0)},
      {"g.obj", test::vertices_faces(box, 1)}, {"h.vf", test::vertices_faces(box, 0)}};
  for (const Row& row : rows) {
    SCOPED_TRACE(row.file);
    expect_is_odd_box(read(row.file, row.bytes));
  }
}

TEST(MeshFile, binary_solid)
{
  std::string bytes = test::binary_stl(odd_box());
  bytes.replace(0, 5, "solid");
  expect_is_odd_box(read("a.stl", bytes));
}

TEST(MeshFile, capitals)
{
  std::string bytes = test::ascii_stl(odd_box());
  for (char& c : bytes) c = static_cast<char>(std::toupper(static_cast<unsigned char>(c)));
  expect_is_odd_box(read("a.stl", bytes));
}

TEST(MeshFile, ply_normals)
{
  Mesh sheet = test::sheet(4, 1);
  sheet.normals.rowwise() = Eigen::RowVector3d(0.6, 0.8, 0);
  const Mesh mesh = read("a.ply", test::ascii_ply(sheet, true));
  constexpr double float_rounding = 1e-7;
  EXPECT_NEAR(mesh.normals(0, 0), 0.6, float_rounding);
  EXPECT_NEAR(mesh.normals(0, 1), 0.8, float_rounding);
}

TEST(MeshFile, concave_polygons)
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

TEST(MeshFile, vertices_faces_layout)
{
  const Mesh mesh = read("v.obj", "# thesis 4.1\n4 2 0 0 0 1 0 0 # two\n1 1 0\n+0 1e0 0\n\n3 0 1 2 3\n0 2 3");
  EXPECT_EQ(mesh.triangles.rows(), 2);
  EXPECT_DOUBLE_EQ(area_mm2(mesh), 1.0);
}

TEST(MeshFile, first_index)
{
  // Only vertices 1 to 3 of 5 are used, which is ambiguous: the default is 0.
  const job::RawMesh raw = job::read_mesh("v.obj", "5 1\n9 9 9\n0 0 0\n1 0 0\n0 1 0\n8 8 8\n3 1 2 3\n");
  EXPECT_EQ(raw.corner, (std::vector<std::int32_t>{1, 2, 3}));
}

struct BadFile {
  const char* file;
  std::string bytes;
  std::string field;
  std::string found = {};
  std::string wanted = {};
};

void expect_refused(const BadFile& row)
{
  SCOPED_TRACE(std::string(row.file) + ": " + row.bytes.substr(0, 60));
  const InputError::Facts facts = test::input_error([&] { job::read_mesh(row.file, row.bytes); });
  EXPECT_THAT(facts, test::refuses({row.file, row.field, row.found, row.wanted}));
}

TEST(MeshFileErrors, TruncatedStl)
{
  const std::string binary = test::binary_stl(odd_box()), ascii = test::ascii_stl(odd_box());
  expect_refused({"a.stl", binary.substr(0, 300), "header", "12", "684"});
  expect_refused({"a.stl", binary + "x", "header", "685", "684"});
  expect_refused({"a.stl", binary.substr(0, 40), "", "40", "84"});
  expect_refused({"a.stl", ascii.substr(0, ascii.size() / 2), "", "truncated"});
  // Cut between two facets: only the missing "endsolid" shows it.
  const std::size_t second = ascii.find("facet normal", 100);
  expect_refused({"a.stl", ascii.substr(0, second), "", "1"});
  std::string four = ascii;
  four.insert(four.find(" endloop"), "  vertex 0 0 0\n");
  expect_refused({"a.stl", four, "line 9"});
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

TEST(MeshFileErrors, TruncatedAndLyingPly)
{
  const std::string ascii = test::ascii_ply(odd_box()), binary = test::binary_ply(odd_box());
  expect_refused({"a.ply", ascii.substr(0, 60), "line 5", "\"prope\""});
  expect_refused({"a.ply", ascii.substr(0, ascii.size() - 8), "face 11", "truncated", "12"});
  expect_refused({"a.ply", binary.substr(0, binary.size() - 5), "face 11", "truncated", "12"});
  expect_refused({"a.ply", binary.substr(0, binary.find("end_header") + 20), "vertex 0", "truncated", "8"});
  std::string huge = ascii;
  huge.replace(huge.find("vertex 8"), 8, "vertex 99999999999");
  expect_refused({"a.ply", huge, "line 3", "99999999999"});
  expect_refused({"a.ply", "plx\n", "line 1"});
  expect_refused({"a.ply", "ply\nformat ascii 1.0\n", "line 2", "", "end_header"});
  expect_refused({"a.ply", "ply\nformat weird 1.0\n", "line 2", "\"weird\""});
  expect_refused({"a.ply", "ply\nformat ascii 1.0\nelement vertex 1\nproperty quad x\n", "line 4", "quad"});
  std::string far_index = ascii;
  far_index.replace(far_index.rfind("\n3 ") + 3, 1, "77");
  expect_refused({"a.ply", far_index, "face 11", "77", "8"});
}

TEST(MeshFileErrors, VerticesFacesCountsThatLie)
{
  const std::string body = "0 0 0\n1 0 0\n0 1 0\n";
  expect_refused({"v.obj", "1000000000 1\n" + body + "3 0 1 2\n", "line 1", "1000000000"});
  expect_refused({"v.obj", "3 1000000000\n" + body + "3 0 1 2\n", "line 1", "1000000000"});
  expect_refused({"v.obj", "3 2\n" + body + "3 0 1 2\n", "line 6", "", "1"});
  expect_refused({"v.obj", "4 1\n" + body + "3 0 1 2\n", "line 5", "2", "0"});
  expect_refused({"v.obj", "3 1\n" + body + "3 0 1 2\n3 2 1 0\n", "line 6", "\"3\"", "1"});
  expect_refused({"v.obj", "2 1\n" + body + "3 0 1 2\n", "line 1", "2", "3"});
  expect_refused({"v.obj", "3 0\n" + body, "line 1", "0", "1"});
  expect_refused({"v.obj", "3 1\n" + body + "2 0 1 2\n", "line 5", "2", "3"});
  expect_refused({"v.obj", "3 1\n" + body + "3 0 1 4\n", "line 5", "4", "3"});
  expect_refused({"v.obj", "3 1\n" + body + "3 0 1 -1\n", "line 5", "-1", "3"});
  expect_refused({"v.obj", "3 1\n" + body + "3 0 1 3\n", "line 5", "0", "3"});
  expect_refused({"v.obj", "3 1\n0 0 0\n1 zero 0\n0 1 0\n3 0 1 2\n", "line 3", "\"zero\"", "1"});
}

TEST(MeshFile, wavefront_syntax)
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
TEST(MeshFile, continued_line)
{
  std::string bytes;
  for (int k = 0; k < 24; ++k)
    bytes += "v " + std::to_string(k) + " " + std::to_string(k * k) + "\\\n" + std::to_string(k % 3) + "\n";
  const Mesh mesh = read("a.obj", bytes + "f 1 2\\\n3 4\nf 5\\\r\n6\\\n7\n");
  EXPECT_EQ(mesh.triangles.rows(), 3);
  EXPECT_EQ(mesh.vertices_mm.rows(), 7);
}

TEST(MeshFileErrors, WavefrontLines)
{
  const std::string three = "v 0 0 0\nv 1 0 0\nv 0 1 0\n";
  expect_refused({"a.obj", "v 0 0\n", "line 1", "2", "3"});
  expect_refused({"a.obj", "v 0 zero 0\n", "line 1", "\"zero\""});
  expect_refused({"a.obj", three + "f 1 2\n", "line 4", "2", "3"});
  expect_refused({"a.obj", three + "f 1 2 0\n", "line 4", "\"0\"", "3"});
  expect_refused({"a.obj", three + "f 1 2 -4\n", "line 4", "\"-4\"", "3"});
  expect_refused({"a.obj", three + "f 1//1 2//1 3//1\n", "line 4", "1", "0"});
  expect_refused({"a.obj", three + "curv2 1 2\n", "line 4", "\"curv2\""});
  expect_refused({"a.obj", three + "f 1 2 3\nf 1 2 3\\", "line 5", "backslash"});
}

TEST(MeshFileErrors, AsciiStlLines)
{
  const std::string ascii = test::ascii_stl(odd_box());
  const auto with = [&](const std::string& old_text, const std::string& new_text) {
    std::string bytes = ascii;
    return bytes.replace(bytes.find(old_text), old_text.size(), new_text);
  };
  expect_refused({"a.stl", with("vertex  -0.5", "vertex x.5"), "line 4"});
  expect_refused({"a.stl", with("normal -1  0", "normal -1"), "line 2"});
  expect_refused({"a.stl", with("outer loop", "hello"), "line 3", "\"hello\""});
  // assimp corrupts memory with these: endsolid or facet within a facet.
  expect_refused({"a.stl", with("outer loop", "endsolid"), "line 3", "\"endsolid\""});
  expect_refused({"a.stl", with("outer loop", "facet"), "line 3", "\"facet\""});
  expect_refused({"a.stl", "solid a\nsolid b\n", "line 2", "\"solid\""});
  expect_refused({"a.stl", "solid a\nendsolid a\nfacet normal 0 0 1\n", "line 3", "\"facet\""});
  expect_refused({"a.stl", "solid a\nvertex 0 0 0\n", "line 2", "\"vertex\""});
}

TEST(MeshFileErrors, PlyPropertiesAndNumbers)
{
  const std::string ascii = test::ascii_ply(odd_box());
  const auto with = [&](const std::string& old_text, const std::string& new_text) {
    std::string bytes = ascii;
    return bytes.replace(bytes.find(old_text), old_text.size(), new_text);
  };
  expect_refused({"a.ply", with("float y", "float q"), "header"});
  expect_refused({"a.ply", with("vertex_indices", "corners"), "header", "vertex_indices"});
  expect_refused({"a.ply", with("-4.25", "-4_25"), "vertex 0", "damaged", "8"});
}

TEST(MeshFileErrors, VerticesThatAreNotFinite)
{
  const std::string faces = "3 0 1 2\n";
  expect_refused({"v.obj", "3 1\n0 0 0\nnan 0 0\n0 1 0\n" + faces, "vertex 1", "(nan, 0, 0)"});
  expect_refused({"v.obj", "3 1\n0 0 0\n1 0 0\n0 -inf 0\n" + faces, "vertex 2", "(0, -inf, 0)"});
  expect_refused({"v.obj", "3 1\n0 0 0\n1 0 0\n0 1.5e9 0\n" + faces, "vertex 2", "(0, 1.5e+09, 0)", "1e9"});
  std::string stl = test::binary_stl(odd_box());
  constexpr float not_a_number = std::numeric_limits<float>::quiet_NaN();
  std::memcpy(stl.data() + 84 + 50 + 12 + 24, &not_a_number, sizeof not_a_number);  // facet 1, third corner
  expect_refused({"a.stl", stl, "vertex 5", "nan"});
  expect_refused({"a.obj", "v 0 0 0\nv nan 0 0\nv 0 1 0\nf 1 2 3\n", "vertex 1", "nan"});
}

TEST(MeshFileErrors, EmptyMeshesAndForeignFiles)
{
  expect_refused({"a.stl", "", "", "an empty file"});
  expect_refused({"a.stl", std::string(84, '\0'), "header"});
  expect_refused({"a.stl", "solid x\nendsolid x\n", "", "an empty mesh"});
  expect_refused({"a.obj", "# nothing here at all\n", "", "an empty mesh"});
  expect_refused({"a.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\n", "", "3"});
  expect_refused({"a.fbx", "x", "", "\".fbx\""});
  expect_refused({"a", "x", "", "extension"});
  // The content is checked too: another format with this extension is refused.
  expect_refused({"a.ply", test::ascii_stl(odd_box()), "line 1"});
  expect_refused({"a.stl", test::ascii_ply(odd_box()), "header"});
  expect_refused({"a.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 9\n", "line 4", "9", "3"});
}

TEST(MeshFileErrors, APolygonOfAThousandAndOneCornersIsRefused)
{
  std::string bytes = "1001 1\n", face = "1001";
  for (int k = 0; k < 1001; ++k) {
    bytes += std::to_string(k) + " " + std::to_string(k * k) + " 0\n";
    face += " " + std::to_string(k);
  }
  expect_refused({"v.obj", bytes + face + "\n", "line 1003", "1001", "1000"});
}

}  // namespace vrda::mesh_file_test
