#include "job/clean_mesh.hpp"

#include <gtest/gtest.h>

#include "job/mesh_text.hpp"

namespace vrda::clean_mesh_test {

Mesh reversed(Mesh mesh)
{
  mesh.triangles.col(1).swap(mesh.triangles.col(2));
  return mesh;
}

TEST(CleanMesh, welded_soup)
{
  const Mesh ball = test::ball(10, 8, 12);
  const job::CleanMesh clean = job::clean_mesh(test::soup_of(ball), job::Winding::outward, Side::right);
  EXPECT_EQ(clean.mesh.vertices_mm.rows(), ball.vertices_mm.rows());
  EXPECT_EQ(clean.n_welded, 3 * ball.triangles.rows() - ball.vertices_mm.rows());
  EXPECT_EQ(clean.n_degenerate, 0);
  EXPECT_FALSE(clean.was_flipped);
  EXPECT_EQ(edge_counts(clean.mesh).boundary, 0);
  EXPECT_DOUBLE_EQ(signed_volume_mm3(clean.mesh), signed_volume_mm3(ball));
}

TEST(CleanMesh, minus_zero)
{
  job::RawMesh raw = test::raw_of(test::sheet(2, 1));
  raw.vertices.col(1).setConstant(-0.0);
  const job::CleanMesh clean = job::clean_mesh(raw, job::Winding::outward, Side::right);
  EXPECT_FALSE(std::signbit(clean.mesh.vertices_mm(0, 1)));
}

TEST(CleanMesh, degenerate_faces)
{
  job::RawMesh raw = test::raw_of(test::box({0, 0, 0}, {2, 2, 2}));
  raw.vertices.conservativeResize(10, 3);
  raw.vertices.row(8) << 5, 5, 5;                                            // unused
  raw.vertices.row(9) << -1, -1, -1;                                         // the same position as vertex 0
  for (const std::int32_t corner : {0, 9, 1}) raw.corner.push_back(corner);  // two corners at one position
  raw.size.push_back(3);
  for (const std::int32_t corner : {0, 1, 0, 1}) raw.corner.push_back(corner);  // a polygon without area
  raw.size.push_back(4);
  const job::CleanMesh clean = job::clean_mesh(raw, job::Winding::outward, Side::right);
  EXPECT_EQ(clean.n_degenerate, 2);
  EXPECT_EQ(clean.n_welded, 1);
  EXPECT_EQ(clean.mesh.vertices_mm.rows(), 8);
  EXPECT_EQ(clean.mesh.triangles.rows(), 12);
  EXPECT_DOUBLE_EQ(signed_volume_mm3(clean.mesh), 8.0);
}

TEST(CleanMesh, points_on_a_line)
{
  job::RawMesh raw;
  raw.vertices.resize(4, 3);
  raw.vertices << 0, 0, 0, 1, 1, 1, 2, 2, 2, 0, 1, 0;
  raw.corner = {0, 1, 2, 0, 2, 3};
  raw.size = {3, 3};
  const job::CleanMesh clean = job::clean_mesh(raw, job::Winding::outward, Side::right);
  EXPECT_EQ(clean.n_degenerate, 1);
  EXPECT_EQ(clean.mesh.triangles.rows(), 1);
  EXPECT_EQ(clean.mesh.vertices_mm.rows(), 3);
}

TEST(CleanMesh, open_sheet)
{
  const Mesh sheet = test::sheet(10, 3);  // normal +Y
  const job::CleanMesh as_is = job::clean_mesh(test::raw_of(sheet), job::Winding::outward, Side::right);
  const job::CleanMesh turned = job::clean_mesh(test::raw_of(sheet), job::Winding::inward, Side::right);
  EXPECT_FALSE(as_is.was_flipped);
  EXPECT_TRUE(turned.was_flipped);
  EXPECT_EQ(as_is.mesh.normals.row(4), Eigen::RowVector3d(0, 1, 0));
  EXPECT_EQ(turned.mesh.normals.row(4), Eigen::RowVector3d(0, -1, 0));
}

TEST(CleanMesh, separate_shells)
{
  Mesh both = test::box({0, 0, 0}, {2, 2, 2});
  append(both, reversed(test::box({2, 2, 2}, {2, 2, 2})));  // a common corner does not connect them
  const job::CleanMesh clean = job::clean_mesh(test::raw_of(both), job::Winding::outward, Side::right);
  EXPECT_TRUE(clean.was_flipped);
  EXPECT_DOUBLE_EQ(signed_volume_mm3(clean.mesh), 16.0);
}

TEST(CleanMesh, inner_wall)
{
  // Outer box 4^3, cavity 2^3, with correct and with reversed winding.
  Mesh hollow = test::box({0, 0, 0}, {4, 4, 4});
  append(hollow, reversed(test::box({0, 0, 0}, {2, 2, 2})));
  EXPECT_DOUBLE_EQ(
      signed_volume_mm3(job::clean_mesh(test::raw_of(hollow), job::Winding::outward, Side::right).mesh),
      56.0);
  const job::CleanMesh turned =
      job::clean_mesh(test::raw_of(reversed(hollow)), job::Winding::outward, Side::right);
  EXPECT_TRUE(turned.was_flipped);
  EXPECT_DOUBLE_EQ(signed_volume_mm3(turned.mesh), 56.0);
}

TEST(CleanMesh, nested_solids)
{
  Mesh nested = test::box({0, 0, 0}, {4, 4, 4});
  append(nested, test::box({0, 0, 0}, {2, 2, 2}));
  EXPECT_DOUBLE_EQ(
      signed_volume_mm3(
          job::clean_mesh(test::raw_of(reversed(nested)), job::Winding::outward, Side::right).mesh),
      72.0);
}

// Copies of triangles (the same three vertices) say nothing new, in either winding and wherever they are.
TEST(CleanMesh, copies_of_triangles)
{
  const Mesh ball = test::ball(10, 8, 12);
  const job::CleanMesh clean = job::clean_mesh(test::soup_of(ball), job::Winding::outward, Side::right);
  const Mesh some = select_triangles(ball, {3, 4, 5, 50, 90}), all = ball;
  const auto joined = [](Mesh first, const Mesh& second) {
    append(first, second);
    return first;
  };
  struct Row {
    const char* name;
    Mesh mesh;
    Eigen::Index n_copies;
  };
  for (const Row& row : {Row{"same", joined(ball, some), 5}, Row{"reversed", joined(ball, reversed(some)), 5},
                         Row{"reversed ones first", joined(reversed(some), ball), 5},
                         Row{"twice", joined(joined(ball, reversed(some)), some), 10},
                         Row{"all reversed", joined(ball, reversed(all)), all.triangles.rows()}}) {
    SCOPED_TRACE(row.name);
    const job::CleanMesh found = job::clean_mesh(test::soup_of(row.mesh), job::Winding::outward, Side::right);
    EXPECT_EQ(found.n_identical, row.n_copies);
    EXPECT_EQ(found.mesh.vertices_mm, clean.mesh.vertices_mm);
    EXPECT_EQ(found.mesh.triangles, clean.mesh.triangles);
    EXPECT_EQ(found.mesh.normals, clean.mesh.normals);
  }
}

// A copy of a polygon that begins with another corner would be divided along the other diagonal.
TEST(CleanMesh, copies_of_polygons)
{
  job::RawMesh raw;
  raw.vertices.resize(4, 3);
  raw.vertices << 0, 0, 0, 1, 0, 0, 1, 0, -1, 0, 0, -1;
  raw.corner = {0, 1, 2, 3, 1, 2, 3, 0, 3, 2, 1, 0};
  raw.size = {4, 4, 4};
  const job::CleanMesh clean = job::clean_mesh(raw, job::Winding::outward, Side::right);
  EXPECT_EQ(clean.n_identical, 4);
  EXPECT_EQ(clean.mesh.triangles.rows(), 2);
  EXPECT_EQ(clean.mesh.normals.row(0), Eigen::RowVector3d(0, 1, 0));
}

// The volume decides whatever the job says; one hole or one odd face does not hide the outside.
TEST(CleanMesh, a_shell_is_turned_outward)
{
  const Mesh ball = test::ball(10, 16, 24);
  std::vector<Eigen::Index> around;  // all but a cap of an eighth of the height
  for (Eigen::Index t = 0; t < ball.triangles.rows(); ++t) {
    if (corners(ball, t)[0].y() < 7.5) around.push_back(t);
  }
  Mesh odd = ball;
  std::swap(odd.triangles(100, 1), odd.triangles(100, 2));
  std::vector<Eigen::Index> all_but_one = job::others_than(ball, {{77}});
  for (const Mesh& mesh : {ball, select_triangles(ball, all_but_one), select_triangles(ball, around), odd}) {
    for (const job::Winding winding : {job::Winding::outward, job::Winding::inward}) {
      const job::CleanMesh kept = job::clean_mesh(test::raw_of(mesh), winding, Side::right);
      const job::CleanMesh turned = job::clean_mesh(test::raw_of(reversed(mesh)), winding, Side::right);
      EXPECT_FALSE(kept.was_flipped || kept.has_sheet);
      EXPECT_TRUE(turned.was_flipped);
      EXPECT_DOUBLE_EQ(signed_volume_mm3(turned.mesh), signed_volume_mm3(kept.mesh));
      EXPECT_GT(signed_volume_mm3(turned.mesh), 0.0);
    }
  }
}

// An inner wall of either winding, also of bodies with a hole, cannot be reached; what lies outside can.
TEST(Shells, outer_surface)
{
  const Mesh outer = test::ball(10, 16, 24), wall = test::ball(7, 16, 24);
  Mesh beside = test::ball(3);
  beside.vertices_mm.col(0).array() += 20.0;
  const Mesh torn = job::compacted(outer, job::others_than(outer, {{77}}));
  for (const Mesh& body : {outer, torn}) {
    for (const Mesh& inner :
         {wall, reversed(wall), job::compacted(wall, job::others_than(wall, {{5, 6, 7}}))}) {
      Mesh mesh = body, expected = body;
      append(mesh, inner);
      append(mesh, beside);
      append(expected, beside);
      const Mesh found = job::outer_surface(mesh);
      EXPECT_EQ(found.vertices_mm, expected.vertices_mm);
      EXPECT_EQ(found.triangles, expected.triangles);
    }
  }
}

TEST(CleanMesh, normals_of_a_file)
{
  const Mesh ball = test::ball(10, 8, 12);
  job::RawMesh raw = test::raw_of(ball);
  raw.normals = -3.0 * ball.normals;  // neither unit nor outward
  const job::CleanMesh clean = job::clean_mesh(raw, job::Winding::outward, Side::right);
  // On a ball about the origin the normal is the vertex by its radius; rounding of a division.
  EXPECT_LT((clean.mesh.normals - clean.mesh.vertices_mm / 10.0).cwiseAbs().maxCoeff(), 1e-14);
  raw.normals.row(3).setZero();
  EXPECT_EQ(job::clean_mesh(raw, job::Winding::outward, Side::right).mesh.normals,
            vertex_normals(clean.mesh));
}

TEST(CleanMesh, mirrored_soup)
{
  Mesh ball = test::ball(7.3, 9, 13);
  ball.vertices_mm.col(2).array() += 1.7;
  const Mesh expected =
      mirrored_z(job::clean_mesh(test::soup_of(ball), job::Winding::outward, Side::right).mesh);
  // With reversed winding, and with z negated only.
  Mesh negated = ball;
  negated.vertices_mm.col(2) *= -1.0;
  for (const Mesh& mirrored : {mirrored_z(ball), negated}) {
    const Mesh mesh = job::clean_mesh(test::soup_of(mirrored), job::Winding::outward, Side::left).mesh;
    EXPECT_EQ(mesh.vertices_mm, expected.vertices_mm);
    EXPECT_EQ(mesh.triangles, expected.triangles);
    EXPECT_EQ(mesh.normals, expected.normals);
  }
}

}  // namespace vrda::clean_mesh_test
