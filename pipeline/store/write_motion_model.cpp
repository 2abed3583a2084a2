#include <filesystem>
#include <span>

#include "core/error.hpp"
#include "core/whole_file.hpp"
#include "store/binding.hpp"
#include "store/dataset_writer.hpp"
#include "store/model_shape.hpp"
#include "store/motion_model_file.hpp"
#include "store/seal.hpp"

namespace vrda {
namespace {

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

/// Journals are removed on the strength of this file: what the disk holds counts.
void require_written(const std::string& path, std::size_t n_bytes)
{
  std::error_code error;
  const std::uintmax_t n_found = std::filesystem::file_size(path, error);
  if (error || n_found != n_bytes) {
    throw InputError({path, "", error ? error.message() : std::to_string(n_found) + " bytes on the disk",
                      "the " + std::to_string(n_bytes) + " bytes just written"});
  }
  read_hdf5(path);
}

}  // namespace

void write_motion_model(const std::string& path, const MotionModel& model)
{
  const std::string content = bytes_of(path, model);
  const std::string seal = seal_of(content);
  write_whole(path, {content, seal});
  require_written(path, content.size() + seal.size());
}

}  // namespace vrda
