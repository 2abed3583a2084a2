/// Where a run writes, and what is there before it is replaced: everything stands beside its output.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "core/error.hpp"
#include "core/open_file.hpp"
#include "load/case.hpp"
#include "store/motion_model.hpp"

namespace vrda {

/// Makes the folder and those above it. Throws InputError naming it.
void make_folder(const std::string& folder);

/// "solver.method: found \"equilibrium\", wanted \"stability-search\"": the first key, or the first input
/// file, in which the job of `record` differs from `job_case`; empty where they are the same. The title
/// comes last, limits do not count.
std::string first_difference(const JobRecord& record, const Case& job_case);

/// The motion model at `output` where it is that of this very job; nothing where there is none, or one that
/// may be replaced. Throws InputError where it is another job's, with both titles and the first difference,
/// or cannot be read, unless `may_replace`; and always where it is no motion model.
std::optional<MotionModel> finished_result(const Case& job_case, const std::string& output, bool may_replace);

/// The same error, or where it says that a journal is another job's and that job's start file is beside it,
/// one that names the first difference instead of two hashes.
InputError with_first_difference(const InputError& error, const Case& job_case);

/// work(), with such errors.
template <typename Work>
auto telling_differences(const Case& job_case, const Work& work)
{
  try {
    return work();
  } catch (const InputError& error) {
    throw with_first_difference(error, job_case);
  }
}

/// `asked`, or results/<job name>/<job name>.h5 where that is empty.
std::string output_of(const std::string& asked, const std::string& job_file);

std::string run_record_of(const std::string& output);

/// Whether the start file of that resolved job stands beside the output. One of another size of the joint,
/// whose journal may serve all the same, is none, nor one that cannot be read.
bool has_start_file(const std::string& output, const std::string& resolved_job);

/// Makes the folder that `file` is to stand in. Throws InputError naming both.
void make_folder_of(const std::string& file);

/// What stands where a motion model or a trace will go must be one itself, never a job, a mesh or a folder:
/// InputError. `what` names it.
void require_replaceable(const std::string& output, const std::string& what);

/// The lock of `output` for `command` ("vrda smooth"), under which it is read, changed and written. Reports
/// which process is waited for. Nothing when interrupted.
std::optional<OutputLock> locked_output(const std::string& output, const std::string& command);

/// Removes, in this order, files that a result makes needless. The first that cannot be removed is a warning,
/// and those behind it stay too: the same command still finds all that it needs to go on.
void remove_needless(const std::vector<std::string>& files);

}  // namespace vrda
