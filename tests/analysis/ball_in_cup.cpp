#include "analysis/ball_in_cup.hpp"

#include <cmath>

namespace vrda::test::cup {

void add_arc(Profile& profile, double radius_mm, double from_rad, double to_rad)
{
  constexpr int n = 32;
  for (int k = 0; k <= n; ++k) {
    const double a = from_rad + (to_rad - from_rad) * k / n;
    profile.emplace_back(std::abs(radius_mm * std::sin(a)), radius_mm * std::cos(a));
  }
}

Mesh revolved(const Profile& profile)
{
  constexpr int n_around = 64;
  const auto n = static_cast<int>(profile.size());
  Mesh mesh;
  mesh.vertices_mm.resize(n * n_around, 3);
  std::vector<std::array<int, 3>> faces;
  for (int k = 0; k < n_around; ++k) {
    const double turn = 2.0 * pi * k / n_around;
    for (int i = 0; i < n; ++i) {
      const auto& p = profile[static_cast<std::size_t>(i)];
      mesh.vertices_mm.row(k * n + i) << p.x() * std::cos(turn), p.y(), p.x() * std::sin(turn);
      if (i + 1 == n) continue;
      // One vertex at a pole.
      const auto is_pole = [&](int row) { return profile[static_cast<std::size_t>(row)].x() < 1e-9; };
      const auto vertex = [&](int around, int row) {
        return is_pole(row) ? row : around % n_around * n + row;
      };
      const int a = vertex(k, i), b = vertex(k, i + 1), c = vertex(k + 1, i), d = vertex(k + 1, i + 1);
      if (!is_pole(i)) faces.push_back({a, c, b});
      if (!is_pole(i + 1)) faces.push_back({b, c, d});
    }
  }
  mesh.triangles.resize(static_cast<Eigen::Index>(faces.size()), 3);
  for (std::size_t k = 0; k < faces.size(); ++k)
    mesh.triangles.row(static_cast<Eigen::Index>(k)) << faces[k][0], faces[k][1], faces[k][2];
  if (signed_volume_mm3(mesh) < 0.0) mesh.triangles.col(0).swap(mesh.triangles.col(1));
  return mesh;
}

Mesh cup()
{
  Profile profile;
  add_arc(profile, cup_mm, 0.0, std::acos(-depth_mm / cup_mm));
  add_arc(profile, cup_mm + wall_mm, std::acos(-depth_mm / (cup_mm + wall_mm)), 0.0);
  return revolved(profile);
}

Mesh cup_sheet()
{
  Profile profile;
  add_arc(profile, cup_mm, 0.0, std::acos(-sheet_depth_mm / cup_mm));
  Mesh mesh = revolved(profile);
  // Towards the centre: the sheet faces down.
  const Eigen::Vector3d a = mesh.vertices_mm.row(mesh.triangles(0, 0)).transpose();
  const Eigen::Vector3d b = mesh.vertices_mm.row(mesh.triangles(0, 1)).transpose();
  const Eigen::Vector3d c = mesh.vertices_mm.row(mesh.triangles(0, 2)).transpose();
  if ((b - a).cross(c - a).y() > 0.0) mesh.triangles.col(0).swap(mesh.triangles.col(1));
  return mesh;
}

Mesh head()
{
  Profile profile;
  add_arc(profile, ball_mm, 0.0, pi - std::asin(neck_mm / ball_mm));
  profile.emplace_back(neck_mm, -60.0);
  profile.emplace_back(0.0, -60.0);
  return revolved(profile);
}

void set_body(Body& body, const std::string& name, const Mesh& mesh)
{
  body.name = name;
  body.components = {{name, "bone"}};
  body.contact.mesh = mesh;
  body.contact.component.assign(static_cast<std::size_t>(mesh.triangles.rows()), 0);
}

job::Case ball_in_cup()
{
  job::Case joint;
  joint.title = "Ball in a cup";
  joint.joint = "other";
  joint.push = {job::Push{}};
  joint.initial.translation_mm = Eigen::Vector3d::Zero();
  set_body(joint.reference, "cup", cup());
  set_body(joint.moving, "head", head());
  return joint;
}

std::vector<double> angles_rad(double to_deg, double spacing_rad)
{
  std::vector<double> rad;
  for (double a = -rad_from_deg(to_deg); a <= rad_from_deg(to_deg) + 1e-9; a += spacing_rad) rad.push_back(a);
  return rad;
}

analysis::RomPlan cup_plan(int n_threads, double spacing_rad)
{
  analysis::RomPlan plan;
  plan.axes.rad = {angles_rad(72, spacing_rad), angles_rad(72, spacing_rad), {0.0}};
  plan.limits = {0.4, 0.1, 0.1};
  plan.delta_body = BodyIndex::reference;
  plan.n_threads = n_threads;
  return plan;
}

}  // namespace vrda::test::cup
