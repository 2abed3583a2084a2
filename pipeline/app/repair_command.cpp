// `vrda repair`: the nearest motion without overlap and separation.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>

#include "analysis/repair.hpp"
#include "app/commands.hpp"
#include "app/printing.hpp"
#include "core/document.hpp"
#include "core/fields_json.hpp"
#include "core/files.hpp"
#include "core/text.hpp"
#include "core/units.hpp"
#include "job/job.hpp"
#include "run/run_output.hpp"
#include "store/motion_model.hpp"

namespace vrda::app {
namespace {

using Json = nlohmann::ordered_json;

struct RepairCommandOptions {
  std::string file, output;
  /// Standard deviations: one number, or three for the canonical axes X, Y and Z. Empty: not stated.
  std::vector<double> noise_mm, noise_deg;
  std::string smooth = "auto";  ///< "auto", "none" or a period in frames
  std::string gap_mm = "auto";  ///< "auto", "none" or a length
  bool may_replace = false;
  int n_threads = 0;  ///< 0: one per processor
  bool as_json = false;
};

constexpr const char* coordinate_names[] = {"rotation_x",    "rotation_y",    "rotation_z",
                                            "translation_x", "translation_y", "translation_z"};

Eigen::Vector3d deviations(const RepairCommandOptions& o, const char* option,
                           const std::vector<double>& values)
{
  if (values.size() == 1) return Eigen::Vector3d::Constant(values.front());
  if (values.size() == 3) return {values[0], values[1], values[2]};
  throw InputError({o.file, option, values.empty() ? "nothing" : std::to_string(values.size()) + " numbers",
                    "the standard deviation of the measurement: one number, or three for X,Y,Z"});
}

double length_of(const std::string& word)
{
  return job::parse_real(word).value_or(nan);  // checked by the command line; NaN is refused
}

analysis::RepairOptions repair_options(const RepairCommandOptions& o)
{
  analysis::RepairOptions options;
  options.noise.translation_mm = deviations(o, "--noise-mm", o.noise_mm);
  options.noise.rotation_rad = deviations(o, "--noise-deg", o.noise_deg) * rad_from_deg(1.0);
  if (o.smooth == "none") {
    options.smoothing = analysis::Smoothing::none;
  } else if (o.smooth != "auto") {
    options.smoothing = analysis::Smoothing::of_period;
    options.period_frames = length_of(o.smooth);
  }
  if (o.gap_mm == "none") {
    options.gap_limit = analysis::GapLimit::none;
  } else if (o.gap_mm != "auto") {
    options.gap_limit = analysis::GapLimit::of_length;
    options.gap_limit_mm = length_of(o.gap_mm);
  }
  options.n_threads = run::thread_count_or_all(o.n_threads);
  return options;
}

/// Largest over the frames.
struct Extremes {
  double penetration_mm = 0.0, gap_mm = 0.0;
  int n_overlapping = 0;

