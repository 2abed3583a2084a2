// `vrda laxity`: loads at held flexions.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>

#include "analysis/laxity.hpp"
#include "app/commands.hpp"
#include "app/printing.hpp"
#include "core/document.hpp"
#include "core/files.hpp"
#include "core/text.hpp"
#include "job/job.hpp"
#include "job/job_parts.hpp"
#include "report/result_pages.hpp"
#include "run/run_command.hpp"
#include "run/run_output.hpp"
#include "solve/case_solver.hpp"

namespace vrda::app {
namespace {

struct LaxityOptions : job::JobSource {
  std::string folder;
  std::string against;  ///< table of published values; empty: none
  bool may_replace = false;
  int n_threads = 0;  ///< 0: one per processor
  std::string progress = "auto";
  bool as_json = false;
};

constexpr std::uintmax_t largest_laxity_bytes = 64U << 20U;

// Refuses the result of another job.
void require_same_job(const std::string& file, const std::string& job)
{
  std::error_code error;
  if (!std::filesystem::exists(file, error)) return;
  const std::string wanted = "laxity.json of vrda laxity";
  const core::JsonFile found(
      file, job::file_bytes(file, {file, "", "no such file", wanted}, largest_laxity_bytes), wanted);
  if (found.text("job") == job) return;
  throw InputError({file, "job", "the result of another job", "this one's, another --output, or --replace"});
}

std::vector<analysis::PublishedValue> published_of(const std::string& file)
{
  if (file.empty()) return {};
  return analysis::published_values(
      file, job::file_bytes(file, {file, "", "", "a CSV file of laxities"}, largest_laxity_bytes));
}

std::string three_digits(double value)
{
  return formatted("%.3f", value);
}

void print_curves(const analysis::LaxityResult& result)
{
  std::printf("%-10s %-10s %8s %10s %10s %10s  %s\n", "state", "test", "flexion", "load", "laxity", "",
              "largest shares");
  for (const analysis::LaxityCurve& curve : result.curves) {
    const analysis::TestKind& kind = analysis::kind_of(curve.test);
    std::vector<analysis::BundleResistance> rows = curve.bundles;
    if (curve.is_complete()) rows.push_back(curve.contact);
    std::stable_sort(rows.begin(), rows.end(),
                     [](const auto& a, const auto& b) { return a.share > b.share; });
    std::string shares;
    for (std::size_t k = 0; k < rows.size() && k < 3; ++k) {
      shares += rows[k].bundle + formatted(" %.0f %%  ", 100.0 * rows[k].share);
    }
    std::printf(
        "%-10s %-10s %8.4g %10.6g %10s %10s  %s\n", result.states[curve.state].c_str(), kind.name,
        result.loads.flexion_deg[curve.flexion], curve.poses.back().load,
        three_digits(analysis::in_file_unit(kind, curve.laxity())).c_str(),
        curve.is_complete() ? (kind.is_force() ? "mm" : "degrees") : name_of(curve.poses.back().status),
        shares.c_str());
  }
}

void print_published(const std::vector<analysis::Compared>& compared)
{
  for (const analysis::Compared& one : compared) {
    const analysis::PublishedValue& row = one.published;
    std::printf("%s at %.4g degrees: published %.3f, found %s%s%s\n", row.test.c_str(), row.flexion_deg,
                row.value, three_digits(one.found).c_str(), row.source.empty() ? "" : ", ",
                row.source.c_str());
  }
}

// Writes laxity.json, laxity.csv, share.csv and index.html into the folder and prints the laxities. Exit
// code 3 if a load has no equilibrium. Throws InputError before solving if the job has no [laxity], or if
// the folder has the result of another job.
core::ExitCode laxity_command(const LaxityOptions& o)
{
  const job::Job job = job::read_job(o.job_file, o.overrides);
  if (!job.laxity)
    throw InputError(
        {o.job_file, "laxity", "nothing", "[laxity] with flexion_deg and a load (schemas/laxity.md)"});
  const std::vector<analysis::PublishedValue> published = published_of(o.against);
  const job::Case job_case = job::scaled_to_subject(
      run::load_checked_case(job::over_flexions(job, job.laxity->flexion_deg), o.data_directory).job_case);
  for (const std::string& warning : job_case.warnings) core::log_warning(warning);
  const std::filesystem::path folder = o.folder;
  const std::string file = (folder / "laxity.json").string();
  run::make_folder(folder.string());
  std::optional<Publication> output = run::begin_result(file, "vrda laxity");
  if (!output) return core::ExitCode::interrupted;
  if (!o.may_replace) require_same_job(file, job_case.resolved_job);
  analysis::LaxityPlan plan;
  plan.loads = *job.laxity;
  plan.n_threads = run::thread_count_or_all(o.n_threads);
  core::install_signal_handlers();
  plan.is_stopped = core::is_interrupted;
  core::Progress progress(core::progress_style_of(o.progress), "curves",
                          static_cast<int>(analysis::n_curves(plan.loads)), 0);
  plan.on_progress = [&] { progress.advance(); };
  analysis::LaxityDocument document{
      "vrda " VRDA_VERSION, solve::solver_version_of(job_case),        job_case.title,
      job_case.joint,       job.side == Side::left ? "left" : "right", job_case.resolved_job,
      job_case.inputs,      analysis::laxity_of(job_case, plan),       {}};
  if (document.result.curves.empty()) return core::ExitCode::interrupted;
  document.compared = analysis::compared(document.result, published);
  output->add((folder / "index.html").string(), report::laxity_page(document));
  output->add((folder / "laxity.csv").string(), analysis::laxity_csv(document));
  output->add((folder / "share.csv").string(), analysis::share_csv(document));
  output->publish(analysis::laxity_json(document));
  if (o.as_json) {
    std::printf("%s", analysis::laxity_json(document).c_str());
  } else {
    print_curves(document.result);
    print_published(document.compared);
  }
  const bool is_solved = std::all_of(document.result.curves.begin(), document.result.curves.end(),
                                     [](const analysis::LaxityCurve& curve) { return curve.is_complete(); });
  return is_solved ? core::ExitCode::done : core::ExitCode::incomplete;
}

}  // namespace

void declare_laxity(Command& c)
{
  auto& o = c.options<LaxityOptions>();
  c.job(o.job_file, "Job file (TOML) with [laxity]; its grid is not used");
  c.option("-o,--output", o.folder, "Output folder: laxity.json, laxity.csv, share.csv, index.html")
      .required();
  c.option("--against", o.against, "Published values (CSV, schemas/laxity.md) to compare with");
  c.loading(o, "Base folder of relative file names");
  c.flag("--replace", o.may_replace, "Replace the result of another job");
  c.threads(o.n_threads);
  c.progress(o.progress);
  c.json(o.as_json);
  c.runs([&o] { return laxity_command(o); });
}

}  // namespace vrda::app
