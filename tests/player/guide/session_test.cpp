#include "guide/session.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <functional>

#include "calibration/eyepoint_fit.hpp"
#include "guide/parts.hpp"
#include "guide/solve_part.hpp"
#include "support/input_error.hpp"
#include "trial.hpp"

namespace vrda {
namespace {

using test::Trial;
using testing::HasSubstr;

const BenchFile& bench()
{
  static const BenchFile read = test::virtual_bench(HeadKind::stage);
  return read;
}

/// All parts done, once for all tests.
const Calibration& all_done()
{
  static const Calibration done = [] {
    Trial trial(bench());
    trial.do_all();
    return trial.session->calibration();
  }();
  return done;
}

/// `part` alone, as whoever does it again.
GuideOptions anew(const std::string& part)
{
  GuideOptions options = test::options_of(bench(), part);
  options.is_anew = true;
  return options;
}

TEST(GuideSession, BeginsWithTheFirstTaskAndCountsThem)
{
  const Trial trial(bench());
  EXPECT_TRUE(trial.is_asked(CalibrationPart::viewport, "left eye, left edge, 1"));
  const GuideProgress& progress = trial.session->progress();
  EXPECT_EQ(progress.n_done, 0);
  EXPECT_EQ(progress.n_tasks, 2 * (4 * 4 + 2));
  EXPECT_FALSE(progress.is_taking);
  EXPECT_FALSE(progress.is_refused);
}

TEST(GuideSession, EveryMarkMakesARevisionAndBackspaceAsksAgain)
{
  Trial trial(bench());
  const std::uint64_t before = trial.session->revision();
  trial.do_task();
  EXPECT_GT(trial.session->revision(), before);
  EXPECT_TRUE(trial.is_asked(CalibrationPart::viewport, "left eye, right edge, 1"));
  trial.press(Key::backspace);
  EXPECT_TRUE(trial.is_asked(CalibrationPart::viewport, "left eye, left edge, 1"));
  EXPECT_TRUE(trial.record(CalibrationPart::viewport).marks.empty());
  // At the first task there is nothing before.
  trial.press(Key::backspace);
  EXPECT_TRUE(trial.is_asked(CalibrationPart::viewport, "left eye, left edge, 1"));
}

TEST(GuideSession, RAsksForTheWholePartAgainAndEscapeLeaves)
{
  Trial trial(bench());
  for (int k = 0; k < 5; ++k) trial.do_task();
  trial.press('R');
  EXPECT_TRUE(trial.is_asked(CalibrationPart::viewport, "left eye, left edge, 1"));
  EXPECT_TRUE(trial.record(CalibrationPart::viewport).marks.empty());
  EXPECT_FALSE(trial.session->is_left());
  trial.press(Key::escape);
  EXPECT_TRUE(trial.session->is_left());
}

TEST(GuideSession, CrossedEdgesAreRefusedAtOnce)
{
  Trial trial(bench());
  trial.do_task();
  // The right edge left of the left one.
  for (int k = 0; k < 20; ++k) trial.press(Key::left, false, true);
  trial.press(Key::enter);
  EXPECT_TRUE(trial.session->progress().is_refused);
  EXPECT_THAT(trial.words(), HasSubstr("crossed edges of the left eye"));
  EXPECT_TRUE(trial.is_asked(CalibrationPart::viewport, "left eye, left edge, 1"));
  trial.do_all();
  EXPECT_TRUE(is_done(trial.session->calibration(), CalibrationPart::viewport));
}

/// A task that is confirmed without being aligned: the fit names it, and it alone is asked again.
TEST(GuideSession, AMarkFarOffIsAskedForAgainAlone)
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
    Trial trial(bench(), all_done(), anew(name_of(row.part)));
    trial.go_to(row.part, row.task);
    trial.do_badly();
    while (trial.session->task() != nullptr && !trial.session->progress().is_refused) trial.do_task();
    ASSERT_TRUE(trial.is_asked(row.part, row.task)) << trial.words();
    trial.do_task();
    trial.do_all();
    EXPECT_TRUE(is_done(trial.session->calibration(), row.part));
    EXPECT_EQ(trial.record(row.part).marks.size(), all_done().records.at(row.part).marks.size());
  }
}

