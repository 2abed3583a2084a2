#include "run/merge_command.hpp"

#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <iterator>
#include <set>
#include <utility>

#include "run/case_spec.hpp"
#include "run/jobs.hpp"
#include "core/console.hpp"
#include "core/error.hpp"
#include "run/collect.hpp"
#include "run/result.hpp"
#include "run/run_output.hpp"
#include "run/solve_samples.hpp"
#include "run/summary.hpp"
#include "solve/case_solver.hpp"
#include "store/motion_model_file.hpp"

namespace vrda::run {
namespace {

// A network file system may list a folder up to a minute late; access by name is current.
std::vector<std::string> journals_beside(const std::string& output, std::int32_t n_shards)
{
  std::vector<std::string> journals = store::list_shard_journals(output);
  const std::set<std::string> listed(journals.begin(), journals.end());
  for (std::int32_t number = 1; number <= n_shards; ++number) {
    const std::string journal = store::shard_journal_of(output, {number, n_shards});
    if (listed.count(journal) == 0 && access(journal.c_str(), F_OK) == 0) journals.push_back(journal);
  }
  const std::string spine = store::spine_journal_of(output);
  if (access(spine.c_str(), F_OK) == 0) journals.insert(journals.begin(), spine);
  return journals;
}

// The case file of the run that wrote the journals.
std::string case_file_for(const std::string& output, const std::vector<std::string>& journals)
{
  for (const std::string& journal : journals) {  // renamed copies do not identify their run
    const std::string run = store::output_of_journal(journal);
    const std::string case_file = run::case_file_of(run);
    if (!run.empty() && access(case_file.c_str(), F_OK) == 0) return case_file;
  }
  return run::case_file_of(output);
}

job::Case case_to_merge(const MergeOptions& options, const std::vector<std::string>& journals)
{
  if (!options.job_file.empty())
    return load_and_report_case(options.job_file, {options.data_directory, options.overrides});
  const std::string case_file = case_file_for(options.output, journals);
  const run::CaseSpec spec = run::read_case_file(case_file).spec;
  try {
    return load_and_report_case(spec.job_file, {spec.data_directory, spec.overrides});
  } catch (const InputError& error) {
    throw run::error_of_case_file(case_file, spec, error);
  }
}

// "; no journal of shard 3, 5 of 8", from the journals' names.
std::string absent_shards(const std::vector<std::string>& journals)
{
  std::set<std::pair<std::int32_t, std::int32_t>> present;
  for (const std::string& journal : journals) {
    if (const auto shard = store::shard_of_journal(journal)) present.emplace(shard->count, shard->number);
  }
  if (present.empty()) return "";
  const std::int32_t count = present.begin()->first;
  std::string absent;
  for (std::int32_t number = 1; number <= count; ++number) {
    if (present.count({count, number}) == 0) absent += (absent.empty() ? "" : ", ") + std::to_string(number);
  }
  return absent.empty() ? "" : "; no journal of shard " + absent + " of " + std::to_string(count);
}

// The records of all samples.
std::vector<StepRecord> whole_samples(const job::Case& job_case, const CollectedSteps& collected,
                                      const std::vector<std::string>& journals, const std::string& output)
{
  KnownSamples known = known_samples(job_case, collected.steps);
  if (known.missing.empty()) return std::move(known.records);
  throw InputError({output, "journals",
                    "no result for " + std::to_string(known.missing.size()) + " of " +
                        std::to_string(n_samples_of(job_case)) + " samples" + absent_shards(journals),
                    "complete journals of the spine and of every shard; the journals found are kept"});
}

void require_whole(const job::Case& job_case, const CollectedSteps& collected,
                   const std::vector<std::string>& journals, const std::string& output)
{
  const MissingSteps missing = missing_steps(solve::plan_of(job_case), collected.steps);
  if (missing.is_empty()) return;
  std::string found = missing_text(missing, job_case.grid.flexion_deg, job_case.grid.varus_deg);
  if (!found.empty()) found += absent_shards(journals);
  if (!missing.is_spine_complete) found += found.empty() ? "no complete spine" : "; the spine is incomplete";
  throw InputError({output, "journals", found,
                    "complete journals of the spine and of every shard; the journals found are kept"});
}

std::string doubled_text(const CollectedSteps& collected, const job::Case& job_case)
{
  const std::vector<std::int32_t> rows(collected.duplicate_rows.begin(), collected.duplicate_rows.end());
  std::string text = std::to_string(collected.n_duplicates) +
                     " steps are in more than one journal, with the same result: at flexion " +
                     angles_text(rows, job_case.grid.flexion_deg) + ", in";
  const char* separator = " ";
  for (const std::string& journal : collected.duplicate_journals)
    text += std::exchange(separator, ", ") + journal;
  return text;
}

// Removes the shards' files next to the output; others are copies of the user.
void remove_shard_files(const std::string& output, const std::vector<std::string>& journals)
{
  std::vector<std::string> obsolete;
  std::copy_if(journals.begin(), journals.end(), std::back_inserter(obsolete),
               [&](const std::string& journal) { return store::output_of_journal(journal) == output; });
  obsolete.push_back(store::start_file_of(output));
  obsolete.push_back(
      run::case_file_of(output));  // last: until then it records that the model is complete
  remove_obsolete_files(obsolete);
}

// A complete model without journals and case file, so that its job cannot be compared.
bool is_merged(const std::string& output, const std::vector<std::string>& journals)
{
  if (!journals.empty() || access(run::case_file_of(output).c_str(), F_OK) == 0) return false;
  if (access(output.c_str(), F_OK) != 0) return false;
  return (store::read_motion_model(output).status != status_pending).all();
}

void note_merged(const std::string& output)
{
  const std::string case_file = run::case_file_of(output);
  if (access(case_file.c_str(), F_OK) != 0) return;
  run::CaseFile content = run::read_case_file(case_file);
  content.merged_sha256 = run::sha256_of_model(output);
  run::write_case_file(case_file, content);
}

/// The model is complete; if that cannot be recorded in the case file, the journals are kept for another
/// merge.
void finish_merge(const std::string& output, const std::vector<std::string>& journals)
{
  try {
    note_merged(output);
  } catch (const InputError& error) {
    core::log_warning(error.what());
    return;
  }
  remove_shard_files(output, journals);
}

}  // namespace

core::ExitCode merge_command(const MergeOptions& options)
{
  const std::string& output = options.output;
  make_parent_folder(output);
  const std::optional<OutputLock> lock = lock_output(output, "vrda merge");
  if (!lock) return core::ExitCode::interrupted;
  // Listed under the lock: a merge that this one waited for has removed them.
  const std::vector<std::string> journals =
      options.journals.empty() ? journals_beside(output, options.n_shards) : options.journals;
  require_replaceable(output, "a motion model");
  if (!options.keeps_journals && run::is_cleanup_pending(output)) {
    remove_shard_files(output, journals);
    core::log_info(output + ": already merged");
    return core::ExitCode::done;
  }
  if (is_merged(output, journals)) {
    core::log_info(output + ": complete; there are no journals to merge");
    return core::ExitCode::done;
  }
  const job::Case job_case = case_to_merge(options, journals);
  if (const auto model = existing_result(job_case, output, options.may_replace)) {
    core::log_info(output + ": this job is already merged");
    const core::ExitCode code =
        finish_existing_result(job_case, *model, output, {}, thread_count_or_all(options.n_threads));
    std::printf("%s\n", output.c_str());
    if (!options.keeps_journals) finish_merge(output, journals);
    return code;
  }

  const int n_threads = thread_count_or_all(options.n_threads);
  const CollectedSteps collected = with_difference_in_errors(
      job_case, [&] { return collect_steps(journals, solve::fingerprint_of(job_case)); });
  for (const std::string& remark : collected.warnings) core::log_warning(remark);
  if (collected.n_duplicates > 0) {
    core::log_info(doubled_text(collected, job_case));
  }
  require_whole(job_case, collected, journals, output);
  const std::vector<StepRecord> samples = whole_samples(job_case, collected, journals, output);
  RunRecord record(n_threads, static_cast<int>(collected.steps.size()));
  const solve::SweepResult result = replay_sweep(solve::plan_of(job_case), collected.steps);
  const std::optional<store::MotionModel> model =
      build_result(job_case, result, samples, output, n_threads, core::is_interrupted, record);
  if (!model) {
    core::log_info("interrupted: the journals are kept; run the same command to merge again");
    return core::ExitCode::interrupted;
  }
  const core::ExitCode code = write_result(job_case, *model, output, {}, record);
  std::printf("%s\n", output.c_str());
  if (!options.keeps_journals) finish_merge(output, journals);
  return code;
}

}  // namespace vrda::run
