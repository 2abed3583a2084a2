#include "run/merge_command.hpp"

#include <unistd.h>

#include <algorithm>
#include <iterator>
#include <set>
#include <utility>

#include "assemble/case_solver.hpp"
#include "cluster/case_spec.hpp"
#include "cluster/jobs.hpp"
#include "core/error.hpp"
#include "run/collect.hpp"
#include "run/result.hpp"
#include "run/run_output.hpp"
#include "run/summary.hpp"
#include "store/motion_model_file.hpp"
#include "talk/talk.hpp"

namespace vrda {
namespace {

// A network file system may list a folder up to a minute late; access by name is current.
std::vector<std::string> journals_beside(const std::string& output, std::int32_t n_shards)
{
  std::vector<std::string> journals = shard_journals_beside(output);
  const std::set<std::string> listed(journals.begin(), journals.end());
  for (std::int32_t number = 1; number <= n_shards; ++number) {
    const std::string journal = shard_journal_of(output, {number, n_shards});
    if (listed.count(journal) == 0 && access(journal.c_str(), F_OK) == 0) journals.push_back(journal);
  }
  const std::string spine = spine_journal_of(output);
  if (access(spine.c_str(), F_OK) == 0) journals.insert(journals.begin(), spine);
  return journals;
}

// The case file of the run that wrote the journals.
std::string case_file_for(const std::string& output, const std::vector<std::string>& journals)
{
  for (const std::string& journal : journals) {  // renamed copies do not identify their run
    const std::string run = output_of_journal(journal);
    const std::string case_file = case_file_of(run);
    if (!run.empty() && access(case_file.c_str(), F_OK) == 0) return case_file;
  }
  return case_file_of(output);
}

Case case_to_merge(const MergeOptions& options, const std::vector<std::string>& journals)
{
  if (!options.job_file.empty())
    return announced_case(options.job_file, {options.data_directory, options.overrides});
  const std::string case_file = case_file_for(options.output, journals);
  const CaseSpec spec = read_case_file(case_file).spec;
  try {
    return announced_case(spec.job_file, {spec.data_directory, spec.overrides});
  } catch (const InputError& error) {
    throw fault_of_case_file(case_file, spec, error);
  }
}

// "; no journal of shard 3, 5 of 8", from the journals' names.
std::string absent_shards(const std::vector<std::string>& journals)
{
  std::set<std::pair<std::int32_t, std::int32_t>> present;
  for (const std::string& journal : journals) {
    if (const auto shard = shard_of_journal(journal)) present.emplace(shard->count, shard->number);
  }
  if (present.empty()) return "";
  const std::int32_t count = present.begin()->first;
  std::string absent;
  for (std::int32_t number = 1; number <= count; ++number) {
    if (present.count({count, number}) == 0) absent += (absent.empty() ? "" : ", ") + std::to_string(number);
  }
  return absent.empty() ? "" : "; no journal of shard " + absent + " of " + std::to_string(count);
}

void require_whole(const Case& job_case, const CollectedSteps& collected,
                   const std::vector<std::string>& journals, const std::string& output)
{
  const MissingSteps missing = missing_steps(plan_of(job_case), collected.steps);
  if (missing.is_nothing()) return;
  std::string found = missing_text(missing, job_case.grid.flexion_deg, job_case.grid.varus_deg);
  if (!found.empty()) found += absent_shards(journals);
  if (!missing.is_spine_complete) found += found.empty() ? "no complete spine" : "; the spine is incomplete";
  throw InputError({output, "journals", found,
                    "complete journals of the spine and of every shard; the journals found are kept"});
}

std::string doubled_text(const CollectedSteps& collected, const Case& job_case)
{
  const std::vector<std::int32_t> rows(collected.doubled_rows.begin(), collected.doubled_rows.end());
  std::string text = std::to_string(collected.n_doubled) +
                     " steps are in more than one journal, with the same result: at flexion " +
                     angles_text(rows, job_case.grid.flexion_deg) + ", in";
  const char* separator = " ";
  for (const std::string& journal : collected.doubled_in) text += std::exchange(separator, ", ") + journal;
  return text;
}

// Removes the shards' files next to the output; others are copies of the user.
void remove_shard_files(const std::string& output, const std::vector<std::string>& journals)
{
  std::vector<std::string> obsolete;
  std::copy_if(journals.begin(), journals.end(), std::back_inserter(obsolete),
               [&](const std::string& journal) { return output_of_journal(journal) == output; });
  obsolete.push_back(start_file_of(output));
  obsolete.push_back(case_file_of(output));  // last: until then it records that the model is complete
  remove_needless(obsolete);
}

// A complete model without journals and case file, so that its job cannot be compared.
bool is_merged(const std::string& output, const std::vector<std::string>& journals)
{
  if (!journals.empty() || access(case_file_of(output).c_str(), F_OK) == 0) return false;
  if (access(output.c_str(), F_OK) != 0) return false;
  return (read_motion_model(output).status != status_pending).all();
}

void note_merged(const std::string& output)
{
  const std::string case_file = case_file_of(output);
  if (access(case_file.c_str(), F_OK) != 0) return;
  CaseFile content = read_case_file(case_file);
  content.merged_sha256 = sha256_of_model(output);
  write_case_file(case_file, content);
}

/// The model is complete; if that cannot be recorded in the case file, the journals are kept for another
/// merge.
void finish_merge(const std::string& output, const std::vector<std::string>& journals)
{
  try {
    note_merged(output);
  } catch (const InputError& error) {
    warn(error.what());
    return;
  }
  remove_shard_files(output, journals);
}

}  // namespace

ExitCode merge_command(const MergeOptions& options)
{
  const std::string& output = options.output;
  const std::vector<std::string> journals =
      options.journals.empty() ? journals_beside(output, options.n_shards) : options.journals;
  make_folder_of(output);
  const std::optional<OutputLock> lock = locked_output(output, "vrda merge");
  if (!lock) return ExitCode::interrupted;
  require_replaceable(output, "a motion model");
  if (!options.keeps_journals && is_only_to_clear_up(output)) {
    remove_shard_files(output, journals);
    say(output + ": already merged");
    return ExitCode::done;
  }
  if (is_merged(output, journals)) {
    say(output + ": complete; there are no journals to merge");
    return ExitCode::done;
  }
  const Case job_case = case_to_merge(options, journals);
  if (const auto model = finished_result(job_case, output, options.may_replace)) {
    say(output + ": this job is already merged");
    const ExitCode code = keep_result(job_case, *model, output, {}, threads_or_all(options.n_threads));
    if (!options.keeps_journals) finish_merge(output, journals);
    return code;
  }

  const int n_threads = threads_or_all(options.n_threads);
  const CollectedSteps collected =
      telling_differences(job_case, [&] { return collect(journals, fingerprint_of(job_case)); });
  for (const std::string& remark : collected.remarks) warn(remark);
  if (collected.n_doubled > 0) {
    say(doubled_text(collected, job_case));
  }
  require_whole(job_case, collected, journals, output);
  const RunRecord record(n_threads, static_cast<int>(collected.steps.size()));
  const SweepResult result = replayed(plan_of(job_case), collected.steps);
  const std::optional<MotionModel> model = result_of(job_case, result, output, n_threads, is_interrupted);
  if (!model) {
    say("interrupted: the journals are kept; run the same command to merge again");
    return ExitCode::interrupted;
  }
  const ExitCode code = write_result(job_case, *model, output, {}, record);
  if (!options.keeps_journals) finish_merge(output, journals);
  return code;
}

}  // namespace vrda