/// Both eyes' result is known with the part; of the first one, while there is time to place rectangles better.
TEST(GuideSession, AnEyeThatIsDoneSaysHowWellItIsKnown)
{
  Trial trial(bench(), all_done(), anew("eyepoints"));
  EXPECT_THAT(trial.words(), HasSubstr("half a pixel of noise an eye's distance will be known to about +-"));
  trial.go_to(CalibrationPart::eyepoints, "right eye, rectangle 1, 1");
  EXPECT_FALSE(trial.session->progress().is_refused);
  const std::vector<std::string>& remarks =
      all_done().records.at(CalibrationPart::eyepoints).estimate->remarks;
  ASSERT_EQ(remarks.size(), 2u);
  EXPECT_THAT(remarks[0], testing::StartsWith("left eye: "));
  EXPECT_EQ(trial.session->progress().words.size(), 1u);
  EXPECT_THAT(trial.words(), testing::MatchesRegex(
                                 "left eye: [0-9.]+ mm before the first rectangle's plane, 95 %: "
                                 ".-[0-9.]+ mm; a side's noise [0-9.]+ px\n"));
  trial.do_task();
  EXPECT_TRUE(trial.words().empty());
}

/// Of a reading that is too large what is drawn lies in front, as the true distance is the smaller one.
TEST(GuideSession, TheWordsOfAWrongPupillaryDistanceHaveItsSign)
{
  const std::optional<Estimate>& ipd = all_done().records.at(CalibrationPart::ipd).estimate;
  const double read_mm = ipd->values[0], depth_mm = all_done().image_distance_mm;
  EXPECT_GT(depth_error_mm(depth_mm, read_mm, read_mm + 1.0), 0.0);
  EXPECT_LT(depth_error_mm(depth_mm, read_mm + 1.0, read_mm), 0.0);
  EXPECT_NEAR(depth_error_mm(800.0, 65.0, 64.0), -12.3, 0.05);
  EXPECT_THAT(ipd->remarks.back(), HasSubstr("if the eyes are 1 mm further apart than that, what lies at "));
  EXPECT_THAT(ipd->remarks.back(), testing::EndsWith(" mm behind its place"));
}

TEST(GuideSession, APointTouchedBesideIsAskedForAgainAlone)
{
  Trial trial(bench(), all_done(), anew("leg"));
  const std::string name = bench().calibration.points[5].name;
  trial.go_to(CalibrationPart::leg, name);
  VirtualNoise wild;
  wild.touch_mm = 20.0;
  VirtualOperator clumsy(trial.bench, trial.truth, wild);
  clumsy.do_task(*trial.session);
  while (trial.session->task() != nullptr && !trial.session->progress().is_refused) trial.do_task();
  ASSERT_TRUE(trial.is_asked(CalibrationPart::leg, name)) << trial.words();
  EXPECT_THAT(trial.words(), HasSubstr(name));
  trial.do_all();
  EXPECT_TRUE(is_done(trial.session->calibration(), CalibrationPart::leg));
}

/// Samples of a tool at one place, as if nobody moved it.
void send_still(GuideSession& session, const BenchFile& file, const std::string& tool, const Pose& X)
{
  const std::vector<std::string>& tools = file.tracker->tools;
  Sample sample;
  sample.kind = SampleKind::place;
  sample.state = static_cast<std::uint8_t>(SeenState::seen);
  sample.source = static_cast<std::uint16_t>(std::find(tools.begin(), tools.end(), tool) - tools.begin());
  sample.place = place_of(X);
  session.take(sample);
}

