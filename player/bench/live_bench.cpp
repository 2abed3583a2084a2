#include "bench/live_bench.hpp"

#include <algorithm>
#include <array>
#include <vector>

#include "bench/bench_panel.hpp"
#include "core/units.hpp"
#include "show/settings_text.hpp"

namespace vrda::bench {
namespace {

/// Screens of phones show no more.
constexpr double most_rate_hz = 60.0;

// JSON and TOML have the same escapes in strings, and number_text() is valid in both for finite numbers.
using show::list_text, show::number_text, show::quoted_text;

std::string rows_text(const Pose& X)
{
  std::array<double, 12> rows{};
  for (std::size_t k = 0; k < rows.size(); ++k)
    rows[k] = X.matrix()(static_cast<Eigen::Index>(k / 4), static_cast<Eigen::Index>(k % 4));
  return list_text(rows);
}

void add_points(std::string& text, const std::vector<bench::CalibrationPoint>& points, const char* body)
{
  for (const bench::CalibrationPoint& point : points) {
    if (point.is_target) continue;
    if (text.back() != '[') text += ", ";
    text += "{\"name\": " + quoted_text(point.name) + ", \"body\": \"" + body +
            "\", \"point\": " + list_text(std::span(point.p_model_mm.data(), 3)) + "}";
  }
}

}  // namespace

struct LiveBench::State {
  explicit State(const BenchOptions& options)
      : setup(read_bench_setup(options)),
        bench(setup.bench, setup.calibration, setup.motion, setup.frame),
        devices(setup.bench.tracker, setup.bench.board)
  {
  }

  BenchSetup setup;
  BenchState bench;
  bench::Devices devices;
  std::uint64_t n_messages = 0;
};

LiveBench::LiveBench(const BenchOptions& options) : state_(std::make_unique<State>(options)) {}

LiveBench::~LiveBench() = default;

double LiveBench::interval_s() const
{
  return 1.0 / std::min(state_->setup.bench.display.refresh_hz, most_rate_hz);
}

std::string LiveBench::greeting() const
{
  const BenchSetup& setup = state_->setup;
  std::string text = "{\"kind\": \"bench\", \"version\": 1, \"title\": " + quoted_text(setup.bench.title) +
                     ", \"set\": " + quoted_text(setup.facts.set) +
                     ", \"scale\": " + number_text(setup.calibration.subject_scale) + ", \"points\": [";
  add_points(text, setup.bench.calibration.points, "reference");
  add_points(text, setup.bench.calibration.tibia_points, "moving");
  return text + "]}";
}

std::string LiveBench::next()
{
  for (bench::Sample sample; state_->devices.take(sample);) state_->bench.take(sample);
  std::string error_message;
  if (state_->setup.bench.tracker) {
    const bench::DeviceReport report = state_->devices.report(bench::DeviceId::tracker);
    if (report.link != bench::LinkState::up) error_message = device_text("tracker", report);
  }
  return live_message(state_->bench.frame(state_->devices.now_ns()), ++state_->n_messages, error_message);
}

std::string live_message(const BenchFrame& frame, std::uint64_t number, const std::string& error_message)
{
  std::string text = "{\"kind\": \"pose\", \"number\": " + std::to_string(number);
  text += ", \"flexion\": " + number_text(deg_from_rad(frame.pose.attitude.flexion_rad));
  text += ", \"varus\": " + number_text(deg_from_rad(frame.pose.attitude.varus_rad));
  text += ", \"placement\": " + rows_text(frame.X_tracker_reference) + ", \"marks\": [";
  const auto mark = [&text](const std::string& words) {
    if (!words.empty()) text += (text.back() == '[' ? "" : ", ") + quoted_text(words);
  };
  mark(error_message);
  // The display and its stage do not matter to a browser.
  for (const bench::BodyRole role :
       {bench::BodyRole::leg, bench::BodyRole::femur, bench::BodyRole::tibia})
    mark(input_status_text(bench::name_of(role), frame.bodies[static_cast<std::size_t>(role)]));
  mark(leg_check_text(frame.leg));
  mark(input_status_text("potentiometer", frame.potentiometer));
  return text + "]}";
}

}  // namespace vrda::bench
