#include "trial.hpp"

#include <gtest/gtest.h>

#include "core/error.hpp"

namespace vrda::test {

bench_files::BenchFile virtual_bench(bench_files::HeadKind head, const std::string& changed,
                                     const std::string& into)
{
  std::string text = virtual_bench::virtual_bench_text(head);
  if (!changed.empty()) {
    const std::size_t at = text.find(changed);
    check(at != std::string::npos, "the text to be replaced is in the file");
    text.replace(at, changed.size(), into);
  }
  return bench_files::parse_bench_file(text, "bench.toml");
}

calibration_tasks::CalibrationSessionOptions options_of(const bench_files::BenchFile& bench,
                                                        const std::string& step)
{
  calibration_tasks::CalibrationSessionOptions options;
  options.parts = calibration_tasks::parts_of_step(step, bench);
  options.date = "2026-11-22";
  options.path = "c.toml";
  return options;
}

const bench_files::BenchFile& bench()
{
  static const bench_files::BenchFile read = virtual_bench(bench_files::HeadKind::stage);
  return read;
}

const bench_files::Calibration& all_done()
{
  static const bench_files::Calibration done = [] {
    Trial trial(bench());
    trial.do_all();
    return trial.session->calibration();
  }();
  return done;
}

calibration_tasks::CalibrationSessionOptions restarted(const std::string& step)
{
  calibration_tasks::CalibrationSessionOptions options = options_of(bench(), step);
  options.is_repeated = true;
  return options;
}

Trial::Trial(const bench_files::BenchFile& wanted, const std::string& step)
    : Trial(wanted, bench_files::nominal_calibration(wanted), options_of(wanted, step))
{
}

Trial::Trial(const bench_files::BenchFile& wanted, const bench_files::Calibration& begun,
             const calibration_tasks::CalibrationSessionOptions& options)
    : bench(wanted),
      truth(virtual_bench::virtual_truth(bench, 1)),
      virtual_operator(bench, truth, virtual_bench::VirtualNoise()),
      session(std::make_unique<calibration_tasks::CalibrationSession>(bench, begun, options))
{
}

void Trial::press(navigation::Key key, bool has_shift, bool has_control)
{
  session->take(navigation::KeyPress{key, has_shift, has_control});
}

void Trial::press(char key)
{
  press(navigation::key_of(key));
}

void Trial::do_task()
{
  virtual_operator.do_task(*session);
}

void Trial::go_to(bench_files::CalibrationPart part, const std::string& task)
{
  while (session->task() != nullptr && !is_requested(part, task)) do_task();
  check(is_requested(part, task), "there is such a task");
}

void Trial::do_part(bench_files::CalibrationPart part)
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
  for (const navigation::Key key :
       {navigation::Key::right, navigation::Key::left, navigation::Key::up, navigation::Key::down})
    press(key);
  press(navigation::Key::enter);
  while (session->progress().is_sampling) virtual_operator.send_samples(*session);
}

std::string Trial::words() const
{
  std::string all;
  for (const std::string& line : session->progress().messages) all += line + "\n";
  return all;
}

bool Trial::is_requested(bench_files::CalibrationPart part, const std::string& task) const
{
  return session->task() != nullptr && session->progress().part == part && session->task()->name == task;
}

const bench_files::CalibrationRecord& Trial::record(bench_files::CalibrationPart part) const
{
  return session->calibration().records.at(part);
}

}  // namespace vrda::test
