#include "run/run_output.hpp"

#include <unistd.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <limits>
#include <sstream>
#include <thread>
#include <utility>

#include "core/process.hpp"
#include "job/job.hpp"
#include "run/run_command.hpp"
#include "solve/case_solver.hpp"

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

std::string result_name_of(const std::string& job_file)
{
  constexpr std::size_t most_folders = 2;
  const fs::path folder = fs::absolute(job_file).lexically_normal().parent_path();
  const fs::path here = folder.lexically_relative(fs::current_path());
  const bool is_below = !here.empty() && *here.begin() != "..";
  std::vector<std::string> names;
  for (const fs::path& part : is_below ? here : folder.relative_path()) {
    if (part == "jobs") {
      names.clear();
    } else if (!part.empty() && part != ".") {
      names.push_back(part.string());
    }
  }
  if (names.size() > most_folders) names.erase(names.begin(), names.end() - most_folders);
  const std::string file = fs::path(job_file).stem().string();
  if (names.empty() || !names.back().ends_with(file)) names.push_back(file);
  return core::joined(names, "-");
}

std::string output_path_of(const std::string& requested, const std::string& job_file)
{
  if (!requested.empty()) return requested;
  const std::string name = result_name_of(job_file);
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

namespace {

using Json = nlohmann::ordered_json;

std::string factor_text(const Eigen::Vector3d& factor)
{
  if (is_uniform(factor)) return rounded_text(factor.x());
  return printed("[%.6g, %.6g, %.6g]", factor.x(), factor.y(), factor.z());
}

}  // namespace

std::string scaling_line(const job::Case& job_case)
{
  if (!job_case.scaling) return "";
  const Scaling& scaling = *job_case.scaling;
  if (scaling.factor == Eigen::Vector3d::Ones()) return "scaled by 1: the joint has the size of the meshes";
  const std::string by = "scaled by " + factor_text(scaling.factor);
  if (scaling.keeps_steps)
    return by + " from the unscaled joint: uniform scaling keeps contact, the steps are shared";
  return by + ": a new run, since " + job_case.rerun_reason;
}

Json scaling_json(const std::optional<Scaling>& scaling)
{
  if (!scaling) return {};
  Json landmarks = Json::array();
  for (std::size_t i = 0; i < scaling->landmark.size(); ++i) {
    landmarks.push_back({{"name", scaling->landmark[i]},
                         {"model_mm", scaling->model_mm[i]},
                         {"scaled_mm", scaling->factor.x() * scaling->model_mm[i]},
                         {"subject_mm", scaling->subject_mm[i]},
                         {"residual_mm", scaling->residual_mm[i]}});
  }
  return {{"factor", {scaling->factor.x(), scaling->factor.y(), scaling->factor.z()}},
          {"keeps_steps", scaling->keeps_steps},
          {"standard_error", scaling->standard_error},
          {"residual_rms_mm", scaling->residual_rms_mm},
          {"landmarks", landmarks}};
}

void print_scaling(const Json& scaling)
{
  if (scaling.is_null()) return;
  const Json& f = scaling["factor"];
  std::printf("scaling: factor %s",
              factor_text({f[0].get<double>(), f[1].get<double>(), f[2].get<double>()}).c_str());
  const Json& pairs = scaling["landmarks"];
  if (!pairs.empty()) {
    const Json& error = scaling["standard_error"];
    std::printf(" (standard error %s), from %zu pair(s) of landmarks, residual %.2f mm root mean square",
                error.is_null() ? "unknown" : short_decimal(error.get<double>(), 6).c_str(), pairs.size(),
                scaling["residual_rms_mm"].get<double>());
  }
  std::printf("\n");
  if (pairs.empty()) return;
  std::printf("  %-24s %10s %10s %10s %10s mm\n", "pair", "model", "scaled", "subject", "residual");
  for (const Json& pair : pairs) {
    std::printf("  %-24s %10.2f %10.2f %10.2f %+10.2f\n", pair["name"].get<std::string>().c_str(),
                pair["model_mm"].get<double>(), pair["scaled_mm"].get<double>(),
                pair["subject_mm"].get<double>(), pair["residual_mm"].get<double>());
  }
}

std::map<std::string, int> cells_by_status(const store::MotionModel& model)
{
  std::map<std::string, int> counts;
  for (Eigen::Index c = 0; c < model.status.size(); ++c) {
    ++counts[name_of(static_cast<StepStatus>(model.status.data()[c]))];
  }
  return counts;
}

store::GridB is_past_border(const store::MotionModel& model)
{
  store::GridB past = store::GridB::Zero(model.status.rows(), model.status.cols());
  const std::vector<double>& flexion_deg = model.flexion_deg;
  const double start_deg = *std::min_element(flexion_deg.begin(), flexion_deg.end(),
                                             [](double a, double b) { return std::abs(a) < std::abs(b); });
  for (Eigen::Index j = 0; j < past.cols(); ++j) {
    for (const double sign : {1.0, -1.0}) {
      const auto is_at_border = [&](Eigen::Index i) {
        return model.plausibility(i, j) == static_cast<std::int8_t>(Plausibility::border_contact);
      };
      const auto beyond_start_deg = [&](Eigen::Index i) {
        return sign * (flexion_deg[static_cast<std::size_t>(i)] - start_deg);
      };
      double first_deg = std::numeric_limits<double>::infinity();
      for (Eigen::Index i = 0; i < past.rows(); ++i) {
        if (is_at_border(i) && beyond_start_deg(i) >= 0.0)
          first_deg = std::min(first_deg, beyond_start_deg(i));
      }
      for (Eigen::Index i = 0; i < past.rows(); ++i)
        if (is_at_border(i) && beyond_start_deg(i) > first_deg + border_margin_deg) past(i, j) = 1;
    }
  }
  return past;
}

double unsolved_fraction(const store::MotionModel& model)
{
  const auto stable = (model.status == status_stable && is_past_border(model) == 0).count();
  return 1.0 - static_cast<double>(stable) / static_cast<double>(model.status.size());
}

std::string samples_line(const store::MotionModel& model)
{
  if (!model.uncertainty) return "";
  const std::vector<std::int8_t>& status = model.uncertainty->status;
  const auto n_stable = std::count(status.begin(), status.end(), status_stable);
  const auto n_failed = static_cast<std::ptrdiff_t>(status.size()) - n_stable;
  std::string line = std::to_string(model.uncertainty->n_samples()) +
                     " samples: " + std::to_string(n_stable) + " of " + std::to_string(status.size()) +
                     " poses stable";
  if (n_failed > 0) line += ", " + std::to_string(n_failed) + " left out of the bands";
  return line;
}

namespace {

// The grids of the joint and of its followers, by name; the joint's is empty.
std::vector<std::pair<std::string, const store::GridB*>> plausibilities_of(const store::MotionModel& model)
{
  std::vector<std::pair<std::string, const store::GridB*>> all{{"", &model.plausibility}};
  for (const store::FollowerRows& follower : model.followers)
    all.emplace_back(follower.name, &follower.plausibility);
  return all;
}

}  // namespace

std::vector<DoubtfulCell> doubtful_cells(const store::MotionModel& model)
{
  std::vector<DoubtfulCell> cells;
  for (const auto& [name, grid] : plausibilities_of(model)) {
    for (Eigen::Index i = 0; i < grid->rows(); ++i) {
      for (Eigen::Index j = 0; j < grid->cols(); ++j) {
        const auto plausibility = static_cast<Plausibility>((*grid)(i, j));
        if (!is_doubtful(plausibility)) continue;
        cells.push_back({model.flexion_deg[static_cast<std::size_t>(i)],
                         model.varus_deg[static_cast<std::size_t>(j)], plausibility, name});
      }
    }
  }
  return cells;
}

std::string plausibility_line(const store::MotionModel& model)
{
  std::vector<std::string> words;
  for (const auto& [name, grid] : plausibilities_of(model)) {
    for (const Plausibility plausibility : doubtful_plausibilities) {
      const auto n = (*grid == static_cast<std::int8_t>(plausibility)).count();
      if (n > 0)
        words.push_back(std::to_string(n) + ' ' + name_of(plausibility) +
                        (name.empty() ? "" : " of " + name));
    }
  }
  return joined(words);
}

bool has_any(const store::MotionModel& model, Plausibility plausibility)
{
  return std::ranges::any_of(plausibilities_of(model), [&](const auto& of) {
    return (*of.second == static_cast<std::int8_t>(plausibility)).any();
  });
}

std::string status_line(const store::MotionModel& model)
{
  std::vector<std::string> words;
  for (const auto& [name, n] : cells_by_status(model)) words.push_back(std::to_string(n) + ' ' + name);
  return std::to_string(model.status.size()) + " attitudes: " + joined(words);
}

job::Case load_and_report_case(const std::string& job_file, const job::LoadOptions& options)
{
  job::Case job_case =
      load_checked_case(job::read_job(job_file, options.overrides), options.data_directory).job_case;
  for (const std::string& line : job_case.warnings) core::log_warning(line);
  if (const std::string line = scaling_line(job_case); !line.empty()) core::log_info(line);
  return job_case;
}

store::MotionModel read_solved_model(const std::string& file)
{
  store::MotionModel model = store::read_motion_model(file);
  const auto n_stable = (model.status == status_stable).count();
  if (n_stable == 0) throw InputError({file, "/status", status_line(model), "at least one stable attitude"});
  return model;
}

int thread_count_or_all(int requested)
{
  if (requested > 0) return requested;
  return core::usable_processors();
}

namespace {

StepLog log_of(const std::string& path, store::OpenJournal opened)
{
  const store::JournalContent& content = opened.content;
  if (!content.dropped_reason.empty()) {
    core::log_warning(path + ": dropped " + std::to_string(content.dropped_bytes) + " bytes at the end (" +
                      content.dropped_reason + "); those steps are solved again");
  }
  StepLog log{path, std::move(opened.writer), {}, {}};
  for (const StepRecord& r : content.records) log.known.emplace(r.key, r);
  if (!log.known.empty())
    core::log_info("resuming: " + std::to_string(log.known.size()) + " steps found in " + path);
  return log;
}

bool is_in_place(const StepLog& log)
{
  return log.writer.is_in_place() && (!log.traces || log.traces->is_in_place());
}

}  // namespace

StepLog open_log(const std::string& path, const std::string& key, bool is_fresh)
{
  if (is_fresh) return {path, store::JournalWriter::create(path, key), {}, {}};
  return log_of(path, store::JournalWriter::open(path, key));
}

std::optional<StepLog> open_log_waiting(const std::string& path, const std::string& key, bool is_fresh,
                                        const JournalWait& patience)
{
  if (is_fresh) return open_log(path, key, true);
  constexpr std::chrono::milliseconds pause{100};
  for (std::chrono::milliseconds waited{0};; waited += pause) {
    if (core::is_interrupted()) return std::nullopt;
    if (std::optional<store::OpenJournal> opened = store::JournalWriter::try_open(path, key)) {
      return log_of(path, std::move(*opened));
    }
    if (waited == pause) {
      core::log_info("waiting for the run that writes " + path);
      patience.on_start();
    }
    if (waited >= patience.timeout) return std::nullopt;
    std::this_thread::sleep_for(pause);
  }
}

std::optional<StepRecord> recalled_step(const StepLog& log, const StepKey& key)
{
  const auto found = log.known.find(key);
  return found == log.known.end() ? std::nullopt : std::optional(found->second);
}

void restore_lost_journals(const StepLog& log, const std::string& output)
{
  if (is_in_place(log)) return;
  const std::string found = "a folder that was deleted or moved during the run",
                    wanted = "an unchanged folder";
  try {
    if (!log.writer.is_in_place()) log.writer.restore();
    if (log.traces && !log.traces->is_in_place()) log.traces->restore();
  } catch (const InputError& error) {
    throw InputError({output, "folder", found, wanted + "; the solved steps are lost: " + error.what()});
  }
  const std::size_t n = store::read_journal(log.path).records.size();
  throw InputError({output, "folder", found,
                    wanted + "; it was restored with the journal of all " + std::to_string(n) +
                        " steps solved; run the same command to resume"});
}

namespace {

// The free spine has no cells. A spine cell of the search was solved as a probe, which has the trace.
bool needs_trace(const StepKey& key, const std::map<StepKey, StepRecord>& known)
{
  if (key.kind == StepKind::spine) return !known.contains({StepKind::spine_probe, key.flexion, key.varus});
  return key.kind == StepKind::row || key.kind == StepKind::spine_probe;
}

}  // namespace

core::FrameWriter open_trace_log(const std::string& path, const std::string& key,
                                 const std::string& steps_path, const std::map<StepKey, StepRecord>& known)
{
  if (known.empty()) return store::create_trace_journal(path, key);
  store::TraceJournalContent content;
  if (std::filesystem::exists(path)) {
    content = store::read_trace_journal(path);
    store::require_key(content.key, path, key);
  }
  const auto n_missing = std::count_if(known.begin(), known.end(), [&](const auto& step) {
    return needs_trace(step.first, known) && content.searches.count(step.first) == 0;
  });
  if (n_missing > 0) {
    throw InputError({path, "",
                      "no trace of " + std::to_string(n_missing) + " steps that " + steps_path + " contains",
                      "a run traced from its start; use --fresh to start over, or continue without --trace"});
  }
  if (!content.dropped_reason.empty()) {
    core::log_warning(path + ": dropped " + std::to_string(content.dropped_bytes) + " bytes at the end (" +
                      content.dropped_reason + ")");
  }
  return store::resume_trace_journal(path, content);
}

StepRecord solve_with_trace(core::FrameWriter& log, const StepKey& key, const MovingPose& seed,
                            const std::function<StepRecord(const SearchObserver&)>& solve)
{
  SearchTrace trace;
  trace.key = key;
  trace.seed = seed;
  StepRecord record = solve([&](const SearchMove& move) { trace.moves.push_back(move); });
  trace.status = record.status;
  log.append(core::bytes_of_value(trace));
  return record;
}

}  // namespace vrda::run
