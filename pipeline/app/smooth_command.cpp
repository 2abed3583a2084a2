#include "app/smooth_command.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <nlohmann/json.hpp>
#include <utility>
#include <vector>

#include "audit/recontact.hpp"
#include "run/json_number.hpp"
#include "run/run_output.hpp"
#include "run/solved_model.hpp"
#include "smooth/smooth.hpp"
#include "store/motion_model_file.hpp"

namespace vrda {
namespace {

using Json = nlohmann::ordered_json;

// Audits of a set that became another go with it.
void say_what_went(const std::vector<AuditSet>& before, const std::vector<AuditSet>& after)
{
  for (const AuditSet& audit : before) {
    const bool is_there = std::any_of(after.begin(), after.end(),
                                      [&](const AuditSet& other) { return other.name == audit.name; });
    if (!is_there) say("dropped /audit/" + audit.name + ", which measured the set before");
  }
}

struct Travels {
  Eigen::Index n_without_contact = 0;
  double least_mm = 0.0, largest_mm = 0.0, rms_mm = 0.0;
};

Travels travels_of(const GridD& travel_mm)
{
  Travels t;
  Eigen::Index n = 0;
  double sum_sq_mm2 = 0.0;
  for (Eigen::Index cell = 0; cell < travel_mm.size(); ++cell) {
    const double mm = travel_mm.data()[cell];
    if (std::isnan(mm)) continue;
    t.least_mm = n == 0 ? mm : std::min(t.least_mm, mm);
    t.largest_mm = n == 0 ? mm : std::max(t.largest_mm, mm);
    sum_sq_mm2 += mm * mm;
    ++n;
  }
  t.n_without_contact = travel_mm.size() - n;
  if (n > 0) t.rms_mm = std::sqrt(sum_sq_mm2 / static_cast<double>(n));
  return t;
}

Json json_of(const SmoothedSet& set)
{
  Json surfaces = Json::object();
  for (const SmoothedSurface& s : set.surfaces) {
    surfaces[s.name] = {{"rms", s.rms},
                        {"largest_residual", s.largest_residual},
                        {"leave_one_out_rms", number_or_null(s.leave_one_out_rms)},
                        {"cells", s.n_cells},
                        {"condition_number", s.condition_number}};
  }
  Json recontact;
  if (set.recontact_mm) {
    const Travels t = travels_of(*set.recontact_mm);
    recontact = {{"attitudes", set.recontact_mm->size()},
                 {"without_contact", t.n_without_contact},
                 {"least_travel_mm", t.least_mm},
                 {"largest_travel_mm", t.largest_mm},
                 {"rms_travel_mm", t.rms_mm}};
  }
  return {
      {"degree", set.degree}, {"robust", set.is_robust}, {"surfaces", surfaces}, {"recontact", recontact}};
}

void print(const SmoothedSet& set)
{
  std::printf("smoothed, degree %d: %d terms%s; mm and degrees\n", set.degree,
              static_cast<int>(set.exponents.rows()), set.is_robust ? ", robust" : "");
  std::printf("  %-6s %-10s %-10s %-14s %-6s %s\n", "", "RMS", "largest", "leave-one-out", "cells",
              "condition");
  for (const SmoothedSurface& s : set.surfaces) {
    std::printf("  %-6s %-10.4g %-10.4g %-14.4g %-6d %.3g\n", s.name.c_str(), s.rms, s.largest_residual,
                s.leave_one_out_rms, s.n_cells, s.condition_number);
  }
  if (!set.recontact_mm) return;
  const Travels t = travels_of(*set.recontact_mm);
  std::printf(
      "recontacted: travel along Delta %.4g to %.4g mm, RMS %.4g; %d of %d attitudes without contact\n",
      t.least_mm, t.largest_mm, t.rms_mm, static_cast<int>(t.n_without_contact),
      static_cast<int>(set.recontact_mm->size()));
}

}  // namespace

ExitCode smooth_command(const SmoothCommandOptions& options)
{
  const std::optional<OutputLock> lock = locked_output(options.file, "vrda smooth");
  if (!lock) return ExitCode::interrupted;
  MotionModel model = read_solved_model(options.file);
  SmoothFit fit = smooth_fit(smooth_input(model, options.file), options.degree, {options.is_robust});
  if (std::find(fit.is_converged.begin(), fit.is_converged.end(), false) != fit.is_converged.end())
    warn("the robust weights had not settled after all steps");
  SmoothedSet set = std::move(fit.set);
  if (options.is_recontacted) set.recontact_mm = recontact(model, set, threads_or_all(options.n_threads));
  const std::vector<AuditSet> audits = model.audits;
  model = with_smoothed(std::move(model), set);
  write_motion_model(options.file, model);
  say_what_went(audits, model.audits);
  if (options.as_json) {
    std::printf("%s\n", json_of(set).dump(2).c_str());
  } else {
    print(set);
  }
  return ExitCode::done;
}

}  // namespace vrda
