#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <functional>

#include "player/calibration/trial.hpp"
#include "support/refusal.hpp"

namespace vrda::calibration::session_test {

using test::all_done, test::bench, test::restarted, test::Trial, testing::HasSubstr;

TEST(CalibrationSession, TheWheelTurnsTheDials)
{
  Trial trial(bench());
  const double before = trial.session->values()[0];
  trial.session->take(press_of_wheel(true, false, false));
  EXPECT_GT(trial.session->values()[0], before);
  trial.session->take(press_of_wheel(false, false, false));
  EXPECT_EQ(trial.session->values()[0], before);
  EXPECT_EQ(press_of_wheel(true, true, false).key, view::Key::up);
  EXPECT_EQ(press_of_wheel(false, true, true).key, view::Key::down);
}

TEST(CalibrationSession, OverallProgressCountsPartsAndTasks)
{
  CalibrationProgress progress;
  EXPECT_EQ(overall_progress(progress), 0.0);
  progress.n_parts = 4;
  progress.number = 3;
  progress.n_tasks = 10;
  progress.n_done = 5;
  EXPECT_DOUBLE_EQ(overall_progress(progress), 0.625);
}

TEST(CalibrationSession, EveryMarkMakesARevisionAndBackspaceAsksAgain)
{
  Trial trial(bench());
  const std::uint64_t before = trial.session->revision();
  trial.do_task();
  EXPECT_GT(trial.session->revision(), before);
  EXPECT_TRUE(trial.is_requested(CalibrationPart::viewport, "left eye, right edge, 1"));
  trial.press(view::Key::backspace);
  EXPECT_TRUE(trial.is_requested(CalibrationPart::viewport, "left eye, left edge, 1"));
  EXPECT_TRUE(trial.record(CalibrationPart::viewport).marks.empty());
  // The first task has no previous one.
  trial.press(view::Key::backspace);
  EXPECT_TRUE(trial.is_requested(CalibrationPart::viewport, "left eye, left edge, 1"));
}

TEST(CalibrationSession, RAsksForTheWholePartAgainAndQLeaves)
{
  Trial trial(bench());
  for (int k = 0; k < 5; ++k) trial.do_task();
  trial.press('R');
  EXPECT_TRUE(trial.is_requested(CalibrationPart::viewport, "left eye, left edge, 1"));
  EXPECT_TRUE(trial.record(CalibrationPart::viewport).marks.empty());
  EXPECT_FALSE(trial.session->has_quit());
  trial.press(view::Key::escape);
  EXPECT_FALSE(trial.session->has_quit());
  trial.press('Q');
  EXPECT_TRUE(trial.session->has_quit());
}

TEST(CalibrationSession, CrossedEdgesAreRefusedAtOnce)
{
  Trial trial(bench());
  trial.do_task();
  // The right edge left of the left one.
  for (int k = 0; k < 20; ++k) trial.press(view::Key::left, false, true);
  trial.press(view::Key::enter);
  trial.expect_refused("crossed edges of the left eye", CalibrationPart::viewport, "left eye, left edge, 1");
  trial.do_all();
  EXPECT_TRUE(is_done(trial.session->calibration(), CalibrationPart::viewport));
}

/// A task confirmed without alignment: the fit names it, and only this task is repeated.
TEST(CalibrationSession, OnlyAnOutlyingMarkIsRequestedAgain)
{
  struct Row {
    CalibrationPart part;
    std::string task;
  };
  for (const Row& row : {Row{CalibrationPart::viewport, "right eye, top edge, 3"},
                         Row{CalibrationPart::distortion, "left eye, node 2, -1"},
                         Row{CalibrationPart::distortion, "right eye, node 3, 2"},
                         Row{CalibrationPart::eyepoints, "left eye, rectangle 2, 3"},
                         Row{CalibrationPart::eyepoints, "right eye, rectangle 1, 2"},
                         Row{CalibrationPart::bullseye, "right eye, place 4"}}) {
    SCOPED_TRACE(row.task);
    Trial trial(bench(), all_done(), restarted(bench::name_of(row.part)));
    trial.go_to(row.part, row.task);
    trial.do_badly();
    while (trial.session->task() != nullptr && !trial.session->progress().has_error) trial.do_task();
    ASSERT_TRUE(trial.is_requested(row.part, row.task)) << trial.words();
    trial.do_task();
    trial.do_all();
    EXPECT_TRUE(is_done(trial.session->calibration(), row.part));
    EXPECT_EQ(trial.record(row.part).marks.size(), all_done().records.at(row.part).marks.size());
  }
}

/// The result of the first eye is reported before the second one, so that rectangles can still be moved.
TEST(CalibrationSession, AnEyeThatIsDoneSaysHowWellItIsKnown)
{
  Trial trial(bench(), all_done(), restarted("eyepoints"));
  EXPECT_THAT(trial.words(), HasSubstr("+-"));
  trial.go_to(CalibrationPart::eyepoints, "right eye, rectangle 1, 1");
  EXPECT_FALSE(trial.session->progress().has_error);
  EXPECT_THAT(trial.words(), testing::AllOf(testing::StartsWith("left eye: "), HasSubstr("95 %: +-")));
  trial.do_task();
  EXPECT_TRUE(trial.words().empty());
}

TEST(CalibrationSession, OnlyAnOutlyingPointIsRequestedAgain)
{
  Trial trial(bench(), all_done(), restarted("leg"));
  const std::string name = bench().calibration.points[5].name;
  trial.go_to(CalibrationPart::leg, name);
  VirtualNoise wild;
  wild.touch_mm = 20.0;
  VirtualOperator clumsy(trial.bench, trial.truth, wild);
  clumsy.do_task(*trial.session);
  while (trial.session->task() != nullptr && !trial.session->progress().has_error) trial.do_task();
  trial.expect_refused(name, CalibrationPart::leg, name);
  trial.do_all();
  EXPECT_TRUE(is_done(trial.session->calibration(), CalibrationPart::leg));
}

TEST(CalibrationSession, AProbeThatIsNotRotatedIsRefused)
{
  Trial trial(bench(), "probe");
  trial.press(view::Key::enter);
  while (trial.session->progress().is_sampling) trial.send_still("probe", {10, 20, -2000});
  trial.expect_refused("deg", CalibrationPart::probe, "sweep");
}

/// Before the marker is moved to the other rail.
TEST(CalibrationSession, AnInvalidFirstRailIsRefusedAtOnce)
{
  Trial trial(bench(), "rails");
  trial.send_stage(0.0, 0);
  trial.press(view::Key::enter);
  for (int k = 0; trial.session->progress().is_sampling; ++k) {
    trial.send_stage(-k, 0);
    trial.send_still("marker", {1.0 * k, 0, -2000});
  }
  trial.expect_refused("-1 mm per mm", CalibrationPart::rails, "x rail");
  EXPECT_TRUE(trial.record(CalibrationPart::rails).marks.empty());
}

TEST(CalibrationSession, RailsThatAreParallelAreRefusedAndTheOtherOneIsSweptAgain)
{
  Trial trial(bench(), "rails");
  trial.do_task();
  trial.press(view::Key::enter);
  for (int k = 0; trial.session->progress().is_sampling; ++k) {
    const CalibrationMark& x_rail = trial.record(CalibrationPart::rails).marks[0];
    const std::vector<double>& row = x_rail.rows[static_cast<std::size_t>(k)];
    trial.send_still("marker", {row[0], row[1], row[2]});
  }
  trial.expect_refused("angle", CalibrationPart::rails, "z rail");
  trial.do_all();
  EXPECT_TRUE(is_done(trial.session->calibration(), CalibrationPart::rails));
}

TEST(CalibrationSession, WhatMovedWhileItHadToRestIsRefusedAndTheDialsStay)
{
  Trial trial(bench(), all_done(), restarted("bullseye"));
  trial.virtual_operator.send_samples(*trial.session);
  trial.press('Z');
  trial.press(view::Key::right, true);
  const double x = trial.session->values()[0];
  trial.press(view::Key::enter);
  for (int k = 0; trial.session->progress().is_sampling; ++k) trial.send_still("marker", {1.0 * k, 0, -2000});
  trial.expect_refused("hold it still", CalibrationPart::bullseye, "left eye, place 1");
  EXPECT_EQ(trial.session->values()[0], x);
}

TEST(CalibrationSession, ABullseyeWantsAStageThatIsThereZeroedAndAtRest)
{
  Trial trial(bench(), all_done(), restarted("bullseye"));
  trial.press(view::Key::enter);
  EXPECT_TRUE(trial.session->progress().has_error);
  EXPECT_THAT(trial.words(), HasSubstr("No message from the stage"));
  trial.send_stage(3.0, 0);
  trial.press(view::Key::enter);
  EXPECT_THAT(trial.words(), HasSubstr("not zeroed"));
  trial.press(view::Key::right);
  trial.send_stage(3.0, bench::stage_zeroed);
  trial.press(view::Key::enter);
  ASSERT_TRUE(trial.session->progress().is_sampling);
  trial.send_stage(3.2, bench::stage_zeroed);
  while (trial.session->progress().is_sampling) trial.send_still("marker", {0, 0, -2000});
  EXPECT_THAT(trial.words(), HasSubstr("The stage moved"));
  trial.do_all();
  EXPECT_TRUE(is_done(trial.session->calibration(), CalibrationPart::bullseye));
}

/// A restart of the board between two positions does not remove marks.
TEST(CalibrationSession, AStageThatLostItsZeroIsZeroedByKeyAndEveryMarkIsKept)
{
  Trial trial(bench(), all_done(), restarted("bullseye"));
  trial.go_to(CalibrationPart::bullseye, "right eye, place 2");
  const std::size_t n_marks = trial.record(CalibrationPart::bullseye).marks.size();
  ASSERT_EQ(n_marks, 3u);
  const CalibrationRecord stop = trial.record(CalibrationPart::stop);
  trial.send_stage(37.25, 0);
  trial.press(view::Key::enter);
  EXPECT_TRUE(trial.session->progress().has_error);
  EXPECT_THAT(trial.words(), HasSubstr("press Z"));
  EXPECT_FALSE(trial.session->take_zero_request());
  trial.press('Z');
  EXPECT_TRUE(trial.session->take_zero_request());
  EXPECT_FALSE(trial.session->take_zero_request());
  EXPECT_FALSE(trial.session->progress().has_error);
  EXPECT_THAT(trial.words(), HasSubstr(" 37.25 mm"));
  EXPECT_TRUE(trial.is_requested(CalibrationPart::bullseye, "right eye, place 2"));
  EXPECT_EQ(trial.record(CalibrationPart::bullseye).marks.size(), n_marks);
  EXPECT_EQ(trial.record(CalibrationPart::stop).marks.at(0).rows, stop.marks.at(0).rows);
  EXPECT_FALSE(trial.record(CalibrationPart::bullseye).is_outdated);
  trial.press(view::Key::right);
  trial.press(view::Key::enter);
  EXPECT_TRUE(trial.session->progress().is_sampling);
}

TEST(CalibrationSession, TheStopAsksOnceForAStageAtZero)
{
  Trial trial(bench(), "stop");
  EXPECT_FALSE(trial.session->take_zero_request());
  trial.send_stage(12.5, 0);
  trial.press(view::Key::enter);
  EXPECT_TRUE(trial.session->take_zero_request());
  EXPECT_FALSE(trial.session->take_zero_request());
  EXPECT_EQ(trial.record(CalibrationPart::stop).marks.at(0).rows, (std::vector<std::vector<double>>{{12.5}}));
  EXPECT_TRUE(is_done(trial.session->calibration(), CalibrationPart::stop));
}

TEST(CalibrationSession, ASubjectOfAnotherShapeAsksForANewRun)
{
  Trial trial(bench(), "subject");
  // One distance is 50 % too long.
  for (int k = 0; k < 10; ++k) trial.press(view::Key::right, false, true);
  trial.press(view::Key::enter);
  while (trial.session->task() != nullptr && !trial.session->progress().has_error) trial.do_task();
  EXPECT_TRUE(trial.session->progress().has_error);
  EXPECT_THAT(trial.words(), HasSubstr("schemas/scaling.md"));
  EXPECT_EQ(trial.session->calibration().subject_scale, 1.0);
  EXPECT_EQ(trial.session->progress().n_done, 0);
  trial.do_all();
  EXPECT_NEAR(trial.session->calibration().subject_scale, trial.truth.calibration.subject_scale, 0.05);
}

TEST(TimeLeft, FallsWithEveryTask)
{
  Trial trial(bench());
  const double before_s = trial.session->progress().typical_left_s;
  EXPECT_GT(before_s, 20.0 * 60.0) << "a new bench takes about half an hour";
  EXPECT_LT(before_s, 60.0 * 60.0);
  const double first_s = trial.session->task()->kind->traits().typical_s;
  trial.do_task();
  EXPECT_DOUBLE_EQ(trial.session->progress().typical_left_s, before_s - first_s);
}

TEST(TimeLeft, FollowsTheOperatorsPace)
{
  EXPECT_DOUBLE_EQ(time_left_s({}, 600.0), 600.0);
  EXPECT_NEAR(time_left_s({1e6, 2e6}, 600.0), 1200.0, 1.0);
  EXPECT_GT(time_left_s({600.0, 300.0}, 600.0), 300.0) << "a short observation counts less";
}

// Readings that must not become marks: not touched, implausible, of a tool that was not moved.

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

// Valid steps, their order, and records that do not match the bench file.

TEST(CalibrationPlan, APartDoneAgainOutdatesWhatRestsOnItWithItsFirstMark)
{
  Trial trial(bench(), all_done(), restarted("distortion"));
  Calibration outdated = all_done();
  outdated.records.at(CalibrationPart::distortion).is_outdated = true;
  EXPECT_TRUE(bench::calibration_text(trial.session->calibration(), bench()) ==
              bench::calibration_text(outdated, bench()));
  trial.do_task();
  const Calibration& now = trial.session->calibration();
  for (const CalibrationPart part :
       {CalibrationPart::eyepoints, CalibrationPart::ipd, CalibrationPart::bullseye})
    EXPECT_TRUE(now.records.at(part).is_outdated) << bench::name_of(part);
  for (const CalibrationPart part : {CalibrationPart::viewport, CalibrationPart::rails, CalibrationPart::stop,
                                     CalibrationPart::probe, CalibrationPart::subject, CalibrationPart::leg})
    EXPECT_FALSE(now.records.at(part).is_outdated) << bench::name_of(part);
  EXPECT_EQ(now.records.at(CalibrationPart::distortion).marks.size(), 1u);
  EXPECT_FALSE(is_done(now, CalibrationPart::distortion));
  trial.do_all();
  // The step "all" repeats only outdated parts.
  Trial rest(bench(), trial.session->calibration(), test::options_of(bench()));
  EXPECT_EQ(rest.session->progress().part, CalibrationPart::eyepoints);
  std::set<CalibrationPart> requested;
  while (rest.session->task() != nullptr) {
    requested.insert(rest.session->progress().part);
    rest.do_task();
  }
  EXPECT_EQ(requested, (std::set<CalibrationPart>{CalibrationPart::eyepoints, CalibrationPart::ipd,
                                                  CalibrationPart::bullseye}));
}

/// After an interruption of --anew the command without --anew resumes: finished parts are not repeated and
/// unfinished parts keep their marks.
TEST(CalibrationPlan, AnInterruptedRepetitionIsResumedWithoutItsOption)
{
  CalibrationSessionOptions both = restarted("subject");
  both.parts = {CalibrationPart::stop, CalibrationPart::probe, CalibrationPart::subject};
  CalibrationSessionOptions plain = both;
  plain.is_repeated = false;
  Trial trial(bench(), all_done(), both);
  EXPECT_GT(trial.session->revision(), 0u);  // also for an interruption before the first task
  int n_tasks = 0;
  for (; trial.session->task() != nullptr; ++n_tasks) {
    trial.do_task();
    const std::string file = bench::calibration_text(trial.session->calibration(), bench());
    trial.session = std::make_unique<CalibrationSession>(
        bench(), bench::parse_calibration(file, "c.toml", bench()), plain);
  }
  EXPECT_EQ(n_tasks, 2 + static_cast<int>(bench().calibration.landmarks.size()));
  for (const CalibrationPart part : both.parts)
    EXPECT_TRUE(is_done(trial.session->calibration(), part)) << bench::name_of(part);
}

TEST(CalibrationPlan, APartBeforeOneThatItRestsOnIsRefused)
{
  const auto field_of = [](const Calibration& begun, const std::string& step) {
    return test::input_error([&] { CalibrationSession(bench(), begun, test::options_of(bench(), step)); });
  };
  const Calibration nominal = bench::nominal_calibration(bench());
  EXPECT_THAT(field_of(nominal, "distortion"), test::refuses({.field = "distortion", .found = "viewport"}));
  EXPECT_THAT(field_of(nominal, "ipd"), test::refuses({.field = "ipd", .found = "eyepoints"}));
  EXPECT_THAT(field_of(nominal, "leg"), test::refuses({.field = "leg", .found = "probe"}));
  Calibration old = all_done();
  old.records.at(CalibrationPart::rails).is_outdated = true;
  old.records.at(CalibrationPart::bullseye).is_outdated = true;
  EXPECT_THAT(field_of(old, "bullseye"),
              test::refuses({.field = "bullseye", .found = {"rails", "outdated"}}));
  CalibrationSession(bench(), nominal, test::options_of(bench(), "viewport"));
}

TEST(CalibrationPlan, ARecordOfAnotherPlanIsRefusedUnlessThePartIsRepeated)
{
  const BenchFile other =
      test::virtual_bench(HeadKind::stage, "[calibration]\n", "[calibration]\nedge_repeats = 3\n");
  Calibration begun = bench::nominal_calibration(bench());
  begun.records[CalibrationPart::viewport] = all_done().records.at(CalibrationPart::viewport);
  begun.records[CalibrationPart::viewport].estimate.reset();
  EXPECT_THAT(
      test::input_error([&] { CalibrationSession(other, begun, test::options_of(other, "viewport")); }),
      test::refuses({.field = "per_bench.viewport", .found = "'left eye, left edge, 4'"}));
  CalibrationSessionOptions options = test::options_of(other, "viewport");
  options.is_repeated = true;
  EXPECT_NE(CalibrationSession(other, begun, options).task(), nullptr);
  Calibration damaged = all_done();
  damaged.records.at(CalibrationPart::rails).estimate.reset();
  damaged.records.at(CalibrationPart::rails).marks[0].rows[3].pop_back();
  damaged.records.at(CalibrationPart::rails).marks[0].rows[3].pop_back();
  EXPECT_THAT(
      test::input_error([&] { CalibrationSession(bench(), damaged, test::options_of(bench(), "rails")); }),
      test::refuses({.field = "per_bench.rails", .found = "'x rail'"}));
}

/// Five bull's-eyes are done, then the bench file changes.
TEST(CalibrationPlan, ChangedValuesOfTheBenchFileAreReportedBeforeTheFirstTask)
{
  Trial trial(bench(), all_done(), restarted("bullseye"));
  trial.go_to(CalibrationPart::bullseye, "right eye, place 3");
  const Calibration begun = trial.session->calibration();
  ASSERT_EQ(begun.records.at(CalibrationPart::bullseye).marks.size(), 5u);
  BenchFile deeper = bench(), touched = bench(), geared = bench();
  deeper.calibration.rectangles[1].depth_mm += 25.0;
  touched.calibration.points[2].p_model_mm.y() += 1.0;
  touched.calibration.landmarks[0].model_mm += 1.0;
  geared.stage_mm_per_count *= 2.0;
  const auto refused = [&](const BenchFile& file, const Calibration& so_far, const std::string& step) {
    return test::input_error(
        [&] { calibration::CalibrationSession(file, so_far, test::options_of(file, step)); });
  };
  for (const char* step : {"bullseye", "ipd", "eyepoints", "all"}) {
    EXPECT_THAT(refused(deeper, begun, step),
                test::refuses({.field = "per_person.eyepoints",
                               .found = {"calibration.rectangles", "150.0", "175.0"},
                               .wanted = "--anew"}))
        << step;
  }
  EXPECT_EQ(refused(touched, all_done(), "leg").field, "per_person.leg");
  EXPECT_EQ(refused(touched, all_done(), "subject").field, "per_person.subject");
  EXPECT_EQ(refused(geared, begun, "bullseye").field, "per_person.bullseye");
  // Independent parts can continue.
  EXPECT_NE(calibration::CalibrationSession(touched, begun, test::options_of(touched, "bullseye")).task(),
            nullptr);
  // A value that was wrong during the measurement and is correct now; the stage samples contain its scale.
  Calibration mistyped = all_done();
  mistyped.records.at(CalibrationPart::eyepoints).made_with[3] += 25.0;
  EXPECT_THAT(refused(bench(), mistyped, "bullseye"),
              test::refuses({.field = "per_person.eyepoints", .wanted = "calibrate solve"}));
  EXPECT_EQ(bench::calibration_text(solve_again(bench(), mistyped, "c.toml"), bench()),
            bench::calibration_text(all_done(), bench()));
  EXPECT_EQ(test::input_error([&] { solve_again(geared, all_done(), "c.toml"); }).field,
            "per_person.bullseye");
  // Without `made_with` the fit of the rectangles is checked before the bull's-eyes.
  Calibration silent = begun;
  silent.records.at(CalibrationPart::eyepoints).made_with.clear();
  for (CalibrationRectangle& r : deeper.calibration.rectangles) r.depth_mm = 0.0;
  EXPECT_THAT(refused(deeper, silent, "bullseye"),
              test::refuses({.field = "per_person.eyepoints: left", .wanted = "bullseye"}));
}

TEST(CalibrationPlan, DataMissingFromTheBenchFileAreReportedByKey)
{
  const BenchFile bare = [] {
    BenchFile file = bench();
    file.calibration.points.resize(3);
    file.calibration.landmarks.resize(2);
    return file;
  }();
  const auto wanted = [&](const BenchFile& file, const std::string& step) {
    return test::input_error([&] { CalibrationSession(file, all_done(), test::options_of(file, step)); });
  };
  EXPECT_EQ(wanted(bare, "leg").field, "calibration.point");
  EXPECT_EQ(wanted(bare, "subject").field, "calibration.landmarks");
  BenchFile none = bench();
  none.calibration = CalibrationSettings();
  EXPECT_EQ(wanted(none, "viewport").field, "calibration");
}

}  // namespace vrda::calibration::session_test