Sample stage_sample(double at_mm, const BenchFile& file, std::uint8_t flags)
{
  Sample sample;
  sample.kind = SampleKind::stage;
  sample.state = flags;
  sample.count = static_cast<std::int32_t>(std::lround(at_mm / file.stage_mm_per_count));
  return sample;
}

TEST(GuideSession, AProbeThatNobodyTurnsIsRefused)
{
  Trial trial(bench(), "probe");
  trial.press(Key::enter);
  while (trial.session->progress().is_taking)
    send_still(*trial.session, trial.bench, "probe", Pose(Eigen::Translation3d(10, 20, -2000)));
  EXPECT_TRUE(trial.session->progress().is_refused);
  EXPECT_THAT(trial.words(), HasSubstr("deg"));
  EXPECT_TRUE(trial.is_asked(CalibrationPart::probe, "sweep"));
  EXPECT_FALSE(is_done(trial.session->calibration(), CalibrationPart::probe));
}

/// Before anybody fastens the marker to the other rail.
TEST(GuideSession, AFirstRailThatIsNoneIsRefusedAtOnce)
{
  struct Row {
    std::string name, words;
    double way_mm, bend_mm, stage_mm;  ///< of the whole sweep
  };
  for (const Row& row : {Row{"short", "a sweep of 30", 30, 0, 30}, Row{"bent", "off any line", 300, 40, 300},
                         Row{"the other way", "an encoder that counts", 300, 0, -300},
                         Row{"another gear", "mm a mm of the encoder", 300, 0, 200}}) {
    SCOPED_TRACE(row.name);
    Trial trial(bench(), "rails");
    trial.session->take(stage_sample(0.0, trial.bench, 0));
    trial.press(Key::enter);
    const double n = trial.session->task()->n_samples - 1.0;
    for (int k = 0; trial.session->progress().is_taking; ++k) {
      const double s = k / n;
      trial.session->take(stage_sample(row.stage_mm * s, trial.bench, 0));
      send_still(*trial.session, trial.bench, "marker",
                 Pose(Eigen::Translation3d(row.way_mm * s, row.bend_mm * s * s, -2000)));
    }
    EXPECT_TRUE(trial.session->progress().is_refused);
    EXPECT_THAT(trial.words(), HasSubstr(row.words));
    EXPECT_TRUE(trial.is_asked(CalibrationPart::rails, "x rail"));
    EXPECT_TRUE(trial.record(CalibrationPart::rails).marks.empty());
  }
}

TEST(GuideSession, RailsThatAreParallelAreRefusedAndTheOtherOneIsSweptAgain)
{
  Trial trial(bench(), "rails");
  trial.do_task();
  trial.press(Key::enter);
  for (int k = 0; trial.session->progress().is_taking; ++k) {
    const CalibrationMark& x_rail = trial.record(CalibrationPart::rails).marks[0];
    const std::vector<double>& row = x_rail.rows[static_cast<std::size_t>(k)];
    send_still(*trial.session, trial.bench, "marker", Pose(Eigen::Translation3d(row[0], row[1], row[2])));
  }
  EXPECT_TRUE(trial.session->progress().is_refused);
  EXPECT_THAT(trial.words(), HasSubstr("apart"));
  EXPECT_TRUE(trial.is_asked(CalibrationPart::rails, "z rail"));
  trial.do_all();
  EXPECT_TRUE(is_done(trial.session->calibration(), CalibrationPart::rails));
}

TEST(GuideSession, WhatMovedWhileItHadToRestIsRefusedAndTheDialsStay)
{
  Trial trial(bench(), all_done(), anew("bullseye"));
  trial.somebody.send_samples(*trial.session);
  trial.press('Z');
  trial.press(Key::right, true);
  const double x = trial.session->values()[0];
  trial.press(Key::enter);
  for (int k = 0; trial.session->progress().is_taking; ++k)
    send_still(*trial.session, trial.bench, "marker", Pose(Eigen::Translation3d(k, 0, -2000)));
  EXPECT_TRUE(trial.session->progress().is_refused);
  EXPECT_THAT(trial.words(), HasSubstr("hold it still"));
  EXPECT_TRUE(trial.is_asked(CalibrationPart::bullseye, "left eye, place 1"));
  EXPECT_EQ(trial.session->values()[0], x);
}

