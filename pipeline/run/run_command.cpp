#include "run/run_command.hpp"

#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <iterator>
#include <map>
#include <set>
#include <utility>

#include "core/text.hpp"
#include "geometry/gap_query.hpp"
#include "geometry/knee_fit.hpp"
#include "job/case_warnings.hpp"
#include "job/clean_mesh.hpp"
#include "job/job.hpp"
#include "model/frames.hpp"
#include "prepare/template_joint.hpp"
#include "run/campaign.hpp"
#include "run/result.hpp"
#include "run/solve_part.hpp"
#include "solve/case_solver.hpp"
#include "store/journal.hpp"
#include "store/motion_model.hpp"
#include "store/trace.hpp"

namespace vrda::run {
namespace {

// A trace has a single Delta and the varus of each cell; a free varus is the best of many starts.
void require_traceable(const job::Case& job_case, const std::string& job_file)
{
  if (job_case.is_varus_free)
    throw InputError({job_file, "grid.varus", "\"free\" with --trace", "values of varus"});
  for (const job::Push& push : job_case.push) {
    if (push.delta == job_case.frame.delta) continue;
    throw InputError(
        {job_file, "push.delta", "directions that differ over flexion with --trace", "one direction"});
  }
}

// Reads the traces back from their journal: a run does not keep them in memory.
void write_trace_of(const job::Case& job_case, const solve::SweepResult& result, const std::string& output)
{
  const store::TraceJournalContent content = store::read_trace_journal(store::trace_journal_of(output));
  check(content.dropped_reason.empty(), "the journal of traces is undamaged");
  const std::string path = store::trace_name(output);
  store::write_trace(path, solve::trace_of(job_case, solve::fingerprint_of(job_case), content.searches,
                                           result.spine_column));
  core::log_info("trace of " + std::to_string(content.searches.size()) + " searches: " + path);
}

/// Files to remove when the model is complete. The journal of steps comes first: without its traces it could
/// not be resumed with --trace.
std::vector<std::string> obsolete_files(const StepLog& log, const std::string& output)
{
  return {log.path, store::trace_journal_of(output), store::start_file_of(output)};
}

core::ExitCode solve_and_write(const job::Case& job_case, const RunOptions& options, StepLog& log,
                               const std::string& output)
{
  const int n_threads = thread_count_or_all(options.n_threads);
  RunRecord record(n_threads, static_cast<int>(log.known.size()));
  const solve::SweepPlan plan = solve::plan_of(job_case);
  const SolvedPart part = solve_part(job_case, plan, ProgressUnit::cells, options, log);
  const solve::SweepResult& result = part.result;
  if (!result.is_complete) return report_interrupted(log);
  const auto samples = solve_samples(job_case, plan, part, all_samples(job_case), options, log);
  if (!samples) return report_interrupted(log);
  record.end_phase(solving_phase);
  if (log.traces) write_trace_of(job_case, result, output);
  const std::optional<store::MotionModel> model =
      build_result(job_case, result, *samples, output, n_threads, core::is_interrupted, record);
  if (!model) return report_interrupted(log);
  const core::ExitCode code = write_result(job_case, *model, output, obsolete_files(log, output), record);
  if (options.has_profile) record.report_profile();
  return code;
}

/// An existing result of this job that includes the requested trace. Throws if it is another job's.
std::optional<store::MotionModel> finished_before(const job::Case& job_case, const RunOptions& options,
                                                  const std::string& output)
{
  std::optional<store::MotionModel> model = existing_result(job_case, output, options.may_replace);
  const bool has_trace = !options.writes_trace || access(store::trace_name(output).c_str(), F_OK) == 0;
  return options.is_fresh || !has_trace ? std::nullopt : std::move(model);
}

// Empty when interrupted.
std::optional<StepLog> opened_log(const RunOptions& options, const std::string& output,
                                  const std::string& key)
{
  const std::string path = store::journal_of(output);
  if (!options.journal_wait) return open_log(path, key, options.is_fresh);
  std::optional<StepLog> log = open_log_waiting(path, key, options.is_fresh, *options.journal_wait);
  return log || core::is_interrupted() ? std::move(log) : open_log(path, key, options.is_fresh);
}

core::ExitCode whole_run(const RunOptions& options)
{
  const job::Case job_case = load_and_report_case(options.job_file, options);
  if (options.writes_trace) require_traceable(job_case, options.job_file);
  const std::string output = output_path_of(options.output, options.job_file);
  make_parent_folder(output);
  finished_before(job_case, options, output);  // throws for another job's result before anything is written
  if (options.writes_trace) require_replaceable(store::trace_name(output), "a trace");
  const std::string key = solve::fingerprint_of(job_case);
  std::optional<StepLog> opened =
      with_difference_in_errors(job_case, [&] { return opened_log(options, output, key); });
  if (!opened) return core::ExitCode::interrupted;
  StepLog& log = *opened;
  const std::optional<OutputLock> lock = lock_output(output, "vrda run");
  if (!lock) return core::ExitCode::interrupted;
  // Checked again under both locks: another run may have written it meanwhile.
  if (const auto model = finished_before(job_case, options, output)) {
    core::log_info(output + ": this job is finished; --fresh solves it again");
    return finish_existing_result(job_case, *model, output, obsolete_files(log, output),
                                  thread_count_or_all(options.n_threads));
  }
  if (options.writes_trace) {
    log.traces.emplace(open_trace_log(store::trace_journal_of(output), key, log.path, log.known));
  }
  // A resumed run keeps its start file: a full disk may have no space for a second one.
  if (log.known.empty() || !has_start_file(output, job_case.resolved_job)) {
    store::write_motion_model(store::start_file_of(output), solve::pending_model_of(job_case));
  }
  if (!options.is_hosted) core::install_signal_handlers();
  return with_journal_restore(log, output, [&] { return solve_and_write(job_case, options, log, output); });
}

}  // namespace

core::ExitCode run_command(const RunOptions& options)
{
  core::progress_style_of(options.progress);  // throws for an invalid style before any work
  if (options.only_spine) return spine_command(options);
  if (options.shard) return shard_command(options);
  const core::ExitCode code = whole_run(options);
  if (code != core::ExitCode::interrupted && !options.is_hosted)
    std::printf("%s\n", output_path_of(options.output, options.job_file).c_str());
  return code;
}

namespace {

// A network file system may list a folder up to a minute late; access by name is current.
std::vector<std::string> journals_beside(const std::string& output, std::int32_t n_shards)
{
  std::vector<std::string> journals = store::list_shard_journals(output);
  const std::set<std::string> listed(journals.begin(), journals.end());
  for (std::int32_t number = 1; number <= n_shards; ++number) {
    const std::string journal = store::shard_journal_of(output, {number, n_shards});
    if (listed.count(journal) == 0 && access(journal.c_str(), F_OK) == 0) journals.push_back(journal);
  }
  const std::string spine = store::spine_journal_of(output);
  if (access(spine.c_str(), F_OK) == 0) journals.insert(journals.begin(), spine);
  return journals;
}

// The case file of the run that wrote the journals.
std::string case_file_for(const std::string& output, const std::vector<std::string>& journals)
{
  for (const std::string& journal : journals) {  // renamed copies do not identify their run
    const std::string run = store::output_of_journal(journal);
    const std::string case_file = run::case_file_of(run);
    if (!run.empty() && access(case_file.c_str(), F_OK) == 0) return case_file;
  }
  return run::case_file_of(output);
}

job::Case case_to_merge(const MergeOptions& options, const std::vector<std::string>& journals)
{
  if (!options.job_file.empty()) return load_and_report_case(options.job_file, options);
  const std::string case_file = case_file_for(options.output, journals);
  const run::CaseSpec spec = run::read_case_file(case_file).spec;
  try {
    return load_and_report_case(spec.job_file, {spec.data_directory, spec.overrides});
  } catch (const InputError& error) {
    throw run::error_of_case_file(case_file, spec, error);
  }
}

// "; no journal of shard 3, 5 of 8", from the journals' names.
std::string absent_shards(const std::vector<std::string>& journals)
{
  std::set<std::pair<std::int32_t, std::int32_t>> present;
  for (const std::string& journal : journals) {
    if (const auto shard = store::shard_of_journal(journal)) present.emplace(shard->count, shard->number);
  }
  if (present.empty()) return "";
  const std::int32_t count = present.begin()->first;
  std::vector<std::string> absent;
  for (std::int32_t number = 1; number <= count; ++number)
    if (present.count({count, number}) == 0) absent.push_back(std::to_string(number));
  return absent.empty() ? "" : "; no journal of shard " + joined(absent) + " of " + std::to_string(count);
}

// The records of all samples.
std::vector<StepRecord> whole_samples(const job::Case& job_case, const CollectedSteps& collected,
                                      const std::vector<std::string>& journals, const std::string& output)
{
  KnownSamples known = known_samples(job_case, collected.steps);
  if (known.missing.empty()) return std::move(known.records);
  throw InputError({output, "journals",
                    "no result for " + std::to_string(known.missing.size()) + " of " +
                        std::to_string(n_samples_of(job_case)) + " samples" + absent_shards(journals),
                    "complete journals of the spine and of every shard; the journals found are kept"});
}

void require_whole(const job::Case& job_case, const CollectedSteps& collected,
                   const std::vector<std::string>& journals, const std::string& output)
{
  const MissingSteps missing = missing_steps(solve::plan_of(job_case), collected.steps);
  if (missing.is_empty()) return;
  std::string found = missing_text(missing, job_case.grid.flexion_deg, job_case.grid.varus_deg);
  if (!found.empty()) found += absent_shards(journals);
  if (!missing.is_spine_complete) found += found.empty() ? "no complete spine" : "; the spine is incomplete";
  throw InputError({output, "journals", found,
                    "complete journals of the spine and of every shard; the journals found are kept"});
}

std::string doubled_text(const CollectedSteps& collected, const job::Case& job_case)
{
  const std::vector<std::int32_t> rows(collected.duplicate_rows.begin(), collected.duplicate_rows.end());
  return std::to_string(collected.n_duplicates) +
         " steps are in more than one journal, with the same result: at flexion " +
         angles_text(rows, job_case.grid.flexion_deg) + ", in " +
         joined({collected.duplicate_journals.begin(), collected.duplicate_journals.end()});
}

// Removes the shards' files next to the output; others are copies of the user.
void remove_shard_files(const std::string& output, const std::vector<std::string>& journals)
{
  std::vector<std::string> obsolete;
  std::copy_if(journals.begin(), journals.end(), std::back_inserter(obsolete),
               [&](const std::string& journal) { return store::output_of_journal(journal) == output; });
  obsolete.push_back(store::start_file_of(output));
  obsolete.push_back(run::case_file_of(output));  // last: until then it records that the model is complete
  remove_obsolete_files(obsolete);
}

// A complete model without journals and case file, so that its job cannot be compared.
bool is_merged(const std::string& output, const std::vector<std::string>& journals)
{
  if (!journals.empty() || access(run::case_file_of(output).c_str(), F_OK) == 0) return false;
  if (access(output.c_str(), F_OK) != 0) return false;
  return (store::read_motion_model(output).status != status_pending).all();
}

void note_merged(const std::string& output)
{
  const std::string case_file = run::case_file_of(output);
  if (access(case_file.c_str(), F_OK) != 0) return;
  run::CaseFile content = run::read_case_file(case_file);
  content.merged_sha256 = run::sha256_of_model(output);
  run::write_case_file(case_file, content);
}

/// The model is complete; if that cannot be recorded in the case file, the journals are kept for another
/// merge.
void finish_merge(const std::string& output, const std::vector<std::string>& journals)
{
  try {
    note_merged(output);
  } catch (const InputError& error) {
    core::log_warning(error.what());
    return;
  }
  remove_shard_files(output, journals);
}

}  // namespace

core::ExitCode merge_command(const MergeOptions& options)
{
  const std::string& output = options.output;
  make_parent_folder(output);
  const std::optional<OutputLock> lock = lock_output(output, "vrda merge");
  if (!lock) return core::ExitCode::interrupted;
  // Listed under the lock: a merge that this one waited for has removed them.
  const std::vector<std::string> journals =
      options.journals.empty() ? journals_beside(output, options.n_shards) : options.journals;
  require_replaceable(output, "a motion model");
  if (!options.keeps_journals && run::is_cleanup_pending(output)) {
    remove_shard_files(output, journals);
    core::log_info(output + ": already merged");
    return core::ExitCode::done;
  }
  if (is_merged(output, journals)) {
    core::log_info(output + ": complete; there are no journals to merge");
    return core::ExitCode::done;
  }
  const job::Case job_case = case_to_merge(options, journals);
  if (const auto model = existing_result(job_case, output, options.may_replace)) {
    core::log_info(output + ": this job is already merged");
    const core::ExitCode code =
        finish_existing_result(job_case, *model, output, {}, thread_count_or_all(options.n_threads));
    std::printf("%s\n", output.c_str());
    if (!options.keeps_journals) finish_merge(output, journals);
    return code;
  }

  const int n_threads = thread_count_or_all(options.n_threads);
  const CollectedSteps collected = with_difference_in_errors(
      job_case, [&] { return collect_steps(journals, solve::fingerprint_of(job_case)); });
  for (const std::string& remark : collected.warnings) core::log_warning(remark);
  if (collected.n_duplicates > 0) {
    core::log_info(doubled_text(collected, job_case));
  }
  require_whole(job_case, collected, journals, output);
  const std::vector<StepRecord> samples = whole_samples(job_case, collected, journals, output);
  RunRecord record(n_threads, static_cast<int>(collected.steps.size()));
  const solve::SweepResult result = replay_sweep(solve::plan_of(job_case), collected.steps);
  const std::optional<store::MotionModel> model =
      build_result(job_case, result, samples, output, n_threads, core::is_interrupted, record);
  if (!model) {
    core::log_info("interrupted: the journals are kept; run the same command to merge again");
    return core::ExitCode::interrupted;
  }
  const core::ExitCode code = write_result(job_case, *model, output, {}, record);
  std::printf("%s\n", output.c_str());
  if (!options.keeps_journals) finish_merge(output, journals);
  return code;
}

namespace {

using Warnings = std::vector<std::string>;

std::string list_text(const Eigen::Vector3d& v)
{
  std::string text;
  for (const double value : v) text += (text.empty() ? "[" : ", ") + short_decimal(value, 2);
  return text + "]";
}

// Signed coordinate axis nearest to the direction from the moving object to the reference.
Eigen::Vector3d towards_reference(const job::Case& job_case)
{
  const Box reference = bounding_box(job_case.reference.contact.mesh);
  const Box moving = bounding_box(job_case.moving.contact.mesh);
  const Eigen::Vector3d offset_mm = reference.min_mm + reference.max_mm - moving.min_mm - moving.max_mm;
  Eigen::Index k = 0;
  offset_mm.cwiseAbs().maxCoeff(&k);
  return Eigen::Vector3d::Unit(k) * (offset_mm[k] < 0.0 ? -1.0 : 1.0);
}

// At the first flexion.
InitialContact initial_contact(const job::Case& job_case)
{
  const solve::InitialBodies bodies = solve::initial_bodies_of(job_case);
  const solve::SweepPlan plan = solve::plan_of(job_case);
  contact::NarrowPhase narrow_phase;
  const Attitude attitude{plan.flexion_rad.front(), 0.0};
  const geometry::TreeMesh reference = geometry::rotated_reference(bodies.reference, attitude);
  const bool is_overlapping =
      contact::find_collision(reference, bodies.moving, plan.initial, narrow_phase).has_value();
  geometry::GapQuery query(geometry::GapTree(bodies.reference.mesh), geometry::GapTree(bodies.moving.mesh));
  query.set_attitude(attitude);
  const double travel_mm =
      is_overlapping ? query.travel_mm(plan.initial) : query.next_contact(plan.initial).travel_mm;
  return {is_overlapping, travel_mm, bodies.substep_mm};
}

// An initial pose from which the first step cannot approach the reference.
void warn_of_start(const job::Case& job_case, const InitialContact& start, Warnings& warnings)
{
  const Eigen::Vector3d& delta = job_case.frame.delta;
  if (start.is_overlapping) {
    constexpr double clearance_mm = 5.0;
    std::string remedy = "a larger shift against push.delta";
    if (std::isfinite(start.travel_mm)) {
      const Eigen::Vector3d clear_mm =
          job_case.initial.translation_mm + (start.travel_mm - clearance_mm) * delta;
      remedy = "moving.initial.translation_mm = " + list_text(clear_mm);
    }
    warnings.push_back(
        "moving.initial.translation_mm: the objects overlap in the initial pose; to clear it, use " + remedy);
  } else if (!std::isfinite(start.travel_mm)) {
    warnings.push_back(
        "push.delta: the reference is not along Delta from the initial pose, so no attitude can be solved; "
        "the direction to it is push.delta = " +
        list_text(towards_reference(job_case)) +
        "; also check moving.initial.translation_mm, and winding, which sets the outside of open sheets");
  }
}

// Enough to identify a faulty component; the exact number is not needed.
constexpr std::size_t most_overlaps = 100;

// Components whose triangles intersect each other: their thickness is undefined. The case is at the subject's
// size, and places are those of the files.
void warn_of_self_overlaps(const job::Job& job, const job::Case& at_size, BodyIndex index, Warnings& warnings)
{
  const Body& body = part_of(at_size, index);
  const job::BodyJob& body_job = part_of(job, index);
  const Pose X_file_canonical = job::body_map(job, body_job).X_canonical_native.inverse();
  const Eigen::Vector3d centre_mm = at_size.frame.rotation_centre_mm;
  const Eigen::Vector3d factor =
      at_size.scaling ? at_size.scaling->factor : Eigen::Vector3d(Eigen::Vector3d::Ones());
  const std::vector<std::vector<Eigen::Index>> rows = triangles_by_component(body, body.contact);
  contact::NarrowPhase narrow_phase;
  for (std::size_t c = 0; c < body.components.size(); ++c) {
    if (rows[c].empty()) continue;
    const Mesh mesh = select_triangles(body.contact.mesh, rows[c]);
    const std::vector<geometry::TrianglePair> pairs =
        contact::find_self_overlaps(geometry::make_tree_mesh(mesh), narrow_phase, most_overlaps);
    if (pairs.empty()) continue;
    std::vector<Eigen::Vector3d> places_mm;
    for (const geometry::TrianglePair& pair : pairs) {
      const auto [p, q, r] = corners(mesh, pair.reference);
      const Eigen::Vector3d at_mm = centre_mm + ((p + q + r) / 3.0 - centre_mm).cwiseQuotient(factor);
      places_mm.push_back(body_job.components[c].generate ? at_mm : X_file_canonical * at_mm);
    }
    warnings.push_back(body.name + " component \"" + body.components[c].name +
                       "\": its triangles intersect each other in " +
                       (pairs.size() == most_overlaps ? "at least " : "") + std::to_string(pairs.size()) +
                       " place(s), " + job::places_text(places_mm));
  }
}

// The contact triangles of bones, without those of `left_out`.
Mesh bones_of(const Body& body, std::size_t left_out)
{
  const std::vector<std::vector<Eigen::Index>> rows = triangles_by_component(body, body.contact);
  std::vector<Eigen::Index> kept;
  for (std::size_t c = 0; c < rows.size(); ++c) {
    if (c != left_out && body.components[c].material == "bone")
      kept.insert(kept.end(), rows[c].begin(), rows[c].end());
  }
  return job::compacted(body.contact.mesh, kept);
}

// "the mesh of moving.component.0" with the same file as a cartilage, if that is of the other body or no
// cartilage; empty: none.
std::string same_file_as(const job::ComponentJob& cartilage, bool is_reference, const job::Job& job,
                         const job::Case& job_case)
{
  std::map<std::string, std::string> sha256;
  for (const job::LoadedInput& input : job_case.inputs) sha256[input.name] = input.sha256;
  for (const bool is_other_reference : {true, false}) {
    for (const job::ComponentJob& part : (is_other_reference ? job.reference : job.moving).components) {
      const bool may_be_same = is_reference == is_other_reference && part.material == cartilage.material;
      if (!may_be_same && !part.generate && sha256[part.file] == sha256[cartilage.file])
        return "the mesh of " + part.key + " (\"" + part.name + "\")";
    }
  }
  return "";
}

// The cartilage of a knee is neither its bone nor a meniscus. Both bones are compared where their meshes have
// common axes.
void require_own_cartilage(const job::Job& job, const job::Case& job_case)
{
  const bool is_one_scan = !job.reference.frame && !job.moving.frame;
  for (const bool is_femur : {true, false}) {
    const Body& body = is_femur ? job_case.reference : job_case.moving;
    const Body& other = is_femur ? job_case.moving : job_case.reference;
    const std::vector<job::ComponentJob>& parts = (is_femur ? job.reference : job.moving).components;
    const std::vector<std::vector<Eigen::Index>> rows = triangles_by_component(body, body.contact);
    for (std::size_t c = 0; c < rows.size(); ++c) {
      // A bone with an offset may be its own cartilage.
      if (rows[c].empty() || body.components[c].material != "cartilage" || parts[c].generate ||
          parts[c].is_offset_fitted || parts[c].offset_mm != 0.0 || parts[c].inset_mm != 0.0)
        continue;
      const Mesh part = job::compacted(body.contact.mesh, rows[c]), own = bones_of(body, c);
      std::string found = same_file_as(parts[c], is_femur, job, job_case);
      if (found.empty() && own.triangles.rows() > 0 && geometry::is_part_of(part, own))
        found = "the surface of its bone";
      if (found.empty() && is_one_scan) {
        found = geometry::cartilage_check(
                    part, is_femur ? geometry::CartilageOf::femur : geometry::CartilageOf::tibia, own,
                    bones_of(other, other.components.size()))
                    .rejection;
      }
      if (!found.empty())
        job.document.refuse(parts[c].key + ".file", found,
                            "the mesh of the cartilage \"" + parts[c].name +
                                "\", in the scan of the bones; or another material");
    }
  }
}

// Collaterals on the wrong side are those of the other knee, unless the bones also say that the side is
// wrong: then a warning says so.
void require_table_of_side(const job::Job& job, const job::Case& job_case)
{
  const std::string misplaced = job::misplaced_collateral(job_case, job.side);
  if (!misplaced.empty()) {
    const std::string place = misplaced == "MCL" ? "lateral" : "medial";
    job.document.refuse("ligaments",
                        misplaced + " on the " + place + " side of a " + side_name(job.side) +
                            " knee, as its other collateral",
                        misplaced + " on the " + (misplaced == "MCL" ? "medial" : "lateral") +
                            " side: check the sign of its coordinate along frame.right");
  }
  const std::optional<Side> found = job::collateral_side(job_case);
  if (!found || *found == job.side) return;
  for (const std::string& warning : job_case.warnings)
    if (warning.starts_with("side: ")) return;
  const std::string side = side_name(job.side), other = side_name(*found);
  job.document.refuse(
      "ligaments", "MCL and LCL where a " + other + " knee has them, and side = \"" + side + "\"",
      "the fibres of a " + side + " knee: in a table of a " + other +
          " knee the coordinate along frame.right of both attachments changes its sign; or side "
          "= \"" +
          other + "\" if the bones are of a " + other + " knee");
}

}  // namespace

CheckedCase load_checked_case(const job::Job& job, const std::string& data_directory,
                              std::uintmax_t large_bytes)
{
  constexpr std::uintmax_t bytes_per_mb = 1'000'000;
  if (const std::uintmax_t n_bytes = job::mesh_bytes(job, data_directory); n_bytes >= large_bytes)
    core::log_info("reading and checking meshes of " + std::to_string(n_bytes / bytes_per_mb) + " MB");
  job::Case loaded = job::load_case(job, data_directory);
  const job::Case at_size = job::scaled_to_subject(loaded);
  const InitialContact initial = initial_contact(at_size);
  Warnings& warnings = loaded.warnings;
  warn_of_start(at_size, initial, warnings);
  for (const BodyIndex index : {BodyIndex::reference, BodyIndex::moving})
    warn_of_self_overlaps(job, at_size, index, warnings);
  if (job::has_mesh_file(job)) {
    const prepare::FrameKeys keys{frame_of(job, job.reference).key, frame_of(job, job.moving).key};
    for (const std::string& warning : prepare::frame_warnings(at_size, keys)) warnings.push_back(warning);
  }
  require_table_of_side(job, loaded);
  if (job.joint == "knee") require_own_cartilage(job, loaded);
  return {std::move(loaded), initial};
}

}  // namespace vrda::run
