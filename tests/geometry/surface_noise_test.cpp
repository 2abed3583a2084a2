#include "geometry/surface_noise.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <random>

#include "geometry/generated_knee.hpp"
#include "job/clean_mesh.hpp"
#include "job/job.hpp"
#include "job/mesh_file.hpp"
#include "support/meshes.hpp"
#include "support/real_knees.hpp"

namespace vrda::surface_noise_test {

using geometry::SmoothedSurface;
using geometry::SurfaceNoise;

constexpr double radius_mm = 25.0;

// Vertices moved along their normals.
Mesh with_noise(Mesh mesh, double noise_mm, std::uint32_t seed = 1)
{
  std::mt19937 random(seed);
  std::normal_distribution<double> across_mm(0.0, noise_mm);
  for (Eigen::Index v = 0; v < mesh.vertices_mm.rows(); ++v)
    mesh.vertices_mm.row(v) += across_mm(random) * mesh.normals.row(v);
  return mesh;
}

double rms(const Eigen::ArrayXd& values)
{
  return std::sqrt(values.square().mean());
}

double off_sphere_mm(const Mesh& mesh)
{
  return rms(mesh.vertices_mm.rowwise().norm().array() - radius_mm);
}

double volume_change(const Mesh& mesh, const Mesh& before)
{
  return std::abs(signed_volume_mm3(mesh) / signed_volume_mm3(before) - 1.0);
}

// A box of n x n quads a face, welded.
Mesh divided_box(double size_mm, int n)
{
  job::RawMesh raw;
  const Mesh sheet = test::sheet(size_mm, n);
  for (int axis = 0; axis < 3; ++axis) {
    for (const double side : {1.0, -1.0}) {
      const auto first = static_cast<std::int32_t>(raw.vertices.rows());
      raw.vertices.conservativeResize(first + sheet.vertices_mm.rows(), 3);
      for (Eigen::Index v = 0; v < sheet.vertices_mm.rows(); ++v) {
        const Eigen::RowVector3d p = sheet.vertices_mm.row(v);
        Eigen::RowVector3d q;
        q[axis] = side * 0.5 * size_mm;
        q[(axis + 1) % 3] = p.z();
        q[(axis + 2) % 3] = side * p.x();
        raw.vertices.row(first + v) = q;
      }
      for (const std::int32_t corner : sheet.triangles.reshaped<Eigen::RowMajor>())
        raw.corner.push_back(first + corner);
      raw.size.insert(raw.size.end(), static_cast<std::size_t>(sheet.triangles.rows()), 3);
    }
  }
  return job::clean_mesh(raw, job::Winding::outward, Side::right).mesh;
}

TEST(SurfaceNoise, known_noise_of_a_sphere)
{
  for (const int rings : {32, 64}) {
    const Mesh ball = test::ball(radius_mm, rings, 2 * rings);
    EXPECT_FALSE(geometry::surface_noise(ball).is_noisy());
    for (const double noise_mm : {0.25, 0.5, 1.0}) {
      const SurfaceNoise found = geometry::surface_noise(with_noise(ball, noise_mm));
      EXPECT_NEAR(found.noise_mm, noise_mm, 0.15 * noise_mm) << rings;
      EXPECT_TRUE(found.is_noisy()) << rings << ' ' << noise_mm;
    }
  }
}

// Curvature, edges and few triangles are no noise.
TEST(SurfaceNoise, clean_meshes)
{
  for (const int rings : {6, 10, 16, 40})
    EXPECT_FALSE(geometry::surface_noise(test::ball(radius_mm, rings, 2 * rings)).is_noisy()) << rings;
  EXPECT_FALSE(geometry::surface_noise(test::box({0, 0, 0}, {40, 30, 20})).is_noisy());
  EXPECT_FALSE(geometry::surface_noise(divided_box(40, 16)).is_noisy());
  for (const double resolution : {0.5, 0.7, 1.0, 2.0}) {
    const geometry::Shape knee = geometry::generate_shape({"knee", {{"resolution", resolution}}, {}});
    for (const auto* parts : {&knee.reference, &knee.moving}) {
      for (const geometry::ShapePart& part : *parts) {
        const SurfaceNoise found = geometry::surface_noise(part.mesh);
        EXPECT_FALSE(found.is_noisy()) << part.name << ' ' << resolution << ' ' << found.noise_mm;
      }
    }
  }
}

TEST(SurfaceNoise, clean_real_knees)
{
  VRDA_REQUIRE_REAL_KNEES();
  for (const char* file : {"pymskt-dess/femur_bone.stl", "pymskt-dess/tibia_cartilage_medial.stl",
                           "vhf-left/femur_cartilage.stl", "tka-dm/tibia_bone.stl"}) {
    const std::string path = (*test::data_directory() / "knees" / file).string();
    const Mesh mesh =
        job::clean_mesh(job::read_mesh(path, job::file_bytes(path, {}, job::largest_mesh_bytes)),
                        job::Winding::outward, Side::right)
            .mesh;
    EXPECT_FALSE(geometry::surface_noise(mesh).is_noisy()) << file;
    for (const double noise_mm : {0.25, 1.0})
      EXPECT_NEAR(geometry::surface_noise(with_noise(mesh, noise_mm)).noise_mm, noise_mm, 0.25 * noise_mm)
          << file;
  }
}

// With noise of the length of the edges, too.
TEST(SmoothedSurface, sphere)
{
  const Mesh ball = test::ball(radius_mm, 64, 128);
  struct Row {
    double noise_mm, factor;  // by which smoothing reduces it, at least
  };
  for (const Row& row : {Row{0.1, 2.0}, Row{0.25, 3.5}, Row{0.5, 4.0}, Row{1.0, 5.0}}) {
    for (const std::uint32_t seed : {1U, 2U, 3U}) {
      const Mesh noisy = with_noise(ball, row.noise_mm, seed);
      const SmoothedSurface smoothed = geometry::smoothed_surface(noisy, geometry::surface_noise(noisy));
      EXPECT_LT(off_sphere_mm(smoothed.mesh), off_sphere_mm(noisy) / row.factor) << row.noise_mm;
      EXPECT_LT(volume_change(smoothed.mesh, ball), 0.005) << row.noise_mm;
      EXPECT_FALSE(geometry::surface_noise(smoothed.mesh).is_noisy()) << row.noise_mm;
    }
  }
}

// The mirrored mesh bit for bit; other numbers of the vertices but for rounding.
TEST(SmoothedSurface, mirrored_and_renumbered)
{
  const Mesh noisy = with_noise(test::ball(radius_mm, 32, 64), 0.5);
  const SurfaceNoise noise = geometry::surface_noise(noisy);
  const Mesh expected = geometry::smoothed_surface(noisy, noise).mesh;
  const SurfaceNoise of_mirrored = geometry::surface_noise(mirrored_z(noisy));
  EXPECT_EQ(of_mirrored.noise_mm, noise.noise_mm);
  EXPECT_EQ(geometry::smoothed_surface(mirrored_z(noisy), of_mirrored).mesh.vertices_mm,
            mirrored_z(expected).vertices_mm);
  Mesh renumbered = noisy;
  const Eigen::Index n = noisy.vertices_mm.rows();
  renumbered.vertices_mm = noisy.vertices_mm.colwise().reverse().eval();
  renumbered.triangles = static_cast<std::int32_t>(n - 1) - noisy.triangles.array();
  const Mesh found = geometry::smoothed_surface(renumbered, geometry::surface_noise(renumbered)).mesh;
  EXPECT_LT((found.vertices_mm.colwise().reverse() - expected.vertices_mm).cwiseAbs().maxCoeff(), 1e-10);
}

// Where noise lets edges be found, they stay: corners do not move, edges move along themselves.
TEST(SmoothedSurface, edges_of_a_box)
{
  constexpr double half_mm = 20.0, noise_mm = 0.12;
  Mesh box = divided_box(2.0 * half_mm, 32);
  const Points clean = box.vertices_mm;
  const Eigen::ArrayXi n_sides = (clean.array().abs() == half_mm).rowwise().count().cast<int>();
  std::mt19937 random(1);
  std::normal_distribution<double> across_mm(0.0, noise_mm);
  for (Eigen::Index v = 0; v < clean.rows(); ++v) {
    if (n_sides[v] == 1) box.vertices_mm.row(v) += across_mm(random) * box.normals.row(v);
  }
  const SurfaceNoise noise = geometry::surface_noise(box);
  ASSERT_TRUE(noise.is_noisy());
  const Points smoothed = geometry::smoothed_surface(box, noise).mesh.vertices_mm;
  const Eigen::ArrayXd moved_mm = (smoothed - clean).rowwise().norm();
  const Eigen::ArrayXd off_mm = smoothed.cwiseAbs().rowwise().maxCoeff().array() - half_mm;
  EXPECT_EQ((n_sides == 3).select(moved_mm, 0.0).maxCoeff(), 0.0);
  EXPECT_LT((n_sides == 2).select(moved_mm, 0.0).maxCoeff(), 1e-9);
  EXPECT_LT(rms((n_sides == 1).select(off_mm, 0.0)), noise_mm / 2.0);
}

// The border of a sheet keeps its shape from above and its corners.
TEST(SmoothedSurface, border_of_a_sheet)
{
  constexpr double half_mm = 20.0, noise_mm = 0.15;
  const Mesh flat = test::sheet(2.0 * half_mm, 40), noisy = with_noise(flat, noise_mm);
  const SurfaceNoise noise = geometry::surface_noise(noisy);
  ASSERT_TRUE(noise.is_noisy());
  const Points smoothed = geometry::smoothed_surface(noisy, noise).mesh.vertices_mm;
  const Eigen::ArrayXd moved_mm = (smoothed - noisy.vertices_mm).rowwise().norm();
  const Eigen::ArrayXd moved_x_mm = (smoothed - flat.vertices_mm).col(0).cwiseAbs();
  const auto is_on_x = flat.vertices_mm.col(0).array().abs() == half_mm;
  const auto is_on_z = flat.vertices_mm.col(2).array().abs() == half_mm;
  EXPECT_EQ((is_on_x && is_on_z).select(moved_mm, 0.0).maxCoeff(), 0.0);
  EXPECT_LT(is_on_x.select(moved_x_mm, 0.0).maxCoeff(), 1e-12);
  EXPECT_LT(rms(smoothed.col(1).array()), noise_mm / 2.0);
}

}  // namespace vrda::surface_noise_test