TEST(GuideSession, ABullseyeWantsAStageThatIsThereZeroedAndAtRest)
{
  Trial trial(bench(), all_done(), anew("bullseye"));
  trial.press(Key::enter);
  EXPECT_TRUE(trial.session->progress().is_refused);
  EXPECT_THAT(trial.words(), HasSubstr("said nothing"));
  trial.session->take(stage_sample(3.0, trial.bench, 0));
  trial.press(Key::enter);
  EXPECT_THAT(trial.words(), HasSubstr("not set to zero"));
  trial.session->take(stage_sample(3.0, trial.bench, stage_zeroed));
  trial.press(Key::enter);
  ASSERT_TRUE(trial.session->progress().is_taking);
  trial.session->take(stage_sample(3.2, trial.bench, stage_zeroed));
  while (trial.session->progress().is_taking)
    send_still(*trial.session, trial.bench, "marker", Pose(Eigen::Translation3d(0, 0, -2000)));
  EXPECT_THAT(trial.words(), HasSubstr("The stage moved"));
  trial.do_all();
  EXPECT_TRUE(is_done(trial.session->calibration(), CalibrationPart::bullseye));
}

/// A board that restarted between two places: nothing that is marked is lost.
TEST(GuideSession, AStageThatLostItsZeroIsZeroedByKeyAndEveryMarkIsKept)
{
  Trial trial(bench(), all_done(), anew("bullseye"));
  trial.go_to(CalibrationPart::bullseye, "right eye, place 2");
  const std::size_t n_marks = trial.record(CalibrationPart::bullseye).marks.size();
  ASSERT_EQ(n_marks, 3u);
  const CalibrationRecord stop = trial.record(CalibrationPart::stop);
  trial.session->take(stage_sample(37.25, trial.bench, 0));
  trial.press(Key::enter);
  EXPECT_TRUE(trial.session->progress().is_refused);
  EXPECT_THAT(trial.words(), HasSubstr("push the stage against its stop and press Z"));
  EXPECT_FALSE(trial.session->zeroes_stage());
  trial.press('Z');
  EXPECT_TRUE(trial.session->zeroes_stage());
  EXPECT_FALSE(trial.session->zeroes_stage());
  EXPECT_FALSE(trial.session->progress().is_refused);
  EXPECT_THAT(trial.words(), HasSubstr("it stood at 37.25 mm"));
  EXPECT_TRUE(trial.is_asked(CalibrationPart::bullseye, "right eye, place 2"));
  EXPECT_EQ(trial.record(CalibrationPart::bullseye).marks.size(), n_marks);
  EXPECT_EQ(trial.record(CalibrationPart::stop).marks.at(0).rows, stop.marks.at(0).rows);
  EXPECT_FALSE(trial.record(CalibrationPart::bullseye).is_outdated);
  trial.press(Key::enter);
  EXPECT_TRUE(trial.session->progress().is_taking);
}

TEST(GuideSession, ZWantsAStageWhoseBoardSpeaks)
{
  Trial trial(bench(), all_done(), anew("bullseye"));
  trial.press('Z');
  EXPECT_FALSE(trial.session->zeroes_stage());
  EXPECT_THAT(trial.words(), HasSubstr("said nothing"));
  const BenchFile tracked = test::virtual_bench(HeadKind::tracker);
  Trial without(tracked);
  without.press('Z');
  EXPECT_FALSE(without.session->zeroes_stage());
  EXPECT_TRUE(without.words().empty());
}

