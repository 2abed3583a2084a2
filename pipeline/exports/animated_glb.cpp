// The motion over flexion as binary glTF: one node a component, one key a frame.
#include "exports/formats.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>
#include <vector>

#include "core/render_mesh.hpp"
#include "core/units.hpp"

namespace vrda::exports {
namespace {

using Json = nlohmann::ordered_json;
using Quaternion = std::array<float, 4>;  ///< x, y, z, w: the order of glTF

constexpr int type_float = 5126, type_uint32 = 5125;
constexpr int target_vertices = 34962, target_indices = 34963;

/// The glTF scene under construction: JSON description and binary buffer.
struct Scene {
  Json nodes = Json::array(), meshes = Json::array(), materials = Json::array();
  Json accessors = Json::array(), views = Json::array();
  std::vector<std::string> material_names;
  std::string bytes;
};

template <std::size_t n>
struct Limits {
  std::array<double, n> min, max;
  Limits()
  {
    min.fill(std::numeric_limits<double>::infinity());
    max.fill(-std::numeric_limits<double>::infinity());
  }
};

/// Adds a block of rows of n numbers; `target` is 0 for animation data. Returns its accessor.
template <typename Number, std::size_t n>
std::size_t add_block(Scene& scene, const std::vector<std::array<Number, n>>& rows, const std::string& type,
                      int target)
{
  Limits<n> limits;
  Json view = {
      {"buffer", 0}, {"byteOffset", scene.bytes.size()}, {"byteLength", rows.size() * n * sizeof(Number)}};
  if (target != 0) view["target"] = target;
  for (const std::array<Number, n>& row : rows) {
    for (std::size_t k = 0; k < n; ++k) {
      append_value(scene.bytes, row[k]);
      limits.min[k] = std::min(limits.min[k], static_cast<double>(row[k]));
      limits.max[k] = std::max(limits.max[k], static_cast<double>(row[k]));
    }
  }
  Json accessor = {{"bufferView", scene.views.size()},
                   {"componentType", std::is_same_v<Number, float> ? type_float : type_uint32},
                   {"count", rows.size()},
                   {"type", type}};
  // Required for positions and times, omitted for indices.
  if (std::is_same_v<Number, float>) {
    accessor["min"] = limits.min;
    accessor["max"] = limits.max;
  }
  scene.views.push_back(view);
  scene.accessors.push_back(accessor);
  return scene.accessors.size() - 1;
}

/// glTF has no Blinn-Phong model: roughness with an equally wide highlight, roughness^4 = 2 / (exponent + 2).
Json material_json(const std::string& name)
{
  const Material material = material_of(name);
  const double roughness = std::sqrt(std::sqrt(2.0 / (static_cast<double>(material.shininess) + 2.0)));
  const std::array<float, 4> colour{material.colour.x(), material.colour.y(), material.colour.z(),
                                    material.opacity};
  Json json = {{"name", name},
               {"pbrMetallicRoughness",
                {{"baseColorFactor", colour}, {"metallicFactor", 0.0}, {"roughnessFactor", roughness}}},
               {"doubleSided", true}};
  if (material.opacity < 1.0F) json["alphaMode"] = "BLEND";
  return json;
}

std::size_t material_row(Scene& scene, const std::string& name)
{
  const auto found = std::find(scene.material_names.begin(), scene.material_names.end(), name);
  const auto row = static_cast<std::size_t>(found - scene.material_names.begin());
  if (found == scene.material_names.end()) {
    scene.material_names.push_back(name);
    scene.materials.push_back(material_json(name));
  }
  return row;
}

std::array<float, 3> metres(const std::array<float, 3>& p_mm)
{
  std::array<float, 3> p_m{};
  for (std::size_t k = 0; k < 3; ++k)
    p_m[k] = static_cast<float>(static_cast<double>(p_mm[k]) * metres_per_mm);
  return p_m;
}

/// Adds the node of one component's mesh.
std::size_t add_component(Scene& scene, const Component& component, const RenderMesh& mesh)
{
  std::vector<std::array<float, 3>> positions, normals;
  for (const RenderVertex& vertex : mesh.vertices) {
    positions.push_back(metres(vertex.position_mm));
    normals.push_back(vertex.normal);
  }
  std::vector<std::array<std::uint32_t, 1>> indices;
  for (const std::uint32_t index : mesh.triangles) indices.push_back({index});
  Json primitive;
  primitive["attributes"]["POSITION"] = add_block(scene, positions, "VEC3", target_vertices);
  primitive["attributes"]["NORMAL"] = add_block(scene, normals, "VEC3", target_vertices);
  primitive["indices"] = add_block(scene, indices, "SCALAR", target_indices);
  primitive["material"] = material_row(scene, component.material);
  scene.meshes.push_back({{"name", component.name}, {"primitives", Json::array({primitive})}});
  scene.nodes.push_back({{"name", component.name}, {"mesh", scene.meshes.size() - 1}});
  return scene.nodes.size() - 1;
}

/// Adds the node of a body, with the rotation centre as origin.
std::size_t add_body(Scene& scene, const Body& body, const Eigen::Vector3d& centre_mm)
{
  Json children = Json::array();
  for (const Part* part : {&body.contact, &body.visual}) {
    const std::vector<std::vector<Eigen::Index>> triangles = triangles_by_component(body, *part);
    for (std::size_t c = 0; c < triangles.size(); ++c) {
      const RenderMesh mesh = make_render_mesh(part->mesh, triangles[c], centre_mm,
                                               crease_rad_of(body.components[c].material));
      if (mesh.triangles.empty()) continue;
      children.push_back(add_component(scene, body.components[c], mesh));
    }
  }
  Json node = {{"name", body.name}};
  if (!children.empty()) node["children"] = children;
  scene.nodes.push_back(node);
  return scene.nodes.size() - 1;
}

/// Rotation keys, each in the hemisphere of the previous one: viewers interpolate along the shorter arc.
std::vector<Quaternion> rotations_of(const FlexionMotion& motion, Pose motion::JointPose::*X_world_body)
{
  std::vector<Quaternion> rotations;
  Eigen::Quaterniond previous = Eigen::Quaterniond::Identity();
  for (const FlexionFrame& frame : motion.frames) {
    const Eigen::Matrix3d R = (frame.pose.*X_world_body).linear();
    Eigen::Quaterniond q = Eigen::Quaterniond(R).normalized();
    if (q.dot(previous) < 0.0) q.coeffs() = -q.coeffs();
    rotations.push_back({static_cast<float>(q.x()), static_cast<float>(q.y()), static_cast<float>(q.z()),
                         static_cast<float>(q.w())});
    previous = q;
  }
  return rotations;
}

/// Translation keys: the position of the body's point at the rotation centre, in metres.
std::vector<std::array<float, 3>> translations_of(const FlexionMotion& motion,
                                                  Pose motion::JointPose::*X_world_body)
{
  std::vector<std::array<float, 3>> translations;
  for (const FlexionFrame& frame : motion.frames) {
    const Eigen::Vector3d p_m = (frame.pose.*X_world_body) * motion.rotation_centre_mm * metres_per_mm;
    translations.push_back(
        {static_cast<float>(p_m.x()), static_cast<float>(p_m.y()), static_cast<float>(p_m.z())});
  }
  return translations;
}

struct Animation {
  std::size_t times = 0;  ///< accessor of the keys' times
  Json channels = Json::array(), samplers = Json::array();
};

void add_channel(Animation& animation, std::size_t node, const char* path, std::size_t values)
{
  animation.channels.push_back(
      {{"sampler", animation.samplers.size()}, {"target", {{"node", node}, {"path", path}}}});
  animation.samplers.push_back({{"input", animation.times}, {"output", values}, {"interpolation", "LINEAR"}});
}

/// Animates a node and sets its static pose to the first frame, for viewers without animation.
void animate(Scene& scene, Animation& animation, std::size_t node, const FlexionMotion& motion,
             Pose motion::JointPose::*X_world_body)
{
  const std::vector<Quaternion> rotations = rotations_of(motion, X_world_body);
  const std::vector<std::array<float, 3>> translations = translations_of(motion, X_world_body);
  add_channel(animation, node, "rotation", add_block(scene, rotations, "VEC4", 0));
  add_channel(animation, node, "translation", add_block(scene, translations, "VEC3", 0));
  scene.nodes[node]["rotation"] = rotations.front();
  scene.nodes[node]["translation"] = translations.front();
}

std::size_t add_times(Scene& scene, const FlexionMotion& motion, double degrees_per_second)
{
  std::vector<std::array<float, 1>> times;
  for (const FlexionFrame& frame : motion.frames) {
    times.push_back({static_cast<float>(time_s(motion, frame, degrees_per_second))});
  }
  return add_block(scene, times, "SCALAR", 0);
}

void put_chunk(std::string& file, const char* kind, std::string chunk, char filler)
{
  chunk.append((4 - chunk.size() % 4) % 4, filler);
  append_value(file, static_cast<std::uint32_t>(chunk.size()));
  file.append(kind, 4);
  file += chunk;
}

std::string glb_file(const Json& json, const std::string& bytes)
{
  // The title may come from another program and contain invalid UTF-8.
  std::string chunks;
  put_chunk(chunks, "JSON", json.dump(-1, ' ', false, Json::error_handler_t::replace), ' ');
  put_chunk(chunks, "BIN\0", bytes, '\0');
  std::string file = "glTF";
  append_value(file, std::uint32_t{2});
  append_value(file, static_cast<std::uint32_t>(chunks.size() + 12));
  return file + chunks;
}

}  // namespace

std::string animated_glb(const store::MotionModel& model, const FlexionMotion& motion,
                         double degrees_per_second)
{
  Scene scene;
  const std::size_t reference = add_body(scene, model.reference, model.rotation_centre_mm);
  const std::size_t moving = add_body(scene, model.moving, model.rotation_centre_mm);
  Animation animation;
  animation.times = add_times(scene, motion, degrees_per_second);
  animate(scene, animation, reference, motion, &motion::JointPose::X_world_reference);
  animate(scene, animation, moving, motion, &motion::JointPose::X_world_moving);
  // A rotation by 90 degrees about Y maps anterior (+X) to glTF's front (+Z) and the subject's right to -X.
  const double half = std::sqrt(0.5);
  scene.nodes.push_back({{"name", model.title},
                         {"rotation", Json::array({0.0, -half, 0.0, half})},
                         {"children", Json::array({reference, moving})}});
  Json json;
  json["asset"] = {{"version", "2.0"}, {"generator", "vrda"}};
  json["scene"] = 0;
  json["scenes"][0]["nodes"][0] = scene.nodes.size() - 1;
  json["nodes"] = scene.nodes;
  json["meshes"] = scene.meshes;
  json["materials"] = scene.materials;
  json["animations"][0] = {
      {"name", "flexion"}, {"channels", animation.channels}, {"samplers", animation.samplers}};
  json["accessors"] = scene.accessors;
  json["bufferViews"] = scene.views;
  json["buffers"][0]["byteLength"] = scene.bytes.size();
  return glb_file(json, scene.bytes);
}

}  // namespace vrda::exports
