#include "assemble/prepare.hpp"

#include "load/file_bytes.hpp"

namespace vrda {
namespace {

// Raised whenever the same job may give other bytes: journals of an older solver are then refused.
constexpr const char* search_version = "stability-search 3";
constexpr const char* equilibrium_version = "equilibrium 2";

SolverBody solver_body(const Body& body, const SolverFrame& frame)
{
  return {solver_mesh(body.contact.mesh, frame), body.contact.component};
}

std::vector<double> radians(const std::vector<double>& degrees)
{
  std::vector<double> result;
  result.reserve(degrees.size());
  for (const double value : degrees) result.push_back(rad_from_deg(value));
  return result;
}

}  // namespace

Joint joint_of(const Case& job_case, const SolverFrame& frame)
{
  return make_joint(solver_body(job_case.reference, frame), solver_body(job_case.moving, frame),
                    job_case.compartment_of_triangle);
}

SweepPlan plan_of(const Case& job_case)
{
  SweepPlan plan;
  plan.flexion_rad = radians(job_case.grid.flexion_deg);
  plan.varus_rad = radians(job_case.grid.varus_deg);
  plan.initial = {solver_translation_mm(job_case.frame, job_case.initial.translation_mm),
                  job_case.initial.theta_rad};
  if (job_case.method == "equilibrium") {
    plan.spine = SpineRule::free_varus;
    plan.is_varus_free = job_case.is_varus_free;
    // Contact alone hardly resists a moment about Delta: a band would say nothing.
    plan.has_band = job_case.spine.band_moment_nmm > 0.0 && !job_case.ligaments.fibres.empty();
    plan.n_restarts = job_case.spine.n_restarts;
  } else if (job_case.compartment_of_triangle.empty()) {
    plan.spine = SpineRule::nearest_zero;
  }
  return plan;
}

std::string fingerprint_of(const Case& job_case)
{
  const char* version = job_case.method == "equilibrium" ? equilibrium_version : search_version;
  std::string all = std::string(version) + '\n' + job_case.steps_job;
  for (const LoadedInput& input : job_case.inputs) {
    if (input.decides_steps) all += '\n' + input.name + ' ' + input.sha256;
  }
  return sha256_of(all);
}

}  // namespace vrda
