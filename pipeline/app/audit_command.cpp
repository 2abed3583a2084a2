#include "app/audit_command.hpp"

#include <algorithm>
#include <cstdio>
#include <nlohmann/json.hpp>
#include <vector>

#include "audit/audit.hpp"
#include "core/error.hpp"
#include "motion/poses.hpp"
#include "run/run_output.hpp"
#include "run/solved_model.hpp"
#include "store/motion_model_file.hpp"

namespace vrda {
namespace {

using Json = nlohmann::ordered_json;

std::vector<std::string> chosen_sets(const MotionModel& model, const AuditOptions& options)
{
  const std::vector<std::string> names = set_names(model);
  if (options.set == "all") return names;
  if (std::find(names.begin(), names.end(), options.set) != names.end()) return {options.set};
  std::string wanted = "all";
  for (const std::string& name : names) wanted += ", " + name;
  throw InputError({options.file, "--set", options.set, "one of " + wanted});
}

Json json_of(const AuditExtreme& extreme, int n)
{
  if (n == 0) return {};
  return {{"mm", extreme.value_mm}, {"flexion_deg", extreme.flexion_deg}, {"varus_deg", extreme.varus_deg}};
}

Json json_of(const AuditSet& set)
{
  const AuditFigures f = figures_of(set);
  const int n_free = f.n_poses - f.n_overlapping - f.n_nothing_ahead;
  return {{"set", set.name},
          {"refine", set.refine},
          {"attitudes", set.state.size()},
          {"poses", f.n_poses},
          {"overlapping", f.n_overlapping},
          {"nothing_ahead", f.n_nothing_ahead},
          {"largest_penetration", json_of(f.largest_penetration, f.n_overlapping)},
          {"mean_penetration_mm", f.n_overlapping > 0 ? Json(f.mean_penetration_mm) : Json()},
          {"largest_gap", json_of(f.largest_gap, n_free)},
          {"mean_gap_mm", n_free > 0 ? Json(f.mean_gap_mm) : Json()}};
}

// "0.0123 at 45, -2.5", or a dash.
std::string place_of(const AuditExtreme& extreme, int n)
{
  if (n == 0) return "-";
  char text[96];
  std::snprintf(text, sizeof text, "%.3g at %g, %g", extreme.value_mm, extreme.flexion_deg,
                extreme.varus_deg);
  return text;
}

std::string mean_of(double mean_mm, int n)
{
  if (n == 0) return "-";
  char text[32];
  std::snprintf(text, sizeof text, "%.3g", mean_mm);
  return text;
}

void print(const std::vector<AuditSet>& sets)
{
  constexpr const char* row = "%-22s %6s %8s %11s  %-24s %-10s %-24s %-10s %s\n";
  std::printf("lengths in mm along Delta, attitudes as flexion, varus in degrees\n");
  std::printf(row, "set", "refine", "poses", "overlapping", "largest penetration", "mean", "largest gap",
              "mean", "nothing ahead");
  for (const AuditSet& set : sets) {
    const AuditFigures f = figures_of(set);
    const int n_free = f.n_poses - f.n_overlapping - f.n_nothing_ahead;
    std::printf(
        row, set.name.c_str(), std::to_string(set.refine).c_str(), std::to_string(f.n_poses).c_str(),
        std::to_string(f.n_overlapping).c_str(), place_of(f.largest_penetration, f.n_overlapping).c_str(),
        mean_of(f.mean_penetration_mm, f.n_overlapping).c_str(), place_of(f.largest_gap, n_free).c_str(),
        mean_of(f.mean_gap_mm, n_free).c_str(), std::to_string(f.n_nothing_ahead).c_str());
  }
}

}  // namespace

ExitCode audit_command(const AuditOptions& options)
{
  const std::optional<OutputLock> lock = locked_output(options.file, "vrda audit");
  if (!lock) return ExitCode::interrupted;
  MotionModel model = read_solved_model(options.file);
  std::vector<AuditSet> measured;
  for (const std::string& set : chosen_sets(model, options)) {
    measured.push_back(audit(model, set, options.refine, threads_or_all(options.n_threads)));
  }
  for (const AuditSet& set : measured) model.audits = with_audit(std::move(model.audits), set);
  write_motion_model(options.file, model);
  if (!options.as_json) {
    print(measured);
    return ExitCode::done;
  }
  Json list = Json::array();
  for (const AuditSet& set : measured) list.push_back(json_of(set));
  std::printf("%s\n", list.dump(2).c_str());
  return ExitCode::done;
}

}  // namespace vrda
