#include "cluster/slurm.hpp"

#include <fcntl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <sstream>

#include "cluster/child.hpp"
#include "core/error.hpp"

namespace vrda {
namespace {

// Ids in one command line: far below what a system takes.
constexpr std::size_t ids_at_once = 2000;

std::vector<std::string> lines_of(const std::string& text)
{
  std::vector<std::string> lines;
  std::istringstream stream(text);
  for (std::string line; std::getline(stream, line);) lines.push_back(line);
  return lines;
}

std::string trimmed(const std::string& text)
{
  const std::size_t first = text.find_first_not_of(" \t\r\n");
  if (first == std::string::npos) return {};
  return text.substr(first, text.find_last_not_of(" \t\r\n") - first + 1);
}

std::int32_t number_in(const std::string& text, std::int32_t otherwise)
{
  char* end = nullptr;
  errno = 0;
  const long value = std::strtol(text.c_str(), &end, 10);
  const bool is_number = end != text.c_str() && errno == 0 && value >= 0 && value <= 1'000'000'000;
  return is_number ? static_cast<std::int32_t>(value) : otherwise;
}

InputError::Facts failure_of(const std::vector<std::string>& words, const Said& said, const char* wanted)
{
  if (said.is_absent) {
    return {words.front(), "", "no such program: Slurm is not installed here",
            "a machine of a Slurm cluster, or --local"};
  }
  const std::string message = slurm_message(said.err);
  return {words.front(), "", message.empty() ? "an end with code " + std::to_string(said.exit_code) : message,
          wanted};
}

bool is_done(const Said& said)
{
  return !said.is_absent && said.exit_code == 0;
}

constexpr const char* wanted_controller = "a Slurm controller that answers, or --local";

std::string joined(const std::vector<std::string>& words, std::size_t from, std::size_t n)
{
  std::string text;
  for (std::size_t k = from; k < std::min(from + n, words.size()); ++k)
    text += (text.empty() ? "" : ",") + words[k];
  return text;
}

}  // namespace

std::vector<SlurmRow> rows_of_squeue(const std::string& text)
{
  std::vector<SlurmRow> rows;
  for (const std::string& line : lines_of(text)) {
    std::vector<std::string> fields;
    std::size_t from = 0;
    for (int k = 0; k < 4 && from != std::string::npos; ++k) {
      const std::size_t bar = line.find('|', from);
      if (bar == std::string::npos) break;
      fields.push_back(trimmed(line.substr(from, bar - from)));
      from = bar + 1;
    }
    if (fields.size() != 4 || fields[0].empty()) continue;
    rows.push_back({fields[0], number_in(fields[1], 0), fields[2], fields[3], trimmed(line.substr(from))});
  }
  return rows;
}

SlurmLimits limits_of_config(const std::string& text)
{
  SlurmLimits limits;
  for (const std::string& line : lines_of(text)) {
    const std::size_t equals = line.find('=');
    if (equals == std::string::npos) continue;
    const std::string key = trimmed(line.substr(0, equals)), value = trimmed(line.substr(equals + 1));
    if (key == "MaxArraySize") limits.max_array_size = number_in(value, limits.max_array_size);
    if (key == "MaxJobCount") limits.max_job_count = number_in(value, limits.max_job_count);
  }
  return limits;
}

bool is_queued(const SlurmRow& row)
{
  constexpr std::array<const char*, 4> states{"PENDING", "REQUEUED", "REQUEUE_HOLD", "SPECIAL_EXIT"};
  const bool is_waiting = std::find(states.begin(), states.end(), row.state) != states.end();
  return is_waiting && row.reason != "DependencyNeverSatisfied";
}

bool is_held_after_failed_launch(const SlurmRow& row)
{
  return is_queued(row) && row.reason.find("launch failed requeued held") != std::string::npos;
}

bool is_running(const SlurmRow& row)
{
  constexpr std::array<const char*, 8> states{"RUNNING", "CONFIGURING", "COMPLETING", "SUSPENDED",
                                              "STOPPED", "SIGNALING",   "STAGE_OUT",  "RESIZING"};
  return std::find(states.begin(), states.end(), row.state) != states.end();
}

std::string slurm_message(const std::string& standard_error)
{
  std::string message;
  for (std::string line : lines_of(standard_error)) {
    line = trimmed(line);
    for (const char* mark : {"error: ", "fatal: "}) {
      const std::size_t at = line.find(mark);
      if (at != std::string::npos) line = line.substr(at + std::strlen(mark));
    }
    if (!line.empty()) message += (message.empty() ? "" : "; ") + line;
  }
  return message;
}

SlurmLimits ask_limits()
{
  const std::vector<std::string> words{"scontrol", "show", "config"};
  const Said said = run_program(words, "");
  if (!is_done(said)) throw InputError(failure_of(words, said, wanted_controller));
  return limits_of_config(said.out);
}

SubmitAnswer submit_job(const std::vector<std::string>& words, const std::string& folder)
{
  const Said said = run_program(words, folder);
  const std::string id = trimmed(said.out.substr(0, said.out.find_first_of(";\n")));
  if (is_done(said) && !id.empty()) return {id, std::nullopt};
  return {"", failure_of(words, said, "a job that Slurm takes")};
}

QueueAnswer ask_rows(const std::vector<std::string>& ids)
{
  QueueAnswer answer;
  for (std::size_t k = 0; k < ids.size(); k += ids_at_once) {
    const std::vector<std::string> words{
        "squeue",       "--noheader", "--all",       "--array",
        "--states=all", "-o",         squeue_format, "--jobs=" + joined(ids, k, ids_at_once)};
    const Said said = run_program(words, "");
    // Of one job alone squeue takes it ill that it is forgotten.
    const bool is_forgotten = said.err.find("Invalid job id") != std::string::npos;
    if (!is_done(said) && !is_forgotten) return {{}, failure_of(words, said, wanted_controller)};
    const std::vector<SlurmRow> some = rows_of_squeue(said.out);
    answer.rows.insert(answer.rows.end(), some.begin(), some.end());
  }
  return answer;
}

std::optional<InputError::Facts> cancel_jobs(const std::vector<std::string>& ids)
{
  for (std::size_t k = 0; k < ids.size(); k += ids_at_once) {
    std::vector<std::string> words{"scancel"};
    for (std::size_t i = k; i < std::min(k + ids_at_once, ids.size()); ++i) words.push_back(ids[i]);
    const Said said = run_program(words, "");
    if (!is_done(said)) return failure_of(words, said, "jobs that may be cancelled");
  }
  return std::nullopt;
}

void release_jobs(const std::vector<std::string>& ids)
{
  for (std::size_t k = 0; k < ids.size(); k += ids_at_once) {
    const std::vector<std::string> words{"scontrol", "release", joined(ids, k, ids_at_once)};
    const Said said = run_program(words, "");
    if (!is_done(said)) throw InputError(failure_of(words, said, "jobs that may be released"));
  }
}

}  // namespace vrda
