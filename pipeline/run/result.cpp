#include "run/result.hpp"

#include <unistd.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <ctime>
#include <set>
#include <utility>

#include "analysis/audit.hpp"
#include "analysis/reduce.hpp"
#include "analysis/smooth.hpp"
#include "core/document.hpp"
#include "core/files.hpp"
#include "core/process.hpp"
#include "core/text.hpp"
#include "run/run_output.hpp"
#include "run/status.hpp"
#include "solve/case_solver.hpp"
#include "store/motion.hpp"
#include "store/solved_cells.hpp"
#include "store/verdict.hpp"

namespace vrda::run {
namespace {

// User and system time of all threads so far.
double processor_s()
{
  timespec spent{};
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &spent);
  return static_cast<double>(spent.tv_sec) + 1e-9 * static_cast<double>(spent.tv_nsec);
}

}  // namespace

RunRecord::RunRecord(int n_threads, int n_recalled)
    : started_(std::chrono::system_clock::now()),
      start_(std::chrono::steady_clock::now()),
      processor_start_s_(processor_s()),
      n_threads_(n_threads),
      n_recalled_(n_recalled)
{
}

// Since the start.
RunRecord::Phase RunRecord::elapsed() const
{
  const std::chrono::duration<double> seconds = std::chrono::steady_clock::now() - start_;
  return {"", seconds.count(), processor_s() - processor_start_s_};
}

void RunRecord::end_phase(const std::string& name)
{
  Phase phase = elapsed();
  phase.name = name;
  for (const Phase& earlier : phases_) {
    phase.seconds -= earlier.seconds;
    phase.processor_s -= earlier.processor_s;
  }
  phases_.push_back(phase);
}

void RunRecord::report_profile() const
{
  const Phase all = elapsed();
  const auto line = [&](const Phase& phase) {
    std::fprintf(stderr, "%-24s %8.2f %8.2f %5.0f %%\n", phase.name.c_str(), phase.seconds, phase.processor_s,
                 100.0 * phase.processor_s / all.processor_s);
  };
  std::fprintf(stderr, "%-24s %8s %8s %7s\n", "phase", "s", "CPU s", "share");
  for (const Phase& phase : phases_) line(phase);
  line({"all", all.seconds, all.processor_s});
}

void RunRecord::write(const std::string& path) const
{
  const auto solving = std::find_if(phases_.begin(), phases_.end(),
                                    [](const Phase& phase) { return phase.name == solving_phase; });
  const Phase solved = solving == phases_.end() ? Phase{} : *solving;
  const nlohmann::ordered_json record = {{"begun", run::utc_text(started_)},
                                         {"seconds", elapsed().seconds},
                                         {"solving_seconds", solved.seconds},
                                         {"solving_processor_seconds", solved.processor_s},
                                         {"threads", n_threads_},
                                         {"steps_recalled", n_recalled_},
                                         {"host", run::host_name()},
                                         {"processors", core::usable_processors()}};
  write_atomically(path, {core::json_text(record, 2), "\n"});
}

