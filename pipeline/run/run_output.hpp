/// Where a run writes: everything stands beside its output.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "core/output_lock.hpp"
#include "journal/run_files.hpp"

namespace vrda {

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
