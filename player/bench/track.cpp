#include "bench/track.hpp"

#include <chrono>
#include <ostream>

#include "bench/bench_file.hpp"
#include "core/error.hpp"
#include "core/publication.hpp"
#include "core/units.hpp"
#include "bench/message.hpp"
#include "show/settings_text.hpp"
#include "bench/camera_fit.hpp"
#include "bench/picture_source.hpp"
#include "bench/pose_finder.hpp"

namespace vrda::bench {
namespace {

bench::BenchFile read_bench(const std::string& path)
{
  bench::BenchFile bench = bench::read_bench_file(path, bench::MarkerPositions::optional);
  if (!bench.camera) throw InputError({path, "tracker", "a server", "tracker = \"aruco\""});
  return bench;
}

PictureSource open_source(const bench::CameraSettings& camera)
{
  PictureSourceOptions options;
  options.device = camera.device;
  options.width = camera.width;
  options.height = camera.height;
  options.rate_hz = camera.rate_hz;
  return PictureSource(options);
}

std::string text_of(const bench::IgtlMessage& message)
{
  const std::vector<std::uint8_t> bytes = bench::bytes_of(message);
  return {bytes.begin(), bytes.end()};
}

bench::IgtlMessage tdata_of(const std::vector<FoundBody>& bodies, const std::vector<std::string>& tools,
                           std::int64_t taken_ns)
{
  bench::IgtlMessage message;
  message.kind = bench::IgtlKind::tdata;
  // States that the listed bodies are visible: those of a still film do not jitter.
  message.header_version = 2;
  message.device = "webcam";
  message.device_ns = taken_ns;
  for (std::size_t k = 0; k < bodies.size(); ++k) {
    const bool is_misfit = bodies[k].state == BodyState::misfit;
    if (bodies[k].state != BodyState::seen && !is_misfit) continue;
    message.tools.push_back({tools[k],
                             is_misfit ? bench::ToolVisibility::invalid_pose : bench::ToolVisibility::seen,
                             bodies[k].X_camera_body});
  }
  return message;
}

}  // namespace

void track(const std::string& bench_path, const ByteSink& sink)
{
  const bench::BenchFile bench = read_bench(bench_path);
  const Camera camera = read_camera(bench.camera->calibration);
  const std::vector<std::string>& tools = bench.tracker->tools;
  PoseFinderOptions options;
  options.n_bodies = tools.size();
  options.sheet = {bench.camera->marker_mm, bench.camera->fold_rad};
  PoseFinder finder(camera, options);
  PictureSource source = open_source(*bench.camera);
  for (bool goes_on = true; goes_on;) {
    const TimedPicture taken = source.next();
    if (taken.is_frozen) continue;
    const double time_s = static_cast<double>(taken.taken_ns) * s_per_ns;
    goes_on = sink(text_of(tdata_of(finder.find(taken.picture, time_s), tools, taken.taken_ns)));
  }
}

std::string error_message(const std::string& text)
{
  bench::IgtlMessage message;
  message.kind = bench::IgtlKind::status;
  message.device = "webcam";
  constexpr int igtl_unknown_error = 2;
  message.code = igtl_unknown_error;
  message.text = text;
  return text_of(message);
}

void write_sheets(const std::string& bench_path, const std::string& pdf)
{
  const bench::BenchFile bench = read_bench(bench_path);
  Publication::begin(pdf, "vrda-webcam")->publish(sheets_pdf(bench.tracker->tools));
}

void calibrate(const CalibrateOptions& options, std::ostream& messages)
{
  const bench::BenchFile bench = read_bench(options.bench);
  const std::string output = options.output.empty() ? bench.camera->calibration : options.output;
  PictureSource source = open_source(*bench.camera);
  CameraFit fit({options.n_views});
  std::string last;
  const auto end = std::chrono::steady_clock::now() + std::chrono::duration<double>(options.seconds);
  while (!fit.is_complete() && std::chrono::steady_clock::now() < end) {
    const std::string said = fit.take(source.next().picture);
    if (said != last) messages << said << std::endl;
    last = said;
  }
  const Camera camera = fit.camera(output);
  Publication::begin(output, "vrda-webcam")->publish(camera_text(camera));
  messages << output << ": focal length " << show::rounded_text(camera.focal_px.x(), 1) << " px, error "
           << show::rounded_text(camera.rms_px, 2) << " px in " << camera.n_views << " views\n";
}

}  // namespace vrda::bench
