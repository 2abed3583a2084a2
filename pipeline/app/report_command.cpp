#include "app/report_command.hpp"

#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <limits>
#include <optional>

#include "app/player_stills.hpp"
#include "audit/audit.hpp"
#include "compare/compare.hpp"
#include "core/whole_file.hpp"
#include "motion/poses.hpp"
#include "reduce/reduce.hpp"
#include "report/findings.hpp"
#include "report/page.hpp"
#include "run/output_file.hpp"
#include "run/solved_model.hpp"
#include "smooth/smooth.hpp"

namespace vrda {
namespace {

#ifndef VRDA_VERSION
#error "the version of the program"
#endif

// An audit of the file's own grid, as it stands in the file or measured now.
AuditSet grid_audit(const MotionModel& model, const std::string& set)
{
  for (const AuditSet& stored : model.audits) {
    if (stored.name == set && stored.refine == 1) return stored;
  }
  return audit(model, set, 1, threads_or_all(0));
}

RawExtremes raw_extremes(const MotionModel& model)
{
  const AuditFigures figures = figures_of(grid_audit(model, "raw"));
  const double gap_mm =
      figures.n_nothing_ahead > 0 ? std::numeric_limits<double>::infinity() : figures.largest_gap.value_mm;
  return {figures.n_overlapping, figures.largest_penetration.value_mm, gap_mm};
}

// None where the solved cells cannot carry even the first degree.
std::optional<Comparison> comparison_of(const MotionModel& model, const ReportOptions& options)
{
  if (largest_degree(smooth_input(model, options.files.front())) < 1) return std::nullopt;
  CompareOptions asked;
  asked.name = options.files.front();
  if (!options.is_quick) {
    asked.audit = [](const MotionModel& smoothed, const std::string& set) {
      return audit(smoothed, set, 1, threads_or_all(0));
    };
  }
  return compare(model, asked);
}

// The sets in the file, where it holds no audit of them.
void add_audits(MotionModel& model)
{
  for (const std::string& set : set_names(model)) {
    const bool is_there = std::any_of(model.audits.begin(), model.audits.end(),
                                      [&](const AuditSet& a) { return a.name == set; });
    if (!is_there) model.audits.push_back(audit(model, set, 1, threads_or_all(0)));
  }
}

// Files of one name in several folders stay apart.
std::string unique_name(const std::vector<ReportModel>& models, const std::string& file)
{
  const std::string stem = std::filesystem::path(file).stem().string();
  std::string name = stem;
  for (int k = 2; std::any_of(models.begin(), models.end(), [&](const auto& m) { return m.name == name; });
       ++k)
    name = stem + " (" + std::to_string(k) + ")";
  return name;
}

// The flexion-only motion is the first thing a reader looks for: a file without it gets that of its raw
// cells.
MotionModel reduced(MotionModel model)
{
  if (model.zero_varus || !is_reducible(model)) return model;
  ZeroVarus zero_varus = reduce(model, "raw");
  if (n_reduced(zero_varus) > 0) model.zero_varus = std::move(zero_varus);
  return model;
}

std::vector<ReportModel> models_of(const ReportOptions& options)
{
  std::vector<ReportModel> models;
  for (const std::string& file : options.files) {
    ReportModel entry;
    entry.name = unique_name(models, file);
    entry.model = reduced(read_solved_model(file));
    models.push_back(std::move(entry));
  }
  return models;
}

Report gathered(const ReportOptions& options)
{
  Report report;
  report.program = "vrda " VRDA_VERSION;
  report.models = models_of(options);
  for (const std::string& file : options.against) report.against.push_back(read_curve_file(file));
  const std::string player = player_program(options.player);
  for (ReportModel& entry : report.models) entry.raw = raw_extremes(entry.model);
  if (report.models.size() == 1) {
    ReportModel& only = report.models.front();
    only.comparison = comparison_of(only.model, options);
    if (!options.is_quick) add_audits(only.model);
    only.stills = player_stills(player, options.files.front(), only.model);
    if (!only.stills.note.empty()) warn(only.stills.note);
  }
  return report;
}

}  // namespace

ExitCode report_command(const ReportOptions& options)
{
  const Report report = gathered(options);
  for (const ReportModel& entry : report.models) {
    for (const std::string& line : warnings_of(entry)) say(entry.name + ": " + line);
  }
  make_folder(options.folder);
  const std::string file = (std::filesystem::path(options.folder) / "index.html").string();
  write_whole(file, {report_page(report)});
  std::printf("%s\n", options.as_json ? report_json(report).c_str() : file.c_str());
  return ExitCode::done;
}

}  // namespace vrda
