#include "app/laxity_command.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>

#include "core/error.hpp"
#include "core/open_file.hpp"
#include "documents/json_file.hpp"
#include "job_run/job_checks.hpp"
#include "job_run/run_output.hpp"
#include "job_run/summary.hpp"
#include "laxity/laxity_files.hpp"
#include "load/command_jobs.hpp"
#include "load/input_file.hpp"
#include "model_build/case_solver.hpp"

namespace vrda::app {
namespace {

constexpr std::uintmax_t largest_laxity_bytes = 64U << 20U;

// Refuses the result of another job.
void require_same_job(const std::string& file, const std::string& job)
{
  std::error_code error;
  if (!std::filesystem::exists(file, error)) return;
  const std::string wanted = "laxity.json of vrda laxity";
  const documents::JsonFile found(
      file, load::file_bytes(file, {file, "", "no such file", wanted}, largest_laxity_bytes), wanted);
  if (found.text("job") == job) return;
  throw InputError({file, "job", "the result of another job", "this one's, another --output, or --replace"});
}

std::vector<laxity::PublishedValue> published_of(const std::string& file)
{
  if (file.empty()) return {};
  return laxity::published_values(
      file, load::file_bytes(file, {file, "", "", "a CSV file of laxities"}, largest_laxity_bytes));
}

std::string three_digits(double value)
{
  if (std::isnan(value)) return "-";
  char text[32];
  std::snprintf(text, sizeof text, "%.3f", value);
  return text;
}

void print_curves(const laxity::LaxityResult& result)
{
  std::printf("%-10s %-10s %8s %10s %10s %10s  %s\n", "state", "test", "flexion", "load", "laxity", "",
              "largest shares");
  for (const laxity::LaxityCurve& curve : result.curves) {
    const laxity::TestKind& kind = laxity::kind_of(curve.test);
    std::vector<laxity::BundleResistance> rows = curve.bundles;
    if (curve.is_complete()) rows.push_back(curve.contact);
    std::stable_sort(rows.begin(), rows.end(),
                     [](const auto& a, const auto& b) { return a.share > b.share; });
    std::string shares;
    for (std::size_t k = 0; k < rows.size() && k < 3; ++k) {
      char text[32];
      std::snprintf(text, sizeof text, " %.0f %%  ", 100.0 * rows[k].share);
      shares += rows[k].bundle + text;
    }
    std::printf(
        "%-10s %-10s %8.4g %10.6g %10s %10s  %s\n", result.states[curve.state].c_str(), kind.name,
        result.loads.flexion_deg[curve.flexion], curve.poses.back().load,
        three_digits(laxity::in_file_unit(kind, curve.laxity())).c_str(),
        curve.is_complete() ? (kind.is_force() ? "mm" : "degrees") : name_of(curve.poses.back().status),
        shares.c_str());
  }
}

void print_published(const std::vector<laxity::Compared>& compared)
{
  for (const laxity::Compared& one : compared) {
    const laxity::PublishedValue& row = one.published;
    std::printf("%s at %.4g degrees: published %.3f, found %s%s%s\n", row.test.c_str(), row.flexion_deg,
                row.value, three_digits(one.found).c_str(), row.source.empty() ? "" : ", ",
                row.source.c_str());
  }
}

}  // namespace

console::ExitCode laxity_command(const LaxityOptions& o)
{
  const load::Job job = load::read_job(o.job_file, o.overrides);
  if (!job.laxity)
    throw InputError(
        {o.job_file, "laxity", "nothing", "[laxity] with flexion_deg and a load (schemas/laxity.md)"});
  const std::vector<laxity::PublishedValue> published = published_of(o.against);
  const load::Case job_case = load::scaled_to_subject(
      job_run::load_checked_case(load::over_flexions(job, job.laxity->flexion_deg), o.data_directory)
          .job_case);
  for (const std::string& warning : job_case.warnings) console::log_warning(warning);
  const std::filesystem::path folder = o.folder;
  const std::string file = (folder / "laxity.json").string();
  job_run::make_folder(folder.string());
  std::optional<Publication> output = job_run::begin_result(file, "vrda laxity");
  if (!output) return console::ExitCode::interrupted;
  if (!o.may_replace) require_same_job(file, job_case.resolved_job);
  laxity::LaxityPlan plan;
  plan.loads = *job.laxity;
  plan.n_threads = job_run::thread_count_or_all(o.n_threads);
  console::install_signal_handlers();
  plan.is_stopped = console::is_interrupted;
  console::Progress progress(console::progress_style_of(o.progress), "curves",
                             static_cast<int>(laxity::n_curves(plan.loads)), 0);
  plan.on_progress = [&] { progress.advance(); };
  laxity::LaxityDocument document{
      "vrda " VRDA_VERSION, model_build::solver_version_of(job_case),  job_case.title,
      job_case.joint,       job.side == Side::left ? "left" : "right", job_case.resolved_job,
      job_case.inputs,      laxity::laxity_of(job_case, plan),         {}};
  if (document.result.curves.empty()) return console::ExitCode::interrupted;
  document.compared = laxity::compared(document.result, published);
  output->add((folder / "index.html").string(), laxity::laxity_page(document));
  output->add((folder / "laxity.csv").string(), laxity::laxity_csv(document));
  output->add((folder / "share.csv").string(), laxity::share_csv(document));
  output->publish(laxity::laxity_json(document));
  if (o.as_json) {
    std::printf("%s", laxity::laxity_json(document).c_str());
  } else {
    print_curves(document.result);
    print_published(document.compared);
  }
  const bool is_solved = std::all_of(document.result.curves.begin(), document.result.curves.end(),
                                     [](const laxity::LaxityCurve& curve) { return curve.is_complete(); });
  return is_solved ? console::ExitCode::done : console::ExitCode::incomplete;
}

}  // namespace vrda::app
