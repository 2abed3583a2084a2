/// The output path of a run, the files next to it, and checks before an existing file is replaced.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "core/console.hpp"
#include "core/error.hpp"
#include "core/open_file.hpp"
#include "core/publication.hpp"
#include "job/case.hpp"
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

/// `requested`, or results/<job name>/<job name>.h5 if that is empty.
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

}  // namespace vrda::run
