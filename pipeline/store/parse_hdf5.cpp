#include "store/parse_hdf5.hpp"

#include <cmath>
#include <limits>
#include <utility>

#include "core/error.hpp"
#include "store/binding.hpp"
#include "store/contact_paths.hpp"
#include "store/dataset_reader.hpp"
#include "store/h5_reader.hpp"
#include "store/trace_binding.hpp"
#include "store/trace_layout.hpp"
#include "store/trace_values.hpp"
#include "store/value_findings.hpp"
#include "store/values.hpp"

namespace vrda {
namespace {

Eigen::Vector3d vector(const H5Reader& reader, const std::string& object, const std::string& name)
{
  const AttributeValue value = attribute(reader, object, name);
  return {value.numbers.at(0), value.numbers.at(1), value.numbers.at(2)};
}

SmoothedSet empty_set(const H5Reader& reader, const SmoothedShape& shape, std::int32_t minor_version)
{
  SmoothedSet set;
  set.degree = shape.degree;
  const std::string group = smoothed_group(shape.degree);
  set.is_robust = minor_version >= 2 && number(reader, group, "is_robust") != 0.0;
  for (const std::string& name : smoothed_names(shape)) {
    const std::string path = smoothed_path(shape.degree, name);
    SmoothedSurface surface;
    surface.name = name;
    surface.n_cells = static_cast<std::int32_t>(number(reader, path, "n_cells"));
    surface.rms = number(reader, path, "rms");
    surface.largest_residual = number(reader, path, "largest_residual");
    surface.leave_one_out_rms = number(reader, path, "leave_one_out_rms");
    surface.condition_number = number(reader, path, "condition_number");
    set.surfaces.push_back(surface);
  }
  if (shape.has_recontact) set.recontact_mm.emplace();
  return set;
}

void open_derived(MotionModel& model, const H5Reader& reader, const FileShape& shape)
{
  for (const SmoothedShape& set : shape.smoothed)
    model.smoothed.push_back(empty_set(reader, set, shape.minor_version));
  if (shape.has_zero_varus) model.zero_varus.emplace().set = text(reader, "/zero_varus", "set");
  for (const AuditShape& audit : shape.audits) {
    model.audits.emplace_back().name = audit.name;
    model.audits.back().refine = static_cast<std::int32_t>(number(reader, audit_group(audit.name), "refine"));
  }
}

/// The attributes that repeat what the values say.
void check_summaries(const H5Reader& reader, const MotionModel& model, std::vector<Finding>& findings)
{
  for (const AuditSet& audit : model.audits) {
    const std::string group = audit_group(audit.name);
    const AuditSummary wanted = summary_of(audit);
    for (const auto& [name, value] : {std::pair("largest_penetration", wanted.largest_penetration_mm),
                                      std::pair("largest_gap", wanted.largest_gap_mm)}) {
      const double found = number(reader, group, name);
      const bool are_both_nan = std::isnan(found) && std::isnan(value);
      if (are_both_nan || found == value) continue;
      findings.push_back(
          {group + "@" + name, text_of(found), text_of(value) + ", the largest of its values"});
    }
  }
}

/// The members that files of `shape` have, with what stands in their groups' attributes.
void open_mechanics(MotionModel& model, const H5Reader& reader, const FileShape& shape)
{
  if (shape.minor_version == 0) return;
  model.push.point_mm = vector(reader, "/push", "point_mm");
  if (shape.has_compartments) model.contact_paths.emplace();
  if (shape.n_forces)
    model.equilibrium.emplace().band_moment_nmm = number(reader, "/equilibrium", "band_moment_nmm");
  if (shape.ligaments)
    model.ligaments.emplace().transition_strain = number(reader, "/ligaments", "transition_strain");
}

void open_scaling(MotionModel& model, const H5Reader& reader, const FileShape& shape)
{
  if (!shape.n_landmarks) return;
  const std::string group = "/job/scaling";
  Scaling& scaling = model.job.scaling.emplace();
  scaling.factor = vector(reader, group, "factor");
  scaling.keeps_steps = number(reader, group, "keeps_steps") != 0.0;
  scaling.standard_error = number(reader, group, "standard_error");
  scaling.residual_rms_mm = number(reader, group, "residual_rms_mm");
}

/// What version 1.0 did not write, and what it means that it is not there.
void complete_first_version(MotionModel& model)
{
  model.push = constant_push(model.delta, model.flexion_deg.size());
  model.varus_solved_deg = GridD(model.tx_mm.rows(), model.tx_mm.cols());
  for (Eigen::Index cell = 0; cell < model.status.size(); ++cell) {
    const bool is_stable = model.status.data()[cell] == status_stable;
    const auto varus = static_cast<std::size_t>(cell % model.status.cols());
    model.varus_solved_deg.data()[cell] =
        is_stable ? model.varus_deg[varus] : std::numeric_limits<double>::quiet_NaN();
  }
}

MotionModel read_model_values(const H5Reader& reader, const Structure& structure)
{
  MotionModel model;
  model.title = text(reader, "/", "title");
  model.joint = text(reader, "/", "joint");
  model.side = text(reader, "/", "side");
  model.method = text(reader, "/", "method");
  model.rotation_centre_mm = vector(reader, "/", "rotation_centre_mm");
  model.delta = vector(reader, "/", "delta");
  model.contact_resolution_mm = number(reader, "/", "contact_resolution_mm");
  model.has_compartments = structure.shape.has_compartments;
  model.reference.name = text(reader, "/bodies/reference", "name");
  model.moving.name = text(reader, "/bodies/moving", "name");
  open_derived(model, reader, structure.shape);
  open_mechanics(model, reader, structure.shape);
  open_scaling(model, reader, structure.shape);
  visit_datasets(model, structure.shape, DatasetReader(reader, structure.layout, structure.shape));
  if (structure.shape.minor_version == 0) complete_first_version(model);
  if (structure.shape.minor_version < 4) {
    model.plausibility = GridB::Constant(model.status.rows(), model.status.cols(), plausibility_not_judged);
  }
  if (!model.has_compartments) set_no_compartments(model);
  return model;
}

std::vector<Finding> findings_of(const H5Reader& reader, const MotionModel& model)
{
  std::vector<Finding> findings = check_values(model);
  check_summaries(reader, model, findings);
  return findings;
}

Trace read_trace_values(const H5Reader& reader, const Structure& structure)
{
  Trace trace;
  trace.title = text(reader, "/", "title");
  trace.side = text(reader, "/", "side");
  trace.job_key = text(reader, "/", "job_key");
  trace.approach_step_mm = number(reader, "/", "approach_step_mm");
  trace.translation_resolution_mm = number(reader, "/", "translation_resolution_mm");
  trace.rotation_resolution_deg = number(reader, "/", "rotation_resolution_deg");
  visit_trace(trace, DatasetReader(reader, structure.layout, structure.shape));
  return trace;
}

}  // namespace

MotionModel parse_motion_model(const Hdf5Content& content)
{
  const H5Reader reader(content);
  const Structure structure = structure_of(reader);
  require_none(structure.findings, content.file);
  MotionModel model = read_model_values(reader, structure);
  require_none(findings_of(reader, model), content.file);
  // Of version 1.0 they are told by the contacts, once these are known to be sound.
  if (model.has_compartments && !model.contact_paths) model.contact_paths = contact_paths_of(model);
  return model;
}

Trace parse_trace(const Hdf5Content& content)
{
  const H5Reader reader(content);
  const Structure structure = trace_structure_of(reader);
  require_none(structure.findings, content.file);
  Trace trace = read_trace_values(reader, structure);
  require_none(check_values(trace), content.file);
  return trace;
}

std::vector<Finding> findings_in(const Hdf5Content& content)
{
  const H5Reader reader(content);
  const std::optional<AttributeValue> format = reader.attribute("/", "format");
  const bool is_trace = format && format->texts == std::vector<std::string>{trace_format_name};
  const Structure structure = is_trace ? trace_structure_of(reader) : structure_of(reader);
  if (!structure.findings.empty()) return structure.findings;
  try {
    return is_trace ? check_values(read_trace_values(reader, structure))
                    : findings_of(reader, read_model_values(reader, structure));
  } catch (const InputError& error) {
    // A damaged chunk shows only when its values are read.
    return {{error.facts().field, error.facts().found, error.facts().wanted}};
  }
}

}  // namespace vrda
