// Contact points, normals and distances against closed form, under random rigid motions of both objects.
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "contact/contacts.hpp"
#include "core/units.hpp"
#include "support/meshes.hpp"

namespace vrda::closed_form_test {

constexpr double exact_mm = 1e-9;
constexpr int n_placements = 400;
// Less than the distance to the neighbours of a ball's vertex.
constexpr double band_mm = 0.02;

class Random {
 public:
  explicit Random(unsigned seed) : engine_(seed) {}
  double between(double low, double high)
  {
    return std::uniform_real_distribution<double>(low, high)(engine_);
  }
  int below(int n) { return std::uniform_int_distribution<int>(0, n - 1)(engine_); }
  Eigen::Vector3d within(double size_mm)
  {
    return {between(-size_mm, size_mm), between(-size_mm, size_mm), between(-size_mm, size_mm)};
  }
  /// Log-uniform from 1e-7 mm to half the band.
  double standoff_mm() { return 0.5 * band_mm * std::pow(10.0, between(-5.0, 0.0)); }

 private:
  std::mt19937_64 engine_;
};

Pose turned_by(const Eigen::Matrix3d& R)
{
  Pose X = Pose::Identity();
  X.linear() = R;
  return X;
}

Pose shifted_by(const Eigen::Vector3d& by_mm)
{
  return Pose(Eigen::Translation3d(by_mm));
}

// Two objects made in a local frame L in which the contact's normal is known, and the pose of L in S. The
// reference is placed by an attitude, the moving object by a pose.
struct Placed {
  Pose X_S_L;
  geometry::TreeMesh reference;
  contact::SurfaceFeatures reference_features;
  contact::Collider moving;
  MovingPose pose;
};

Placed placed(const Mesh& reference, const Mesh& moving, const Eigen::Vector3d& normal_local, Random& random)
{
  Placed result;
  Attitude attitude;
  Pose X_reference_L;
  // Reactions must oppose Delta.
  do {
    attitude = {random.between(-pi, pi), random.between(-1.5, 1.5)};
    X_reference_L = shifted_by(random.within(100.0)) *
                    turned_by(rotation_z(random.between(-1.0, 1.0)) * rotation_y(random.between(-pi, pi)));
    result.X_S_L = turned_by(reference_rotation(attitude)) * X_reference_L;
  } while ((result.X_S_L.linear() * normal_local).y() > -0.1);
  result.pose = {random.within(100.0), random.between(-pi, pi)};
  const contact::Collider fixed = contact::make_collider(transformed(reference, X_reference_L));
  result.reference = geometry::rotated_reference(fixed.tree_mesh, attitude);
  result.reference_features = fixed.features;
  result.moving = contact::make_collider(transformed(moving, pose_of(result.pose).inverse() * result.X_S_L));
  return result;
}

struct Expected {
  Eigen::Vector3d on_reference;
  Eigen::Vector3d on_moving;
  Eigen::Vector3d normal;
};

enum class Taken { from_reference, from_moving };

// Expects one contact, given in L.
void expect_contact(const Placed& scene, const Expected& expected, Taken taken, ContactNormals normals)
{
  contact::NarrowPhase narrow_phase;
  contact::ContactOptions options;
  options.band_mm = band_mm;
  options.normals = normals;
  const std::vector<contact::Contact> contacts = contact::find_contacts(
      {scene.reference, scene.reference_features, scene.moving}, scene.pose, narrow_phase, options);
  ASSERT_EQ(contacts.size(), 1U);
  const Pose X_L_S = scene.X_S_L.inverse();
  const contact::Contact& c = contacts[0];
  EXPECT_LT((X_L_S * c.point_mm - expected.on_reference).norm(), exact_mm);
  const Eigen::Vector3d application =
      taken == Taken::from_reference ? expected.on_reference : expected.on_moving;
  EXPECT_LT((X_L_S * c.application_mm - application).norm(), exact_mm);
  EXPECT_LT((X_L_S.linear() * c.normal - expected.normal).norm(), exact_mm);
  EXPECT_NEAR(c.distance_mm, (expected.on_moving - expected.on_reference).norm(), exact_mm);
}

// Square pyramid with its apex up at the origin.
Mesh pyramid()
{
  Mesh mesh;
  mesh.vertices_mm.resize(5, 3);
  mesh.vertices_mm << 0, 0, 0, 3, -4, 3, 3, -4, -3, -3, -4, -3, -3, -4, 3;
  mesh.triangles.resize(6, 3);
  mesh.triangles << 0, 1, 2, 0, 2, 3, 0, 3, 4, 0, 4, 1, 1, 4, 3, 1, 3, 2;
  return mesh;
}

// Apex at the origin, pointing up, tilted by up to 20 degrees.
Mesh tilted_pyramid(Random& random)
{
  return transformed(
      pyramid(), turned_by(rotation_y(random.between(-pi, pi)) * rotation_x(random.between(-0.35, 0.35))));
}

const Eigen::Matrix3d upside_down = Eigen::Vector3d(1, -1, -1).asDiagonal();

// Random points of the face away from its diagonal, which is an edge.
Eigen::Vector3d on_face(Random& random)
{
  Eigen::Vector3d p;
  do {
    p = {random.between(-9, 9), 0.0, random.between(-9, 9)};
  } while (std::abs(std::abs(p.x()) - std::abs(p.z())) < 0.1);
  return p;
}

TEST(ClosedForm, VertexUnderAFace)
{
  Random random(61);
  const Mesh above = test::box({0, 5, 0}, {20, 10, 20});
  for (int k = 0; k < n_placements; ++k) {
    SCOPED_TRACE(k);
    const Eigen::Vector3d p = on_face(random), apex = p - random.standoff_mm() * Eigen::Vector3d::UnitY();
    const Mesh below = transformed(tilted_pyramid(random), shifted_by(apex));
    const Eigen::Vector3d n(0, -1, 0);
    expect_contact(placed(above, below, n, random), {p, apex, n}, Taken::from_reference,
                   ContactNormals::least_curvature);
  }
}

TEST(ClosedForm, VertexOverAFace)
{
  Random random(62);
  const Mesh below = test::box({0, -5, 0}, {20, 10, 20});
  for (int k = 0; k < n_placements; ++k) {
    SCOPED_TRACE(k);
    const Eigen::Vector3d p = on_face(random), apex = p + random.standoff_mm() * Eigen::Vector3d::UnitY();
    const Mesh above = transformed(tilted_pyramid(random), shifted_by(apex) * turned_by(upside_down));
    const Eigen::Vector3d n(0, -1, 0);
    expect_contact(placed(above, below, n, random), {apex, p, n}, Taken::from_moving,
                   ContactNormals::least_curvature);
  }
}

// A bar along X whose lowest edge runs through the origin, both faces there at least 20 degrees from level.
Mesh bar_over_its_edge(Random& random)
{
  Mesh bar = test::box({0, 1, 1}, {30, 2, 2});
  return transformed(bar, turned_by(rotation_x(-rad_from_deg(45.0 + random.between(-25.0, 25.0)))) *
                              shifted_by({random.between(-12, 12), 0, 0}));
}

TEST(ClosedForm, EdgeAcrossEdge)
{
  Random random(63);
  for (int k = 0; k < n_placements; ++k) {
    SCOPED_TRACE(k);
    const Eigen::Vector3d n(0, -1, 0), below_mm = random.standoff_mm() * n;
    const double crossing_rad = random.between(0.1, pi - 0.1);
    const Mesh above = bar_over_its_edge(random);
    const Mesh below =
        transformed(bar_over_its_edge(random),
                    shifted_by(below_mm) * turned_by(rotation_y(crossing_rad)) * turned_by(upside_down));
    expect_contact(placed(above, below, n, random), {Eigen::Vector3d::Zero(), below_mm, n},
                   Taken::from_reference, ContactNormals::least_curvature);
  }
}

constexpr int n_rings = 12;
constexpr int n_sectors = 24;

// A ball with any of its vertices on top, centred at the origin.
Mesh ball_vertex_up(double radius_mm, Random& random)
{
  const Mesh ball = test::ball(radius_mm, n_rings, n_sectors);
  const Eigen::Vector3d vertex =
      ball.vertices_mm.row(random.below(static_cast<int>(ball.vertices_mm.rows())));
  return transformed(ball, turned_by(rotation_y(random.between(-pi, pi)) *
                                     shortest_rotation(vertex.normalized(), Eigen::Vector3d::UnitY())));
}

TEST(ClosedForm, SphereUnderAPlane)
{
  // d = c . n - r along the plane's normal, here with the ball's vertex on that line.
  Random random(64);
  const Mesh above = test::box({0, 5, 0}, {20, 10, 20});
  const Eigen::Vector3d n(0, -1, 0);
  for (int k = 0; k < n_placements; ++k) {
    SCOPED_TRACE(k);
    const double radius_mm = random.between(15.0, 40.0);
    const Eigen::Vector3d p = on_face(random), centre = p + (radius_mm + random.standoff_mm()) * n;
    const Mesh below = transformed(ball_vertex_up(radius_mm, random), shifted_by(centre));
    const Placed scene = placed(above, below, n, random);
    const Expected expected{p, centre - radius_mm * n, n};
    expect_contact(scene, expected, Taken::from_reference, ContactNormals::least_curvature);
    expect_contact(scene, expected, Taken::from_moving, ContactNormals::moving);
  }
}

TEST(ClosedForm, SphereOverAPlane)
{
  Random random(65);
  const Mesh below = test::box({0, -5, 0}, {20, 10, 20});
  const Eigen::Vector3d n(0, -1, 0);
  for (int k = 0; k < n_placements; ++k) {
    SCOPED_TRACE(k);
    const double radius_mm = random.between(15.0, 40.0);
    const Eigen::Vector3d p = on_face(random), centre = p - (radius_mm + random.standoff_mm()) * n;
    const Mesh above =
        transformed(ball_vertex_up(radius_mm, random), shifted_by(centre) * turned_by(upside_down));
    const Placed scene = placed(above, below, n, random);
    const Expected expected{centre + radius_mm * n, p, n};
    expect_contact(scene, expected, Taken::from_moving, ContactNormals::least_curvature);
    expect_contact(scene, expected, Taken::from_reference, ContactNormals::reference);
  }
}

TEST(ClosedForm, SphereUnderSphere)
{
  // d = |c - C| - r - R, with a vertex of each ball on the line of centres.
  Random random(66);
  const Eigen::Vector3d n(0, -1, 0);
  for (int k = 0; k < n_placements; ++k) {
    SCOPED_TRACE(k);
    const double upper_mm = random.between(15.0, 40.0), lower_mm = random.between(15.0, 40.0);
    const Mesh above = transformed(ball_vertex_up(upper_mm, random), turned_by(upside_down));
    const Eigen::Vector3d centre = (upper_mm + lower_mm + random.standoff_mm()) * n;
    const Mesh below = transformed(ball_vertex_up(lower_mm, random), shifted_by(centre));
    const Placed scene = placed(above, below, n, random);
    const Expected expected{upper_mm * n, centre - lower_mm * n, n};
    expect_contact(scene, expected, Taken::from_reference, ContactNormals::reference);
    expect_contact(scene, expected, Taken::from_moving, ContactNormals::moving);
  }
}

TEST(ClosedForm, NormalsInterpolatedOnASphereAreRadialAnywhere)
{
  Random random(67);
  const double radius_mm = 20.0;
  const Mesh ball = test::ball(radius_mm, n_rings, n_sectors);
  for (int k = 0; k < n_placements; ++k) {
    SCOPED_TRACE(k);
    const auto [a, b, c] = corners(ball, random.below(static_cast<int>(ball.triangles.rows())));
    const double u = random.between(0.05, 0.45), v = random.between(0.05, 0.45);
    const Eigen::Vector3d p = a + u * (b - a) + v * (c - a), outward = (b - a).cross(c - a).normalized();
    const Eigen::Vector3d apex = p + random.standoff_mm() * outward;
    const Mesh tip =
        transformed(tilted_pyramid(random),
                    shifted_by(apex) * turned_by(shortest_rotation(Eigen::Vector3d::UnitY(), -outward)));
    const Eigen::Vector3d radial = p.normalized();
    expect_contact(placed(ball, tip, radial, random), {p, apex, radial}, Taken::from_reference,
                   ContactNormals::reference);
    expect_contact(placed(tip, ball, -radial, random), {apex, p, -radial}, Taken::from_moving,
                   ContactNormals::moving);
  }
}

}  // namespace vrda::closed_form_test
