#include "app/fit_command.hpp"

#include <cmath>
#include <cstdio>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>

#include "analysis/offset_fit.hpp"
#include "app/score_command.hpp"
#include "core/document.hpp"
#include "core/text.hpp"
#include "job/job.hpp"
#include "model/frames.hpp"
#include "run/run_output.hpp"
#include "tables/imported_model.hpp"

namespace vrda::app {
namespace {

using FitJson = nlohmann::ordered_json;
using analysis::FitStatus;
using analysis::OffsetFit;
using analysis::OffsetFitInput;

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
    of_table.stated.angles = tables::angle_unit_named(o.angles);
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

FitJson number_json(double value)
{
  return std::isnan(value) ? FitJson() : FitJson(value);
}

void print(const Report& r, const FitCommandOptions& o)
{
  const OffsetFit& found = r.fit;
  if (o.as_json) {
    const FitJson json = {{"keys", r.keys},
                          {"status", analysis::name_of(found.status)},
                          {"offset_mm", number_json(found.offset_mm)},
                          {"standard_error_mm", number_json(found.standard_error_mm)},
                          {"gap_rms_mm", number_json(found.gap_rms_mm)},
                          {"bare_gap_rms_mm", number_json(found.bare_gap_rms_mm)},
                          {"other_gap_rms_mm", number_json(r.other_gap_rms_mm)},
                          {"travel_per_mm", number_json(found.travel_per_mm)},
                          {"training_frames", r.n_training},
                          {"frames_with_gap", found.n_frames}};
    std::printf("%s\n", core::json_text(json, 2).c_str());
    return;
  }
  for (const std::string& key : r.keys) std::printf("%s\n", key.c_str());
  if (found.status == FitStatus::undetermined) {
    std::printf("undetermined: %d of %zu training frames have a gap, and it hardly depends on the offset\n",
                found.n_frames, r.n_training);
    return;
  }
  std::printf("%s: %.4f mm, 95 %% within %.4f mm (remaining gaps of %d frames taken as independent)\n",
              analysis::name_of(found.status), found.offset_mm, interval_95 * found.standard_error_mm,
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

}  // namespace

void require_absent(const Publication& result, const FitCommandOptions& o,
                    const std::vector<std::string>& files)
{
  if (!o.may_replace)
    result.require_absent(
        files, {"", "--output", "a file that is not a result of this job", "another --output, or --replace"});
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

}  // namespace vrda::app
