#include "load/case.hpp"

#include "core/error.hpp"
#include "load/axis_map.hpp"
#include "load/case_ligaments.hpp"
#include "load/case_warnings.hpp"
#include "load/compartments.hpp"
#include "load/component_source.hpp"
#include "load/job.hpp"

namespace vrda {
namespace {

// The one place that says what of a valid job this version does not solve.
void check_solvable(const Job& job)
{
  const auto refuse = [&](const std::string& key, const std::string& found, const std::string& wanted) {
    throw InputError({job.document.source_of(key), key, found, wanted});
  };
  if (job.method != SolverMethod::stability_search) {
    refuse("solver.method", "\"equilibrium\"", "\"stability-search\", by which this version solves");
  }
  if (job.is_varus_free) {
    refuse("grid.varus", "\"free\"",
           "a table { from, to, step }: this version solves by \"stability-search\", where varus is given");
  }
  const Eigen::MatrixXd& delta = job.push.delta.value;
  if ((delta.rowwise() - delta.row(0)).cwiseAbs().maxCoeff() > 0.0) {
    refuse("push.delta", "directions that differ over flexion",
           "one direction: this version pushes along the same one at every attitude");
  }
}

void append_part(Part& part, const Mesh& mesh, std::int32_t component)
{
  append(part.mesh, mesh);
  part.component.insert(part.component.end(), static_cast<std::size_t>(mesh.triangles.rows()), component);
}

Body loaded_body(const BodyJob& body_job, ComponentSource& source, Case& loaded)
{
  Body body;
  body.name = body_job.name;
  for (const ComponentJob& component : body_job.components) {
    LoadedComponent part = source.load(component);
    part.survey.body = body.name;
    const auto index = static_cast<std::int32_t>(body.components.size());
    append_part(component.has_contact ? body.contact : body.visual, part.clean.mesh, index);
    body.components.push_back({component.name, component.material});
    loaded.inputs.push_back(part.input);
    loaded.survey.push_back(part.survey);
  }
  return body;
}

}  // namespace

Case load_case(const std::string& job_file, const LoadOptions& options)
{
  const Job job = read_job(job_file, options.overrides);
  check_solvable(job);
  const AxisMap map = axis_map(job);
  const LoadedLigaments ligaments = load_ligaments(job, options.data_directory, map);
  Case loaded;
  loaded.title = job.title;
  loaded.joint = job.joint;
  loaded.frame.side = job.side;
  loaded.frame.rotation_centre_mm = map(job.frame.origin_native);
  loaded.frame.delta = job.push.delta.value.row(0).transpose();
  ComponentSource source(job, options.data_directory);
  loaded.reference = loaded_body(job.reference, source, loaded);
  loaded.moving = loaded_body(job.moving, source, loaded);
  check_attachments(ligaments, loaded.reference, loaded.moving);
  loaded.ligaments = ligaments.ligaments;
  loaded.inputs.insert(loaded.inputs.end(), ligaments.inputs.begin(), ligaments.inputs.end());
  loaded.initial = job.initial;
  loaded.grid = job.grid;
  loaded.method = "stability-search";
  loaded.search = job.search;
  loaded.compartment_of_triangle = compartments_of(job, loaded.moving, loaded.frame.rotation_centre_mm.z());
  loaded.smooth_degrees = job.smooth_degrees;
  loaded.unsolved_fraction = job.unsolved_fraction;
  loaded.job_text = job.text;
  loaded.resolved_job = job.resolved_text;
  loaded.warnings = case_warnings(job, loaded);
  return loaded;
}

}  // namespace vrda
