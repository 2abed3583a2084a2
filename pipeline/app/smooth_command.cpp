#include "app/smooth_command.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <nlohmann/json.hpp>
#include <utility>

#include "app/solved_model.hpp"
#include "audit/recontact.hpp"
#include "smooth/smooth.hpp"
#include "store/motion_model_file.hpp"

namespace vrda {
namespace {

using Json = nlohmann::ordered_json;

bool is_same(double a, double b)
{
  return a == b || (std::isnan(a) && std::isnan(b));
}

bool is_same(const GridD& a, const GridD& b)
{
  if (a.rows() != b.rows() || a.cols() != b.cols()) return false;
  return std::equal(a.data(), a.data() + a.size(), b.data(),
                    [](double x, double y) { return is_same(x, y); });
}

// The motion of both sets is the same; their statistics follow from the model's raw surfaces.
bool is_same_motion(const SmoothedSet& a, const SmoothedSet& b)
{
  if (a.exponents.rows() != b.exponents.rows() || (a.exponents != b.exponents).any()) return false;
  const auto is_same_surface = [](const SmoothedSurface& s, const SmoothedSurface& t) {
    return s.name == t.name && s.coefficients == t.coefficients;
  };
  return std::equal(a.surfaces.begin(), a.surfaces.end(), b.surfaces.begin(), b.surfaces.end(),
                    is_same_surface);
}

bool is_same_recontact(const SmoothedSet& a, const SmoothedSet& b)
{
  if (!a.recontact_mm || !b.recontact_mm) return false;
  return is_same_motion(a, b) && is_same(*a.recontact_mm, *b.recontact_mm);
}

// Audits measured on what `set` is about to replace say nothing of it.
void drop_stale_audits(MotionModel& model, const SmoothedSet& set)
{
  const auto before = std::find_if(model.smoothed.begin(), model.smoothed.end(),
                                   [&](const SmoothedSet& other) { return other.degree == set.degree; });
  const bool has_before = before != model.smoothed.end();
  const std::string name = "degree_" + std::to_string(set.degree);
  std::erase_if(model.audits, [&](const AuditSet& audit) {
    const bool is_stale =
        (audit.name == name && !(has_before && is_same_motion(*before, set))) ||
        (audit.name == name + "_recontacted" && !(has_before && is_same_recontact(*before, set)));
    if (is_stale) say("dropped /audit/" + audit.name + ", which measured the set before");
    return is_stale;
  });
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

Json number_or_null(double value)
{
  return std::isfinite(value) ? Json(value) : Json();
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
  MotionModel model = read_solved_model(options.file);
  SmoothFit fit = smooth_fit(smooth_input(model, options.file), options.degree, {options.is_robust});
  if (std::find(fit.is_converged.begin(), fit.is_converged.end(), false) != fit.is_converged.end())
    warn("the robust weights had not settled after all steps");
  SmoothedSet set = std::move(fit.set);
  if (options.is_recontacted) set.recontact_mm = recontact(model, set, threads_or_all(options.n_threads));
  drop_stale_audits(model, set);
  model.smoothed = with_set(std::move(model.smoothed), set);
  write_motion_model(options.file, model);
  if (options.as_json) {
    std::printf("%s\n", json_of(set).dump(2).c_str());
  } else {
    print(set);
  }
  return ExitCode::done;
}

}  // namespace vrda
