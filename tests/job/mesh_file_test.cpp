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

TEST(MeshFile, EveryFormatGivesTheSameBox)
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

TEST(MeshFile, ABinaryStlWhoseHeaderBeginsWithSolidIsStillBinary)
{
  std::string bytes = test::binary_stl(odd_box());
  bytes.replace(0, 5, "solid");
  expect_is_odd_box(read("a.stl", bytes));
}

TEST(MeshFile, AnAsciiStlMayShout)
{
  std::string bytes = test::ascii_stl(odd_box());
  for (char& c : bytes) c = static_cast<char>(std::toupper(static_cast<unsigned char>(c)));
  expect_is_odd_box(read("a.stl", bytes));
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

}  // namespace vrda::mesh_file_test
