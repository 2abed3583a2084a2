// Valid steps, their order, and records that do not match the bench file.
#include "calibration/parts.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <functional>
#include <set>

#include "player/calibration/trial.hpp"
#include "support/refusal.hpp"

namespace vrda::calibration::plan_test {

using test::all_done;
using test::bench;
using test::restarted;
using test::Trial;

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

}  // namespace vrda::calibration::plan_test
