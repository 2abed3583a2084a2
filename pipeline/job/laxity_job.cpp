// [laxity] of a job: the loads of `vrda laxity`; and a job over other flexions with free varus.
#include "job/command_jobs.hpp"

#include <algorithm>
#include <functional>

#include "core/value.hpp"

namespace vrda::job {

std::optional<LaxityJob> laxity_of(const core::Document& document)
{
  const core::DocumentValue* table = document.root.find("laxity");
  if (table == nullptr) return std::nullopt;
  const auto load = [&](const char* key) {
    const core::DocumentValue* value = table->find(key);
    return value == nullptr ? 0.0 : core::number_at(*value, "");
  };
  LaxityJob laxity;
  laxity.flexion_deg = core::numbers_at(*table, "flexion_deg");
  if (std::adjacent_find(laxity.flexion_deg.begin(), laxity.flexion_deg.end(), std::greater_equal<>()) !=
      laxity.flexion_deg.end())
    document.refuse("laxity.flexion_deg", core::shown(core::value_at(*table, "flexion_deg")),
                    "ascending angles");
  laxity.anterior_force_n = load("anterior_force_n");
  laxity.internal_moment_nmm = load("internal_moment_nmm");
  laxity.varus_moment_nmm = load("varus_moment_nmm");
  if (laxity.anterior_force_n + laxity.internal_moment_nmm + laxity.varus_moment_nmm == 0.0)
    document.refuse("laxity", "no load", "one of anterior_force_n, internal_moment_nmm and varus_moment_nmm");
  laxity.load_steps = static_cast<int>(core::integer_at(*table, "load_steps"));
  if (const core::DocumentValue* cuts = table->find("cut")) {
    for (const core::DocumentValue& cut : *cuts->list())
      laxity.cuts.push_back({core::text_at(cut, "name"), core::texts_at(cut, "bundles")});
  }
  return laxity;
}

Job over_flexions(const Job& job, const std::vector<double>& flexion_deg)
{
  if (job.method != SolverMethod::equilibrium)
    job.document.refuse("solver.method", "\"stability-search\"", "\"equilibrium\": a search has no loads");
  if (job.coordinates) job.document.refuse("coordinates", "coordinates with roles of their own", "[grid]");
  if (job.push.is_fixed_in_reference) job.document.refuse("push.frame", "\"reference\"", "\"world\"");
  for (Eigen::Index row = 0; row < job.push.delta.value.rows(); ++row) {
    const Eigen::Vector3d delta = job.push.delta.value.row(row).transpose();
    if (delta != Eigen::Vector3d::UnitY())
      job.document.refuse("push.delta",
                          core::shown(core::value_at(job.document.root, "push.delta")),
                          "[0, 1, 0]: loads act on the joint's own coordinates");
  }
  Job over = job;
  over.grid = {flexion_deg, {0.0}};
  over.is_varus_free = true;
  over.smooth_degrees.clear();
  // No warnings of a grid that is not used.
  std::erase_if(std::get<core::DocumentValue::Table>(over.document.root.data),
                [](const core::DocumentEntry& entry) { return entry.key == "grid"; });
  return over;
}

}  // namespace vrda::job