namespace {

using IsStopped = std::function<bool()>;

// Audits the poses against the meshes: overlapping cells become unsolved, doubtful ones are marked.
store::MotionModel audited_model_of(const job::Case& job_case, const solve::SweepResult& result,
                                    int n_threads)
{
  store::MotionModel model = solve::motion_model_of(job_case, result);
  analysis::PoseAssessment verdicts =
      analysis::assess_poses(model, job_case.ligaments, solve::joint_bounds_of(job_case), n_threads);
  const auto overlaps = [](const analysis::PoseAssessment& of) { return (of.is_overlapping == 1).any(); };
  if (overlaps(verdicts) || std::ranges::any_of(verdicts.followers, overlaps)) {
    solve::SweepResult accepted = result;
    for (StepRecord& cell : accepted.cells) {
      if (verdicts.is_overlapping(cell.key.flexion, cell.key.varus) == 1)
        cell.status = StepStatus::overlapping;
    }
    for (std::size_t f = 0; f < model.followers.size(); ++f) {
      const std::size_t row = model::follower_row(static_cast<BodyIndex>(model.followers[f].body_index));
      for (std::size_t c = 0; c < accepted.followers.size(); ++c) {
        if (verdicts.followers[f].is_overlapping.data()[c] != 1) continue;
        // Those after it may depend on it.
        for (std::size_t k = row; k < accepted.followers[c].size(); ++k)
          accepted.followers[c][k].status = StepStatus::overlapping;
      }
    }
    model = solve::motion_model_of(job_case, accepted);
  }
  model.plausibility = std::move(verdicts.plausibility);
  for (std::size_t f = 0; f < model.followers.size(); ++f) {
    store::FollowerRows& rows = model.followers[f];
    rows.plausibility =
        (rows.status == status_stable)
            .select(verdicts.followers[f].plausibility,
                    store::GridB::Constant(rows.status.rows(), rows.status.cols(), plausibility_not_judged));
  }
  return model;
}

// Incomplete if stopped.
void add_smoothed(store::MotionModel& model, const job::Case& job_case, const std::string& output,
                  int n_threads, const IsStopped& is_stopped)
{
  if (job_case.smooth_degrees.empty()) return;
  const analysis::SmoothInput input = analysis::smooth_input(model, output);
  const int largest = analysis::largest_degree(
      input, *std::max_element(job_case.smooth_degrees.begin(), job_case.smooth_degrees.end()));
  for (const std::int32_t degree : job_case.smooth_degrees) {
    if (is_stopped()) return;
    if (degree > largest) {
      // Too few angles: job/case_warnings.cpp says so before the run.
      const bool is_said =
          !job_case.coordinates && static_cast<std::size_t>(degree) >= n_fitted_angles(job_case.grid);
      if (is_said) continue;
      core::log_warning("smooth.degrees: found " + std::to_string(degree) + ", wanted at most " +
                        std::to_string(std::max(largest, 0)) +
                        " on this grid with these solved cells; the degree is skipped");
      continue;
    }
    store::SmoothedSet set = analysis::smooth(input, degree, {job_case.smooth_robust});
    if (job_case.smooth_recontact) analysis::add_recontact(model, set, n_threads);
    model = store::with_smoothed(std::move(model), std::move(set));
  }
}

// With the highest degree of the job, or the default.
void add_two_sided(store::MotionModel& model, const job::Case& job_case, int n_threads)
{
  analysis::TwoSidedOptions options;
  options.is_robust = job_case.smooth_robust;
  if (!job_case.smooth_degrees.empty())
    options.degree = *std::max_element(job_case.smooth_degrees.begin(), job_case.smooth_degrees.end());
  model.two_sided = analysis::two_sided(model, options, n_threads);
}

// From the raw poses; omitted for joints or results without such a motion.
void add_zero_varus(store::MotionModel& model)
{
  if (!analysis::is_reducible(model)) return;
  store::ZeroVarus zero_varus = analysis::reduce(model, "raw");
  if (analysis::n_reduced_flexions(zero_varus) > 0) model.zero_varus = std::move(zero_varus);
}

/// An error is only a warning: the model is complete.
void write_record(const RunRecord& record, const std::string& output)
{
  try {
    record.write(run_record_of(output));
  } catch (const InputError& error) {
    core::log_warning(error.what());
  }
}

// Warns of stable poses whose plausibility is doubtful.
void warn_of_doubtful(const store::MotionModel& model, const std::string& output)
{
  const std::vector<DoubtfulCell> cells = doubtful_cells(model);
  if (cells.empty()) return;
  core::log_warning(output + ": /plausibility: " + plausibility_line(model) + " of " +
                    std::to_string((model.status == status_stable).count()) +
                    " stable attitudes, the first at flexion " + shortest_decimal(cells[0].flexion_deg) +
                    ", varus " + shortest_decimal(cells[0].varus_deg) +
                    " degrees; vrda info explains them, vrda info --json lists the attitudes");
}

/// The default motion, the rotation of a knee and its jumps.
void report_motion(const store::MotionModel& model)
{
  if (model.frames || !(model.status == status_stable).any()) return;
  core::log_info(default_motion_line(model));
  if (model.prior) core::log_info(model.prior->statement);
  if (const std::string rotation = screw_home_line(model); !rotation.empty()) core::log_info(rotation);
  for (const std::string& jump : jump_lines(model)) core::log_info(jump);
}

// Warns of attitudes so far past the first contact at a border that they count as unsolved.
void warn_of_past_border(const store::MotionModel& model, const std::string& output)
{
  std::string flexions;
  Eigen::Index n = 0;
  const store::GridB past = is_past_border(model);
  for (Eigen::Index i = 0; i < past.rows(); ++i) {
    if (!past.row(i).any()) continue;
    n += past.row(i).count();
    if (flexions.empty()) flexions = shortest_decimal(model.flexion_deg[static_cast<std::size_t>(i)]);
  }
  if (n == 0) return;
  core::log_warning(output + ": /plausibility: " + std::to_string(n) + " border_contact more than " +
                    shortest_decimal(border_margin_deg) +
                    " degrees past the first contact at a border, the first at flexion " + flexions +
                    " degrees: the surfaces end there, and these attitudes count as unsolved; use meshes "
                    "that reach further, or a smaller grid.flexion");
}

/// Too few stable samples for a band at a flexion.
bool lacks_bands(const store::MotionModel& model)
{
  constexpr std::int32_t fewest = 2;
  if (!model.uncertainty) return false;
  const auto lacks = [](const store::UncertainPose& of) {
    return std::ranges::any_of(of.n_solved, [](std::int32_t n_solved) { return n_solved < fewest; });
  };
  return lacks(*model.uncertainty) || std::ranges::any_of(model.uncertainty->followers, lacks);
}

/// Reports the statuses; warns if more attitudes are unsolved than the job allows, or a band is missing.
core::ExitCode outcome_of(const job::Case& job_case, const store::MotionModel& model,
                          const std::string& output)
{
  const double unsolved = unsolved_fraction(model);
  if (unsolved > job_case.unsolved_fraction && job_case.joint == "knee" && job_case.ligaments.fibres.empty())
    core::log_warning(output +
                      ": ligaments: found none, which is probably why attitudes are unsolved: contact alone "
                      "hardly holds a knee; give [ligaments], as vrda prepare writes them");
  core::log_info(status_line(model));
  warn_of_doubtful(model, output);
  warn_of_past_border(model, output);
  report_motion(model);
  const std::string cut_off = model.zero_varus ? analysis::cut_off_warning(*model.zero_varus) : "";
  if (!cut_off.empty()) core::log_warning(output + ": /zero_varus/is_cut_off: " + cut_off);
  if (model.uncertainty) core::log_info(run::samples_line(model));
  if (lacks_bands(model))
    core::log_warning(output +
                      ": /uncertainty: found flexions with fewer than 2 stable samples, wanted 2 for a band");
  if (unsolved <= job_case.unsolved_fraction)
    return lacks_bands(model) ? core::ExitCode::incomplete : core::ExitCode::done;
  core::log_warning(output + ": limits.unsolved_fraction: found " + std::to_string(unsolved) +
                    ", wanted at most " + std::to_string(job_case.unsolved_fraction));
  return core::ExitCode::incomplete;
}

}  // namespace