TEST(GuideSession, TheStopAsksOnceForAStageAtZero)
{
  Trial trial(bench(), "stop");
  EXPECT_FALSE(trial.session->zeroes_stage());
  trial.session->take(stage_sample(12.5, trial.bench, 0));
  trial.press(Key::enter);
  EXPECT_TRUE(trial.session->zeroes_stage());
  EXPECT_FALSE(trial.session->zeroes_stage());
  EXPECT_EQ(trial.record(CalibrationPart::stop).marks.at(0).rows, (std::vector<std::vector<double>>{{12.5}}));
  EXPECT_TRUE(is_done(trial.session->calibration(), CalibrationPart::stop));
}

TEST(GuideSession, ASubjectOfAnotherShapeAsksForANewRun)
{
  Trial trial(bench(), "subject");
  // One distance half as long again as the others say.
  for (int k = 0; k < 10; ++k) trial.press(Key::right, false, true);
  trial.press(Key::enter);
  while (trial.session->task() != nullptr && !trial.session->progress().is_refused) trial.do_task();
  EXPECT_TRUE(trial.session->progress().is_refused);
  EXPECT_THAT(trial.words(), HasSubstr("schemas/scaling.md"));
  EXPECT_EQ(trial.session->calibration().subject_scale, 1.0);
  EXPECT_EQ(trial.session->progress().n_done, 0);
  trial.do_all();
  EXPECT_NEAR(trial.session->calibration().subject_scale, trial.truth.calibration.subject_scale, 0.05);
}

TEST(GuideSession, APartDoneAgainOutdatesWhatRestsOnItWithItsFirstMark)
{
  Trial trial(bench(), all_done(), anew("distortion"));
  Calibration outdated = all_done();
  outdated.records.at(CalibrationPart::distortion).is_outdated = true;
  EXPECT_TRUE(calibration_text(trial.session->calibration(), bench()) == calibration_text(outdated, bench()));
  trial.do_task();
  const Calibration& now = trial.session->calibration();
  for (const CalibrationPart part :
       {CalibrationPart::eyepoints, CalibrationPart::ipd, CalibrationPart::bullseye})
    EXPECT_TRUE(now.records.at(part).is_outdated) << name_of(part);
  for (const CalibrationPart part : {CalibrationPart::viewport, CalibrationPart::rails, CalibrationPart::stop,
                                     CalibrationPart::probe, CalibrationPart::subject, CalibrationPart::leg})
    EXPECT_FALSE(now.records.at(part).is_outdated) << name_of(part);
  EXPECT_EQ(now.records.at(CalibrationPart::distortion).marks.size(), 1u);
  EXPECT_FALSE(is_done(now, CalibrationPart::distortion));
  trial.do_all();
  // Everything again asks for just what is outdated.
  Trial rest(bench(), trial.session->calibration(), test::options_of(bench()));
  EXPECT_EQ(rest.session->progress().part, CalibrationPart::eyepoints);
  std::set<CalibrationPart> asked;
  while (rest.session->task() != nullptr) {
    asked.insert(rest.session->progress().part);
    rest.do_task();
  }
  EXPECT_EQ(asked, (std::set<CalibrationPart>{CalibrationPart::eyepoints, CalibrationPart::ipd,
                                              CalibrationPart::bullseye}));
}

/// Wherever doing parts anew is interrupted, the plain command goes on: what is done is not asked for again,
/// what is under way keeps its marks.
TEST(GuideSession, WhatIsDoneAnewGoesOnWithoutSayingSoAgain)
{
  GuideOptions both = anew("subject");
  both.parts = {CalibrationPart::stop, CalibrationPart::probe, CalibrationPart::subject};
  GuideOptions plain = both;
  plain.is_anew = false;
  Trial trial(bench(), all_done(), both);
  EXPECT_GT(trial.session->revision(), 0u);  // of an interruption before the first task
  int n_tasks = 0;
  for (; trial.session->task() != nullptr; ++n_tasks) {
    trial.do_task();
    const std::string file = calibration_text(trial.session->calibration(), bench());
    trial.session =
        std::make_unique<GuideSession>(bench(), parsed_calibration(file, "c.toml", bench()), plain);
  }
  EXPECT_EQ(n_tasks, 2 + static_cast<int>(bench().calibration.landmarks.size()));
  for (const CalibrationPart part : both.parts)
    EXPECT_TRUE(is_done(trial.session->calibration(), part)) << name_of(part);
}

