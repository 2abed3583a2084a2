#include "job/thesis_files.hpp"

#include <gmock/gmock.h>

#include <algorithm>
#include <random>

#include "job/mesh_text.hpp"

namespace vrda::mesh_writer_test {

// A square and a concave pentagon in one plane, with vertex normals.
job::RawMesh polygons()
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

TEST(MeshWriter, polygons)
{
  const job::RawMesh mesh = polygons();
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
  const std::string bytes = job::mesh_bytes("a.stl", polygons());
  EXPECT_EQ(bytes.size(), 84u + 50u * 5u);
  const job::RawMesh mesh = through("a.stl", polygons());
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
    const job::RawMesh mesh = through(file, polygons());
    ASSERT_EQ(mesh.normals.rows(), 7);
    EXPECT_EQ(mesh.normals.row(6), Eigen::RowVector3d(0, 0, 1));
  }
}

TEST(MeshWriter, every_pair_of_formats)
{
  // Float coordinates are restored exactly through every pair of formats.
  job::RawMesh mesh = test::raw_of(test::ball(7.3, 6, 9));
  mesh.vertices = mesh.vertices.cast<float>().cast<double>().eval();
  const auto faces = faces_of(mesh);
  for (const std::string first : {"a.vf", "a.stl", "a.obj", "a.ply"}) {
    for (const std::string second : {"b.vf", "b.stl", "b.obj", "b.ply"}) {
      SCOPED_TRACE(testing::Message() << first << " to " << second);
      const job::RawMesh back = through(second, through(first, mesh));
      EXPECT_EQ(back.vertices.rows(), mesh.vertices.rows());
      EXPECT_EQ(faces_of(back), faces);
    }
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
  job::RawMesh mesh = polygons();
  mesh.vertices.row(3) = mesh.vertices.row(0);
  mesh.normals.row(3) << 0, 2, 1;
  const job::RawMesh merged = job::merge_equal_vertices(mesh);
  EXPECT_EQ(merged.vertices.rows(), 6);
  EXPECT_EQ(merged.corner, (std::vector<std::int32_t>{0, 1, 2, 0, 1, 3, 4, 2, 5}));
  EXPECT_DOUBLE_EQ(merged.normals(0, 1), std::sqrt(0.5));
  mesh.normals.row(3) << 0, 0, -1;
  EXPECT_EQ(job::merge_equal_vertices(mesh).normals.rows(), 0);
}

TEST(MeshWriterErrors, OtherExtensionsAndWhatAnStlCannotHold)
{
  job::RawMesh mesh = polygons();
  EXPECT_THAT(test::input_error([&] { job::mesh_bytes("a.fbx", mesh); }),
              test::refuses({"a.fbx", "", "\".fbx\""}));
  mesh.vertices(4, 0) = 1e39;
  EXPECT_THAT(test::input_error([&] { job::mesh_bytes("a.stl", mesh); }),
              test::refuses({.field = "vertex 4", .wanted = "single precision"}));
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

}  // namespace vrda::mesh_writer_test
