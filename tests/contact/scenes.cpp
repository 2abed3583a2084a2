#include "contact/scenes.hpp"

#include <cmath>
#include <stdexcept>

#include "core/units.hpp"
#include "geometry/shapes.hpp"
#include "job/case.hpp"
#include "support/directional_gap.hpp"
#include "support/real_knees.hpp"

namespace vrda::test {
namespace {

// Share of attitudes without rotation: faces and edges of generated scenes are parallel there, which random
// attitudes never are.
constexpr double level_share = 0.2;

double uniform(std::mt19937_64& random, double low, double high)
{
  return std::uniform_real_distribution<double>(low, high)(random);
}

// Log-uniform between 10^low and 10^high.
double spread(std::mt19937_64& random, double low, double high)
{
  return std::pow(10.0, uniform(random, low, high));
}

Eigen::Vector3d any_vertex(const Mesh& mesh, std::mt19937_64& random)
{
  return mesh.vertices_mm.row(
      std::uniform_int_distribution<Eigen::Index>(0, mesh.vertices_mm.rows() - 1)(random));
}

Mesh contact_mesh(const std::vector<geometry::ShapePart>& parts)
{
  Mesh mesh;
  for (const geometry::ShapePart& part : parts) {
    if (!part.has_contact) continue;
    if (mesh.triangles.rows() == 0) {
      mesh = part.mesh;
    } else {
      append(mesh, part.mesh);
    }
  }
  return mesh;
}

struct Generated {
  std::string name;
  geometry::ShapeRequest request;
};

const std::vector<Generated>& generated()
{
  static const std::vector<Generated> all{
      {"BallInBowl", {"ball-in-dish", {}, {{"section", "bowl"}}}},
      {"BallInCone", {"ball-in-dish", {}, {{"section", "cone"}}}},
      {"BallInWave", {"ball-in-dish", {}, {{"section", "wave"}}}},
      {"BallInHoledDish", {"ball-in-dish", {{"hole", 8.0}}, {{"section", "bowl"}}}},
      {"BarOnPyramids", {"bar-on-pyramids", {}, {}}},
      {"CapInSink", {"cap-in-sink", {}, {}}},
      {"Hip", {"hip", {}, {}}},
      {"GenericKnee", {"knee", {}, {}}},
  };
  return all;
}

job::Case real_knee(const std::string& name)
{
  return job::load_case((source_directory() / ("jobs/knee-" + name + ".toml")).string(),
                        {data_directory()->string(), {}});
}

// A pose that touches the reference: centres aligned to within a quarter of the extent, or any two vertices
// aligned.
MovingPose below_reference(const geometry::TreeMesh& reference, const Mesh& moving, bool is_level,
                           std::mt19937_64& random)
{
  const bool is_central = uniform(random, 0.0, 1.0) < 0.5;
  const double most_rad = is_central ? 0.4 : pi;
  MovingPose pose;
  if (!is_level) pose.theta_rad = uniform(random, -most_rad, most_rad);
  const Box above = bounding_box(reference.mesh), own = bounding_box(moving);
  const geometry::Placement turn({Eigen::Vector3d::Zero(), pose.theta_rad});
  if (is_central) {
    const Eigen::Vector3d quarter = 0.25 * (above.max_mm - above.min_mm);
    pose.translation_mm = 0.5 * (above.min_mm + above.max_mm) - turn(0.5 * (own.min_mm + own.max_mm));
    pose.translation_mm.x() += uniform(random, -quarter.x(), quarter.x());
    pose.translation_mm.z() += uniform(random, -quarter.z(), quarter.z());
  } else {
    pose.translation_mm = any_vertex(reference.mesh, random) - turn(any_vertex(moving, random));
  }
  pose.translation_mm.y() = above.min_mm.y() - own.max_mm.y() - 1.0;
  return pose;
}

void add_poses(const MovingPose& below, double travel_mm, double height_mm, std::mt19937_64& random,
               std::vector<TestPose>& poses)
{
  const auto add = [&](Zone zone, double from_below_mm) {
    MovingPose pose = below;
    pose.translation_mm.y() += from_below_mm;
    poses.push_back({pose, zone});
  };
  add(Zone::apart, travel_mm - spread(random, -2.0, 1.3));
  for (const double sign : {-1.0, 1.0}) {
    add(Zone::milli, travel_mm + sign * spread(random, -4.0, -3.0));
    add(Zone::micro, travel_mm + sign * spread(random, -7.0, -6.0));
    add(Zone::nano, travel_mm + sign * spread(random, -10.0, -9.0));
  }
  add(Zone::deep, travel_mm + spread(random, -2.0, 1.0));
  add(Zone::deep, travel_mm + spread(random, -2.0, 1.0));
  add(Zone::anywhere, uniform(random, 0.0, height_mm));
}

}  // namespace

const std::vector<std::string>& generated_scenes()
{
  static const std::vector<std::string> names = [] {
    std::vector<std::string> all;
    for (const Generated& scene : generated()) all.push_back(scene.name);
    return all;
  }();
  return names;
}

const std::vector<std::string>& real_knee_scenes()
{
  static const std::vector<std::string> names{"jam-smith2019", "pymskt-dess", "vhf-left", "vhf-right"};
  return names;
}

TwoObjects two_objects(const std::string& scene)
{
  for (const Generated& known : generated()) {
    if (known.name != scene) continue;
    const geometry::Shape shape = geometry::generate_shape(known.request);
    return {geometry::make_tree_mesh(contact_mesh(shape.reference)),
            geometry::make_tree_mesh(contact_mesh(shape.moving))};
  }
  const job::Case knee = real_knee(scene);
  return {geometry::make_tree_mesh(solver_mesh(knee.reference.contact.mesh, knee.frame)),
          geometry::make_tree_mesh(solver_mesh(knee.moving.contact.mesh, knee.frame))};
}

TestAttitude random_attitude(const TwoObjects& objects, int n_touches, std::mt19937_64& random)
{
  TestAttitude sample;
  const bool is_level = uniform(random, 0.0, 1.0) < level_share;
  if (!is_level) {
    sample.attitude = {rad_from_deg(uniform(random, -10.0, 130.0)),
                       rad_from_deg(uniform(random, -10.0, 10.0))};
  }
  sample.reference = geometry::rotated_reference(objects.reference, sample.attitude);
  const Box above = bounding_box(sample.reference.mesh), own = bounding_box(objects.moving.mesh);
  const double height_mm = above.max_mm.y() - above.min_mm.y() + own.max_mm.y() - own.min_mm.y() + 2.0;
  // The moving object may pass through a hole or past an edge; ten tries per contact suffice.
  for (int tries = 0; static_cast<int>(sample.poses.size()) < n_touches * poses_per_contact; ++tries) {
    if (tries > 10 * n_touches) throw std::runtime_error("the moving object rarely touches the reference");
    const MovingPose below = below_reference(sample.reference, objects.moving.mesh, is_level, random);
    const geometry::Gap gap =
        test::directional_gap(sample.reference, objects.moving.mesh, objects.moving.tree, below);
    if (std::isfinite(gap.travel_mm)) add_poses(below, gap.travel_mm, height_mm, random, sample.poses);
  }
  return sample;
}

}  // namespace vrda::test