std::optional<store::MotionModel> build_result(const job::Case& job_case, const solve::SweepResult& result,
                                               const std::vector<StepRecord>& samples,
                                               const std::string& output, int n_threads,
                                               const IsStopped& is_stopped, RunRecord& record)
{
  check(result.is_complete, "result_of: the sweep is complete");
  store::MotionModel model = audited_model_of(job_case, result, n_threads);
  record.end_phase("plausibility");
  if (job_case.uncertainty) {
    model.uncertainty = solve::uncertain_motion_of(job_case, samples);
    record.end_phase("bands of samples");
  }
  // Frames are points in time, not surfaces over flexion.
  if (model.frames) return is_stopped() ? std::nullopt : std::optional(std::move(model));
  add_smoothed(model, job_case, output, n_threads, is_stopped);
  record.end_phase("smoothing, recontact");
  if (is_stopped()) return std::nullopt;
  add_two_sided(model, job_case, n_threads);
  if (is_stopped()) return std::nullopt;
  add_zero_varus(model);
  record.end_phase("two-sided, zero varus");
  if (is_stopped()) return std::nullopt;
  model = with_default_motion(std::move(model), job_case.smooth_robust, n_threads);
  record.end_phase("default motion");
  return is_stopped() ? std::nullopt : std::optional(std::move(model));
}

