/// Scenes of the equilibrium with closed-form solutions: steep pins pushed up under ceilings of flat faces.
#pragma once

#include <functional>

#include "solve/equilibrium.hpp"
#include "support/meshes.hpp"

namespace vrda::test {

/// y = height(x, z) over a square about the origin, facing down; n even puts grid lines on both axes.
inline Mesh ceiling(double size_mm, int n, const std::function<double(double, double)>& height)
{
  Mesh mesh = sheet(size_mm, n);
  for (Eigen::Index v = 0; v < mesh.vertices_mm.rows(); ++v)
    mesh.vertices_mm(v, 1) = height(mesh.vertices_mm(v, 0), mesh.vertices_mm(v, 2));
  mesh.triangles.col(1).swap(mesh.triangles.col(2));
  mesh.normals = vertex_normals(mesh);
  return mesh;
}

/// A four-sided spike, tip up, flanks five times as steep as 45 degrees.
inline Mesh pin(const Eigen::Vector3d& tip_mm)
{
  Mesh mesh;
  mesh.vertices_mm.resize(5, 3);
  mesh.vertices_mm << 0, 0, 0, -1, -5, -1, 1, -5, -1, 1, -5, 1, -1, -5, 1;
  mesh.vertices_mm.rowwise() += tip_mm.transpose();
  mesh.triangles.resize(6, 3);
  mesh.triangles << 0, 2, 1, 0, 3, 2, 0, 4, 3, 0, 1, 4, 1, 2, 3, 1, 3, 4;
  mesh.normals = vertex_normals(mesh);
  return mesh;
}

inline Mesh pins(const std::vector<Eigen::Vector3d>& tips_mm)
{
  Mesh all;
  for (const Eigen::Vector3d& tip : tips_mm) append(all, pin(tip));
  return all;
}

/// Triangles on either side of z = 0: medial on the left of a right knee.
inline std::vector<Compartment> sides(const Mesh& moving)
{
  std::vector<Compartment> of;
  for (Eigen::Index t = 0; t < moving.triangles.rows(); ++t) {
    const auto c = corners(moving, t);
    of.push_back(c[0].z() + c[1].z() + c[2].z() < 0.0 ? Compartment::medial : Compartment::lateral);
  }
  return of;
}

inline solve::Joint joint_of(const Mesh& reference, const Mesh& moving)
{
  return solve::make_joint({reference, {}}, {moving, {}}, sides(moving));
}

/// The force vector of a recorded contact force.
inline Eigen::Vector3d force_of(const ContactForce& f)
{
  return f.normal_solver * (f.along_delta_n / -f.normal_solver.y());
}

inline constexpr double fibre_stiffness_n = 2000;  // per unit strain

inline model::Fibre fibre(const Eigen::Vector3d& reference_mm, const Eigen::Vector3d& moving_mm,
                          double slack_mm)
{
  model::Fibre f;
  f.reference_mm = reference_mm;
  f.moving_mm = moving_mm;
  f.stiffness_n = fibre_stiffness_n;
  f.slack_length_mm = slack_mm;
  return f;
}

/// A minimal knee: two pins under two faceted bowls, and five fibres.
struct MinimalKnee {
  solve::Joint joint = joint_of(ceiling(80, 40,
                                        [](double x, double z) {
                                          const double side = std::abs(z) - 20;
                                          return -(x * x + side * side) / 60;
                                        }),
                                pins({{0, 0, 20}, {0, 0.4, -20}}));
  model::Ligaments ligaments;
  MinimalKnee()
  {
    ligaments.fibres = {fibre({2, 12, 30}, {-3, -30, 30}, 41), fibre({0, 12, -30}, {4, -35, -30}, 46),
                        fibre({-12, 5, 4}, {10, -4, -3}, 24), fibre({10, 5, -4}, {-12, -6, 3}, 25),
                        fibre({-2, 12, 32}, {-8, -30, 31}, 41.5)};
  }
  StepRecord solve(const MovingPose& seed, double varus_rad, const Loads& loads = {}) const
  {
    return solve::EquilibriumSolver(joint, ligaments, {}).solve({{0.1, varus_rad}, seed, loads, true});
  }
};

}  // namespace vrda::test
