/// The output path of a run, the files next to it, and checks before an existing file is replaced.
#pragma once

#include <nlohmann/json_fwd.hpp>

#include <chrono>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "core/console.hpp"
#include "core/files.hpp"
#include "core/text.hpp"
#include "job/case.hpp"
#include "model/step_record.hpp"
#include "solve/stability_search.hpp"
#include "store/journal.hpp"
#include "store/motion_model.hpp"

namespace vrda::run {

/// Makes the folder and its parents. Throws InputError.
void make_folder(const std::string& folder);

/// "solver.method: found \"equilibrium\", this job has \"stability-search\"": the first key, or the first
/// input file, in which the job of `record` differs from `job_case`; empty if they are equal. The title is
/// compared last, limits are ignored.
std::string first_difference(const store::JobRecord& record, const job::Case& job_case);

/// The motion model at `output` if it is that of this job; empty if there is no file, or one that may be
/// replaced. Throws InputError unless `may_replace` if it is another job's, with both titles and the first
/// difference, or cannot be read; and always if it is not a motion model.
std::optional<store::MotionModel> existing_result(const job::Case& job_case, const std::string& output,
                                                  bool may_replace);

/// The same error; if it reports a journal of another job whose start file is next to it, with the first
/// difference instead of two hashes.
InputError with_first_difference(const InputError& error, const job::Case& job_case);

/// Calls work() and rethrows its InputErrors with_first_difference().
template <typename Work>
auto with_difference_in_errors(const job::Case& job_case, const Work& work)
{
  try {
    return work();
  } catch (const InputError& error) {
    throw with_first_difference(error, job_case);
  }
}

/// The name of a job's results: that of its file after those of its folders, at most two, joined by "-". No
/// folder counts for a job in the working folder or in a folder "jobs", so two prepared knees have two names.
/// Where the folder's name ends with that of the file, it is the name.
std::string result_name_of(const std::string& job_file);

/// `requested`, or results/NAME/NAME.h5 with result_name_of() if that is empty.
std::string output_path_of(const std::string& requested, const std::string& job_file);

std::string run_record_of(const std::string& output);

/// Whether a readable start file of that resolved job is next to the output. False for another size of the
/// joint, even if its journal can be resumed.
bool has_start_file(const std::string& output, const std::string& resolved_job);

/// Throws InputError naming `option` if a part of its path that the result contains has control characters or
/// is not UTF-8: the result could not be read again.
void require_plain_text(const std::string& option, const std::string& part);

/// Makes the parent folder of `file`. Throws InputError.
void make_parent_folder(const std::string& file);

/// Throws InputError if an existing file at `output` is not a writable HDF5 file, for example a job, a mesh
/// or a folder. `what` is the expected kind, for the message.
void require_replaceable(const std::string& output, const std::string& what);

/// Takes the lock of `output` for `command` ("vrda smooth"), held while the file is read, changed and
/// written. Reports the process that it waits for. Empty when interrupted.
std::optional<OutputLock> lock_output(const std::string& output, const std::string& command);

/// Begins the publication of `output` in the same way.
std::optional<Publication> begin_result(const std::string& output, const std::string& command);

/// Writes `bytes` to `output`, over an earlier result, as one publication. Returns interrupted or done.
core::ExitCode publish(const std::string& output, const std::string& command, const std::string& bytes);

/// Whether a command that adds to the motion model `file` may replace it: the file and its folder are
/// writable. Warns otherwise that the command's result is printed only.
bool may_add_to(const std::string& file);

/// Removes obsolete files in this order; warns and stops at the first that cannot be removed.
void remove_obsolete_files(const std::vector<std::string>& files);

// Short summaries of cases and motion models, and how commands load them.

/// One line about the scaling: that the steps are shared, or why it is a new run. Empty without [scaling].
std::string scaling_line(const job::Case& job_case);

/// Null without scaling; landmarks are an empty list if the job gives the factor.
nlohmann::ordered_json scaling_json(const std::optional<Scaling>& scaling);

/// Prints scaling_json(): the factor, its standard error, and one line per pair of landmarks. Nothing for
/// null.
void print_scaling(const nlohmann::ordered_json& scaling);

/// Number of cells of each status that occurs, by name.
std::map<std::string, int> cells_by_status(const store::MotionModel& model);

/// A contact at a border so far in flexion past the first one of its column has left the surface that the
/// mesh has: the pose is not usable. A mesh's edge is first touched by a few mm of its rim, and 10 degrees of
/// flexion move the contact of a knee by 3 to 5 mm.
inline constexpr double border_margin_deg = 10.0;

/// Stable cells with Plausibility::border_contact more than border_margin_deg further in flexion than the
/// first one of their column, from the flexion nearest to zero on, in either direction.
store::GridB is_past_border(const store::MotionModel& model);

/// Share of cells that are not stable, or past a border.
double unsolved_fraction(const store::MotionModel& model);

/// "1911 attitudes: 1900 stable, 11 no_contact".
std::string status_line(const store::MotionModel& model);

/// "20 samples: 58 of 60 poses stable, 2 left out of the bands"; empty without samples.
std::string samples_line(const store::MotionModel& model);

/// Stable cells of doubtful plausibility, in attitude order; then those of the followers.
struct DoubtfulCell {
  double flexion_deg = 0.0, varus_deg = 0.0;
  Plausibility plausibility = Plausibility::nothing_found;
  std::string follower;  ///< name; empty: the joint
};
std::vector<DoubtfulCell> doubtful_cells(const store::MotionModel& model);

/// "2 nothing_ahead, 1 unstable_balance, 1 border_contact of patella"; empty without any.
std::string plausibility_line(const store::MotionModel& model);
/// Whether a stable cell of the joint or of a follower has it.
bool has_any(const store::MotionModel& model, Plausibility plausibility);

/// load_checked_case(); prints its warnings and scaling.
job::Case load_and_report_case(const std::string& job_file, const job::LoadOptions& options);

/// Reads a motion model. Throws InputError if the file is invalid, too new, or has no stable attitude.
store::MotionModel read_solved_model(const std::string& file);

/// `requested`, or one per processor if that is 0.
int thread_count_or_all(int requested);

// The journal of one run: the steps of earlier runs of the same job, and the writers for new steps and
// traces. In: path and job key (SHA-256). Out: known steps by key. A damaged tail is dropped with a warning;
// another job's journal, or one that another process is writing, throws InputError.

/// How to wait for a journal that another process has locked.
struct JournalWait {
  std::chrono::milliseconds timeout{0};
  std::function<void()> on_start = [] {};  ///< called once when waiting starts
};

struct StepLog {
  std::string path;  ///< of the journal
  store::JournalWriter writer;
  std::map<StepKey, StepRecord> known;
  std::optional<core::FrameWriter> traces;
};

/// Resumes the journal at `path` or starts one. Throws InputError if it is another job's or being written.
StepLog open_log(const std::string& path, const std::string& key, bool is_fresh);

/// The same, but waits while another process writes the journal. Empty after the timeout, or when
/// interrupted.
std::optional<StepLog> open_log_waiting(const std::string& path, const std::string& key, bool is_fresh,
                                        const JournalWait& patience);

/// The step of an earlier run, if any.
std::optional<StepRecord> recalled_step(const StepLog& log, const StepKey& key);

/// If the output's folder was deleted or moved during a run: restores the journals from the open files and
/// throws an InputError that reports it. Otherwise returns.
void restore_lost_journals(const StepLog& log, const std::string& output);

/// Calls work(), and restore_lost_journals() if it throws InputError.
template <typename Work>
auto with_journal_restore(const StepLog& log, const std::string& output, const Work& work)
{
  try {
    return work();
  } catch (const InputError&) {
    restore_lost_journals(log, output);
    throw;
  }
}

/// Resumes the journal of traces at `path`, or starts one if `known` is empty. Throws InputError if a step of
/// the journal `steps_path` has no trace.
core::FrameWriter open_trace_log(const std::string& path, const std::string& key,
                                 const std::string& steps_path, const std::map<StepKey, StepRecord>& known);

/// Calls `solve` with an observer and appends the observed trace. Thread-safe. Must be called before the step
/// is kept, so that a kill in between loses no trace.
StepRecord solve_with_trace(core::FrameWriter& log, const StepKey& key, const MovingPose& seed,
                            const std::function<StepRecord(const SearchObserver&)>& solve);

}  // namespace vrda::run
