/// What is at the place where a result goes, before it is replaced.
#pragma once

#include <optional>
#include <string>

#include "core/error.hpp"
#include "load/case.hpp"
#include "store/motion_model.hpp"

namespace vrda {

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

}  // namespace vrda
