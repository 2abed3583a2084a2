// Objects and contacts of a frame as VTK PolyData (.vtp), the series as .pvd.
#include "tables/formats.hpp"

#include <algorithm>
#include <cmath>

#include "core/text.hpp"
#include "core/units.hpp"

namespace vrda::tables {
namespace {

/// Appended data section of a VTK XML file: raw arrays, each preceded by its size in bytes.
struct Appended {
  std::string bytes;

  /// Appends `block` and returns its DataArray element; `type` is the VTK number type, such as Float32.
  std::string array(const std::string& type, const std::string& name, int n_components,
                    const std::string& block)
  {
    const std::string element = "<DataArray type=\"" + type + "\" Name=\"" + name +
                                "\" NumberOfComponents=\"" + std::to_string(n_components) +
                                "\" format=\"appended\" offset=\"" + std::to_string(bytes.size()) + "\"/>\n";
    append_value(bytes, static_cast<std::uint64_t>(block.size()));
    bytes += block;
    return element;
  }
};

struct Bodies {
  std::string points, connectivity, offsets;
  std::string body, component, material, has_contact;  ///< of each cell
  std::int32_t n_points = 0, n_cells = 0;
  std::vector<std::string> component_names, material_names;
};

void put_point(std::string& bytes, const Eigen::Vector3d& p)
{
  for (Eigen::Index axis = 0; axis < 3; ++axis) append_value(bytes, static_cast<float>(p[axis]));
}

std::int32_t row_of(std::vector<std::string>& names, const std::string& name)
{
  const auto found = std::find(names.begin(), names.end(), name);
  const auto row = static_cast<std::int32_t>(found - names.begin());
  if (found == names.end()) names.push_back(name);
  return row;
}

void add_part(Bodies& all, const Part& part, const Pose& X_world_body, std::int32_t first_component,
              const std::vector<std::int32_t>& material)
{
  for (Eigen::Index v = 0; v < part.mesh.vertices_mm.rows(); ++v) {
    put_point(all.points, X_world_body * part.mesh.vertices_mm.row(v).transpose());
  }
  for (Eigen::Index t = 0; t < part.mesh.triangles.rows(); ++t) {
    for (Eigen::Index c = 0; c < 3; ++c)
      append_value(all.connectivity, all.n_points + part.mesh.triangles(t, c));
    append_value(all.offsets, 3 * ++all.n_cells);
    const std::int32_t component = part.component[static_cast<std::size_t>(t)];
    append_value(all.component, first_component + component);
    append_value(all.material, material[static_cast<std::size_t>(component)]);
  }
  all.n_points += static_cast<std::int32_t>(part.mesh.vertices_mm.rows());
}

void add_body(Bodies& all, const Body& body, std::uint8_t number, const Pose& X_world_body)
{
  const auto first = static_cast<std::int32_t>(all.component_names.size());
  std::vector<std::int32_t> material;
  for (const Component& component : body.components) {
    all.component_names.push_back(body.name + "/" + component.name);
    material.push_back(row_of(all.material_names, component.material));
  }
  for (const Part* part : {&body.contact, &body.visual}) {
    add_part(all, *part, X_world_body, first, material);
    const auto n = static_cast<std::size_t>(part->mesh.triangles.rows());
    all.body.append(n, static_cast<char>(number));
    all.has_contact.append(n, part == &body.contact ? '\1' : '\0');
  }
}

std::string number_field(const std::string& name, double value)
{
  return "<DataArray type=\"Float64\" Name=\"" + name + "\" NumberOfTuples=\"1\" format=\"ascii\">" +
         shortest_decimal(value) + "</DataArray>\n";
}

std::string point_field(const std::string& name, const Eigen::Vector3d& p)
{
  return "<DataArray type=\"Float64\" Name=\"" + name +
         "\" NumberOfComponents=\"3\" NumberOfTuples=\"1\" format=\"ascii\">" + shortest_decimal(p.x()) +
         " " + shortest_decimal(p.y()) + " " + shortest_decimal(p.z()) + "</DataArray>\n";
}

/// VTK's ASCII string arrays: byte values as numbers, each word ended by 0.
std::string words_field(const std::string& name, const std::vector<std::string>& words)
{
  std::string text = "<Array type=\"String\" Name=\"" + name + "\" NumberOfTuples=\"" +
                     std::to_string(words.size()) + "\" format=\"ascii\">";
  for (const std::string& word : words) {
    for (const char c : word) text += std::to_string(static_cast<unsigned char>(c)) + " ";
    text += "0 ";
  }
  return text + "</Array>\n";
}

// With turned axes, flexion and varus are the joint's own, like internal rotation, next to the attitude's.
std::string angle_fields(const store::MotionModel& model, const FlexionFrame& frame)
{
  const std::string prefix = store::has_turned_axes(model) ? "attitude_" : "";
  const std::string attitude =
      number_field(prefix + "flexion_deg", frame.flexion_deg) +
      number_field(prefix + "varus_deg", deg_from_rad(frame.pose.attitude.varus_rad));
  if (prefix.empty()) return attitude;
  return number_field("flexion_deg", deg_from_rad(frame.clinical.flexion_rad)) +
         number_field("varus_deg", deg_from_rad(frame.clinical.varus_rad)) + attitude;
}

std::string attitude_fields(const store::MotionModel& model, const FlexionFrame& frame)
{
  const ClinicalCoordinates& c = frame.clinical;
  return number_field("TimeValue", std::isnan(frame.pose.key) ? frame.flexion_deg : frame.pose.key) +
         angle_fields(model, frame) +
         number_field("internal_rotation_deg", deg_from_rad(c.internal_rotation_rad)) +
         number_field("anterior_mm", c.anterior_mm) + number_field("proximal_mm", c.proximal_mm) +
         number_field("lateral_mm", c.lateral_mm) +
         point_field("rotation_centre_mm", model.rotation_centre_mm);
}

std::string opening(const std::string& fields)
{
  return "<?xml version=\"1.0\"?>\n"
         "<VTKFile type=\"PolyData\" version=\"1.0\" byte_order=\"LittleEndian\" header_type=\"UInt64\">\n"
         "<PolyData>\n<FieldData>\n" +
         fields + "</FieldData>\n";
}

std::string piece(std::int32_t n_points, std::int32_t n_verts, std::int32_t n_polys)
{
  return "<Piece NumberOfPoints=\"" + std::to_string(n_points) + "\" NumberOfVerts=\"" +
         std::to_string(n_verts) + "\" NumberOfLines=\"0\" NumberOfStrips=\"0\" NumberOfPolys=\"" +
         std::to_string(n_polys) + "\">\n";
}

std::string closing(const Appended& appended)
{
  return "</Piece>\n</PolyData>\n<AppendedData encoding=\"raw\">\n_" + appended.bytes +
         "\n</AppendedData>\n</VTKFile>\n";
}

}  // namespace

Eigen::Index raw_cell(const store::MotionModel& model, const FlexionFrame& frame)
{
  constexpr double same_deg = 1e-9;  // tolerance of conversion between degrees and radians
  for (Eigen::Index cell = 0; cell < model.status.size(); ++cell) {
    const Eigen::Index i = cell / model.status.cols();
    if (model.status.data()[cell] != status_stable) continue;
    if (model.frames && model.frames->key[static_cast<std::size_t>(i)] != frame.pose.key) continue;
    if (model.frames) return cell;
    if (std::abs(model.flexion_deg[static_cast<std::size_t>(i)] - frame.flexion_deg) > same_deg) continue;
    const double varus_deg = deg_from_rad(frame.pose.attitude.varus_rad);
    if (std::abs(model.varus_solved_deg.data()[cell] - varus_deg) <= same_deg) return cell;
  }
  return -1;
}

std::string posed_vtp(const store::MotionModel& model, const FlexionFrame& frame)
{
  Bodies all;
  add_body(all, model.reference, 0, frame.pose.X_world_reference);
  add_body(all, model.moving, 1, frame.pose.X_world_moving);
  for (const store::FollowerRows* follower : store::in_order(model.followers)) {
    const auto body = static_cast<BodyIndex>(follower->body_index);
    if (frame.pose.has_follower.at(model::follower_row(body)))
      add_body(all, follower->body, static_cast<std::uint8_t>(follower->body_index),
               frame.pose.X_world(body));
  }
  Appended appended;
  std::string text =
      opening(attitude_fields(model, frame) + words_field("component_name", all.component_names) +
              words_field("material_name", all.material_names));
  text += piece(all.n_points, 0, all.n_cells);
  text += "<Points>\n" + appended.array("Float32", "Points", 3, all.points) + "</Points>\n<Polys>\n";
  text += appended.array("Int32", "connectivity", 1, all.connectivity);
  text += appended.array("Int32", "offsets", 1, all.offsets) + "</Polys>\n<CellData Scalars=\"material\">\n";
  text += appended.array("UInt8", "body", 1, all.body);
  text += appended.array("Int32", "component", 1, all.component);
  text += appended.array("Int32", "material", 1, all.material);
  text += appended.array("UInt8", "has_contact", 1, all.has_contact) + "</CellData>\n";
  return text + closing(appended);
}

std::string contacts_vtp(const store::MotionModel& model, const FlexionFrame& frame)
{
  const Eigen::Index cell = raw_cell(model, frame);
  if (cell < 0) return {};
  const store::ContactRows& rows = model.contacts;
  const auto c = static_cast<std::size_t>(cell);
  std::string points, normals, distances, compartments, connectivity, offsets;
  std::int32_t n = 0;
  for (std::int64_t k = rows.row_start[c]; k < rows.row_start[c + 1]; ++k) {
    put_point(points, rows.point_world_mm.row(k).transpose());
    put_point(normals, rows.normal_world.row(k).transpose());
    append_value(distances, static_cast<float>(rows.distance_mm[static_cast<std::size_t>(k)]));
    append_value(compartments, rows.compartment[static_cast<std::size_t>(k)]);
    append_value(connectivity, n);
    append_value(offsets, ++n);
  }
  Appended appended;
  std::string text = opening(attitude_fields(model, frame)) + piece(n, n, 0);
  text += "<Points>\n" + appended.array("Float32", "Points", 3, points) + "</Points>\n<Verts>\n";
  text += appended.array("Int32", "connectivity", 1, connectivity);
  text += appended.array("Int32", "offsets", 1, offsets) + "</Verts>\n<PointData Normals=\"normal\">\n";
  text += appended.array("Float32", "normal", 3, normals);
  text += appended.array("Float32", "distance_mm", 1, distances);
  text += appended.array("Int8", "compartment", 1, compartments) + "</PointData>\n";
  return text + closing(appended);
}

std::string series_pvd(const FlexionMotion& motion, const std::vector<SeriesEntry>& entries)
{
  std::string set = escape_markup(set_text(motion));
  for (std::size_t at = set.find("--"); at != std::string::npos; at = set.find("--")) set.erase(at, 1);
  std::string text = "<?xml version=\"1.0\"?>\n<!-- set " + set +
                     " -->\n<VTKFile type=\"Collection\" version=\"1.0\">\n<Collection>\n";
  for (const SeriesEntry& entry : entries) {
    text += "<DataSet timestep=\"" + shortest_decimal(entry.time) + "\" part=\"" +
            std::to_string(entry.part) + "\" file=\"" + escape_markup(entry.file) + "\"/>\n";
  }
  return text + "</Collection>\n</VTKFile>\n";
}

}  // namespace vrda::tables
