#include "run/slurm.hpp"

#include <fcntl.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <cerrno>
#include <charconv>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <set>
#include <sstream>
#include <utility>
#include <variant>

#include "core/document.hpp"
#include "core/fields_json.hpp"
#include "core/files.hpp"
#include "run/status.hpp"

namespace vrda::run {
namespace {

// Ids per command line, far below the system's limit.
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

InputError::Facts failure_of(const std::vector<std::string>& words, const ProgramResult& result,
                             const char* wanted)
{
  if (result.is_not_found) {
    return {words.front(), "", "no such program: Slurm is not installed here",
            "a machine of a Slurm cluster, or --local"};
  }
  const std::string message = slurm_message(result.err);
  return {words.front(), "", message.empty() ? "exit code " + std::to_string(result.exit_code) : message,
          wanted};
}

bool is_done(const ProgramResult& result)
{
  return !result.is_not_found && result.exit_code == 0;
}

// User settings that would override or filter our options of Slurm's programs, and variables of an enclosing
// Slurm job, which sbatch would propagate to the new job.
constexpr std::array<std::string_view, 6> excluded_prefixes{
    "SBATCH_", "SQUEUE_", "SCANCEL_", "SLURM_JOB", "SLURM_ARRAY_", "SLURM_RESTART_COUNT="};

bool is_for_slurm(std::string_view entry)
{
  return entry.starts_with("SBATCH_EXPORT=") ||
         std::none_of(excluded_prefixes.begin(), excluded_prefixes.end(),
                      [&](std::string_view prefix) { return entry.starts_with(prefix); });
}

constexpr const char* wanted_controller = "a responding Slurm controller, or --local";

std::string ids_text(const std::vector<std::string>& words, std::size_t from, std::size_t n)
{
  const auto begin = words.begin() + static_cast<std::ptrdiff_t>(from);
  return core::joined({begin, begin + static_cast<std::ptrdiff_t>(std::min(n, words.size() - from))}, ",");
}

}  // namespace

ProgramResult run_slurm(const std::vector<std::string>& words, const std::string& folder)
{
  ProcessOptions options;
  options.folder = folder;
  options.is_inherited = is_for_slurm;
  return run_program(words, options);
}

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

SlurmLimits query_limits()
{
  const std::vector<std::string> words{"scontrol", "show", "config"};
  const ProgramResult result = run_slurm(words);
  if (!is_done(result)) throw InputError(failure_of(words, result, wanted_controller));
  return limits_of_config(result.out);
}

SubmitResult submit_job(const std::vector<std::string>& words, const std::string& folder)
{
  const ProgramResult result = run_slurm(words, folder);
  const std::string id = trimmed(result.out.substr(0, result.out.find_first_of(";\n")));
  if (is_done(result) && !id.empty()) return {id, std::nullopt};
  return {"", failure_of(words, result, "a job that Slurm accepts")};
}

QueueResult query_queue(const std::vector<std::string>& ids)
{
  QueueResult answer;
  for (std::size_t k = 0; k < ids.size(); k += ids_at_once) {
    const std::vector<std::string> words{
        "squeue",       "--noheader", "--all",       "--array",
        "--states=all", "-o",         squeue_format, "--jobs=" + ids_text(ids, k, ids_at_once)};
    const ProgramResult result = run_slurm(words);
    // For a single purged job squeue fails instead of printing no row.
    const bool is_purged = result.err.find("Invalid job id") != std::string::npos;
    if (!is_done(result) && !is_purged) return {{}, failure_of(words, result, wanted_controller)};
    const std::vector<SlurmRow> some = rows_of_squeue(result.out);
    answer.rows.insert(answer.rows.end(), some.begin(), some.end());
  }
  return answer;
}

std::optional<InputError::Facts> cancel_jobs(const std::vector<std::string>& ids)
{
  for (std::size_t k = 0; k < ids.size(); k += ids_at_once) {
    std::vector<std::string> words{"scancel"};
    for (std::size_t i = k; i < std::min(k + ids_at_once, ids.size()); ++i) words.push_back(ids[i]);
    const ProgramResult result = run_slurm(words);
    if (!is_done(result)) return failure_of(words, result, "jobs that may be cancelled");
  }
  return std::nullopt;
}

void release_jobs(const std::vector<std::string>& ids)
{
  for (std::size_t k = 0; k < ids.size(); k += ids_at_once) {
    const std::vector<std::string> words{"scontrol", "release", ids_text(ids, k, ids_at_once)};
    const ProgramResult result = run_slurm(words);
    if (!is_done(result)) throw InputError(failure_of(words, result, "jobs that may be released"));
  }
}

namespace {

using Json = nlohmann::ordered_json;

// Whether the last line is incomplete (killed writer, full disk), so that a line break must be added.
bool has_incomplete_line(int descriptor)
{
  const off_t size = lseek(descriptor, 0, SEEK_END);
  char last = '\n';
  return size > 0 && pread(descriptor, &last, 1, size - 1) == 1 && last != '\n';
}

}  // namespace

std::optional<InputError::Facts> append_submitted(const std::string& folder, const SubmittedJob& submitted)
{
  const std::string path = submitted_file_of(folder);
  const OpenFile file(open(path.c_str(), O_RDWR | O_CREAT | O_APPEND | O_CLOEXEC, 0666));
  if (file.is_open() &&
      write_all(file.get(),
                (has_incomplete_line(file.get()) ? "\n" : "") + core::json_text(submitted, -1) + "\n") &&
      fsync(file.get()) == 0) {
    return std::nullopt;
  }
  return InputError::Facts{path, "",
                           std::string("a file that cannot be written (") + std::strerror(errno) + ")",
                           "disk space and permission to record job " + submitted.id};
}

std::vector<SubmittedJob> read_submitted(const std::string& folder)
{
  std::vector<SubmittedJob> jobs;
  std::ifstream file(submitted_file_of(folder), std::ios::binary);
  for (std::string line; std::getline(file, line);) {
    try {
      jobs.push_back(core::json_in(line).get<SubmittedJob>());
    } catch (const Json::exception&) {  // an incomplete line
    }
  }
  return jobs;
}

std::map<TaskId, SlurmTask> tasks_in_slurm(const Submission& submission,
                                           const std::vector<SubmittedJob>& jobs,
                                           const std::vector<SlurmRow>& rows)
{
  std::map<std::pair<std::string, std::int32_t>, const SlurmRow*> row_of;
  for (const SlurmRow& row : rows) row_of[{row.id, row.number}] = &row;
  std::map<TaskId, SlurmTask> tasks;
  for (const SubmittedJob& submitted : jobs) {
    const bool has_array = !submitted.job.numbers.empty();
    const std::vector<std::int32_t> numbers =
        has_array ? submitted.job.numbers : std::vector<std::int32_t>{0};
    for (const std::int32_t number : numbers) {
      const auto found = row_of.find({submitted.id, number});
      const std::string job = has_array ? submitted.id + "_" + std::to_string(number) : submitted.id;
      SlurmTask task{job, found == row_of.end() ? SlurmRow{} : *found->second, ""};
      for (const TaskId& id : tasks_of(submission, submitted.job, number)) {
        const bool is_shared = id.kind == TaskKind::run;
        task.per_task = submitted.job.per_task;
        task.log = is_shared ? log_of_runs(submitted.job.offset, std::to_string(number))
                             : file_stem_of(id, submission) + ".log";
        tasks[id] = task;
      }
    }
  }
  return tasks;
}

void require_same_cases_per_task(const std::map<TaskId, SlurmTask>& tasks, std::int32_t requested)
{
  for (const auto& [id, task] : tasks) {
    const bool is_under_way = is_queued(task.row) || is_running(task.row);
    if (id.kind != TaskKind::run || !is_under_way || task.per_task == requested) continue;
    const std::string active = std::to_string(task.per_task);
    throw InputError({"--cases-per-task", "",
                      std::to_string(requested) + ", while tasks of " + active + " are queued or running",
                      active + "; another number after they have ended (scancel ends them)"});
  }
}

namespace {

constexpr const char* wanted_time = "minutes, hours:minutes:seconds or days-hours, e.g. 30, 2:00:00 or 1-12";

std::vector<std::int64_t> numbers_of(const std::string& text, const std::string& whole)
{
  std::vector<std::int64_t> numbers;
  std::size_t from = 0;
  while (from <= text.size()) {
    const std::size_t colon = std::min(text.find(':', from), text.size());
    std::int64_t value = -1;
    const auto [end, error] = std::from_chars(text.data() + from, text.data() + colon, value);
    constexpr std::int64_t largest = 10'000'000;  // minutes: 19 years
    const bool is_whole =
        error == std::errc() && end == text.data() + colon && value >= 0 && value <= largest;
    if (!is_whole) throw InputError({"--time", "", whole.empty() ? "nothing" : whole, wanted_time});
    numbers.push_back(value);
    from = colon + 1;
  }
  return numbers;
}

void require_word(const char* option, const std::string& text)
{
  const bool is_valid = std::all_of(text.begin(), text.end(), [](unsigned char c) {
    return std::isalnum(c) != 0 ||
           std::string_view("_-.,:@%+=/").find(static_cast<char>(c)) != std::string_view::npos;
  });
  if (!is_valid) throw InputError({option, "", text, "letters, digits and _-.,:@%+=/"});
}

struct Script {
  const char* purpose;
  const char* command;  // arguments of vrda task; "$1" is appended by sbatch_words()
};

// [kinds]
constexpr std::array<Script, 5> scripts{{
    {"Solves the spine of case $1, which every shard reads.", "--kind spine --case=\"$1\""},
    {"Solves one shard of case $1; the array task number is the shard.",
     "--kind shard --case=\"$1\" --shard \"$SLURM_ARRAY_TASK_ID\""},
    {"Merges the journals of the shards of case $1 into its motion model.", "--kind merge --case=\"$1\""},
    {"Runs whole cases, $2 per task; $1 is the number of cases before the array's first.",
     "--kind run --first $(($1 + (SLURM_ARRAY_TASK_ID - 1) * $2 + 1)) --count \"$2\""},
    {"Writes the table of all cases.", "--kind index"},
}};

std::string options_of(const SlurmOptions& options)
{
  std::string text;
  const auto add = [&](const std::string& line) { text += "#SBATCH " + line + "\n"; };
  if (!options.partition.empty()) add("--partition=" + options.partition);
  if (!options.account.empty()) add("--account=" + options.account);
  if (!options.qos.empty()) add("--qos=" + options.qos);
  if (!options.time.empty()) add("--time=" + options.time);
  if (!options.memory.empty()) add("--mem=" + options.memory);
  add("--nodes=1");
  add("--ntasks=1");
  add("--cpus-per-task=" + std::to_string(options.cpus));
  add("--requeue");
  add("--open-mode=append");
  if (!options.time.empty()) {
    add("--signal=B:TERM@" + std::to_string(warning_seconds(seconds_of_time(options.time))));
  }
  for (const std::string& line : options.extra) add(line);
  return text;
}

// Escapes % in a path, which sbatch would expand as a pattern.
std::string escaped(std::string path)
{
  for (std::size_t at = 0; (at = path.find('%', at)) != std::string::npos; at += 2) path.insert(at, "%");
  return path;
}

// A job's log path with sbatch's patterns. Absolute: sbatch also expands its working folder.
std::string log_of(const std::string& folder, const Submission& submission, const PlannedJob& job)
{
  const std::string logs = escaped(logs_of(folder)) + "/";
  if (job.kind == TaskKind::run) return logs + log_of_runs(job.offset, "%a");
  std::string stem = job.kind == TaskKind::shard
                         ? submission.cases.at(static_cast<std::size_t>(job.case_number)).spec.name
                         : file_stem_of({job.kind, job.case_number, 0}, submission);
  stem = escaped(stem);
  if (job.kind == TaskKind::shard) stem += ".shard-%a-of-" + std::to_string(submission.n_shards);
  return logs + stem + ".log";
}

// Job name for squeue.
std::string job_name_of(const Submission& submission, const PlannedJob& job)
{
  std::string name = "vrda-" + std::string(name_of(job.kind));
  if (job.case_number >= 0) {
    name += "-" + submission.cases.at(static_cast<std::size_t>(job.case_number)).spec.name;
  }
  for (char& c : name) {
    if (std::isalnum(static_cast<unsigned char>(c)) == 0 && c != '.' && c != '_') c = '-';
  }
  return name;
}

// The index also lists failed cases; other jobs are cancelled when a dependency fails.
std::string dependency_of(const PlannedJob& job, const std::vector<std::string>& ids)
{
  std::string text = job.kind == TaskKind::index ? "afterany" : "afterok";
  const std::size_t bare = text.size();
  for (const std::string& id : job.after_ids) text += ":" + id;
  for (const std::size_t k : job.after) text += ":" + ids.at(k);
  return text.size() == bare ? std::string() : text;
}

std::variant<SubmittedJob, InputError::Facts> submit_and_record(const std::string& folder,
                                                                const Submission& submission,
                                                                const PlannedJob& job,
                                                                const std::vector<SubmittedJob>& before)
{
  std::vector<std::string> ids;
  for (const SubmittedJob& one : before) ids.push_back(one.id);
  const SubmitResult answer = submit_job(sbatch_words(folder, submission, job, ids), folder);
  if (answer.error) return *answer.error;
  const SubmittedJob submitted{answer.id, utc_now(), job};
  const auto fault = append_submitted(folder, submitted);
  if (!fault) return submitted;
  cancel_jobs({answer.id});  // the job would be unknown to this submission; the first error is reported
  return *fault;
}

}  // namespace

std::int64_t seconds_of_time(const std::string& text)
{
  const std::size_t dash = text.find('-');
  if (dash == std::string::npos) {
    const std::vector<std::int64_t> n = numbers_of(text, text);
    if (n.size() == 1) return n[0] * 60;
    if (n.size() == 2) return n[0] * 60 + n[1];
    if (n.size() == 3) return n[0] * 3600 + n[1] * 60 + n[2];
  } else {
    const std::vector<std::int64_t> days = numbers_of(text.substr(0, dash), text);
    std::vector<std::int64_t> n = numbers_of(text.substr(dash + 1), text);
    if (days.size() == 1 && n.size() <= 3) {
      n.resize(3, 0);
      return days[0] * 86400 + n[0] * 3600 + n[1] * 60 + n[2];
    }
  }
  throw InputError({"--time", "", text, wanted_time});
}

std::int64_t warning_seconds(std::int64_t time_limit_seconds)
{
  const std::int64_t short_limit = std::min<std::int64_t>(time_limit_seconds / 4, 30);
  return std::clamp<std::int64_t>(time_limit_seconds / 10, short_limit, 120);
}

void require_log_folder(const std::string& folder)
{
  if (folder.find_first_of("\\\n") == std::string::npos) return;
  throw InputError(
      {folder, "folder", "a backslash or a line break", "a path that sbatch accepts for a log file"});
}

void require_valid_options(const SlurmOptions& options)
{
  require_word("--partition", options.partition);
  require_word("--mem", options.memory);
  require_word("--account", options.account);
  require_word("--qos", options.qos);
  if (!options.time.empty() && seconds_of_time(options.time) == 0) {
    throw InputError({"--time", "", options.time, "a limit above 0"});
  }
  for (const std::string& line : options.extra) {
    const bool is_option = line.starts_with("-") && line.find_first_of("\r\n") == std::string::npos;
    if (!is_option) throw InputError({"--extra", "", line, "one option of sbatch, e.g. --constraint=avx2"});
  }
}

std::string shell_word(const std::string& text)
{
  std::string word = "'";
  for (const char c : text) word += c == '\'' ? std::string("'\\''") : std::string(1, c);
  return word + "'";
}

std::string script_name_of(TaskKind kind)
{
  return std::string(name_of(kind)) + ".sbatch";
}

std::string script_of(TaskKind kind, const std::string& folder, const Submission& submission)
{
  const Script& script = scripts.at(static_cast<std::size_t>(kind));
  return "#!/bin/bash\n# " + std::string(script.purpose) +
         "\n# Submit it from the submission's folder, with logs/. It may be killed and restarted at "
         "any time.\n" +
         options_of(submission.slurm) + "\nprogram=" + shell_word(submission.program) +
         "\nfolder=" + shell_word(folder) + R"(

# Slurm sends SIGTERM to this shell before the time limit, and to all its processes on preemption. The shell waits
# until vrda has written its journal.
child= terminated=
trap 'terminated=1; [ -z "$child" ] || kill -TERM "$child" 2>/dev/null' TERM
words=(task "$folder" )" +
         script.command + R"( --cpus "${SLURM_CPUS_PER_TASK:-1}")
"$program" "${words[@]}" &
child=$!
[ -z "$terminated" ] || kill -TERM "$child" 2>/dev/null
wait "$child"; code=$?
while [ -n "$terminated" ]; do  # the signal interrupted the wait
  terminated=
  wait "$child"; next=$?
  [ "$next" -eq 127 ] || code=$next
done

# Interrupted, cleanly (4) or before vrda handled the signal (143): requeue the task, which then resumes. Not if
# it was cancelled, or if Slurm has restarted it already (lost node), which increases the restart count.
job=${SLURM_ARRAY_JOB_ID:+${SLURM_ARRAY_JOB_ID}_$SLURM_ARRAY_TASK_ID}
job=${job:-$SLURM_JOB_ID}
if { [ "$code" -eq 4 ] || [ "$code" -eq 143 ]; } && [ "${SLURM_RESTART_COUNT:-0}" -lt )" +
         std::to_string(max_restarts) + R"( ]; then
  case $(squeue --noheader --jobs="$job" --states=all -O 'RestartCnt: ,State: ,Reason: ') in
    "${SLURM_RESTART_COUNT:-0} RUNNING"* | "${SLURM_RESTART_COUNT:-0} "*TimeLimit*) scontrol requeue "$job" && exit 0 ;;
  esac
elif [ "$code" -gt 128 ]; then
  "$program" "${words[@]}" --ended "$code"  # killed by a signal, e.g. out of memory; vrda could not record it
fi
exit "$code"
)";
}

