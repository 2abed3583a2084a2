// Readings that must not become marks: not touched, implausible, of a tool that was not moved.
#include "calibration/marks.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <set>

#include "calibration/parts.hpp"
#include "player/calibration/trial.hpp"

namespace vrda::calibration::plausible_test {

using test::all_done;
using test::bench;
using test::restarted;
using test::Trial;
using testing::HasSubstr;

/// Presses Enter as a bored novice does; the marks of the current part stay as they are.
void expect_refused(Trial& trial, const std::string& words)
{
  const std::string task = trial.session->task()->name;
  SCOPED_TRACE(task);
  const CalibrationPart part = trial.session->progress().part;
  const auto n_marks = [&] {
    const auto& records = trial.session->calibration().records;
    return records.contains(part) ? records.at(part).marks.size() : 0;
  };
  const std::size_t before = n_marks();
  const std::vector<double> values(trial.session->values().begin(), trial.session->values().end());
  trial.press(view::Key::enter);
  EXPECT_TRUE(trial.session->progress().has_error);
  EXPECT_THAT(trial.words(), HasSubstr(words));
  EXPECT_FALSE(trial.session->progress().is_sampling);
  EXPECT_TRUE(trial.is_requested(part, task));
  EXPECT_EQ(n_marks(), before);
  EXPECT_THAT(values, testing::ElementsAreArray(trial.session->values()));
}

/// Every kind of task with dials, of every part.
TEST(Plausible, WhatWasNotTouchedIsRefused)
{
  std::set<std::string> kinds;
  const std::string head = "[calibration]\n";
  for (const BenchFile& file :
       {bench(),
        test::virtual_bench(HeadKind::stage, head, head + "distortion = \"adjust\"\nmodel = \"adjust\"\n")}) {
    Trial trial(file);
    while (trial.session->task() != nullptr) {
      const Task& task = *trial.session->task();
      const bool is_reading = !task.dials.empty() && !task.is_start_valid;
      if (is_reading && kinds.insert(test::kind_of(task)).second) {
        trial.virtual_operator.send_samples(*trial.session);
        if (task.kind->traits().uses_stage) trial.press('Z');
        trial.virtual_operator.send_samples(*trial.session);
        expect_refused(trial,
                       task.kind->traits().has_two_lines ? "lines were not touched" : "was not touched");
      }
      trial.do_task();
      ASSERT_FALSE(trial.session->progress().has_error) << trial.words();
    }
  }
  EXPECT_EQ(kinds, (std::set<std::string>{"scan line", "screen size", "node", "grid", "rectangle",
                                          "head number", "landmarks", "bull's-eye", "placed model"}));
}

TEST(Plausible, BothLinesOfARectangleAreTouched)
{
  Trial trial(bench(), all_done(), restarted("eyepoints"));
  trial.press(view::Key::right, true);
  expect_refused(trial, "the other line was not touched");
}

/// A set that agrees with itself and not with the start must be measured again, and then accepted.
TEST(Plausible, AnUnexpectedSetIsMeasuredAgain)
{
  constexpr double share = 0.6;  // of a child
  Trial trial(bench(), "subject");
  const int n_tasks = trial.session->progress().n_tasks;
  for (const bool is_again : {false, true}) {
    for (int n = 0; n < n_tasks; ++n) {
      const Dial dial = trial.session->task()->dials[0];
      for (long k = std::lround((1.0 - share) * dial.value / dial.step); k > 0; --k)
        trial.press(view::Key::left);
      trial.press(view::Key::enter);
    }
    EXPECT_EQ(trial.session->progress().has_error, !is_again) << trial.words();
    EXPECT_EQ(trial.words().find("must be measured again") != std::string::npos, !is_again);
    EXPECT_EQ(trial.record(CalibrationPart::subject).marks.empty(), !is_again);
  }
  EXPECT_NEAR(trial.session->calibration().subject_scale, share, 0.01);
}

/// A number that is confirmed although implausible makes its part unexpected.
TEST(Plausible, AnImplausibleNumberIsConfirmedAndItsPartMeasuredAgain)
{
  constexpr double pupils_mm = 42.0;
  Trial trial(bench(), all_done(), restarted("ipd"));
  for (const bool is_again : {false, true}) {
    ASSERT_TRUE(trial.is_requested(CalibrationPart::ipd, "pupillary distance"));
    const Dial dial = trial.session->task()->dials[0];
    for (long k = std::lround((dial.value - pupils_mm) / dial.step); k > 0; --k) trial.press(view::Key::left);
    expect_refused(trial, "is implausible");
    trial.press(view::Key::enter);
    while (trial.session->task() != nullptr && !trial.session->progress().has_error &&
           !trial.is_requested(CalibrationPart::ipd, "pupillary distance"))
      trial.do_task();
    EXPECT_EQ(trial.words().find("must be measured again") != std::string::npos, !is_again) << trial.words();
  }
  EXPECT_TRUE(is_done(trial.session->calibration(), CalibrationPart::ipd));
}

TEST(Plausible, ALineInTheMiddleOfTheWindowIsImplausible)
{
  Trial trial(bench());
  for (int k = 0; k < 12; ++k) trial.press(view::Key::right, true);
  expect_refused(trial, "is implausible");
  trial.press(view::Key::enter);
  EXPECT_FALSE(trial.session->progress().has_error);
  EXPECT_EQ(trial.record(CalibrationPart::viewport).marks.size(), 1u);
}

/// The probe still touches the first point, the marker is still at the first place.
TEST(Plausible, AToolThatWasNotMovedIsRefused)
{
  for (const auto& [step, n_first] : {std::pair{"leg", 1}, std::pair{"bullseye", 2}}) {
    SCOPED_TRACE(step);
    Trial trial(bench(), all_done(), restarted(step));
    BenchPoses poses;
    for (int k = 0; k < n_first; ++k) {
      poses = trial.virtual_operator.poses(*trial.session, 0.0);
      trial.do_task();
    }
    trial.press(view::Key::right, true);
    trial.press(view::Key::enter);
    const std::string task = trial.session->task()->name;
    for (std::uint64_t frame = 0; trial.session->progress().is_sampling; ++frame)
      for (const bench::Sample& sample : trial.virtual_operator.samples(*trial.session, poses, frame))
        trial.session->take(sample);
    EXPECT_TRUE(trial.session->progress().has_error);
    EXPECT_THAT(trial.words(), HasSubstr("is where it was for"));
    EXPECT_EQ(trial.session->task()->name, task);
    trial.do_all();
  }
}

}  // namespace vrda::calibration::plausible_test