core::ExitCode write_result(const job::Case& job_case, const store::MotionModel& model,
                            const std::string& output, const std::vector<std::string>& needless,
                            RunRecord& record)
{
  store::write_motion_model(output, model);
  record.end_phase("writing");
  remove_obsolete_files(needless);
  write_record(record, output);  // last: the removed files free space on a full disk
  return outcome_of(job_case, model, output);
}

core::ExitCode finish_existing_result(const job::Case& job_case, const store::MotionModel& model,
                                      const std::string& output, const std::vector<std::string>& needless,
                                      int n_threads)
{
  remove_obsolete_files(needless);
  if (access(run_record_of(output).c_str(), F_OK) != 0)
    write_record(RunRecord(n_threads, static_cast<int>(model.status.size())), output);
  return outcome_of(job_case, model, output);
}

namespace {

analysis::ContactFigures two_sided_figures(const std::optional<store::TwoSided>& motion)
{
  analysis::ContactFigures figures;
  figures.sides.emplace();
  if (!motion) return figures;
  for (std::size_t i = 0; i < motion->contact.size(); ++i) {
    const auto contact = static_cast<store::TwoSidedContact>(motion->contact[i]);
    if (contact == store::TwoSidedContact::no_pose) continue;
    const double medial_mm = motion->gap_mm[0][i], lateral_mm = motion->gap_mm[1][i];
    figures.sides->include({medial_mm, lateral_mm});
    ++figures.n_poses;
    figures.n_lifted_off += contact == store::TwoSidedContact::both ? 0 : 1;
    for (const auto& [gap_mm, lifted] : {std::pair{medial_mm, store::TwoSidedContact::lateral},
                                         std::pair{lateral_mm, store::TwoSidedContact::medial}}) {
      if (contact != lifted) figures.largest_gap_mm = std::max(figures.largest_gap_mm, gap_mm);
      figures.largest_overlap_mm = std::max(figures.largest_overlap_mm, -gap_mm);
    }
  }
  return figures;
}

analysis::ContactFigures recontacted_figures(store::MotionModel model, store::SmoothedSet set,
                                             const analysis::Measuring& with)
{
  constexpr int refine = 2;
  if (!set.recontact_mm) set.recontact_mm = analysis::recontact(model, set, with);
  model.smoothed = {set};
  const std::string name = "degree_" + std::to_string(set.degree) + "_recontacted";
  const analysis::MotionAuditTotals totals =
      analysis::motion_audit_totals(model, analysis::audit(model, name, refine, with));
  analysis::ContactFigures figures;
  for (const analysis::AuditTotals& part : {totals.at_grid, totals.between}) {
    figures.n_poses += part.n_attitudes - part.n_nothing_ahead;
    figures.largest_gap_mm = std::fmax(figures.largest_gap_mm, part.largest_gap_mm);
    figures.largest_overlap_mm = std::fmax(figures.largest_overlap_mm, part.largest_penetration_mm);
  }
  return figures;
}

/// The model's set of that polynomial, with its travel into contact, or the set itself.
const store::SmoothedSet& stored_set(const store::MotionModel& model, const store::SmoothedSet& set)
{
  for (const store::SmoothedSet& stored : model.smoothed)
    if (stored.degree == set.degree && stored.is_robust == set.is_robust) return stored;
  return set;
}

analysis::CompareOptions criteria_of(const store::MotionModel& model, bool is_robust, int n_threads)
{
  std::set<int> degrees;
  for (const store::SmoothedSet& set : model.smoothed) degrees.insert(set.degree);
  if (model.two_sided) degrees.insert(model.two_sided->degree);
  analysis::CompareOptions options;
  options.name = model.title;
  options.degrees.assign(degrees.begin(), degrees.end());
  options.smooth.is_robust = is_robust;
  options.contact = [&model, measure = contact_measure(n_threads)](const store::MotionModel& bare,
                                                                   const store::SmoothedSet& set) {
    if (model.two_sided && model.two_sided->degree == set.degree) return two_sided_figures(model.two_sided);
    return measure(bare, stored_set(model, set));
  };
  return options;
}

}  // namespace

