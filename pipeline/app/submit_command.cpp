// `vrda submit` and `vrda resume`: write a submission and start its tasks that have no result, as Slurm jobs,
// as local processes, or as a plan only.
#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <set>

#include "app/commands.hpp"
#include "app/printing.hpp"
#include "core/console.hpp"
#include "core/document.hpp"
#include "core/files.hpp"
#include "core/process.hpp"
#include "core/text.hpp"
#include "job/case.hpp"
#include "job/job.hpp"
#include "run/campaign.hpp"
#include "run/local_run.hpp"
#include "run/run_output.hpp"
#include "run/slurm.hpp"
#include "run/status.hpp"

namespace vrda::app {
namespace {

using Json = nlohmann::ordered_json;
namespace fs = std::filesystem;

/// How start_tasks starts the tasks of a submission.
struct StartOptions {
  bool is_dry = false;
  bool is_local = false;
  int n_workers = 0;  ///< concurrent local processes; 0: one per processor
  bool as_json = false;
};

/// `vrda submit` and `vrda resume`: run the cases of a job or campaign through Slurm or local processes.
struct SubmitOptions : job::JobSource {
  std::string folder;  ///< empty: results/NAME
  int n_shards = 1;    ///< shards per case
  run::SlurmOptions slurm;
  StartOptions start;
};

struct ResumeOptions {
  std::string folder;
  run::SlurmOptions slurm;  ///< an empty or 0 option keeps its submitted value
  StartOptions start;
};

std::string dumped(const Json& json)
{
  return core::json_text(json, 2);
}

core::ExitCode run_here(const std::string& folder, const run::Submission& submission, const run::Work& work,
                        const StartOptions& options)
{
  const int n_workers = run::thread_count_or_all(options.n_workers);
  run::LocalOptions local;
  local.n_workers = n_workers;
  local.n_cpus = std::max({1, submission.slurm.cpus, run::thread_count_or_all(0) / n_workers});
  local.is_stop_requested = core::is_interrupted;
  local.report = core::log_info;
  core::install_signal_handlers();
  const run::LocalOutcome outcome =
      run::run_locally(folder, submission, run::jobs_of_work(submission, work, run::no_limits), local);
  if (options.as_json) {
    std::printf("%s\n", dumped({{"folder", folder},
                                {"done", outcome.n_done},
                                {"failed", outcome.n_failed},
                                {"left_out", outcome.n_skipped},
                                {"interrupted", outcome.is_interrupted}})
                            .c_str());
  } else {
    std::printf("%s\n", folder.c_str());
  }
  if (outcome.n_failed > 0) {
    core::log_warning(std::to_string(outcome.n_failed) + " tasks failed; " +
                      std::to_string(outcome.n_skipped) +
                      " tasks that depend on them did not start: see vrda status " + folder);
  }
  if (!outcome.is_interrupted) return static_cast<core::ExitCode>(outcome.worst_code);
  core::log_info("interrupted; to resume: vrda resume " + folder + " --local");
  return core::ExitCode::interrupted;
}

core::ExitCode print_plan(const std::string& folder, const run::Submission& submission, const run::Work& work)
{
  run::SlurmLimits limits;
  try {
    limits = run::query_limits();
  } catch (const InputError& error) {
    core::log_warning(std::string(error.what()) + "; using Slurm's defaults");
  }
  const std::vector<run::PlannedJob> jobs = run::jobs_of_work(submission, work, limits);
  std::set<run::TaskKind> kinds;
  for (const run::PlannedJob& job : jobs) kinds.insert(job.kind);
  for (const run::TaskKind kind : kinds) {
    std::printf("==> scripts/%s <==\n%s\n", run::script_name_of(kind).c_str(),
                run::script_of(kind, folder, submission).c_str());
  }
  std::printf("==> commands <==\n%s", run::sbatch_lines(folder, submission, jobs).c_str());
  return core::ExitCode::done;
}

void print_tasks(const run::Submission& submission, const run::Work& work)
{
  for (const run::PlannedJob& job : run::jobs_of_work(submission, work, run::no_limits)) {
    for (const run::TaskId& task : run::tasks_of(submission, job))
      std::printf("%s\n", run::full_text_of(task, submission).c_str());
  }
}

Json json_of(const run::Submission& submission, const run::SubmittedJob& submitted)
{
  const run::PlannedJob& job = submitted.job;
  const run::TaskId task{job.kind, job.case_number, 0};
  const Json name = job.case_number < 0 ? Json() : Json(run::case_of(submission, task).spec.name);
  return {{"id", submitted.id},
          {"kind", core::name_of(job.kind)},
          {"case", name},
          {"array", job.numbers.empty() ? Json() : Json(run::ranges_text(job.numbers))}};
}

core::ExitCode start_tasks(const std::string& folder, const run::Submission& submission,
                           const run::Work& work, const StartOptions& options)
{
  if (options.is_dry && options.is_local) {
    print_tasks(submission, work);
    return core::ExitCode::done;
  }
  if (options.is_dry) return print_plan(folder, submission, work);
  if (options.is_local) return run_here(folder, submission, work, options);
  const std::vector<run::PlannedJob> jobs = run::jobs_of_work(submission, work, run::query_limits());
  run::write_scripts(folder, submission, jobs);
  const std::vector<run::SubmittedJob> submitted = run::submit_jobs(folder, submission, jobs);
  if (!options.as_json) {
    for (const std::string& line : run::lines_of(submission, submitted)) std::printf("%s\n", line.c_str());
    return core::ExitCode::done;
  }
  Json list = Json::array();
  for (const run::SubmittedJob& job : submitted) list.push_back(json_of(submission, job));
  std::printf("%s\n", dumped({{"folder", folder}, {"jobs", list}}).c_str());
  return core::ExitCode::done;
}

std::string folder_of(const SubmitOptions& options)
{
  if (!options.folder.empty()) return run::absolute_folder(options.folder);
  return run::absolute_folder("results/" + run::result_name_of(options.job_file));
}

std::string program_for_tasks()
{
  const std::string program = own_program();
  if (program.empty())
    throw InputError({"/proc/self/exe", "", "an unreadable link", "the path of this program"});
  return fs::absolute(program).lexically_normal().string();
}

job::Job job_of(const run::Campaign& campaign, const run::CampaignCase& one)
{
  try {
    return job::read_job(one.spec.job_file, one.spec.overrides);
  } catch (const InputError& error) {
    throw run::error_of_case(campaign, one, error);
  }
}

run::Submission submission_of(const SubmitOptions& options)
{
  const run::Campaign campaign =
      run::campaign_of(options.job_file, options.data_directory, options.overrides);
  run::Submission submission;
  submission.program = program_for_tasks();
  submission.title = campaign.title;
  submission.axes = campaign.axes;
  submission.n_shards = options.n_shards;
  submission.slurm = options.slurm;
  submission.permits_missing_locks = are_missing_locks_permitted();
  const bool is_single = campaign.axes.empty() && campaign.cases.size() == 1;
  for (const run::CampaignCase& c : campaign.cases) {
    const job::Job job = job_of(campaign, c);
    run::SubmittedCase submitted;
    submitted.spec = c.spec;
    submitted.levels = c.levels;
    submitted.output = (is_single ? "" : c.spec.name + "/") + c.spec.name + ".h5";
    submitted.n_flexion = static_cast<std::int32_t>(job.grid.flexion_deg.size());
    submitted.n_varus = static_cast<std::int32_t>(job.grid.varus_deg.size());
    if (const auto* samples = core::find_at(job.document.root, "uncertainty.samples"))
      submitted.n_samples = static_cast<std::int32_t>(core::integer_at(*samples, ""));
    submission.cases.push_back(submitted);
  }
  // Checks the meshes before the job is queued. For a campaign vrda plan checks every mesh.
  if (is_single) {
    const run::CaseSpec& spec = submission.cases.front().spec;
    job::load_case(spec.job_file, {spec.data_directory, spec.overrides});
  }
  return submission;
}

void require_slurm_options(const run::SlurmOptions& slurm)
{
  run::require_valid_options(slurm);
  constexpr const char* alternative = ", or --local to run on this machine";
  if (slurm.time.empty())
    throw InputError(
        {"--time", "", "nothing", std::string("the time limit per task, such as 2:00:00") + alternative});
  if (slurm.memory.empty())
    throw InputError(
        {"--mem", "", "nothing", std::string("the memory per task, such as 500M") + alternative});
}

// A folder holds one submission, and only its models.
void require_new(const std::string& folder, const run::Submission& submission)
{
  if (fs::exists(run::submission_file_of(folder))) {
    const bool is_same = run::read_submission(folder) == submission;
    throw InputError({folder, "", is_same ? "the same submission" : "another submission",
                      is_same ? "vrda resume FOLDER" : "another folder (-o), or vrda resume FOLDER"});
  }
  for (const run::SubmittedCase& c : submission.cases) {
    if (!fs::exists(run::output_of(folder, c))) continue;
    throw InputError({run::output_of(folder, c), "", "a motion model that does not belong to a submission",
                      "another folder (-o), or this file moved away"});
  }
}

void make_folders(const std::string& folder)
{
  for (const std::string& one :
       {folder, run::scripts_of(folder), run::logs_of(folder), run::tasks_of(folder)})
    run::make_folder(one);
}

// If Slurm accepted no job, the command can be repeated with other options.
void remove_submission(const std::string& folder)
{
  std::error_code ignored;
  for (const char* name : {"submission.json", "submitted.jsonl", "submission.lock"}) {
    fs::remove(fs::path(folder) / name, ignored);
  }
  fs::remove_all(run::scripts_of(folder), ignored);
  for (const std::string& one : {run::logs_of(folder), run::tasks_of(folder), folder})
    fs::remove(one, ignored);
}

core::ExitCode submit_command(const SubmitOptions& options)
{
  if (!options.start.is_local) require_slurm_options(options.slurm);
  const std::string folder = folder_of(options);
  if (!options.start.is_local) run::require_log_folder(folder);
  const run::Submission submission = submission_of(options);
  const run::Work work = run::all_work(submission);
  require_new(folder, submission);
  if (options.start.is_dry) return start_tasks(folder, submission, work, options.start);
  make_folders(folder);
  const OpenFile lock = run::locked_submission(folder);
  require_new(folder, submission);
  run::write_submission(folder, submission);
  try {
    return start_tasks(folder, submission, work, options.start);
  } catch (const InputError&) {
    if (!options.start.is_local && run::read_submitted(folder).empty()) remove_submission(folder);
    throw;
  }
}

// With the options that are given, neither empty nor 0.
run::SlurmOptions changed(run::SlurmOptions slurm, const run::SlurmOptions& given)
{
  for_each_field(slurm, [&]<typename Member>(const auto& field, Member& member) {
    if (!(given.*field.member == Member{})) member = given.*field.member;
  });
  return slurm;
}

void say_reasons(const std::vector<std::string>& reasons)
{
  constexpr std::size_t most = 20;
  for (std::size_t k = 0; k < std::min(most, reasons.size()); ++k) core::log_info(reasons[k]);
  if (reasons.size() > most)
    core::log_info("and " + std::to_string(reasons.size() - most) + " more: vrda status");
}

void require_options(const ResumeOptions& options, const run::Submission& submission,
                     const run::MissingWork& missing)
{
  if (options.start.is_local) {
    if (missing.n_active == 0) return;
    throw InputError({"--local", "", std::to_string(missing.n_active) + " tasks in Slurm's queue",
                      "vrda resume without --local, or scancel first"});
  }
  run::require_log_folder(run::absolute_folder(options.folder));
  run::require_valid_options(submission.slurm);
  if (submission.slurm.time.empty()) {
    throw InputError({"--time", "", "nothing", "the time limit per task, or --local as before"});
  }
}

// The node whose launch failed may be repaired by now, or another node may start the task.
void release_held(const run::SubmissionSnapshot& snapshot)
{
  std::vector<std::string> held;
  for (const auto& [task, queue] : snapshot.slurm) {
    const bool is_new = std::find(held.begin(), held.end(), queue.job) == held.end();
    if (is_new && run::is_held_after_failed_launch(queue.row)) held.push_back(queue.job);
  }
  if (held.empty()) return;
  run::release_jobs(held);
  for (const std::string& job : held)
    core::log_info(job + " is released: Slurm had held it because its launch failed");
}

core::ExitCode say_nothing_is_missing(const std::string& folder, const run::MissingWork& missing,
                                      bool as_json)
{
  if (as_json) {
    const nlohmann::ordered_json json = {{"folder", folder}, {"jobs", nlohmann::ordered_json::array()}};
    print_json(json);
  }
  const std::string rest = missing.n_active == 0
                               ? "all results are complete"
                               : std::to_string(missing.n_active) + " tasks are queued or running";
  core::log_info("nothing is missing: " + rest);
  return core::ExitCode::done;
}

core::ExitCode resume_command(const ResumeOptions& options)
{
  const std::string folder = run::absolute_folder(options.folder);
  run::read_submission(folder);  // refuses another folder before a lock file is made
  const OpenFile lock = run::locked_submission(folder);
  // Read under the lock: another resume may have changed its options meanwhile.
  run::Submission submission = run::read_submission(folder);
  const run::SubmissionSnapshot snapshot = run::take_snapshot(folder, submission);
  if (!snapshot.remark.empty())
    throw InputError(
        {folder, "", "no state of its tasks from Slurm: " + snapshot.remark, "a reachable Slurm"});
  if (!options.start.is_local && !options.start.is_dry) release_held(snapshot);
  const run::MissingWork missing =
      run::find_missing_work(folder, submission, run::status_of(folder, submission, snapshot), snapshot);
  if (missing.work.is_empty()) return say_nothing_is_missing(folder, missing, options.start.as_json);
  const run::Submission before = submission;
  submission.slurm = changed(submission.slurm, options.slurm);
  submission.permits_missing_locks |= are_missing_locks_permitted();
  require_options(options, submission, missing);
  if (options.slurm.cases_per_task > 0)
    run::require_same_cases_per_task(snapshot.slurm, options.slurm.cases_per_task);
  say_reasons(missing.reasons);
  if (options.start.is_dry) return start_tasks(folder, submission, missing.work, options.start);
  for (const std::string& one : {run::scripts_of(folder), run::logs_of(folder), run::tasks_of(folder)})
    run::make_folder(one);
  if (!(submission == before)) run::write_submission(folder, submission);
  if (const auto fault = run::cancel_jobs(missing.to_cancel)) throw InputError(*fault);
  return start_tasks(folder, submission, missing.work, options.start);
}

// Accepts --extra "#SBATCH --constraint=avx2" and --extra "--constraint=avx2".
std::string without_prefix(const std::string& line)
{
  constexpr std::string_view prefix = "#SBATCH ";
  return line.starts_with(prefix) ? line.substr(prefix.size()) : line;
}

void declare_slurm(Command& c, run::SlurmOptions& slurm)
{
  c.option("--partition", slurm.partition, "Slurm partition; default: the cluster's")
      .from_environment("SBATCH_PARTITION");
  c.option("--time", slurm.time, "Time limit per task in sbatch format: 30 (minutes), 2:00:00");
  c.option("--mem", slurm.memory, "Memory per task: 500M, 2G");
  c.option("--cpus", slurm.cpus, "Processors and threads per task").whole_number(1, 1024);
  c.option("--account", slurm.account, "Slurm account").from_environment("SBATCH_ACCOUNT");
  c.option("--qos", slurm.qos, "Slurm quality of service").from_environment("SBATCH_QOS");
  c.option("--max-parallel", slurm.max_parallel, "Concurrent tasks per job array; default: no limit")
      .whole_number(1, most_tasks);
  c.option("--cases-per-task", slurm.cases_per_task,
           "Cases that each task solves in sequence; default: as few as Slurm's queue limits allow")
      .whole_number(1, most_tasks);
  c.option("--extra", slurm.extra,
           "Additional line of the scripts, \"#SBATCH --constraint=avx2\"; may be repeated")
      .repeatable();
}

// How tasks are started, of submit and resume.
void declare_start(Command& c, StartOptions& start)
{
  c.flag("--local", start.is_local,
         "Run local processes instead of Slurm tasks; returns when all have ended");
  c.option("--workers", start.n_workers, "Concurrent local processes; default: one per processor")
      .whole_number(1, 1024);
  c.flag("--dry-run", start.is_dry, "Print the scripts and the sbatch commands; write nothing");
  c.json(start.as_json);
}

}  // namespace

void declare_submit(Command& c)
{
  auto& o = c.options<SubmitOptions>();
  c.cases(o, o.n_shards);
  c.option("-o,--output", o.folder,
           "Folder of the submission; default: results/NAME, named by job and folder");
  declare_slurm(c, o.slurm);
  declare_start(c, o.start);
  c.runs([&o] {
    for (std::string& line : o.slurm.extra) line = without_prefix(line);
    return submit_command(o);
  });
}

void declare_resume(Command& c)
{
  auto& o = c.options<ResumeOptions>();
  c.option("folder", o.folder, "Folder of the submission").required();
  o.slurm.cpus = 0;  // keep the submitted value
  declare_slurm(c, o.slurm);
  declare_start(c, o.start);
  c.runs([&o] {
    for (std::string& line : o.slurm.extra) line = without_prefix(line);
    return resume_command(o);
  });
}

}  // namespace vrda::app
