#include <span>

#include "core/error.hpp"
#include "core/whole_file.hpp"
#include "store/binding.hpp"
#include "store/dataset_writer.hpp"
#include "store/motion_model_file.hpp"
#include "store/seal.hpp"

namespace vrda {
namespace {

PartShape shape_of(const Part& part)
{
  check(part.mesh.normals.rows() == 0 || part.mesh.normals.rows() == part.mesh.vertices_mm.rows(),
        "a mesh has as many normals as vertices, or none");
  return {part.mesh.vertices_mm.rows(), part.mesh.triangles.rows(), part.mesh.normals.rows() > 0};
}

BodyShape shape_of(const Body& body)
{
  const PartShape visual = shape_of(body.visual);
  return {static_cast<std::int64_t>(body.components.size()), shape_of(body.contact),
          visual.n_vertices > 0 || visual.n_triangles > 0, visual};
}

LigamentShape shape_of(const LigamentRows& ligaments)
{
  return {static_cast<std::int64_t>(ligaments.name.size()),
          static_cast<std::int64_t>(ligaments.wrap_name.size())};
}

SmoothedShape shape_of(const SmoothedSet& set)
{
  SmoothedShape shape{set.degree, set.exponents.rows(), set.surfaces.size() == 5,
                      set.recontact_mm.has_value()};
  const std::vector<std::string>& names = smoothed_names(shape);
  check(set.surfaces.size() == names.size(), "a smoothed set holds tx, ty, tz, theta and perhaps varus");
  for (std::size_t i = 0; i < names.size(); ++i) {
    check(set.surfaces[i].name == names[i],
          "a smoothed set holds tx, ty, tz, theta and perhaps varus, in this order");
  }
  return shape;
}

AuditShape shape_of(const AuditSet& audit)
{
  check(is_audit_name(audit.name), "an audit has the name of a motion");
  return {audit.name, static_cast<std::int64_t>(audit.flexion_deg.size()),
          static_cast<std::int64_t>(audit.varus_deg.size())};
}

void add_derived_shape(FileShape& shape, const MotionModel& model)
{
  for (const SmoothedSet& set : model.smoothed) {
    check(shape.smoothed.empty() || shape.smoothed.back().degree < set.degree,
          "smoothed sets stand by increasing degree, each degree once");
    shape.smoothed.push_back(shape_of(set));
  }
  shape.has_zero_varus = model.zero_varus.has_value();
  for (const AuditSet& audit : model.audits) {
    check(shape.audits.empty() || shape.audits.back().name < audit.name,
          "audits stand by name, each name once");
    shape.audits.push_back(shape_of(audit));
  }
}

FileShape shape_of(const MotionModel& model)
{
  check(model.equilibrium.has_value() == (model.method == "equilibrium"),
        "a motion model has the surfaces of its method");
  check(model.contact_paths.has_value() == model.has_compartments,
        "a motion model has contact paths where it has compartments");
  FileShape shape;
  shape.n_flexion = static_cast<std::int64_t>(model.flexion_deg.size());
  shape.n_varus = static_cast<std::int64_t>(model.varus_deg.size());
  shape.has_compartments = model.has_compartments;
  shape.n_contacts = static_cast<std::int64_t>(model.contacts.distance_mm.size());
  if (model.equilibrium)
    shape.n_forces = static_cast<std::int64_t>(model.equilibrium->forces.along_delta_n.size());
  if (model.ligaments) shape.ligaments = shape_of(*model.ligaments);
  shape.reference = shape_of(model.reference);
  shape.moving = shape_of(model.moving);
  add_derived_shape(shape, model);
  shape.n_inputs = static_cast<std::int64_t>(model.job.inputs.size());
  if (model.job.scaling) shape.n_landmarks = static_cast<std::int64_t>(model.job.scaling->landmark.size());
  return shape;
}

std::span<const double> numbers(const Eigen::Vector3d& v)
{
  return {v.data(), 3};
}
std::span<const double> number(const double& value)
{
  return {&value, 1};
}

void write_root_attributes(H5Writer& writer, const MotionModel& model)
{
  writer.write_attribute("/", "format", std::string(format_name));
  writer.write_attribute("/", "format_version", std::string(format_version));
  writer.write_attribute("/", "Conventions", std::string(conventions));
  writer.write_attribute("/", "title", model.title);
  writer.write_attribute("/", "joint", model.joint);
  writer.write_attribute("/", "side", model.side);
  writer.write_attribute("/", "method", model.method);
  writer.write_attribute("/", "rotation_centre_mm", numbers(model.rotation_centre_mm));
  writer.write_attribute("/", "delta", numbers(model.delta));
  writer.write_attribute("/", "contact_resolution_mm", number(model.contact_resolution_mm));
  const std::int8_t has_compartments = model.has_compartments ? 1 : 0;
  writer.write_attribute("/", "has_compartments", std::span<const std::int8_t>(&has_compartments, 1));
}

void write_group_attributes(H5Writer& writer, const MotionModel& model)
{
  writer.write_attribute("/bodies/reference", "name", model.reference.name);
  writer.write_attribute("/bodies/moving", "name", model.moving.name);
  writer.write_attribute("/push", "point_mm", numbers(model.push.point_mm));
  if (model.equilibrium)
    writer.write_attribute("/equilibrium", "band_moment_nmm", number(model.equilibrium->band_moment_nmm));
  if (model.ligaments)
    writer.write_attribute("/ligaments", "transition_strain", number(model.ligaments->transition_strain));
}

void write_smoothed_attributes(H5Writer& writer, const SmoothedSet& set)
{
  const std::string group = smoothed_group(set.degree);
  const std::int8_t is_robust = set.is_robust ? 1 : 0;
  writer.write_attribute(group, "degree", std::span<const std::int32_t>(&set.degree, 1));
  writer.write_attribute(group, "is_robust", std::span<const std::int8_t>(&is_robust, 1));
  for (const SmoothedSurface& surface : set.surfaces) {
    const std::string path = smoothed_path(set.degree, surface.name);
    writer.write_attribute(path, "n_cells", std::span<const std::int32_t>(&surface.n_cells, 1));
    writer.write_attribute(path, "rms", number(surface.rms));
    writer.write_attribute(path, "largest_residual", number(surface.largest_residual));
    writer.write_attribute(path, "leave_one_out_rms", number(surface.leave_one_out_rms));
    writer.write_attribute(path, "condition_number", number(surface.condition_number));
  }
}

void write_audit_attributes(H5Writer& writer, const AuditSet& audit)
{
  const std::string group = audit_group(audit.name);
  const AuditSummary summary = summary_of(audit);
  writer.write_attribute(group, "refine", std::span<const std::int32_t>(&audit.refine, 1));
  writer.write_attribute(group, "largest_penetration", number(summary.largest_penetration_mm));
  writer.write_attribute(group, "largest_gap", number(summary.largest_gap_mm));
}

void write_scaling_attributes(H5Writer& writer, const Scaling& scaling)
{
  const std::string group = "/job/scaling";
  const std::int8_t keeps_steps = scaling.keeps_steps ? 1 : 0;
  writer.write_attribute(group, "factor", numbers(scaling.factor));
  writer.write_attribute(group, "keeps_steps", std::span<const std::int8_t>(&keeps_steps, 1));
  writer.write_attribute(group, "standard_error", number(scaling.standard_error));
  writer.write_attribute(group, "residual_rms_mm", number(scaling.residual_rms_mm));
}

std::string bytes_of(const std::string& path, const MotionModel& model)
{
  const FileShape shape = shape_of(model);
  const FileLayout layout = layout_of(shape);
  H5Writer writer(path);
  write_root_attributes(writer, model);
  for (const std::string& group : layout.groups) writer.create_group(group);
  visit_datasets(model, shape, DatasetWriter(writer, layout, shape));
  write_group_attributes(writer, model);
  for (const SmoothedSet& set : model.smoothed) write_smoothed_attributes(writer, set);
  if (model.zero_varus) writer.write_attribute("/zero_varus", "set", model.zero_varus->set);
  for (const AuditSet& audit : model.audits) write_audit_attributes(writer, audit);
  if (model.job.scaling) write_scaling_attributes(writer, *model.job.scaling);
  return writer.bytes();
}

}  // namespace

void write_motion_model(const std::string& path, const MotionModel& model)
{
  const std::string content = bytes_of(path, model);
  write_whole(path, {content, seal_of(content)});
}

}  // namespace vrda