  void include(const analysis::PoseAudit& audit)
  {
    n_overlapping += audit.is_overlapping ? 1 : 0;
    penetration_mm = std::max(penetration_mm, audit.penetration_mm);
    if (std::isfinite(audit.gap_mm)) gap_mm = std::max(gap_mm, audit.gap_mm);
  }
};

struct RepairFigures {
  Extremes before, after;
  int n_of_status[4] = {};
  double rms_distance = 0.0, largest_distance = 0.0;
  double expected_distance = 0.0;  ///< root mean square of noise alone
};

RepairFigures figures_of(const analysis::RepairedMotion& motion, const analysis::MeasurementNoise& noise)
{
  RepairFigures figures;
  for (const analysis::RepairedFrame& frame : motion.frames) {
    figures.before.include(frame.before.audit);
    figures.after.include(frame.after.audit);
    ++figures.n_of_status[static_cast<int>(frame.status)];
    figures.rms_distance += frame.displacement.squaredNorm() / static_cast<double>(motion.frames.size());
    figures.largest_distance = std::max(figures.largest_distance, frame.displacement.norm());
  }
  figures.rms_distance = std::sqrt(figures.rms_distance);
  const auto n_noisy =
      (noise.rotation_rad.array() > 0.0).count() + (noise.translation_mm.array() > 0.0).count();
  figures.expected_distance = std::sqrt(static_cast<double>(n_noisy));
  return figures;
}

constexpr store::RepairStatus all_statuses[] = {store::RepairStatus::unchanged, store::RepairStatus::repaired,
                                                store::RepairStatus::not_converged,
                                                store::RepairStatus::nothing_ahead};

std::string counts_text(const RepairFigures& figures)
{
  std::vector<std::string> words;
  for (const store::RepairStatus status : all_statuses) {
    const int n = figures.n_of_status[static_cast<int>(status)];
    if (n > 0) words.push_back(std::to_string(n) + ' ' + analysis::name_of(status));
  }
  return joined(words);
}

std::string limits_text(const std::vector<double>& limits_mm)
{
  std::vector<std::string> words;
  for (const double mm : limits_mm) words.push_back(std::isinf(mm) ? "none" : formatted("%.3g", mm));
  return joined(words, " and ") + (words.size() == 2 ? " (medial and lateral)" : "");
}

Json json_of(const Extremes& e)
{
  return {{"overlapping", e.n_overlapping},
          {"largest_penetration_mm", e.penetration_mm},
          {"largest_gap_mm", e.gap_mm}};
}

Json json_of(const analysis::RepairedMotion& motion, const analysis::MeasuredMotion& measured,
             const RepairFigures& figures)
{
  Json statuses = Json::object(), periods = Json::object(), frames = Json::array();
  for (const store::RepairStatus status : all_statuses)
    statuses[analysis::name_of(status)] = figures.n_of_status[static_cast<int>(status)];
  for (Eigen::Index c = 0; c < 6; ++c) periods[coordinate_names[c]] = motion.period_frames(c);
  for (std::size_t k = 0; k < motion.frames.size(); ++k) {
    const analysis::RepairedFrame& frame = motion.frames[k];
    frames.push_back({{"key", measured.key[k]},
                      {"status", analysis::name_of(frame.status)},
                      {"distance", frame.displacement.norm()},
                      {"penetration_before_mm", frame.before.audit.penetration_mm},
                      {"penetration_after_mm", frame.after.audit.penetration_mm},
                      {"gap_before_mm", json_value(frame.before.audit.gap_mm)},
                      {"gap_after_mm", json_value(frame.after.audit.gap_mm)}});
  }
  return {{"converged", motion.is_converged},
          {"iterations", motion.n_iterations},
          {"statuses", statuses},
          {"before", json_of(figures.before)},
          {"after", json_of(figures.after)},
          {"gap_limit_mm", json_value(motion.gap_limit_mm)},
          {"rms_distance", figures.rms_distance},
          {"largest_distance", figures.largest_distance},
          {"distance_of_noise", figures.expected_distance},
          {"period_frames", periods},
          {"frames", frames}};
}

void print(const analysis::RepairedMotion& motion, const RepairFigures& figures, const Json& json)
{
  std::printf("%zu frames: %s; %d iterations%s\n", motion.frames.size(), counts_text(figures).c_str(),
              motion.n_iterations, motion.is_converged ? "" : ", limit reached");
  print_filled(
      "mm          overlapping     largest overlap    largest gap\n"
      "measured   {before.overlapping%12d} {before.largest_penetration_mm%19.3g} "
      "{before.largest_gap_mm%14.3g}\n"
      "repaired   {after.overlapping%12d} {after.largest_penetration_mm%19.3g} "
      "{after.largest_gap_mm%14.3g}\n",
      json);
  std::printf("gap limit along Delta, mm: %s\n", limits_text(motion.gap_limit_mm).c_str());
  print_filled(
      "distance from the measurement in standard deviations: RMS {rms_distance%.3g}, largest "
      "{largest_distance%.3g}; noise alone: {distance_of_noise%.3g}\n"
      "period of half amplitude, frames: rotations {period_frames.rotation_x%.3g}, "
      "{period_frames.rotation_y%.3g}, {period_frames.rotation_z%.3g}; "
      "translations {period_frames.translation_x%.3g}, {period_frames.translation_y%.3g}, "
      "{period_frames.translation_z%.3g}\n",
      json);
}

// Writes the repaired model, with the measured poses next to the repaired ones, and prints gap, overlap and
// distance before and after. Exit code 3, with the model written, if a frame is not_converged.
core::ExitCode repair_command(const RepairCommandOptions& o)
{
  const analysis::RepairOptions options = repair_options(o);
  const store::MotionModel model = store::read_motion_model(o.file);
  const analysis::MeasuredMotion measured = analysis::measured_motion(model, o.file);
  run::make_parent_folder(o.output);
  const std::optional<Publication> result = run::begin_result(o.output, "vrda repair");
  if (!result) return core::ExitCode::interrupted;
  run::require_replaceable(o.output, "a motion model");
  if (!o.may_replace)
    result->require_absent({o.output}, {"", "", "an existing file", "another --output, or --replace"});
  const analysis::RepairedMotion motion = analysis::repair(analysis::scene_of(model), measured, options);
  store::write_motion_model(o.output, analysis::repaired_model(model, measured, motion, options.noise));
  if (model.ligaments)
    core::log_info(o.output + ": without the fibres of " + o.file + ", which belong to the measured poses");
  const RepairFigures figures = figures_of(motion, options.noise);
  const Json json = json_of(motion, measured, figures);
  if (o.as_json) {
    print_json(json);
  } else {
    print(motion, figures, json);
  }
  const int n_failed = figures.n_of_status[static_cast<int>(store::RepairStatus::not_converged)];
  if (n_failed > 0)
    core::log_warning(o.output + ": " + std::to_string(n_failed) +
                      " frames still overlap or have a gap beyond the limit; increase the stated noise "
                      "or the gap limit");
  if (!motion.is_converged)
    core::log_warning(o.output + ": not converged after " + std::to_string(motion.n_iterations) +
                      " iterations; a nearer motion may exist");
  return n_failed == 0 && motion.is_converged ? core::ExitCode::done : core::ExitCode::incomplete;
}

}  // namespace

void declare_repair(Command& c)
{
  auto& o = c.options<RepairCommandOptions>();
  constexpr double largest = 1e6;
  c.model(o.file, "Motion model (HDF5), a sequence of frames");
  c.option("-o,--output", o.output, "Motion model to write").required();
  c.option("--noise-mm", o.noise_mm,
           "Standard deviation of the measured position of the rotation centre: one number, or X,Y,Z; 0: "
           "exact")
      .separated_by_commas()
      .in_one_word()
      .number(0.0, largest);
  c.option("--noise-deg", o.noise_deg,
           "Standard deviation of the measured rotation: one number, or about X,Y,Z; 0: exact")
      .separated_by_commas()
      .in_one_word()
      .number(0.0, largest);
  c.option("--smooth", o.smooth,
           "Period in frames whose amplitude smoothing halves; auto: from the noise; none")
      .number(2.0, largest, {"auto", "none"})
      .shows_default();
  c.option("--gap-mm", o.gap_mm,
           "Largest gap along Delta, of each compartment if there are any; auto: median of the measured "
           "gaps plus twice their spread without noise; none")
      .number(0.0, largest, {"auto", "none"})
      .shows_default();
  c.flag("--replace", o.may_replace, "Replace an existing output");
  c.threads(o.n_threads);
  c.json(o.as_json);
  c.runs([&o] { return repair_command(o); });
}

}  // namespace vrda::app
