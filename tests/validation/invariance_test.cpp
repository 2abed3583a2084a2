// Invariances: which object is the moving one, the position of the scene, the numbering of vertices and
// faces, and the triangulation of flat faces.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <iostream>
#include <map>
#include <numeric>
#include <utility>

#include "core/units.hpp"
#include "validation/scene_case.hpp"

namespace vrda::test::invariance_test {

struct RestCase {
  geometry::ShapeRequest request;
  Eigen::Vector3d middle_mm = Eigen::Vector3d::Zero();  ///< the compared point of the moving mesh
  Eigen::Vector3d held = Eigen::Vector3d::Ones();  ///< 0 along an axis of the scene in which motion is free
  /// Lever from the rotation axis to the contacts that stop a rotation; 0 if theta is free.
  double lever_mm = 0.0;
  double steepness = 1.0;  ///< slope of the steepest flank
};

RestCase ball_in_bowl(Draw& draw)
{
  const double width_mm = draw.uniform(20, 60), dish_mm = width_mm / std::sqrt(2.0) / 0.95;
  const double radius_mm = dish_mm * draw.uniform(1.0, 2.5), ball_mm = dish_mm * draw.uniform(0.2, 0.7);
  RestCase result;
  const double reach_mm = 0.35 * width_mm;
  result.middle_mm = {draw.uniform(-reach_mm, reach_mm), 0.0, draw.uniform(-reach_mm, reach_mm)};
  result.request = {"ball-in-dish",
                    {{"ball_radius", ball_mm},
                     {"dish_radius", radius_mm},
                     {"dish_width", width_mm},
                     {"ball_edges", draw.whole(7, 10)},
                     {"dish_edges", draw.whole(8, 12)},
                     {"offset_x", result.middle_mm.x()},
                     {"offset_z", result.middle_mm.z()}},
                    {}};
  return result;
}

// In the domain of bar_test.cpp: no tip under the bar, whose ends are off the pyramids.
RestCase wide_bar(Draw& draw)
{
  const double base_mm = draw.uniform(12, 40), gap_mm = draw.uniform(4, 20);
  const double width_mm = gap_mm + base_mm * draw.uniform(0.1, 0.7);
  const double steepest_rad = std::acos(width_mm / (gap_mm + base_mm));
  const double turn_rad = draw.sign() * steepest_rad * draw.uniform(0.0, 0.9);
  const double along_mm = draw.uniform(-0.5, 0.5) * base_mm;
  const double across_mm =
      draw.uniform(-0.8, 0.8) * 0.5 * ((gap_mm + base_mm) * std::cos(turn_rad) - width_mm);
  RestCase result;
  result.middle_mm = rotation_y(turn_rad) * Eigen::Vector3d(across_mm, 0.0, along_mm);
  result.held.z() = 0.0;
  result.lever_mm = 0.5 * (gap_mm + base_mm - width_mm);
  result.steepness = 2.0 * draw.uniform(0.4, 1.0);
  result.request = {"bar-on-pyramids",
                    {{"base", base_mm},
                     {"height", 0.5 * result.steepness * base_mm},
                     {"gap", gap_mm},
                     {"bar_length", 3.0 * (gap_mm + base_mm)},
                     {"bar_width", width_mm},
                     {"turn", deg_from_rad(turn_rad)},
                     {"offset_x", result.middle_mm.x()},
                     {"offset_z", result.middle_mm.z()},
                     {"edges", 1}},
                    {}};
  return result;
}

RestCase cap_in_sink(Draw& draw)
{
  RestCase result;
  const double scale = draw.uniform(0.5, 0.95);
  result.middle_mm = {draw.uniform(-3, 3), 0.0, draw.uniform(-3, 3)};
  // The band is measured perpendicular to the faces, which have a slope of 45 degrees (cap_test.cpp).
  result.lever_mm = 20.0 * scale * std::sqrt(0.5);
  result.request = {"cap-in-sink",
                    {{"turn", draw.sign() * draw.uniform(0.0, 40.0)},
                     {"offset_x", result.middle_mm.x()},
                     {"offset_z", result.middle_mm.z()},
                     {"edges", 1},
                     {"cap_scale", scale}},
                    {}};
  return result;
}

// --- equivalent scenes, with the pose of the moving object mapped back to the original frame

struct EquivalentScene {
  Scene scene;
  std::function<Pose(const Pose&)> X_reference_moving;
};

Pose unchanged(const Pose& X)
{
  return X;
}

// Rx(pi) reverses Delta. Only signs change, so all digits are kept.
Mesh turned_over(Mesh mesh)
{
  for (Points* rows : {&mesh.vertices_mm, &mesh.normals}) rows->rightCols<2>() *= -1.0;
  return mesh;
}

EquivalentScene exchanged(const RestCase&, const Scene& scene, Draw&)
{
  Pose over = Pose::Identity();
  over.linear().diagonal() << 1.0, -1.0, -1.0;
  return {{turned_over(scene.moving), turned_over(scene.reference)},
          [over](const Pose& X) { return Pose((over * X * over).inverse()); }};
}

EquivalentScene moved(const RestCase&, const Scene& scene, Draw& draw)
{
  const Eigen::Vector3d shift_mm(draw.uniform(-100, 100), draw.uniform(-100, 100), draw.uniform(-100, 100));
  const Pose X_new_old = pose_of({shift_mm, draw.uniform(-pi, pi)});
  return {{transformed(scene.reference, X_new_old), transformed(scene.moving, X_new_old)},
          [X_new_old](const Pose& X) { return Pose(X_new_old.inverse() * X * X_new_old); }};
}

std::vector<Eigen::Index> shuffled(Eigen::Index n, Draw& draw)
{
  std::vector<Eigen::Index> order(static_cast<std::size_t>(n));
  std::iota(order.begin(), order.end(), Eigen::Index{0});
  for (int k = static_cast<int>(n) - 1; k > 0; --k)
    std::swap(order[static_cast<std::size_t>(k)], order[static_cast<std::size_t>(draw.whole(0, k))]);
  return order;
}

// Vertices and faces in random order, each face starting at a random corner.
Mesh renumbered_mesh(const Mesh& mesh, Draw& draw)
{
  const std::vector<Eigen::Index> vertex = shuffled(mesh.vertices_mm.rows(), draw);
  const std::vector<Eigen::Index> face = shuffled(mesh.triangles.rows(), draw);
  Mesh result = mesh;
  for (Eigen::Index v = 0; v < mesh.vertices_mm.rows(); ++v) {
    result.vertices_mm.row(vertex[static_cast<std::size_t>(v)]) = mesh.vertices_mm.row(v);
    result.normals.row(vertex[static_cast<std::size_t>(v)]) = mesh.normals.row(v);
  }
  for (Eigen::Index t = 0; t < mesh.triangles.rows(); ++t) {
    const int first = draw.whole(0, 2);
    for (int k = 0; k < 3; ++k) {
      const auto corner = static_cast<std::size_t>(mesh.triangles(t, (first + k) % 3));
      result.triangles(face[static_cast<std::size_t>(t)], k) = static_cast<std::int32_t>(vertex[corner]);
    }
  }
  return result;
}

EquivalentScene renumbered(const RestCase&, const Scene& scene, Draw& draw)
{
  Mesh reference = renumbered_mesh(scene.reference, draw);
  return {{std::move(reference), renumbered_mesh(scene.moving, draw)}, unchanged};
}

// Divides every triangle into four at the midpoints of its edges.
Mesh subdivided_mesh(const Mesh& mesh)
{
  std::map<std::pair<std::int32_t, std::int32_t>, std::int32_t> middle_of;
  std::vector<Eigen::Vector3d> middles;
  const auto n_old = static_cast<std::int32_t>(mesh.vertices_mm.rows());
  const auto middle = [&](std::int32_t a, std::int32_t b) {
    const auto [found, is_new] =
        middle_of.try_emplace(std::minmax(a, b), n_old + static_cast<std::int32_t>(middles.size()));
    if (is_new) middles.emplace_back(0.5 * (mesh.vertices_mm.row(a) + mesh.vertices_mm.row(b)));
    return found->second;
  };
  Mesh result;
  result.triangles.resize(4 * mesh.triangles.rows(), 3);
  for (Eigen::Index t = 0; t < mesh.triangles.rows(); ++t) {
    const std::int32_t a = mesh.triangles(t, 0), b = mesh.triangles(t, 1), c = mesh.triangles(t, 2);
    const std::int32_t ab = middle(a, b), bc = middle(b, c), ca = middle(c, a);
    result.triangles.middleRows<4>(4 * t) << a, ab, ca, ab, b, bc, ca, bc, c, ab, bc, ca;
  }
  result.vertices_mm.resize(n_old + static_cast<Eigen::Index>(middles.size()), 3);
  result.vertices_mm.topRows(n_old) = mesh.vertices_mm;
  for (std::size_t k = 0; k < middles.size(); ++k)
    result.vertices_mm.row(n_old + static_cast<Eigen::Index>(k)) = middles[k];
  result.normals = vertex_normals(result);
  return result;
}

EquivalentScene subdivided(const RestCase&, const Scene& scene, Draw&)
{
  return {{subdivided_mesh(scene.reference), subdivided_mesh(scene.moving)}, unchanged};
}

EquivalentScene with_finer_grids(const RestCase& rest, const Scene&, Draw& draw)
{
  geometry::ShapeRequest finer = rest.request;
  finer.numbers["edges"] = draw.whole(2, 5);
  return {scene_of(finer), unchanged};
}

// --- comparison

double turn_of(const Pose& X)
{
  return std::atan2(X.linear()(0, 2), X.linear()(0, 0));
}

struct Named {
  std::string scene;
  RestCase (*draw)(Draw&);
};
const std::vector<Named> flat_scenes = {{"wide bar", wide_bar}, {"cap in a sink", cap_in_sink}};
const std::vector<Named> all_scenes = {{"ball in a bowl", ball_in_bowl}, flat_scenes[0], flat_scenes[1]};

// Two searches of the same equilibrium end within 1.25 translation resolutions of it each (halving from 1
// mm), and rotate to within the stopping tolerance: the rotation resolution and one translation resolution
// at the end of the lever. If theta is determined, a rotation by that angle moves a flank at the lever's
// end by the same amount again.
struct InvarianceCase {
  std::string claim;
  std::uint64_t seed;
  EquivalentScene (*retell)(const RestCase&, const Scene&, Draw&);
  double allowed_resolutions = 2.5;
};

void expect_same_rest_of(const Named& named, const InvarianceCase& variant)
{
  Tally place{.scene = named.scene,
              .claim = variant.claim,
              .measure = "change of position, translation resolutions",
              .seed = variant.seed,
              .allowed = variant.allowed_resolutions};
  Tally angle{.scene = named.scene,
              .claim = variant.claim,
              .measure = "change of angle over the allowed one",
              .seed = variant.seed,
              .allowed = 1.0};
  Draw draw(variant.seed);
  for (int k = 0; k < n_tested(200); ++k) {
    SCOPED_TRACE(named.scene + ", case " + std::to_string(k));
    const RestCase rest = named.draw(draw);
    const Scene scene = scene_of(rest.request);
    const SearchOptions options;
    const EquivalentScene equivalent = variant.retell(rest, scene, draw);
    const Solved first = solve(scene, options), second = solve(equivalent.scene, options);
    EXPECT_EQ(first.record.status, StepStatus::stable);
    EXPECT_EQ(second.record.status, StepStatus::stable);
    ++place.outcomes[std::string(name_of(second.record.status))];
    const Pose X_first = pose_of(first.record.pose);
    const Pose X_second = equivalent.X_reference_moving(pose_of(second.record.pose));
    const Eigen::Vector3d change =
        (X_second * rest.middle_mm - X_first * rest.middle_mm).cwiseProduct(rest.held);
    const double aside = std::hypot(change.x(), change.z());
    const double up = std::abs(change.y()) / rest.steepness;
    if (!place.add(std::max(aside, up) / options.translation_resolution_mm))
      std::cout << named.scene << ", case " << k << ": moved by " << change.transpose() << " mm\n";
    if (change == Eigen::Vector3d::Zero()) ++place.outcomes["bitwise equal"];
    if (rest.lever_mm == 0.0) continue;
    const double allowed_rad =
        2.0 * (options.rotation_resolution_rad + options.translation_resolution_mm / rest.lever_mm);
    const double turned_rad = std::abs(turn_of(X_first.inverse() * X_second));
    if (!angle.add(turned_rad / allowed_rad))
      std::cout << named.scene << ", case " << k << ": turned by " << turned_rad << " rad\n";
  }
  report(place);
  if (angle.cases > 0) report(angle);
}

void expect_same_rest(const InvarianceCase& variant, const std::vector<Named>& scenes = all_scenes)
{
  for (const Named& named : scenes) expect_same_rest_of(named, variant);
}

TEST(Invariance, EitherObjectMayBeTheMovingOne)
{
  expect_same_rest({"same equilibrium with the objects exchanged and Delta reversed", 501, exchanged});
}
TEST(Invariance, ARigidMotionOfTheSceneChangesNothing)
{
  expect_same_rest({"same equilibrium with the scene rotated about Delta and translated", 502, moved});
}
// The order of sums over contacts may change; nothing else does.
TEST(Invariance, NumbersOfVerticesAndFacesDoNotMatter)
{
  expect_same_rest({"same equilibrium with vertices and faces renumbered", 503, renumbered, 1e-9});
}
TEST(Invariance, FlatFacesMayBeCutIntoMore)
{
  expect_same_rest({"same equilibrium with finer grids over flat faces", 505, with_finer_grids}, flat_scenes);
  expect_same_rest({"same equilibrium with every triangle divided into four", 504, subdivided});
}

}  // namespace vrda::test::invariance_test
