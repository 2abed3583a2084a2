#include "player/calibration/trial.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "core/text.hpp"

namespace vrda::test {

bench::BenchFile virtual_bench(bench::HeadKind head, const std::string& changed, const std::string& into)
{
  std::string text = calibration::virtual_bench_text(head);
  if (!changed.empty()) {
    const std::size_t at = text.find(changed);
    check(at != std::string::npos, "the text to be replaced is in the file");
    text.replace(at, changed.size(), into);
  }
  return bench::parse_bench_file(text, "bench.toml");
}

calibration::CalibrationSessionOptions options_of(const bench::BenchFile& bench, const std::string& step)
{
  calibration::CalibrationSessionOptions options;
  options.parts = calibration::parts_of_step(step, bench);
  options.date = "2026-11-22";
  options.path = "c.toml";
  return options;
}

const bench::BenchFile& bench()
{
  static const bench::BenchFile read = virtual_bench(bench::HeadKind::stage);
  return read;
}

const bench::Calibration& all_done()
{
  static const bench::Calibration done = [] {
    Trial trial(bench());
    trial.do_all();
    return trial.session->calibration();
  }();
  return done;
}

calibration::CalibrationSessionOptions restarted(const std::string& step)
{
  calibration::CalibrationSessionOptions options = options_of(bench(), step);
  options.is_repeated = true;
  return options;
}

Trial::Trial(const bench::BenchFile& wanted, const std::string& step)
    : Trial(wanted, bench::nominal_calibration(wanted), options_of(wanted, step))
{
}

Trial::Trial(const bench::BenchFile& wanted, const bench::Calibration& begun,
             const calibration::CalibrationSessionOptions& options)
    : bench(wanted),
      truth(calibration::virtual_truth(bench, 1)),
      virtual_operator(bench, truth, calibration::VirtualNoise()),
      session(std::make_unique<calibration::CalibrationSession>(bench, begun, options))
{
}

void Trial::press(view::Key key, bool has_shift, bool has_control)
{
  session->take(view::KeyPress{key, has_shift, has_control});
}

void Trial::press(char key)
{
  press(view::key_of(key));
}

void Trial::do_task()
{
  virtual_operator.do_task(*session);
}

void Trial::go_to(bench::CalibrationPart part, const std::string& task)
{
  while (session->task() != nullptr && !is_requested(part, task)) do_task();
  check(is_requested(part, task), "there is such a task");
}

void Trial::do_part(bench::CalibrationPart part)
{
  while (session->task() != nullptr && session->progress().part == part) do_task();
}

void Trial::do_all()
{
  while (session->task() != nullptr) do_task();
}

void Trial::do_badly()
{
  virtual_operator.send_samples(*session);
  // Touched, or it would not be taken.
  for (const view::Key key : {view::Key::right, view::Key::left, view::Key::up, view::Key::down}) press(key);
  press(view::Key::enter);
  while (session->progress().is_sampling) virtual_operator.send_samples(*session);
}

void Trial::send_still(const std::string& tool, const Eigen::Vector3d& p_mm)
{
  const std::vector<std::string>& tools = bench.tracker->tools;
  bench::Sample sample;
  sample.kind = bench::SampleKind::tool_pose;
  sample.state = static_cast<std::uint8_t>(bench::ToolVisibility::seen);
  sample.source = static_cast<std::uint16_t>(std::ranges::find(tools, tool) - tools.begin());
  sample.tool_pose = bench::place_of(Pose(Eigen::Translation3d(p_mm)));
  session->take(sample);
}

void Trial::send_stage(double at_mm, std::uint8_t flags)
{
  bench::Sample sample;
  sample.kind = bench::SampleKind::stage;
  sample.state = flags;
  sample.count = static_cast<std::int32_t>(std::lround(at_mm / bench.stage_mm_per_count));
  session->take(sample);
}

void Trial::expect_refused(const std::string& with, bench::CalibrationPart part,
                           const std::string& task) const
{
  EXPECT_TRUE(session->progress().has_error);
  EXPECT_NE(words().find(with), std::string::npos) << words();
  EXPECT_TRUE(is_requested(part, task)) << words();
}

std::string Trial::words() const
{
  std::string all;
  for (const std::string& line : session->progress().messages) all += line + "\n";
  return all;
}

bool Trial::is_requested(bench::CalibrationPart part, const std::string& task) const
{
  return session->task() != nullptr && session->progress().part == part && session->task()->name == task;
}

const bench::CalibrationRecord& Trial::record(bench::CalibrationPart part) const
{
  return session->calibration().records.at(part);
}

}  // namespace vrda::test