std::vector<std::string> sbatch_words(const std::string& folder, const Submission& submission,
                                      const PlannedJob& job, const std::vector<std::string>& ids)
{
  std::vector<std::string> words{"sbatch", "--parsable", "--job-name=" + job_name_of(submission, job),
                                 "--output=" + log_of(folder, submission, job)};
  if (!job.numbers.empty()) {
    std::string array = ranges_text(job.numbers);
    if (submission.slurm.max_parallel > 0) array += "%" + std::to_string(submission.slurm.max_parallel);
    words.push_back("--array=" + array);
  }
  if (const std::string dependency = dependency_of(job, ids); !dependency.empty()) {
    words.push_back("--dependency=" + dependency);
    words.push_back("--kill-on-invalid-dep=yes");
  }
  words.push_back("scripts/" + script_name_of(job.kind));
  if (job.kind == TaskKind::run) {
    words.push_back(std::to_string(job.offset));
    words.push_back(std::to_string(job.per_task));
  } else if (job.case_number >= 0) {
    words.push_back(submission.cases.at(static_cast<std::size_t>(job.case_number)).spec.name);
  }
  return words;
}

std::string sbatch_lines(const std::string& folder, const Submission& submission,
                         const std::vector<PlannedJob>& jobs)
{
  std::string text = "cd " + shell_word(folder) + "\n";
  std::vector<std::string> ids;
  for (const PlannedJob& job : jobs) {
    std::string line;
    for (const std::string& word : sbatch_words(folder, submission, job, ids)) {
      // The ids of earlier jobs are shell variables.
      const bool has_variable = word.starts_with("--dependency=");
      const bool is_plain = word.find_first_not_of(
                                "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ"
                                "0123456789_-.,:=/%") == std::string::npos;
      line += (line.empty() ? "" : " ") + (has_variable || is_plain ? word : shell_word(word));
    }
    ids.push_back("$job" + std::to_string(ids.size() + 1));
    text += ids.back().substr(1) + "=$(" + line + ")\n";
  }
  return text;
}

