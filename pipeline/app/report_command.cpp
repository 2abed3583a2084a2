#include "app/report_command.hpp"

#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <thread>

#include "app/output_file.hpp"
#include "app/player_stills.hpp"
#include "app/remeasure.hpp"
#include "reduce/reduce.hpp"
#include "report/findings.hpp"
#include "report/page.hpp"
#include "store/motion_model_file.hpp"

namespace vrda {
namespace {

#ifndef VRDA_VERSION
#error "the version of the program"
#endif

RawExtremes raw_extremes(const MotionModel& model)
{
  const int n_threads = std::max(1, static_cast<int>(std::thread::hardware_concurrency()));
  const AuditExtremes audit = extremes(model, remeasured(model, n_threads));
  return {audit.n_overlapping, audit.largest_penetration_mm, audit.largest_gap_mm};
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

// The flexion-only motion is the first thing a reader looks for: a file without it gets that of its raw cells.
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
    entry.model = read_motion_model(file);
    require_solved(entry.model, file);
    entry.model = reduced(std::move(entry.model));
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
  write_file(file, report_page(report));
  std::printf("%s\n", options.as_json ? report_json(report).c_str() : file.c_str());
  return ExitCode::done;
}

}  // namespace vrda
