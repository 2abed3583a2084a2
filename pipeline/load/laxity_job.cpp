// [laxity] of a job: the loads of `vrda laxity`; and a job over other flexions with free varus.
#include "load/command_jobs.hpp"

#include <algorithm>
#include <functional>

#include "documents/value.hpp"

namespace vrda::load {

std::optional<LaxityJob> laxity_of(const documents::Document& document)
{
  const documents::DocumentValue* table = document.root.find("laxity");
  if (table == nullptr) return std::nullopt;
  const auto load = [&](const char* key) {
    const documents::DocumentValue* value = table->find(key);
    return value == nullptr ? 0.0 : documents::number_at(*value, "");
  };
  LaxityJob laxity;
  laxity.flexion_deg = documents::numbers_at(*table, "flexion_deg");
  if (std::adjacent_find(laxity.flexion_deg.begin(), laxity.flexion_deg.end(), std::greater_equal<>()) !=
      laxity.flexion_deg.end())
    document.refuse("laxity.flexion_deg", documents::shown(documents::value_at(*table, "flexion_deg")),
                    "ascending angles");
  laxity.anterior_force_n = load("anterior_force_n");
  laxity.internal_moment_nmm = load("internal_moment_nmm");
  laxity.varus_moment_nmm = load("varus_moment_nmm");
  if (laxity.anterior_force_n + laxity.internal_moment_nmm + laxity.varus_moment_nmm == 0.0)
    document.refuse("laxity", "no load", "one of anterior_force_n, internal_moment_nmm and varus_moment_nmm");
  laxity.load_steps = static_cast<int>(documents::integer_at(*table, "load_steps"));
  if (const documents::DocumentValue* cuts = table->find("cut")) {
    for (const documents::DocumentValue& cut : *cuts->list())
      laxity.cuts.push_back({documents::text_at(cut, "name"), documents::texts_at(cut, "bundles")});
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
                          documents::shown(documents::value_at(job.document.root, "push.delta")),
                          "[0, 1, 0]: loads act on the joint's own coordinates");
  }
  Job over = job;
  over.grid = {flexion_deg, {0.0}};
  over.is_varus_free = true;
  over.smooth_degrees.clear();
  // No warnings of a grid that is not used.
  std::erase_if(std::get<documents::DocumentValue::Table>(over.document.root.data),
                [](const documents::DocumentEntry& entry) { return entry.key == "grid"; });
  return over;
}

}  // namespace vrda::load
