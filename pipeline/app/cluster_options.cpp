#include "app/cluster_options.hpp"

#include <CLI/CLI.hpp>

#include "app/usage.hpp"

namespace vrda::app {
namespace {

constexpr int most_tasks = 100000;

// Accepts --extra "#SBATCH --constraint=avx2" and --extra "--constraint=avx2".
std::string without_prefix(const std::string& line)
{
  constexpr std::string_view prefix = "#SBATCH ";
  return line.starts_with(prefix) ? line.substr(prefix.size()) : line;
}

void add_slurm_options(CLI::App& c, run::SlurmOptions& slurm)
{
  c.add_option("--partition", slurm.partition, "Slurm partition; default: the cluster's")
      ->envname("SBATCH_PARTITION");
  c.add_option("--time", slurm.time, "Time limit per task in sbatch format: 30 (minutes), 2:00:00");
  c.add_option("--mem", slurm.memory, "Memory per task: 500M, 2G");
  c.add_option("--cpus", slurm.cpus, "Processors and threads per task")->check(whole_number(1, 1024));
  c.add_option("--account", slurm.account, "Slurm account")->envname("SBATCH_ACCOUNT");
  c.add_option("--qos", slurm.qos, "Slurm quality of service")->envname("SBATCH_QOS");
  c.add_option("--max-parallel", slurm.max_parallel, "Concurrent tasks per job array; default: no limit")
      ->check(whole_number(1, most_tasks));
  c.add_option("--cases-per-task", slurm.cases_per_task,
               "Cases that each task solves in sequence; default: as few as Slurm's queue limits allow")
      ->check(whole_number(1, most_tasks));
  c.add_option_function<std::vector<std::string>>(
       "--extra",
       [&slurm](const std::vector<std::string>& lines) {
         for (const std::string& line : lines) slurm.extra.push_back(without_prefix(line));
       },
       "Additional line of the scripts, \"#SBATCH --constraint=avx2\"; may be repeated")
      ->allow_extra_args(false)
      ->take_all();
}

// Shared by plan and submit.
template <typename Options>
void add_job_options(CLI::App& c, Options& options)
{
  c.add_option("job", options.job_file, "Job or campaign file (TOML)")->required();
  c.add_option("--data", options.data_directory, "Base folder of relative mesh file names");
  add_overrides(c, options.overrides);
  c.add_option("--shards", options.n_shards, "Shards (tasks) per case")
      ->check(whole_number(1, most_tasks))
      ->capture_default_str();
}

void add_local_options(CLI::App& c, bool& is_local, int& n_workers, bool& is_dry, bool& as_json)
{
  c.add_flag("--local", is_local, "Run local processes instead of Slurm tasks; returns when all have ended");
  c.add_option("--workers", n_workers, "Concurrent local processes; default: one per processor")
      ->check(whole_number(1, 1024));
  c.add_flag("--dry-run", is_dry, "Print the scripts and the sbatch commands; write nothing");
  c.add_flag("--json", as_json, "Print JSON");
}

}  // namespace

void ClusterOptions::add_to(const AddCommand& add, std::function<core::ExitCode()>& chosen)
{
  add_plan(add, chosen);
  add_submit(add, chosen);
  add_status(add, chosen);
  add_resume(add, chosen);
  add_index(add, chosen);
  add_task(add, chosen);
}

void ClusterOptions::add_plan(const AddCommand& add, std::function<core::ExitCode()>& chosen)
{
  CLI::App& c =
      add("plan", "Check the cases of a job or campaign and list their estimated cost; solve nothing.",
          "vrda plan jobs/campaign-example.toml");
  add_job_options(c, plan_);
  c.add_flag("--json", plan_.as_json, "Print JSON");
  c.callback([this, &chosen] { chosen = [this] { return plan_command(plan_); }; });
}

void ClusterOptions::add_index(const AddCommand& add, std::function<core::ExitCode()>& chosen)
{
  CLI::App& c = add("index", "Tabulate the results of a submission: one row per case, as CSV and HDF5.",
                    "vrda index results/campaign-example");
  c.add_option("folder", index_.folder, "Folder of the submission")->required();
  c.add_option("--cpus", index_.n_processes, "Processes that read motion models; default: one per processor")
      ->check(whole_number(1, 1024));
  c.add_flag("--json", index_.as_json, "Print JSON");
  c.callback([this, &chosen] { chosen = [this] { return index_command(index_); }; });
}

void ClusterOptions::add_submit(const AddCommand& add, std::function<core::ExitCode()>& chosen)
{
  CLI::App& c = add("submit", "Run the cases of a job or campaign as Slurm tasks or local processes.",
                    "vrda submit jobs/knee-generic.toml --shards 8 --partition batch --time 30 --mem 500M\n  "
                    "vrda submit jobs/knee-generic.toml --shards 8 --local");
  add_job_options(c, submit_);
  c.add_option("-o,--output", submit_.folder, "Folder of the submission; default results/<job name>");
  add_slurm_options(c, submit_.slurm);
  add_local_options(c, submit_.is_local, submit_.n_workers, submit_.is_dry, submit_.as_json);
  c.callback([this, &chosen] { chosen = [this] { return submit_command(submit_); }; });
}

void ClusterOptions::add_resume(const AddCommand& add, std::function<core::ExitCode()>& chosen)
{
  CLI::App& c = add("resume", "Submit the missing tasks of a submission; given options replace its own.",
                    "vrda resume results/knee-generic --time 1:00:00");
  c.add_option("folder", resume_.folder, "Folder of the submission")->required();
  resume_.slurm.cpus = 0;  // keep the submitted value
  add_slurm_options(c, resume_.slurm);
  add_local_options(c, resume_.is_local, resume_.n_workers, resume_.is_dry, resume_.as_json);
  c.callback([this, &chosen] { chosen = [this] { return resume_command(resume_); }; });
}

void ClusterOptions::add_status(const AddCommand& add, std::function<core::ExitCode()>& chosen)
{
  CLI::App& c = add("status", "Print the progress of a submission by task, or of a campaign by case.",
                    "vrda status results/knee-generic");
  c.add_option("folder", status_.folder, "Folder of the submission")->required();
  c.add_option("--case", status_.case_name, "Print the tasks of this case of a campaign");
  c.add_flag("--json", status_.as_json, "Print everything as JSON");
  c.callback([this, &chosen] { chosen = [this] { return status_command(status_); }; });
}

void ClusterOptions::add_task(const AddCommand& add, std::function<core::ExitCode()>& chosen)
{
  CLI::App& c = add("task", "Run one task of a submission; called by its scripts and local processes.",
                    "vrda task results/knee-generic --kind shard --case knee-generic --shard 3");
  c.add_option("folder", task_.folder, "Folder of the submission")->required();
  c.add_option("--kind", task_.kind, "spine, shard, merge, run or index")->required();
  CLI::Option* name = c.add_option("--case", task_.case_name, "Name of the case");
  c.add_option("--first", task_.first, "Number of the case, from 1")->excludes(name);
  c.add_option("--count", task_.count, "Cases to run in sequence")->check(whole_number(1, most_tasks));
  c.add_option("--shard", task_.shard, "Number of the shard, from 1");
  c.add_option("--cpus", task_.n_cpus, "Threads")->check(whole_number(1, 1024));
  c.add_option("--ended", task_.recorded_exit_code,
               "Only record that a signal ended the task, with this exit code of its script")
      ->check(whole_number(129, 255));
  c.callback([this, &chosen] { chosen = [this] { return task_command(task_); }; });
}

}  // namespace vrda::app