TEST(GuideSession, APartBeforeOneThatItRestsOnIsRefused)
{
  const auto field_of = [](const Calibration& begun, const std::string& step) {
    return test::input_error([&] { GuideSession(bench(), begun, test::options_of(bench(), step)); });
  };
  const Calibration nominal = nominal_calibration(bench());
  EXPECT_EQ(field_of(nominal, "distortion").field, "distortion");
  EXPECT_EQ(field_of(nominal, "distortion").found, "viewport, which is not done");
  EXPECT_EQ(field_of(nominal, "ipd").found, "eyepoints, which is not done");
  EXPECT_EQ(field_of(nominal, "leg").found, "probe, which is not done");
  Calibration old = all_done();
  old.records.at(CalibrationPart::rails).is_outdated = true;
  old.records.at(CalibrationPart::bullseye).is_outdated = true;
  EXPECT_EQ(field_of(old, "bullseye").found, "rails, which is outdated");
  GuideSession(bench(), nominal, test::options_of(bench(), "viewport"));
}

TEST(GuideSession, ARecordOfAnotherPlanIsRefusedUnlessThePartIsDoneAnew)
{
  const BenchFile other =
      test::virtual_bench(HeadKind::stage, "[calibration]\n", "[calibration]\nedge_repeats = 3\n");
  Calibration begun = nominal_calibration(bench());
  begun.records[CalibrationPart::viewport] = all_done().records.at(CalibrationPart::viewport);
  begun.records[CalibrationPart::viewport].estimate.reset();
  const InputError::Facts facts =
      test::input_error([&] { GuideSession(other, begun, test::options_of(other, "viewport")); });
  EXPECT_EQ(facts.field, "per_bench.viewport");
  EXPECT_THAT(facts.found, HasSubstr("'left eye, left edge, 4'"));
  GuideOptions options = test::options_of(other, "viewport");
  options.is_anew = true;
  EXPECT_NE(GuideSession(other, begun, options).task(), nullptr);
  Calibration damaged = all_done();
  damaged.records.at(CalibrationPart::rails).estimate.reset();
  damaged.records.at(CalibrationPart::rails).marks[0].rows[3].pop_back();
  damaged.records.at(CalibrationPart::rails).marks[0].rows[3].pop_back();
  EXPECT_THAT(
      test::input_error([&] { GuideSession(bench(), damaged, test::options_of(bench(), "rails")); }).found,
      HasSubstr("rows of 'x rail'"));
}

