// The motion over flexion as binary glTF: one node a component, a link of a fibre and a label; one key a
// frame.
#include "tables/formats.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>

#include "core/canvas.hpp"
#include "core/document.hpp"
#include "core/units.hpp"
#include "model/mesh.hpp"
#include "store/motion.hpp"

namespace vrda::tables {
namespace {

using Json = nlohmann::ordered_json;
using Quaternion = std::array<float, 4>;  ///< x, y, z, w: the order of glTF

constexpr int type_float = 5126, type_uint32 = 5125;
constexpr int target_vertices = 34962, target_indices = 34963;

/// The glTF scene under construction: JSON description and binary buffer.
struct Scene {
  Json nodes = Json::array(), meshes = Json::array(), materials = Json::array();
  Json accessors = Json::array(), views = Json::array(), images = Json::array();
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

/// Fibres are drawn in one colour, since glTF cannot animate it.
const std::string ligament_material = "ligament";

Json ligament_json()
{
  // Linear; the pale yellow of collagen.
  const std::array<float, 4> colour{0.74F, 0.62F, 0.39F, 1.0F};
  return {{"name", ligament_material},
          {"pbrMetallicRoughness",
           {{"baseColorFactor", colour}, {"metallicFactor", 0.0}, {"roughnessFactor", 0.5}}}};
}

std::size_t material_row(Scene& scene, const std::string& name)
{
  const auto found = std::find(scene.material_names.begin(), scene.material_names.end(), name);
  const auto row = static_cast<std::size_t>(found - scene.material_names.begin());
  if (found == scene.material_names.end()) {
    scene.material_names.push_back(name);
    scene.materials.push_back(name == ligament_material ? ligament_json() : material_json(name));
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

/// Geometry of one mesh, metres.
struct Geometry {
  std::vector<std::array<float, 3>> positions, normals;
  std::vector<std::array<float, 2>> texture;  ///< coordinates; may be empty
  std::vector<std::array<std::uint32_t, 1>> indices;
};

std::size_t add_mesh(Scene& scene, const std::string& name, const Geometry& geometry, std::size_t material)
{
  Json primitive;
  primitive["attributes"]["POSITION"] = add_block(scene, geometry.positions, "VEC3", target_vertices);
  primitive["attributes"]["NORMAL"] = add_block(scene, geometry.normals, "VEC3", target_vertices);
  if (!geometry.texture.empty())
    primitive["attributes"]["TEXCOORD_0"] = add_block(scene, geometry.texture, "VEC2", target_vertices);
  primitive["indices"] = add_block(scene, geometry.indices, "SCALAR", target_indices);
  primitive["material"] = material;
  scene.meshes.push_back({{"name", name}, {"primitives", Json::array({primitive})}});
  return scene.meshes.size() - 1;
}

/// Adds the node of one component's mesh.
std::size_t add_component(Scene& scene, const Component& component, const RenderMesh& mesh)
{
  Geometry geometry;
  for (const RenderVertex& vertex : mesh.vertices) {
    geometry.positions.push_back(metres(vertex.position_mm));
    geometry.normals.push_back(vertex.normal);
  }
  for (const std::uint32_t index : mesh.triangles) geometry.indices.push_back({index});
  const std::size_t row = add_mesh(scene, component.name, geometry, material_row(scene, component.material));
  scene.nodes.push_back({{"name", component.name}, {"mesh", row}});
  return scene.nodes.size() - 1;
}

/// Adds the node of a body, with the rotation centre as origin.
std::size_t add_body(Scene& scene, const Body& body, const Eigen::Vector3d& centre_mm)
{
  Json children = Json::array();
  for (const Part* part : {&body.contact, &body.visual}) {
    const std::vector<std::vector<Eigen::Index>> triangles = triangles_by_component(body, *part);
    for (std::size_t c = 0; c < triangles.size(); ++c) {
      const RenderMesh mesh =
          make_render_mesh(part->mesh, triangles[c], centre_mm, crease_rad_of(body.components[c].material));
      if (mesh.triangles.empty()) continue;
      children.push_back(add_component(scene, body.components[c], mesh));
    }
  }
  Json node = {{"name", body.name}};
  if (!children.empty()) node["children"] = children;
  scene.nodes.push_back(node);
  return scene.nodes.size() - 1;
}

std::array<float, 3> single_m(const Eigen::Vector3d& p_mm)
{
  const Eigen::Vector3d p_m = p_mm * metres_per_mm;
  return {static_cast<float>(p_m.x()), static_cast<float>(p_m.y()), static_cast<float>(p_m.z())};
}

Quaternion single(const Eigen::Quaterniond& q)
{
  return {static_cast<float>(q.x()), static_cast<float>(q.y()), static_cast<float>(q.z()),
          static_cast<float>(q.w())};
}

/// Keys of a node's transform, one a frame.
struct Keys {
  std::vector<std::array<float, 3>> translations, scales;  ///< scales may be empty
  std::vector<Quaternion> rotations;
  Eigen::Quaterniond last = Eigen::Quaterniond::Identity();
};

/// Of a body: the position of its point at the rotation centre; each rotation in the hemisphere of the
/// previous one, since viewers interpolate along the shorter arc.
Keys body_keys(const FlexionMotion& motion, BodyIndex body)
{
  Keys keys;
  for (const FlexionFrame& frame : motion.frames) {
    const Pose& X = frame.pose.X_world(body);
    const Eigen::Matrix3d R = X.linear();
    Eigen::Quaterniond q = Eigen::Quaterniond(R).normalized();
    if (q.dot(keys.last) < 0.0) q.coeffs() = -q.coeffs();
    keys.last = q;
    keys.rotations.push_back(single(q));
    keys.translations.push_back(single_m(X * motion.rotation_centre_mm));
  }
  return keys;
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
void animate(Scene& scene, Animation& animation, std::size_t node, const Keys& keys)
{
  add_channel(animation, node, "rotation", add_block(scene, keys.rotations, "VEC4", 0));
  add_channel(animation, node, "translation", add_block(scene, keys.translations, "VEC3", 0));
  scene.nodes[node]["rotation"] = keys.rotations.front();
  scene.nodes[node]["translation"] = keys.translations.front();
}

std::size_t add_times(Scene& scene, const FlexionMotion& motion, double degrees_per_second)
{
  std::vector<std::array<float, 1>> times;
  for (const FlexionFrame& frame : motion.frames) {
    times.push_back({static_cast<float>(time_s(motion, frame, degrees_per_second))});
  }
  return add_block(scene, times, "SCALAR", 0);
}

// Ligaments

/// Points of a fibre's path: two of a straight one; on a wrap seven links bend by up to 15 degrees each.
constexpr std::size_t n_straight = 2, n_wrapped = 8;
constexpr double fibre_radius_mm = 0.9;  // on a knee, where fibres lie 2 to 4 mm apart
constexpr int n_sides = 10;
constexpr double least_length_mm = 1e-3;  // of a link: a scale of 0 has no normals

/// A tube of radius 1 from the origin to -Y, as fibres of a standing knee run.
Geometry unit_tube()
{
  Geometry tube;
  for (int side = 0; side <= n_sides; ++side) {
    const SinCos turn = sin_cos(2.0 * pi * side / n_sides);
    const auto x = static_cast<float>(turn.cos), z = static_cast<float>(turn.sin);
    for (const float y : {0.0F, -1.0F}) {
      tube.positions.push_back({x, y, z});
      tube.normals.push_back({x, 0.0F, z});
    }
  }
  for (std::uint32_t side = 0; side < n_sides; ++side) {
    const std::uint32_t a = 2 * side;
    for (const std::uint32_t index : {a, a + 2, a + 1, a + 1, a + 2, a + 3}) tube.indices.push_back({index});
  }
  return tube;
}

/// Turns the link from its last key by the shortest way, so that it does not twist.
void add_key(Keys& keys, const Eigen::Vector3d& from_mm, const Eigen::Vector3d& to_mm, double radius_mm)
{
  const Eigen::Vector3d along_mm = to_mm - from_mm;
  const double length_mm = std::max(along_mm.norm(), least_length_mm);
  if (along_mm.norm() > least_length_mm) {
    const Eigen::Vector3d before = keys.last * -Eigen::Vector3d::UnitY();
    keys.last = (Eigen::Quaterniond::FromTwoVectors(before, along_mm) * keys.last).normalized();
  }
  keys.translations.push_back(single_m(from_mm));
  keys.rotations.push_back(single(keys.last));
  keys.scales.push_back(single_m({radius_mm, length_mm, radius_mm}));
}

/// The links of all fibres over the frames, and their names.
void add_links(Scene& scene, Animation& animation, Json& children, const FlexionMotion& motion,
               const model::Ligaments& ligaments, double radius_mm)
{
  const std::size_t tube =
      add_mesh(scene, ligament_material, unit_tube(), material_row(scene, ligament_material));
  for (const model::Fibre& fibre : ligaments.fibres) {
    std::vector<Eigen::Vector3d> path_mm(fibre.wrap < 0 ? n_straight : n_wrapped);
    // The sampler requires four points; of a straight fibre only the ends are used.
    std::vector<Eigen::Vector3d> sampled_mm(std::max<std::size_t>(path_mm.size(), 4));
    std::vector<Keys> links(path_mm.size() - 1);
    for (const FlexionFrame& frame : motion.frames) {
      const Pose X_from = frame.pose.X_reference(fibre.from);
      const Pose X = fibre.from == BodyIndex::reference ? frame.pose.X_reference(fibre.to)
                                                        : X_from.inverse() * frame.pose.X_reference(fibre.to);
      model::sample_fibre_path(fibre, ligaments.wraps,
                               {Eigen::Matrix3d::Identity(), X.linear(), X.translation()}, sampled_mm);
      if (fibre.from != BodyIndex::reference)
        for (Eigen::Vector3d& p_mm : sampled_mm) p_mm = X_from * p_mm;
      path_mm = fibre.wrap < 0 ? std::vector{sampled_mm.front(), sampled_mm.back()} : sampled_mm;
      for (std::size_t k = 0; k < links.size(); ++k)
        add_key(links[k], path_mm[k] - motion.rotation_centre_mm, path_mm[k + 1] - motion.rotation_centre_mm,
                radius_mm);
    }
    for (const Keys& keys : links) {
      const std::size_t node = scene.nodes.size();
      scene.nodes.push_back({{"name", fibre.name},
                             {"mesh", tube},
                             {"translation", keys.translations.front()},
                             {"rotation", keys.rotations.front()},
                             {"scale", keys.scales.front()}});
      children.push_back(node);
      add_channel(animation, node, "translation", add_block(scene, keys.translations, "VEC3", 0));
      add_channel(animation, node, "rotation", add_block(scene, keys.rotations, "VEC4", 0));
      add_channel(animation, node, "scale", add_block(scene, keys.scales, "VEC3", 0));
    }
  }
}

/// Adds the fibres to the reference's node.
void add_ligaments(Scene& scene, Animation& animation, std::size_t reference, const store::MotionModel& model,
                   const FlexionMotion& motion)
{
  Json children = Json::array();
  const double radius_mm = store::width_ratio(model.moving) * fibre_radius_mm;
  add_links(scene, animation, children, motion, store::ligaments_of(model), radius_mm);
  for (const store::FollowerRows* follower : store::in_order(model.followers)) {
    if (is_posed(motion, *follower))
      add_links(scene, animation, children, motion, store::ligaments_of(*follower), radius_mm);
  }
  if (children.empty()) return;
  scene.nodes.push_back({{"name", "ligaments"}, {"children", children}});
  scene.nodes[reference]["children"].push_back(scene.nodes.size() - 1);
}

// Labels

constexpr int label_height_px = 64, text_height_px = 44;
constexpr double letter_width = 0.66;     // mean of the font's, in text heights
constexpr double label_height_mm = 8.0;   // on a knee
constexpr double label_radius_mm = 62.0;  // distance from the joint's axis, in front of the bones

/// A material with the text, readable without light.
std::size_t add_text_material(Scene& scene, const std::string& text, int width_px)
{
  core::Canvas canvas(width_px, label_height_px);
  canvas.draw_text({0.5 * width_px, 0.5 * label_height_px + 0.36 * text_height_px}, text_height_px, text,
                   core::TextAlign::centre, {0.1F, 0.13F, 0.17F});
  const std::string png = canvas.png();
  scene.images.push_back({{"bufferView", scene.views.size()}, {"mimeType", "image/png"}});
  scene.views.push_back({{"buffer", 0}, {"byteOffset", scene.bytes.size()}, {"byteLength", png.size()}});
  scene.bytes += png;
  scene.bytes.append((4 - scene.bytes.size() % 4) % 4, '\0');  // accessors begin at multiples of 4
  const Json texture = {{"index", scene.images.size() - 1}};
  scene.material_names.push_back("label " + text);
  scene.materials.push_back(
      {{"name", "label " + text},
       {"pbrMetallicRoughness",
        {{"baseColorTexture", texture}, {"metallicFactor", 0.0}, {"roughnessFactor", 1.0}}},
       {"extensions", {{"KHR_materials_unlit", Json::object()}}}});
  return scene.materials.size() - 1;
}

/// Two rectangles back to back, which face the front (+X) and the back, with the text upright on both.
Geometry plate(double width_m, double height_m)
{
  Geometry plate;
  for (const float facing : {1.0F, -1.0F}) {
    const auto first = static_cast<std::uint32_t>(plate.positions.size());
    for (const float v : {0.0F, 1.0F}) {
      for (const float u : {0.0F, 1.0F}) {
        plate.positions.push_back({facing * 1e-4F, static_cast<float>(height_m) * (0.5F - v),
                                   facing * static_cast<float>(width_m) * (0.5F - u)});
        plate.normals.push_back({facing, 0.0F, 0.0F});
        plate.texture.push_back({u, v});
      }
    }
    for (const std::uint32_t corner : {0U, 2U, 1U, 1U, 2U, 3U}) plate.indices.push_back({first + corner});
  }
  return plate;
}

/// The label's point at a pose, world, moved away from the axis of the joint to where it is seen.
Eigen::Vector3d label_mm(const store::JointLabel& label, const FlexionFrame& frame, double radius_mm)
{
  Eigen::Vector3d p_mm = 0.5 * (frame.pose.X_world(label.first) * label.first_mm +
                                frame.pose.X_world(label.second) * label.second_mm);
  const double away_mm = std::sqrt(p_mm.x() * p_mm.x() + p_mm.z() * p_mm.z());
  constexpr double on_axis_mm = 2.0;
  if (away_mm < on_axis_mm) return {radius_mm, p_mm.y(), 0.0};
  const double factor = std::max(1.0, radius_mm / away_mm);
  return {factor * p_mm.x(), p_mm.y(), factor * p_mm.z()};
}

/// Nodes of the labels, children of the root.
Json add_labels(Scene& scene, Animation& animation, const store::MotionModel& model,
                const FlexionMotion& motion)
{
  Json nodes = Json::array();
  const double scale = store::width_ratio(model.moving);
  for (const store::JointLabel& label : store::joint_labels(model)) {
    const bool is_follower = model::row_of(label.first) > 1;
    if (is_follower && !motion.frames.front().pose.has_follower.at(model::follower_row(label.first)))
      continue;
    const auto n_letters = static_cast<double>(label.text.size());
    const int width_px = static_cast<int>(std::ceil((letter_width * n_letters + 0.6) * text_height_px));
    const double height_m = scale * label_height_mm * metres_per_mm;
    const std::size_t mesh =
        add_mesh(scene, "label " + label.text, plate(height_m * width_px / label_height_px, height_m),
                 add_text_material(scene, label.text, width_px));
    std::vector<std::array<float, 3>> translations;
    for (const FlexionFrame& frame : motion.frames)
      translations.push_back(single_m(label_mm(label, frame, scale * label_radius_mm)));
    nodes.push_back(scene.nodes.size());
    scene.nodes.push_back(
        {{"name", "label " + label.text}, {"mesh", mesh}, {"translation", translations.front()}});
    add_channel(animation, scene.nodes.size() - 1, "translation", add_block(scene, translations, "VEC3", 0));
  }
  return nodes;
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
  put_chunk(chunks, "JSON", core::json_text(json, -1), ' ');
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
  animate(scene, animation, reference, body_keys(motion, BodyIndex::reference));
  animate(scene, animation, moving, body_keys(motion, BodyIndex::moving));
  add_ligaments(scene, animation, reference, model, motion);
  Json children = add_labels(scene, animation, model, motion);
  children.insert(children.begin(), {reference, moving});
  for (const store::FollowerRows& follower : model.followers) {
    if (!is_posed(motion, follower)) continue;
    const std::size_t node = add_body(scene, follower.body, model.rotation_centre_mm);
    animate(scene, animation, node, body_keys(motion, static_cast<BodyIndex>(follower.body_index)));
    children.push_back(node);
  }
  // A rotation by 90 degrees about Y maps anterior (+X) to glTF's front (+Z) and the subject's right to -X.
  const double half = std::sqrt(0.5);
  const Eigen::Vector3d& centre_mm = model.rotation_centre_mm;
  scene.nodes.push_back({{"name", model.title},
                         {"rotation", Json::array({0.0, -half, 0.0, half})},
                         {"extras", {{"rotation_centre_mm", {centre_mm.x(), centre_mm.y(), centre_mm.z()}}}},
                         {"children", children}});
  Json json;
  json["asset"] = {{"version", "2.0"}, {"generator", "vrda"}, {"extras", {{"set", set_text(motion)}}}};
  json["scene"] = 0;
  json["scenes"][0]["nodes"][0] = scene.nodes.size() - 1;
  json["nodes"] = scene.nodes;
  json["meshes"] = scene.meshes;
  json["materials"] = scene.materials;
  json["animations"][0] = {
      {"name", "flexion"}, {"channels", animation.channels}, {"samplers", animation.samplers}};
  json["extensionsUsed"] = {"KHR_materials_unlit"};
  json["images"] = scene.images;
  for (std::size_t k = 0; k < scene.images.size(); ++k) json["textures"].push_back({{"source", k}});
  json["accessors"] = scene.accessors;
  json["bufferViews"] = scene.views;
  json["buffers"][0]["byteLength"] = scene.bytes.size();
  return glb_file(json, scene.bytes);
}

}  // namespace vrda::tables
