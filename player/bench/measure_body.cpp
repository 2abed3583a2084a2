#include "bench/measure_body.hpp"

#include <algorithm>
#include <ostream>
#include <sstream>

#include "bench/bench_run.hpp"
#include "core/error.hpp"
#include "core/units.hpp"
#include "show/settings_text.hpp"
#include "bench/rigid_body.hpp"

namespace vrda::bench {
namespace {

bool has_marker(const bench::MarkerRow& row)
{
  return std::ranges::any_of(row, [](const auto& marker) { return marker.has_value(); });
}

}  // namespace

MarkerFrames::MarkerFrames(std::size_t first_tool, std::size_t n_markers)
    : first_tool_(first_tool), n_markers_(n_markers), has_come_(n_markers), row_(n_markers)
{
}

void MarkerFrames::end_row()
{
  if (has_marker(row_)) rows_.push_back(row_);
  std::fill(row_.begin(), row_.end(), std::nullopt);
  std::fill(has_come_.begin(), has_come_.end(), false);
}

void MarkerFrames::take(const bench::Sample& sample)
{
  const bool is_marker = sample.kind == bench::SampleKind::tool_pose && sample.source >= first_tool_ &&
                         sample.source < first_tool_ + n_markers_;
  if (!is_marker) return;
  const std::size_t k = sample.source - first_tool_;
  // A second sample of a marker starts the next message.
  if (has_come_[k]) end_row();
  has_come_[k] = true;
  if (sample.is(bench::ToolVisibility::seen)) row_[k] = Eigen::Vector3d::Map(sample.tool_pose.position_mm);
}

std::vector<bench::MarkerRow> MarkerFrames::frames(std::size_t most) const
{
  std::vector<bench::MarkerRow> all = rows_;
  if (has_marker(row_)) all.push_back(row_);
  if (all.size() <= most) return all;
  std::vector<bench::MarkerRow> some;
  for (std::size_t k = 0; k < most; ++k) some.push_back(all[k * all.size() / most]);
  return some;
}

FitQuality quality_of(const bench::PoseFit& fit)
{
  FitQuality quality;
  if (fit.status != bench::FitStatus::fitted) return quality;
  const bench::PoseError error = bench::expected_error(fit.cloud, bench::noise_mm(fit));
  quality.residual_mm = fit.residual_rms_mm;
  quality.n_markers = fit.cloud.n;
  quality.rotation_sd_rad = error.turn_rad.maxCoeff();
  quality.centroid_sd_mm = error.centre_mm;
  return quality;
}

std::string fit_text(const bench::PoseFit& fit)
{
  if (fit.status != bench::FitStatus::fitted) {
    std::string why = bench::name_of(fit.status);
    std::replace(why.begin(), why.end(), '_', ' ');
    return why;
  }
  const FitQuality quality = quality_of(fit);
  return "residual " + show::rounded_text(quality.residual_mm, 2) + " mm at " +
         std::to_string(quality.n_markers) + " markers, rotation sd " +
         show::rounded_text(deg_from_rad(quality.rotation_sd_rad), 2) + " deg";
}

namespace {

/// The mean of 500 frames has 1/20 of the noise of one, which is below the systematic error of a tracker.
constexpr std::size_t most_frames = 500;

std::string key_of(bench::BodyRole role)
{
  return std::string("body.") + bench::name_of(role);
}

const bench::BodySettings& settings_of(const bench::BenchFile& bench, bench::BodyRole role)
{
  return *bench.bodies[static_cast<std::size_t>(role)];
}

bench::BodyRole wanted_role(const bench::BenchFile& bench, const std::string& name)
{
  std::string known;
  for (std::size_t k = 0; k < bench::n_body_roles; ++k) {
    const auto role = static_cast<bench::BodyRole>(k);
    if (!bench.bodies[k] || bench.bodies[k]->markers.empty()) continue;
    if (name == bench::name_of(role)) return role;
    known += std::string(known.empty() ? "" : " or ") + bench::name_of(role);
  }
  throw InputError({bench.path, "body",
                    known.empty() ? "no body of markers" : "no body of markers '" + name + "'",
                    known.empty() ? "a body with the key markers" : known});
}

int n_seen_in(const std::vector<bench::MarkerRow>& frames, std::size_t marker)
{
  int n = 0;
  for (const bench::MarkerRow& frame : frames) n += frame[marker] ? 1 : 0;
  return n;
}

void require_seen(const std::vector<bench::MarkerRow>& frames, const bench::BenchFile& bench,
                  bench::BodyRole role)
{
  const std::vector<std::string>& names = settings_of(bench, role).markers;
  std::string unseen;
  for (std::size_t k = 0; k < names.size(); ++k) {
    if (n_seen_in(frames, k) == 0) unseen += (unseen.empty() ? "'" : ", '") + names[k] + "'";
  }
  if (unseen.empty()) return;
  throw InputError({bench.path, key_of(role) + ".markers",
                    unseen + " in none of " + std::to_string(frames.size()) + " frames",
                    "each marker visible together with three others"});
}

/// Rethrows an error of the body fit with the marker names of the file.
[[noreturn]] void refuse_named(const bench::FitError& refusal, const bench::BenchFile& bench,
                               bench::BodyRole role)
{
  const InputError::Facts& facts = refusal.facts();
  std::string what;
  for (const std::size_t marker : refusal.marks())
    what += (what.empty() ? "'" : "and '") + settings_of(bench, role).markers[marker] + "' ";
  if (what.empty() && facts.field != "markers") what = facts.field + ": ";
  throw InputError({bench.path, key_of(role) + ".markers", what + facts.found, facts.wanted});
}

std::string tracker_error_message(const bench::DeviceReport& report)
{
  if (report.link == bench::LinkState::up) return "the tracker answers";
  return "no tracker at " + report.peer + (report.error_message.empty() ? "" : ": " + report.error_message);
}

std::vector<bench::MarkerRow> received_frames(const bench::BenchFile& bench,
                                                 bench::BodyRole role, double seconds)
{
  show::StopSignals stop;
  bench::Devices devices(bench.tracker, std::nullopt);
  MarkerFrames received(bench::first_tool_index(bench, role), settings_of(bench, role).markers.size());
  receive_samples(devices, seconds, stop, [&](const bench::Sample& sample) { received.take(sample); });
  std::vector<bench::MarkerRow> frames = received.frames(most_frames);
  if (frames.empty()) {
    throw InputError({bench.path, key_of(role) + ".markers",
                      "none of them seen in " + show::rounded_text(seconds, 1) + " s (" +
                          tracker_error_message(devices.report(bench::DeviceId::tracker)) + ")",
                      "markers that the tracker reports with these names"});
  }
  return frames;
}

/// Fit of all markers with the noise of the frames.
bench::PoseFit typical_fit(const bench::BuiltBody& built)
{
  bench::PoseFit fit;
  fit.status = bench::FitStatus::fitted;
  fit.residual_rms_mm = built.residual_rms_mm;
  bench::MarkerRow all;
  for (Eigen::Index k = 0; k < built.body.markers_mm.rows(); ++k)
    all.emplace_back(built.body.markers_mm.row(k).transpose());
  fit.cloud = bench::cloud_of(built.body, all);
  return fit;
}

}  // namespace

bench::BuiltBody build_measured_body(const std::vector<bench::MarkerRow>& frames,
                                        const bench::BenchFile& bench, bench::BodyRole role)
{
  require_seen(frames, bench, role);
  bench::BodyOptions options;
  for (const Eigen::Vector3d& p : settings_of(bench, role).markers_body_mm) options.given_mm.emplace_back(p);
  try {
    return bench::build_body(frames, bench.path, options);
  } catch (const bench::FitError& refusal) {
    refuse_named(refusal, bench, role);
  }
}

std::string bench_file_lines(const bench::BuiltBody& built, const bench::BenchFile& bench,
                             bench::BodyRole role)
{
  const bench::BodySettings& settings = settings_of(bench, role);
  std::ostringstream text;
  text << "[" << key_of(role) << "]\nmarkers = [";
  for (std::size_t k = 0; k < settings.markers.size(); ++k)
    text << (k == 0 ? "" : ", ") << show::quoted_text(settings.markers[k]);
  text << "]\nmarkers_mm = [";
  for (Eigen::Index k = 0; k < built.body.markers_mm.size(); ++k)
    text << (k == 0 ? "" : ", ") << show::rounded_text(built.body.markers_mm(k / 3, k % 3), 3);
  const FitQuality quality = quality_of(typical_fit(built));
  text << "]\n# from " << built.n_frames << " frames, " << built.n_refused
       << " with fewer than three markers excluded; residual "
       << show::rounded_text(built.residual_rms_mm, 3)
       << " mm (root mean square)\n# expected pose error with all markers: rotation "
       << show::rounded_text(deg_from_rad(quality.rotation_sd_rad), 3) << " degrees, centroid "
       << show::rounded_text(quality.centroid_sd_mm, 3) << " mm (standard deviations)\n";
  for (std::size_t k = 0; k < settings.markers.size(); ++k)
    text << "# " << settings.markers[k] << ": " << show::rounded_text(built.markers[k].residual_rms_mm, 3)
         << " mm in " << built.markers[k].n_frames << " frames\n";
  if (!settings.markers_body_mm.empty())
    text << "# in the frame of the bench file's markers_mm, difference "
         << show::rounded_text(built.given_rms_mm, 3) << " mm (root mean square)\n";
  if (built.status != bench::BuildStatus::converged)
    text << "# not converged: too few frames with the same markers\n";
  return text.str();
}

void measure_body(const MeasureBodyOptions& options, const show::Streams& streams)
{
  const bench::BenchFile bench =
      bench::read_bench_file(options.bench, bench::MarkerPositions::optional);
  const bench::BodyRole role = wanted_role(bench, options.role);
  if (!options.is_quiet)
    streams.messages << "Rotate the body '" << bench::name_of(role)
                     << "' slowly in front of the tracker for " << show::rounded_text(options.seconds, 1)
                     << " s" << std::endl;
  const std::vector<bench::MarkerRow> frames = received_frames(bench, role, options.seconds);
  streams.data << bench_file_lines(build_measured_body(frames, bench, role), bench, role);
}

}  // namespace vrda::bench