/// With five bull's-eyes done, and a rectangle of the bench file changed.
TEST(GuideSession, NumbersOfTheBenchFileThatChangedAreToldBeforeAnythingIsAsked)
{
  Trial trial(bench(), all_done(), anew("bullseye"));
  trial.go_to(CalibrationPart::bullseye, "right eye, place 3");
  const Calibration begun = trial.session->calibration();
  ASSERT_EQ(begun.records.at(CalibrationPart::bullseye).marks.size(), 5u);
  BenchFile other = bench();
  other.calibration.rectangles[1].depth_mm += 25.0;
  const auto refused = [&](const BenchFile& file, const Calibration& so_far, const std::string& step) {
    return test::input_error([&] { GuideSession(file, so_far, test::options_of(file, step)); });
  };
  for (const char* step : {"bullseye", "ipd", "eyepoints", "all"}) {
    SCOPED_TRACE(step);
    const InputError::Facts facts = refused(other, begun, step);
    EXPECT_EQ(facts.field, "per_person.eyepoints");
    EXPECT_EQ(facts.found,
              "marks made when calibration.rectangles had 150.0 where it now has 175.0");
    EXPECT_THAT(facts.wanted, HasSubstr("do eyepoints anew"));
  }
  EXPECT_THAT(test::input_error([&] { solved_again(other, begun, "c.toml"); }).found,
              HasSubstr("calibration.rectangles"));
  // Of points and distances, too; what does not rest on them goes on.
  BenchFile touched = bench();
  touched.calibration.points[2].p_model_mm.y() += 1.0;
  touched.calibration.landmarks[0].model_mm += 1.0;
  EXPECT_EQ(refused(touched, all_done(), "leg").field, "per_person.leg");
  EXPECT_EQ(refused(touched, all_done(), "subject").field, "per_person.subject");
  BenchFile geared = bench();
  geared.stage_mm_per_count *= 2.0;
  EXPECT_EQ(refused(geared, begun, "bullseye").field, "per_person.bullseye");
  EXPECT_NE(GuideSession(touched, begun, test::options_of(touched, "bullseye")).task(), nullptr);
  // Of a file that does not tell its numbers, what bull's-eyes take from the rectangles is tried.
  Calibration silent = begun;
  silent.records.at(CalibrationPart::eyepoints).made_with.clear();
  for (CalibrationRectangle& r : other.calibration.rectangles) r.depth_mm = 0.0;
  const InputError::Facts flat = refused(other, silent, "bullseye");
  EXPECT_THAT(flat.field, HasSubstr("per_person.eyepoints: left"));
  EXPECT_THAT(flat.wanted, HasSubstr("Do eyepoints anew, as bullseye rests on them"));
}

TEST(GuideSession, MarksOfAnEarlierPartThatAreDamagedAreNamed)
{
  const auto rows_of = [](Calibration& c) -> std::vector<std::vector<double>>& {
    return c.records.at(CalibrationPart::eyepoints).marks[3].rows;
  };
  Calibration shorter = all_done(), empty = all_done();
  rows_of(shorter)[0].pop_back();
  rows_of(empty).clear();
  for (Calibration& damaged : {std::ref(shorter), std::ref(empty)}) {
    damaged.records.at(CalibrationPart::bullseye) = {};
    const InputError::Facts facts =
        test::input_error([&] { GuideSession(bench(), damaged, test::options_of(bench(), "bullseye")); });
    EXPECT_EQ(facts.field, "per_person.eyepoints");
    EXPECT_THAT(facts.found, HasSubstr("rows of 'left eye, rectangle"));
    // Solving does not look at them only where it solves them.
    damaged.records.at(CalibrationPart::distortion).estimate.reset();
    damaged.records.at(CalibrationPart::distortion).marks.pop_back();
    damaged.records.at(CalibrationPart::bullseye) = all_done().records.at(CalibrationPart::bullseye);
    EXPECT_EQ(test::input_error([&] { solved_again(bench(), damaged, "c.toml"); }).field,
              "per_person.eyepoints");
  }
}

TEST(GuideSession, ABenchFileWithoutWhatIsWantedIsNamedByKey)
{
  const BenchFile bare = [] {
    BenchFile file = bench();
    file.calibration.points.resize(3);
    file.calibration.landmarks.resize(2);
    return file;
  }();
  const auto wanted = [&](const BenchFile& file, const std::string& step) {
    return test::input_error([&] { GuideSession(file, all_done(), test::options_of(file, step)); });
  };
  EXPECT_EQ(wanted(bare, "leg").field, "calibration.point");
  EXPECT_EQ(wanted(bare, "subject").field, "calibration.landmarks");
  BenchFile none = bench();
  none.calibration = CalibrationSettings();
  EXPECT_EQ(wanted(none, "viewport").field, "calibration");
}

}  // namespace
}  // namespace vrda