std::string id_text(const std::string& id, const PlannedJob& job, const SlurmOptions& options)
{
  if (job.numbers.empty()) return id;
  std::string text = id + "_[" + ranges_text(job.numbers);
  if (options.max_parallel > 0) text += "%" + std::to_string(options.max_parallel);
  return text + "]";
}

void write_scripts(const std::string& folder, const Submission& submission,
                   const std::vector<PlannedJob>& jobs)
{
  std::set<TaskKind> kinds;
  for (const PlannedJob& job : jobs) kinds.insert(job.kind);
  for (const TaskKind kind : kinds) {
    const std::string path = scripts_of(folder) + "/" + script_name_of(kind);
    write_atomically(path, {script_of(kind, folder, submission)});
    constexpr mode_t readable_by_all = 0755;
    chmod(path.c_str(), readable_by_all);
  }
}

std::vector<SubmittedJob> submit_jobs(const std::string& folder, const Submission& submission,
                                      const std::vector<PlannedJob>& jobs)
{
  std::vector<SubmittedJob> submitted;
  for (const PlannedJob& job : jobs) {
    auto answer = submit_and_record(folder, submission, job, submitted);
    if (const auto* one = std::get_if<SubmittedJob>(&answer)) {
      submitted.push_back(*one);
      continue;
    }
    InputError::Facts fault = std::get<InputError::Facts>(answer);
    if (!submitted.empty()) {
      fault.wanted += "; " + std::to_string(submitted.size()) + " of " + std::to_string(jobs.size()) +
                      " jobs were already submitted and continue; vrda resume " + folder +
                      " submits the others";
    }
    throw InputError(fault);
  }
  return submitted;
}

std::vector<std::string> lines_of(const Submission& submission, const std::vector<SubmittedJob>& jobs)
{
  std::vector<std::string> lines;
  std::int32_t shown = -2;
  for (const SubmittedJob& submitted : jobs) {
    const PlannedJob& job = submitted.job;
    const bool is_of_case = job.case_number >= 0;
    if (lines.empty() || (is_of_case && job.case_number != shown) || (!is_of_case && shown >= 0)) {
      const bool has_name = is_of_case && submission.has_index();
      lines.push_back(has_name ? case_of(submission, {job.kind, job.case_number, 0}).spec.name + ": " : "");
    } else {
      lines.back() += ", ";
    }
    shown = job.case_number;
    std::string what = name_of(job.kind);
    if (job.kind == TaskKind::shard) what += "s";
    if (job.kind == TaskKind::run) what = submission.has_index() ? "cases" : "run";
    lines.back() += what + " " + id_text(submitted.id, job, submission.slurm);
  }
  return lines;
}

}  // namespace vrda::run
