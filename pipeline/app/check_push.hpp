/// The loads of a job in the output of `vrda check`.
#pragma once

#include <nlohmann/json.hpp>
#include <string>

#include "job/job.hpp"

namespace vrda::app {

/// The job's values; only points are scaled with the subject. A setting over flexion is a table with one row
/// per angle, one from columns of the frames has their names.
nlohmann::ordered_json push_json(const job::PushJob& push, const job::Case& job_case);

/// A number, or a list of numbers in brackets.
std::string number_text(const nlohmann::ordered_json& number_or_list);

/// Prints such loads; without forces only the direction.
void print_push(const nlohmann::ordered_json& push, bool has_forces);

}  // namespace vrda::app
