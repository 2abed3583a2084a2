#include "run/run_output.hpp"

#include <unistd.h>

#include <algorithm>
#include <array>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <utility>
#include <vector>

#include "core/error.hpp"
#include "core/text.hpp"
#include "store/run_files.hpp"
#include "solve/case_solver.hpp"
#include "store/motion_model_file.hpp"

namespace vrda::run {

namespace fs = std::filesystem;

void make_folder(const std::string& folder)
{
  std::error_code error;
  fs::create_directories(folder, error);
  if (error) throw InputError({folder, "folder", error.message(), "a folder that can be written"});
}

namespace {

/// Keys with their values, in order; "reference.component.2.file".
std::vector<std::pair<std::string, std::string>> keys_of(const std::string& resolved_job)
{
  std::vector<std::pair<std::string, std::string>> keys;
  std::istringstream lines(resolved_job);
  std::string table, array;
  int n_in_array = 0;
  for (std::string line; std::getline(lines, line);) {
    if (line.starts_with("[[")) {
      const std::string name = line.substr(2, line.find(']') - 2);
      n_in_array = name == array ? n_in_array + 1 : 1;
      array = name;
      table = name + '.' + std::to_string(n_in_array) + '.';
    } else if (line.starts_with('[')) {
      table = line.substr(1, line.find(']') - 1) + '.';
      if (!array.empty() && table.starts_with(array + '.'))
        table.insert(array.size(), '.' + std::to_string(n_in_array));
    } else if (const std::size_t equals = line.find(" = "); equals != std::string::npos) {
      keys.emplace_back(table + line.substr(0, equals), line.substr(equals + 3));
    }
  }
  return keys;
}

std::string difference_text(const std::string& key, const std::string& found, const std::string& wanted)
{
  return key + ": found " + (found.empty() ? "nothing" : found) + ", this job has " +
         (wanted.empty() ? "nothing" : wanted);
}

/// The title is reported last, and limits affect only the exit code.
bool affects_result(const std::string& key)
{
  return key != "title" && !key.starts_with("limits.");
}

bool is_motion_model(const InputError& error)
{
  return error.facts().field != "/@format";
}

}  // namespace

std::string first_difference(const store::JobRecord& record, const job::Case& job_case)
{
  using Entry = std::pair<std::string, std::string>;
  const auto value_of = [](const std::vector<Entry>& keys, const std::string& key) {
    const auto found = std::find_if(keys.begin(), keys.end(), [&](const Entry& e) { return e.first == key; });
    return found == keys.end() ? std::string() : found->second;
  };
  const std::vector<Entry> found = keys_of(record.resolved), wanted = keys_of(job_case.resolved_job);
  for (const auto& [key, value] : wanted) {
    const std::string other = value_of(found, key);
    if (affects_result(key) && other != value) return difference_text(key, other, value);
  }
  for (const auto& [key, value] : found)
    if (affects_result(key) && value_of(wanted, key).empty()) return difference_text(key, value, "");

  for (const job::LoadedInput& input : job_case.inputs) {
    const auto same = std::find_if(record.inputs.begin(), record.inputs.end(),
                                   [&](const auto& other) { return other.name == input.name; });
    if (same == record.inputs.end() || same->sha256 != input.sha256) return input.name + ": other content";
  }
  const std::string title = value_of(found, "title"), other_title = value_of(wanted, "title");
  return title == other_title ? "" : difference_text("title", title, other_title);
}

std::optional<store::MotionModel> existing_result(const job::Case& job_case, const std::string& output,
                                                  bool may_replace)
{
  require_replaceable(output, "a motion model");
  if (!std::filesystem::exists(output)) return std::nullopt;
  try {
    store::MotionModel model = store::read_motion_model(output);
    const std::string difference = first_difference(model.job, job_case);
    if (difference.empty()) return model;
    if (may_replace) return std::nullopt;
    throw InputError({output, "output",
                      "the result of another job, \"" + model.title + "\" (this one is \"" + job_case.title +
                          "\"); first difference: " + difference,
                      "another name (-o), or --replace"});
  } catch (const InputError& error) {
    if (error.facts().file == output && error.facts().field == "output") throw;
    // Only motion models are replaced.
    if (!is_motion_model(error))
      throw InputError({output, "output", "an HDF5 file that is not a motion model", "another name (-o)"});
    if (may_replace) return std::nullopt;
    throw InputError({output, "output", "a motion model that cannot be read (" + error.facts().found + ")",
                      "another name (-o), or --replace"});
  }
}

InputError with_first_difference(const InputError& error, const job::Case& job_case)
{
  InputError::Facts facts = error.facts();
  if (facts.field != "key") return error;
  std::string output = store::output_of_journal(facts.file);
  for (const std::string_view ending : {".trace.journal", ".journal"}) {
    if (output.empty() && facts.file.ends_with(ending))
      output = facts.file.substr(0, facts.file.size() - ending.size());
  }
  const std::string start_file = store::start_file_of(output);
  if (!std::filesystem::exists(start_file)) return error;
  try {
    const std::string difference = first_difference(store::read_motion_model(start_file).job, job_case);
    if (difference.empty()) return error;
    facts.found = "the journal of another job; first difference: " + difference;
  } catch (const InputError&) {
    return error;
  }
  const std::string key = solve::fingerprint_of(job_case);
  if (facts.wanted.starts_with(key)) facts.wanted.replace(0, key.size(), "this job's");
  return InputError(facts);
}

std::string output_path_of(const std::string& requested, const std::string& job_file)
{
  if (!requested.empty()) return requested;
  const std::string name = fs::path(job_file).stem().string();
  return (fs::path("results") / name / (name + ".h5")).string();
}

std::string run_record_of(const std::string& output)
{
  return output + ".run.json";
}

bool has_start_file(const std::string& output, const std::string& resolved_job)
{
  const std::string start = store::start_file_of(output);
  if (!fs::exists(start)) return false;
  try {
    return store::read_motion_model(start).job.resolved == resolved_job;
  } catch (const InputError&) {
    return false;
  }
}

void require_plain_text(const std::string& option, const std::string& part)
{
  if (is_utf8(part) && !has_control_characters(part)) return;
  throw InputError({option, "", part, "a name in UTF-8 without control characters"});
}

void make_parent_folder(const std::string& file)
{
  std::error_code error;
  const std::string target = resolve_links(file);
  const fs::path target_folder = fs::path(target).parent_path();
  if (target != file && !target_folder.empty() && !fs::is_directory(target_folder, error)) {
    throw InputError(
        {file, "", "a link to \"" + target + "\"", "a link into a folder that exists, or another name"});
  }
  const fs::path folder = fs::path(file).parent_path();
  if (folder.empty()) return;
  fs::create_directories(folder, error);
  if (error) throw InputError({file, "folder", error.message(), "a folder that can be written"});
}

void require_replaceable(const std::string& output, const std::string& what)
{
  if (!fs::exists(output)) return;
  const std::string wanted = "a new name, or " + what + " to replace";
  if (!fs::is_regular_file(output))
    throw InputError({output, "output", "something that is not a regular file", wanted});
  std::array<char, 8> head{};
  std::ifstream(output, std::ios::binary).read(head.data(), head.size());
  constexpr std::array<char, 8> hdf5{'\x89', 'H', 'D', 'F', '\r', '\n', '\x1a', '\n'};
  if (head != hdf5) throw InputError({output, "output", "a file that is not HDF5", wanted});
  if (access(output.c_str(), W_OK) != 0)
    throw InputError({output, "output", "a file without write permission", wanted});
}

namespace {

OutputLock::WaitOptions waiting_for(const std::string& output)
{
  return {[output](const std::string& holder) {
            core::log_info(output + ": waiting for " + holder + ", which is writing it");
          },
          core::is_interrupted};
}

}  // namespace

std::optional<OutputLock> lock_output(const std::string& output, const std::string& command)
{
  return OutputLock::acquire(output, command, waiting_for(output));
}

std::optional<Publication> begin_result(const std::string& output, const std::string& command)
{
  return Publication::begin(output, command, waiting_for(output));
}

core::ExitCode publish(const std::string& output, const std::string& command, const std::string& bytes)
{
  std::optional<Publication> result = begin_result(output, command);
  if (!result) return core::ExitCode::interrupted;
  result->publish(bytes);
  return core::ExitCode::done;
}

bool may_add_to(const std::string& file)
{
  std::error_code error;
  const fs::path folder = fs::weakly_canonical(file, error).parent_path();
  if (error || (access(file.c_str(), W_OK) == 0 && access(folder.c_str(), W_OK) == 0)) return true;
  if (access(file.c_str(), R_OK) != 0) return true;  // reading it reports the file
  core::log_warning(
      file +
      ": found no write access to the file or its folder; the result is printed, not stored in the file");
  return false;
}

void remove_obsolete_files(const std::vector<std::string>& files)
{
  for (const std::string& file : files) {
    std::error_code error;
    fs::remove(file, error);
    if (!error) continue;
    core::log_warning(file + ": found a file that cannot be removed (" + error.message() +
                         "); it is no longer needed");
    return;
  }
}

}  // namespace vrda::run