analysis::MeasureContact contact_measure(const analysis::Measuring& with)
{
  return [with](const store::MotionModel& model, const store::SmoothedSet& set) {
    if (!model.has_compartments) return recontacted_figures(model, set, with);
    return two_sided_figures(analysis::two_sided(model, {set.degree, set.is_robust}, with));
  };
}

store::DefaultMotion evaluated_default_motion(const store::MotionModel& model, bool is_robust, int n_threads)
{
  const std::string smoothed = store::set_names(model).front();
  if (smoothed == "raw") return {smoothed, ""};
  const int degree = model.two_sided ? model.two_sided->degree : model.smoothed.back().degree;
  const std::string name = model.two_sided ? smoothed + " (degree " + std::to_string(degree) + ")" : smoothed;
  if (analysis::largest_degree(analysis::smooth_input(model, model.title), degree) < degree)
    return {"raw", name + " cannot be compared: the grid has too few solved cells for that degree"};
  const analysis::Comparison comparison = analysis::compare(model, criteria_of(model, is_robust, n_threads));
  const auto ranked =
      std::ranges::find(comparison.recommendation.ranked, degree, &analysis::RankedDegree::degree);
  if (ranked->fault == analysis::Fault::none) return {smoothed, ""};
  return {"raw", name + " does not meet the criteria of vrda compare: " + ranked->fault_reason};
}

store::MotionModel with_default_motion(store::MotionModel model, bool is_robust, int n_threads)
{
  model.default_motion = evaluated_default_motion(model, is_robust, n_threads);
  if (model.prior) model.prior->statement = store::prior_statement(model, model.default_motion->set);
  return model;
}

std::string default_motion_line(const store::MotionModel& model)
{
  const store::DefaultMotion shown = store::default_motion(model);
  std::string line = "default motion: " + shown.set;
  if (!shown.reason.empty()) return line + ", the solved poses; " + shown.reason;
  if (shown.set != "raw" && !model.default_motion) line += " (not compared: the file has no /default_motion)";
  return line;
}

std::string screw_home_line(const store::MotionModel& model)
{
  if (model.joint != "knee") return "";
  return "screw-home along the spine: internal rotation " +
         store::text_of(store::curve_figures(store::spine_rotation(model)));
}

std::vector<std::string> jump_lines(const store::MotionModel& model)
{
  std::vector<std::string> lines;
  const std::string spine = store::text_of(store::spine_jump(model));
  if (!spine.empty() && !store::has_turned_axes(model)) lines.push_back(spine);
  const analysis::RawJump jump = analysis::raw_jump(model);
  const std::string line = analysis::jump_text(jump);
  const bool is_named = store::default_motion(model).reason.find(line) != std::string::npos;
  if (jump.size > analysis::largest_raw_jump && !is_named) lines.push_back(line);
  return lines;
}

}  // namespace vrda::run
