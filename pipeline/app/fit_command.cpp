// `vrda fit`: inputs of a job from measurements, by identification of the unknowns of [fit] or by a thickness
// in contact.
#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>

#include "analysis/fit_files.hpp"
#include "analysis/offset_fit.hpp"
#include "app/commands.hpp"
#include "app/option_values.hpp"
#include "app/printing.hpp"
#include "core/document.hpp"
#include "core/fields_json.hpp"
#include "core/text.hpp"
#include "core/units.hpp"
#include "job/job.hpp"
#include "job/job_parts.hpp"
#include "job/ligament_files.hpp"
#include "model/coordinates.hpp"
#include "model/frames.hpp"
#include "run/run_command.hpp"
#include "run/run_output.hpp"
#include "solve/case_solver.hpp"
#include "tables/imported_model.hpp"

namespace vrda::app {
namespace {

using FitJson = nlohmann::ordered_json;
using analysis::FitStatus;
using analysis::OffsetFit;
using analysis::OffsetFitInput;

struct FitCommandOptions : job::JobSource {
  std::vector<std::string> to_files;  ///< measured motions and laxities, for [[fit.parameter]]
  std::string motion;                 ///< poses in contact, table or motion model, for offset_mm = "fit"
  std::string rows;  ///< training frames of each motion: A:B, first-half or second-half; empty: all
  std::string translations = "rotation-centre";  ///< of `to_files`, or "mesh-origin"
  std::string angles;        ///< of the tables: deg or rad; empty: as they state, else degrees
  std::string output;        ///< resolved job with the number; empty: none
  bool may_replace = false;  ///< existing files at the output
  bool is_fresh = false;
  int n_threads = 0;  ///< 0: one per processor
  std::string progress = "auto";
  bool as_json = false;
};

// Throws InputError unless `may_replace` if one of the files of `result` exists: it could be an input.
void require_absent(const Publication& result, const FitCommandOptions& o,
                    const std::vector<std::string>& files)
{
  if (!o.may_replace)
    result.require_absent(
        files, {"", "--output", "a file that is not a result of this job", "another --output, or --replace"});
}

constexpr std::uintmax_t largest_measurement_bytes = 64U << 20U;
constexpr double normal_95 = 1.96;  // both sides of a normal distribution

/// The measurements and the cases over their flexions; `data` refers to the cases.
struct Measurements {
  std::vector<analysis::Sequence> trials;
  std::vector<std::vector<std::vector<JointCoordinates>>> followers;  ///< [n_trials, n_followers]
  std::vector<analysis::PublishedValue> laxities;
  std::vector<job::LoadedInput> inputs;
};

bool is_laxity_table(const std::string& file, const std::string& text)
{
  const job::CsvTable table(file, text, {"row", "rows", "rows"});
  return std::ranges::find(table.columns(), "test") != table.columns().end();
}

// Of those that [fit] names.
std::vector<std::vector<JointCoordinates>> measured_followers(const std::string& file, const job::Job& job)
{
  std::vector<std::vector<JointCoordinates>> all;
  for (const job::FollowerJob& follower : job.followers) {
    const bool is_fitted = job.fit->follower_noise.contains(follower.body.name);
    all.push_back(is_fitted ? tables::read_follower(file, follower.body.name, {})
                            : std::vector<JointCoordinates>{});
  }
  return all;
}

// A follower of [fit] that no table has is a mistake.
void require_followers(const FitCommandOptions& o, const job::Job& job, const Measurements& measured)
{
  for (std::size_t k = 0; k < job.followers.size(); ++k) {
    const std::string& name = job.followers[k].body.name;
    const auto has_rows = [&](const auto& trial) { return !trial[k].empty(); };
    if (job.fit->follower_noise.contains(name) && std::ranges::none_of(measured.followers, has_rows))
      throw InputError({o.to_files.back(), "follower_" + name + "_flexion_deg", "no table with this column",
                        "the measured coordinates of " + name + ", which [[fit.follower]] names"});
  }
}

Measurements measurements_of(const FitCommandOptions& o, const analysis::Convention& convention,
                             const job::Job& job)
{
  Measurements all;
  for (const std::string& file : o.to_files) {
    const std::string text = job::file_bytes(file, {file, "", "", "a CSV file of a motion or of laxities"},
                                             largest_measurement_bytes);
    all.inputs.push_back({file, job::sha256_of(text)});
    if (file.ends_with(".csv") && is_laxity_table(file, text)) {
      const std::vector<analysis::PublishedValue> rows = analysis::published_values(file, text);
      all.laxities.insert(all.laxities.end(), rows.begin(), rows.end());
      continue;
    }
    tables::MotionConvention of_table;
    of_table.joint.side = convention.side;
    of_table.joint.rotation_centre_mm = convention.rotation_centre_mm;
    of_table.joint.has_large_flexion = joint_kind(job.joint).has_large_flexion;
    of_table.stated.angles = core::value_named<tables::AngleUnit>(o.angles);
    const tables::MotionSequence motion = tables::read_motion(file, of_table);
    for (const std::string& line : motion.warnings) core::log_warning(line);
    analysis::Sequence trial =
        analysis::sequence_of(file, motion.key_name, motion.key, motion.X_reference_moving, convention);
    const analysis::RowRange rows = rows_of({"vrda fit", "--rows"}, o.rows, trial.rows.size());
    for (std::size_t k = 0; k < trial.rows.size(); ++k) {
      if (!rows.contains(k)) trial.rows[k].missing = "not among --rows";
    }
    all.trials.push_back(std::move(trial));
    all.followers.push_back(measured_followers(file, job));
  }
  require_followers(o, job, all);
  return all;
}

void require_common_flexion(const FitCommandOptions& o, const std::vector<analysis::PublishedValue>& rows,
                            const std::vector<double>& flexion_deg)
{
  const double least = *std::min_element(flexion_deg.begin(), flexion_deg.end());
  const double largest = *std::max_element(flexion_deg.begin(), flexion_deg.end());
  if (std::any_of(rows.begin(), rows.end(), [&](const analysis::PublishedValue& row) {
        return row.flexion_deg >= least && row.flexion_deg <= largest;
      }))
    return;
  throw InputError({o.to_files.back(), "flexion_deg", "no flexion within those of [laxity]",
                    shortest_decimal(least) + " to " + shortest_decimal(largest)});
}

// Whole degrees that cover the trials, and those of the loads, whose unloaded poses are then solved with
// them.
std::vector<double> flexions_of(const std::vector<analysis::Sequence>& trials,
                                const std::vector<double>& of_loads_deg)
{
  double low_deg = 180.0, high_deg = -180.0;
  for (const analysis::Sequence& trial : trials) {
    for (const analysis::Row& row : trial.rows) {
      if (!row.missing.empty()) continue;
      low_deg = std::min(low_deg, std::floor(deg_from_rad(row.value[analysis::at_flexion])));
      high_deg = std::max(high_deg, std::ceil(deg_from_rad(row.value[analysis::at_flexion])));
    }
  }
  std::set<double> flexions_deg(of_loads_deg.begin(), of_loads_deg.end());
  for (double deg = low_deg; deg <= high_deg; deg += 1.0) flexions_deg.insert(deg);
  return {flexions_deg.begin(), flexions_deg.end()};
}

void require_question(const FitCommandOptions& o, const job::Job& job)
{
  if (!job.fit)
    throw InputError({o.job_file, "fit", "nothing", "[[fit.parameter]] for --to (schemas/fit.md)"});
  if (job.scaling)
    throw InputError({o.job_file, "scaling", "a scaled job with --to", "the subject's own meshes"});
}

std::string fixed(double value, int digits = 2)
{
  return std::isnan(value) ? "-" : fixed_text(value, digits);
}

std::string as_shown(double value, std::size_t coordinate)
{
  return fixed(in_file(value, coordinate));
}

void print_unknowns(const analysis::FitDocument& document)
{
  std::printf("%-36s %12s %12s %10s %9s  %s\n", "", "change", "95 % within", "prior sd", "explained", "");
  for (std::size_t k = 0; k < document.unknowns.size(); ++k) {
    const analysis::Unknown& unknown = document.unknowns[k];
    const analysis::FittedUnknown& found = document.found.unknowns[k];
    std::string remark = core::name_of(found.identifiability);
    if (std::abs(found.correlation) > 0.9)
      remark += ", with " + document.unknowns[found.partner].name + ' ' + fixed(found.correlation);
    std::printf("%-36s %12.4g %12.4g %10.4g %8.0f %%  %s\n", (unknown.name + ' ' + unknown.unit()).c_str(),
                found.change, normal_95 * found.sd, unknown.sd, 100.0 * found.explained, remark.c_str());
  }
}

void print_misfit(const analysis::BodyMisfit& misfit, std::size_t c, const char* name)
{
  std::printf("  %-10s %8s %8s %8s\n", name, as_shown(misfit.before[c], c).c_str(),
              as_shown(misfit.after[c], c).c_str(), as_shown(misfit.without[c], c).c_str());
}

void print_misfits(const analysis::Identification& found)
{
  std::printf("root mean square difference (degrees, mm): before, after, after a fit without it\n");
  for (const analysis::TrialMisfit& trial : found.trials) {
    std::printf("%s, %zu rows\n", trial.name.c_str(), trial.n_rows);
    for (std::size_t c = 1; c < analysis::n_scored; ++c)
      print_misfit(trial.joint, c, joint_coordinate_names[c]);
    for (const auto& [follower, misfit] : trial.followers) {
      std::printf("%s\n", follower.c_str());
      for (std::size_t c = 0; c < analysis::n_scored; ++c)
        print_misfit(misfit, c, follower_coordinate_names[c]);
    }
  }
  for (const analysis::LaxityMisfit& row : found.laxities)
    std::printf("%-18s %6.4g degrees: measured %s, before %s, after %s\n", row.measured.test.c_str(),
                row.measured.flexion_deg, fixed(row.measured.value).c_str(), fixed(row.before).c_str(),
                fixed(row.after).c_str());
}

void print_found(const analysis::FitDocument& document)
{
  const analysis::Identification& found = document.found;
  print_unknowns(document);
  std::vector<std::string> undecided;
  for (std::size_t k = 0; k < document.unknowns.size(); ++k) {
    if (found.unknowns[k].identifiability == analysis::Identifiability::undecided)
      undecided.push_back(document.unknowns[k].name);
  }
  std::printf(
      "%s after %d steps; %zu of %zu independent combinations identified; residuals %.2f times the noise\n",
      core::name_of(found.status), found.n_iterations, found.n_directions, document.unknowns.size(),
      found.noise_scale);
  std::printf("not identifiable from the measurements: %s\n",
              undecided.empty() ? "none" : joined(undecided).c_str());
  print_misfits(found);
}

// "fitted.toml" gives "fitted".
std::string stem_of(const std::string& output)
{
  const std::filesystem::path path = output;
  return (path.parent_path() / path.stem()).string();
}

// "fitted.ligaments.csv", "fitted.patella.ligaments.csv".
std::string ligaments_file(const std::string& stem, const job::Job& job, std::optional<std::size_t> follower)
{
  return stem + (follower ? '.' + job.followers.at(*follower).body.name : "") + ".ligaments.csv";
}

std::string journal_of(const FitCommandOptions& o)
{
  return o.output + ".journal";
}

// The job itself, or the bytes of one of its files.
bool is_input(const std::string& file, const FitCommandOptions& o,
              const std::vector<job::LoadedInput>& inputs)
{
  std::error_code error;
  if (!std::filesystem::exists(file, error)) return false;
  if (std::filesystem::equivalent(file, o.job_file, error)) return true;
  const std::string sha256 =
      job::sha256_of(job::file_bytes(file, {file, "", "", "a readable file"}, largest_measurement_bytes));
  return std::any_of(inputs.begin(), inputs.end(),
                     [&](const job::LoadedInput& input) { return input.sha256 == sha256; });
}

bool is_same_fit(const nlohmann::ordered_json& earlier, const job::Job& job,
                 const std::vector<job::LoadedInput>& inputs)
{
  using Json = nlohmann::ordered_json;
  if (!earlier.is_object() || earlier.value("job", Json()) != job.resolved_text) return false;
  const Json found = earlier.value("inputs", Json());
  return found.is_array() && std::equal(found.begin(), found.end(), inputs.begin(), inputs.end(),
                                        [](const Json& a, const auto& b) {
                                          return a.is_object() && a.value("sha256", Json()) == b.sha256;
                                        });
}

// A result of the same job and measurements may be replaced, unless the job reads it.
void require_replaceable_output(const Publication& result, const FitCommandOptions& o, const job::Job& job,
                                const std::vector<job::LoadedInput>& inputs)
{
  const std::string stem = stem_of(o.output), facts = stem + ".fit.json";
  std::vector<std::string> files{o.output, facts, ligaments_file(stem, job, {})};
  for (std::size_t k = 0; k < job.followers.size(); ++k) files.push_back(ligaments_file(stem, job, k));
  std::error_code error;
  const bool is_read =
      std::any_of(files.begin(), files.end(), [&](const auto& file) { return is_input(file, o, inputs); });
  if (!is_read && std::filesystem::exists(facts, error)) {
    const std::string text =
        job::file_bytes(facts, {facts, "", "", "the facts of an earlier fit"}, largest_measurement_bytes);
    try {
      if (is_same_fit(core::json_in(text), job, inputs)) return;
    } catch (const nlohmann::json::exception&) {  // a damaged file is of no fit
    }
  }
  require_absent(result, o, files);
}

void write_fitted(Publication& result, const FitCommandOptions& o, const job::Job& job,
                  const job::Case& job_case, const analysis::FitDocument& document)
{
  const std::string stem = stem_of(o.output);
  analysis::FibreFiles tables;
  for (const analysis::Unknown& unknown : document.unknowns) {
    if (unknown.fibres.empty()) continue;
    const std::string path = ligaments_file(stem, job, unknown.follower);
    if (tables.emplace(unknown.follower, std::filesystem::path(path).filename().string()).second)
      result.add(path, analysis::fitted_ligaments_csv(job, job_case, document.unknowns, document.found,
                                                      unknown.follower));
  }
  result.add(stem + ".fit.json", analysis::fit_json(document));
  result.publish(
      analysis::fitted_job_text(job, job_case, tables, document.unknowns, document.found.change()));
  run::remove_obsolete_files({journal_of(o)});
}

analysis::Identification identified(const FitCommandOptions& o, const analysis::FitData& data,
                                    analysis::IdentifyPlan& plan, const std::vector<job::LoadedInput>& inputs)
{
  std::vector<std::string> hashes{o.rows, o.translations};
  for (const job::LoadedInput& input : inputs) hashes.push_back(input.sha256);
  std::vector<double> noises(plan.fit.noise.begin(), plan.fit.noise.end());
  for (const auto& [follower, of_follower] : plan.fit.follower_noise) {
    hashes.push_back(follower);
    noises.insert(noises.end(), of_follower.begin(), of_follower.end());
  }
  for (const double noise : noises) hashes.push_back(std::isfinite(noise) ? shortest_decimal(noise) : "inf");
  std::optional<core::FrameWriter> journal;
  if (!o.output.empty()) {
    journal.emplace(analysis::open_evaluations(
        journal_of(o), analysis::identification_key(data, plan, hashes), o.is_fresh, plan.known));
    plan.keep = [&](const analysis::Evaluation& evaluation) {
      journal->append(core::bytes_of_value(evaluation));
    };
  }
  core::install_signal_handlers();
  plan.is_stopped = core::is_interrupted;
  analysis::Identification found = analysis::identify(data, plan);
  if (!journal) return found;
  journal->close();
  if (found.is_stopped) core::log_info(journal_of(o) + ": repeat the command to resume");
  return found;
}

core::ExitCode identify_command(const FitCommandOptions& o)
{
  run::require_plain_text("--output", std::filesystem::path(o.output).filename().string());
  const job::Job given = job::read_job(o.job_file, o.overrides);
  require_question(o, given);
  analysis::Convention convention;
  // Frames that are found need the meshes.
  const job::Case first_case =
      run::load_checked_case(job::over_flexions(given, {0.0}), o.data_directory).job_case;
  const job::Job job =
      first_case.found_frames ? job::with_found_frames(given, *first_case.found_frames) : given;
  convention.side = job.side;
  convention.rotation_centre_mm = first_case.frame.rotation_centre_mm;
  if (o.translations == "mesh-origin") convention.translations = analysis::Translations::mesh_origin;
  Measurements measured = measurements_of(o, convention, job);
  if (!measured.laxities.empty() && !job.laxity)
    throw InputError({o.job_file, "laxity", "nothing", "[laxity] with the loads of the measured laxities"});
  analysis::FitData data;
  data.convention = convention;
  std::optional<job::Case> motion, laxity;
  if (!measured.trials.empty()) {
    const std::vector<double> of_loads_deg =
        measured.laxities.empty() ? std::vector<double>{} : job.laxity->flexion_deg;
    motion =
        job::load_case(job::over_flexions(job, flexions_of(measured.trials, of_loads_deg)), o.data_directory);
    data.motion = &*motion;
  }
  if (!measured.laxities.empty()) {
    data.loads = *job.laxity;
    data.loads.cuts.clear();
    require_common_flexion(o, measured.laxities, data.loads.flexion_deg);
    laxity = job::load_case(job::over_flexions(job, data.loads.flexion_deg), o.data_directory);
    data.laxity = &*laxity;
  }
  std::vector<job::LoadedInput> inputs = first_case.inputs;
  inputs.insert(inputs.end(), measured.inputs.begin(), measured.inputs.end());
  std::optional<Publication> result =
      o.output.empty() ? std::nullopt : run::begin_result(o.output, "vrda fit");
  if (!result && !o.output.empty()) return core::ExitCode::interrupted;
  if (result) require_replaceable_output(*result, o, job, inputs);
  data.trials = std::move(measured.trials);
  data.followers = std::move(measured.followers);
  data.laxities = std::move(measured.laxities);
  for (const std::string& warning : first_case.warnings) core::log_warning(warning);
  analysis::IdentifyPlan plan;
  plan.fit = *job.fit;
  plan.unknowns = analysis::unknowns_of(job, first_case);
  plan.n_threads = run::thread_count_or_all(o.n_threads);
  const bool is_shown = core::progress_style_of(o.progress) != core::ProgressStyle::none;
  std::atomic<int> n_done = 0;
  plan.on_progress = [&] {
    const int n = ++n_done;
    if (is_shown && n % 50 == 0) core::log_info(std::to_string(n) + " evaluations");
  };
  const analysis::FitDocument document{
      "vrda " VRDA_VERSION, solve::solver_version_of(first_case),      job.title, job.resolved_text, inputs,
      plan.unknowns,        identified(o, data, plan, measured.inputs)};
  if (document.found.is_stopped) return core::ExitCode::interrupted;
  if (result) write_fitted(*result, o, job, first_case, document);
  if (o.as_json) {
    std::printf("%s", analysis::fit_json(document).c_str());
  } else {
    print_found(document);
  }
  return document.found.status == analysis::FitStatus::converged ? core::ExitCode::done
                                                                 : core::ExitCode::incomplete;
}

// Both sides of a normal distribution: 95 %.
constexpr double interval_95 = 1.96;

// Keys with "fit", and the components in `input`.
std::vector<std::string> fitted_keys(const job::Job& job, OffsetFitInput& input)
{
  std::vector<std::string> keys;
  const auto add = [&keys](const job::BodyJob& body, std::vector<std::int32_t>& rows) {
    for (std::size_t k = 0; k < body.components.size(); ++k) {
      if (!body.components[k].is_offset_fitted) continue;
      keys.push_back(body.components[k].key + ".offset_mm");
      rows.push_back(static_cast<std::int32_t>(k));
    }
  };
  add(job.reference, input.reference);
  add(job.moving, input.moving);
  if (keys.empty())
    job.document.refuse("reference.component.0.offset_mm", "no component with \"fit\"",
                        "offset_mm = \"fit\" of one component or more");
  return keys;
}

std::vector<std::string> with_offset_of(const FitCommandOptions& o, const std::vector<std::string>& keys,
                                        double offset_mm)
{
  std::vector<std::string> overrides = o.overrides;
  for (const std::string& key : keys) overrides.push_back(key + "=" + shortest_decimal(offset_mm));
  return overrides;
}

std::vector<Pose> poses_at(const FitCommandOptions& o, const job::Job& job, const job::Case& job_case)
{
  std::vector<Pose> poses;
  if (!o.motion.ends_with(".h5")) {
    tables::MotionConvention of_table;
    of_table.joint = tables::import_frame(job, job_case).joint;
    of_table.stated.angles = core::value_named<tables::AngleUnit>(o.angles);
    const tables::MotionSequence motion = tables::read_motion(o.motion, of_table);
    for (const std::string& line : motion.warnings) core::log_warning(line);
    poses = motion.X_reference_moving;
  } else {
    const store::MotionModel model = run::read_solved_model(o.motion);
    if (side_named(model.side) != job.side)
      throw InputError({o.motion, "side", model.side, "the side of " + o.job_file});
    for (std::size_t k = 0; 16 * k < model.X_reference_moving.size(); ++k) {
      const Pose X = store::pose_in(model.X_reference_moving, k);
      if (!std::isnan(X.matrix()(0, 0))) poses.push_back(X);
    }
  }
  return poses;
}

struct Report {
  OffsetFit fit;
  std::vector<std::string> keys;
  std::size_t n_frames = 0, n_training = 0;
  double other_gap_rms_mm = nan;
};

void print(const Report& r, const FitCommandOptions& o)
{
  const OffsetFit& found = r.fit;
  if (o.as_json) {
    const FitJson json = {{"keys", r.keys},
                          {"status", core::name_of(found.status)},
                          {"offset_mm", json_value(found.offset_mm)},
                          {"standard_error_mm", json_value(found.standard_error_mm)},
                          {"gap_rms_mm", json_value(found.gap_rms_mm)},
                          {"bare_gap_rms_mm", json_value(found.bare_gap_rms_mm)},
                          {"other_gap_rms_mm", json_value(r.other_gap_rms_mm)},
                          {"travel_per_mm", json_value(found.travel_per_mm)},
                          {"training_frames", r.n_training},
                          {"frames_with_gap", found.n_frames}};
    print_json(json);
    return;
  }
  for (const std::string& key : r.keys) std::printf("%s\n", key.c_str());
  if (found.status == FitStatus::undetermined) {
    std::printf("undetermined: %d of %zu training frames have a gap, and it hardly depends on the offset\n",
                found.n_frames, r.n_training);
    return;
  }
  std::printf("%s: %.4f mm, 95 %% within %.4f mm (remaining gaps of %d frames taken as independent)\n",
              core::name_of(found.status), found.offset_mm, interval_95 * found.standard_error_mm,
              found.n_frames);
  std::printf("gaps along Delta, root mean square: %.4f mm; without offset %.4f mm\n", found.gap_rms_mm,
              found.bare_gap_rms_mm);
  std::printf("1 mm of offset changes a gap by %.3f mm\n", found.travel_per_mm);
  if (!std::isnan(r.other_gap_rms_mm))
    std::printf("the %zu other frames: %.4f mm\n", r.n_frames - r.n_training, r.other_gap_rms_mm);
}

double rms_over(const std::vector<double>& gaps)
{
  double sum = 0.0;
  int n = 0;
  for (const double gap : gaps) {
    sum += std::isnan(gap) ? 0.0 : gap * gap;
    n += std::isnan(gap) ? 0 : 1;
  }
  return n > 0 ? std::sqrt(sum / n) : nan;
}

core::ExitCode fit_command(const FitCommandOptions& o)
{
  if (!o.to_files.empty()) return identify_command(o);
  if (o.motion.empty()) throw InputError({"vrda fit", "--to", "nothing", "--to TABLE, or --motion POSES"});
  std::optional<Publication> result =
      o.output.empty() ? std::nullopt : run::begin_result(o.output, "vrda fit");
  if (!result && !o.output.empty()) return core::ExitCode::interrupted;
  if (result) require_absent(*result, o, {o.output});
  Report report;
  OffsetFitInput input;
  report.keys = fitted_keys(job::read_job(o.job_file, o.overrides), input);
  const job::Job bare_job = job::read_job(o.job_file, with_offset_of(o, report.keys, 0.0));
  job::Case job_case = job::load_case(bare_job, o.data_directory);
  if (!job_case.is_push_fixed_in_reference) job_case = job::with_one_delta(std::move(job_case), o.job_file);
  const job::Case subject = job::scaled_to_subject(job_case);
  if (job_case.scaling)
    throw InputError({o.job_file, "scaling", "a scaled job with offset_mm = \"fit\"",
                      "the subject's own meshes: offset_mm is a length before scaling"});
  const std::vector<Pose> poses = poses_at(o, bare_job, job_case);
  const analysis::RowRange training = rows_of({"vrda fit", "--rows"}, o.rows, poses.size());
  OffsetFitInput others = input;
  for (std::size_t k = 0; k < poses.size(); ++k)
    (training.contains(k) ? input : others).X_reference_moving.push_back(poses[k]);
  report.n_frames = poses.size();
  report.n_training = input.X_reference_moving.size();
  report.fit = analysis::fit_offset(subject, input);
  if (report.fit.status != FitStatus::undetermined)
    report.other_gap_rms_mm = rms_over(analysis::gaps_at_offset(subject, others, report.fit.offset_mm));
  print(report, o);
  if (report.fit.status != FitStatus::converged) return core::ExitCode::incomplete;
  if (!result) return core::ExitCode::done;
  const job::Job found = job::read_job(o.job_file, with_offset_of(o, report.keys, report.fit.offset_mm));
  result->publish(job_case.found_frames ? job::with_found_frames(found, *job_case.found_frames).resolved_text
                                        : found.resolved_text);
  return core::ExitCode::done;
}

}  // namespace

void declare_fit(Command& c)
{
  auto& o = c.options<FitCommandOptions>();
  c.job(o.job_file, "Job file (TOML) with [[fit.parameter]] or offset_mm = \"fit\"");
  Option to = c.option("--to", o.to_files,
                       "Fit [[fit.parameter]] so that the solved motion, or the laxity of [laxity], fits "
                       "this table; may be repeated, each motion is a trial");
  to.repeatable();
  c.option("--motion", o.motion,
           "Fit offset_mm = \"fit\" to these poses in contact: a table, or a motion model (HDF5)")
      .excludes(to);
  c.option("--rows", o.rows,
           "Training frames: A:B (from 1, both included), first-half or second-half; default: all");
  c.option("--translations", o.translations,
           "With --to: rotation-centre, along the Grood-Suntay axes, or mesh-origin, along the "
           "reference's axes")
      .one_of({"rotation-centre", "mesh-origin"})
      .shows_default();
  c.option("--angles", o.angles,
           "Unit of the angles of the tables: deg or rad; default: as they state, else deg")
      .one_of({"deg", "rad"});
  c.option(
      "-o,--output", o.output,
      "Write the resolved job with the numbers found; with --to also JOB.ligaments.csv and JOB.fit.json");
  c.flag("--replace", o.may_replace,
         "Replace existing files that are not results of this job and these measurements");
  c.loading(o);
  c.flag("--fresh", o.is_fresh, "With --to: discard the journal of an interrupted fit");
  c.threads(o.n_threads, "With --to: worker threads; default: one per processor");
  c.progress(o.progress);
  c.json(o.as_json);
  c.runs([&o] { return fit_command(o); });
}

}  // namespace vrda::app
