#include "trial.hpp"

#include <gtest/gtest.h>

#include "core/error.hpp"

namespace vrda::test {

BenchFile virtual_bench(HeadKind head, const std::string& changed, const std::string& into)
{
  std::string text = virtual_bench_text(head);
  if (!changed.empty()) {
    const std::size_t at = text.find(changed);
    check(at != std::string::npos, "the text to be replaced is in the file");
    text.replace(at, changed.size(), into);
  }
  return parsed_bench_file(text, "bench.toml");
}

GuideOptions options_of(const BenchFile& bench, const std::string& step)
{
  GuideOptions options;
  options.parts = parts_of_step(step, bench);
  options.date = "2026-11-22";
  options.path = "c.toml";
  return options;
}

const BenchFile& bench()
{
  static const BenchFile read = virtual_bench(HeadKind::stage);
  return read;
}

const Calibration& all_done()
{
  static const Calibration done = [] {
    Trial trial(bench());
    trial.do_all();
    return trial.session->calibration();
  }();
  return done;
}

GuideOptions anew(const std::string& step)
{
  GuideOptions options = options_of(bench(), step);
  options.is_anew = true;
  return options;
}

Trial::Trial(const BenchFile& wanted, const std::string& step)
    : Trial(wanted, nominal_calibration(wanted), options_of(wanted, step))
{
}

Trial::Trial(const BenchFile& wanted, const Calibration& begun, const GuideOptions& options)
    : bench(wanted),
      truth(virtual_truth(bench, 1)),
      somebody(bench, truth, VirtualNoise()),
      session(std::make_unique<GuideSession>(bench, begun, options))
{
}

void Trial::press(Key key, bool has_shift, bool has_control)
{
  session->take(KeyPress{key, has_shift, has_control});
}

void Trial::press(char key)
{
  press(key_of(key));
}

void Trial::do_task()
{
  somebody.do_task(*session);
}

void Trial::go_to(CalibrationPart part, const std::string& task)
{
  while (session->task() != nullptr && !is_asked(part, task)) do_task();
  check(is_asked(part, task), "there is such a task");
}

void Trial::do_part(CalibrationPart part)
{
  while (session->task() != nullptr && session->progress().part == part) do_task();
}

void Trial::do_all()
{
  while (session->task() != nullptr) do_task();
}

void Trial::do_badly()
{
  somebody.send_samples(*session);
  press(Key::enter);
  while (session->progress().is_taking) somebody.send_samples(*session);
}

std::string Trial::words() const
{
  std::string all;
  for (const std::string& line : session->progress().words) all += line + "\n";
  return all;
}

bool Trial::is_asked(CalibrationPart part, const std::string& task) const
{
  return session->task() != nullptr && session->progress().part == part && session->task()->name == task;
}

const CalibrationRecord& Trial::record(CalibrationPart part) const
{
  return session->calibration().records.at(part);
}

}  // namespace vrda::test
