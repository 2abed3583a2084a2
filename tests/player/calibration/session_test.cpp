#include "calibration/session.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "calibration/eyepoint_fit.hpp"
#include "calibration/parts.hpp"
#include "player/calibration/trial.hpp"

namespace vrda::calibration::session_test {

using test::all_done;
using test::bench;
using test::restarted;
using test::Trial;
using testing::HasSubstr;

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

TEST(CalibrationSession, RAsksForTheWholePartAgainAndEscapeLeaves)
{
  Trial trial(bench());
  for (int k = 0; k < 5; ++k) trial.do_task();
  trial.press('R');
  EXPECT_TRUE(trial.is_requested(CalibrationPart::viewport, "left eye, left edge, 1"));
  EXPECT_TRUE(trial.record(CalibrationPart::viewport).marks.empty());
  EXPECT_FALSE(trial.session->has_quit());
  trial.press(view::Key::escape);
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

}  // namespace vrda::calibration::session_test
