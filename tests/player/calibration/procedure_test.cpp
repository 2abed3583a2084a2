#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "calibration/parts.hpp"
#include "calibration/statistics.hpp"
#include "player/calibration/fit_support.hpp"
#include "player/calibration/trial.hpp"
#include "support/input_error.hpp"
#include "support/refusal.hpp"

namespace vrda::calibration::procedure_test {

using test::Trial;

struct Procedure {
  std::string name;
  HeadKind head = HeadKind::stage;
  std::string changed, into;  ///< replaced text of the bench file
};

const std::string calibration_head = "[calibration]\n";

/// Covers every kind of task.
const std::vector<Procedure>& procedures()
{
  static const std::vector<Procedure> all{
      {"OnAStage", HeadKind::stage, "", ""},
      {"Tracked", HeadKind::tracker, "", ""},
      {"GridsAndPlacesAdjusted", HeadKind::stage, calibration_head,
       calibration_head + "distortion = \"adjust\"\nmodel = \"adjust\"\npupillometer = false\n"}};
  return all;
}

class WholeProcedure : public testing::TestWithParam<Procedure> {
 protected:
  const BenchFile bench = test::virtual_bench(GetParam().head, GetParam().changed, GetParam().into);
};

TEST_P(WholeProcedure, EveryPartIsDoneAndTheFileReads)
{
  Trial trial(bench);
  trial.do_all();
  const Calibration& found = trial.session->calibration();
  for (const CalibrationPart part : parts_of(bench)) {
    SCOPED_TRACE(bench::name_of(part));
    ASSERT_TRUE(is_done(found, part));
    EXPECT_EQ(found.records.at(part).date, "2026-11-22");
  }
  const std::string text = bench::calibration_text(found, bench);
  EXPECT_TRUE(bench::calibration_text(bench::parse_calibration(text, "c.toml", bench), bench) == text);
  EXPECT_LT(text.size(), 400000u);
}

TEST(WholeProcedureOfTheExample, IsDone)
{
  const BenchFile desk = bench::read_bench_file(VRDA_JOBS "/bench-desk.toml");
  Trial trial(desk);
  trial.do_all();
  for (const CalibrationPart part : parts_of_step("all", desk)) {
    SCOPED_TRACE(bench::name_of(part));
    EXPECT_TRUE(is_done(trial.session->calibration(), part));
  }
  for (const CalibrationPart part :
       {CalibrationPart::femur, CalibrationPart::tibia, CalibrationPart::subject})
    EXPECT_FALSE(trial.record(part).marks.empty()) << bench::name_of(part);
}

TEST_P(WholeProcedure, AnInterruptionAfterEveryMarkChangesNoByte)
{
  Trial through(bench);
  through.do_all();
  Trial interrupted(bench);
  const CalibrationSessionOptions options = test::options_of(bench);
  int n = 0;
  while (interrupted.session->task() != nullptr) {
    interrupted.do_task();
    const std::string file = bench::calibration_text(interrupted.session->calibration(), bench);
    interrupted.session =
        std::make_unique<CalibrationSession>(bench, bench::parse_calibration(file, "c.toml", bench), options);
    ++n;
  }
  EXPECT_GT(n, 50);
  EXPECT_TRUE(bench::calibration_text(interrupted.session->calibration(), bench) ==
              bench::calibration_text(through.session->calibration(), bench));
}

TEST_P(WholeProcedure, SolvingAgainGivesTheSameWhateverWasChangedByHand)
{
  Trial trial(bench);
  trial.do_all();
  const Calibration& found = trial.session->calibration();
  Calibration changed = found;
  changed.eyes.left.distance_px += 3.0;
  changed.eyes.right.distortion.k1 += 0.1;
  changed.eyes.right.position_head_mm.x() += 2.0;
  for (const CalibrationPart part : parts_of(bench)) {
    if (part == CalibrationPart::rails) changed.X_tracker_table.shift_mm.x() += 10.0;
    if (part == CalibrationPart::bullseye) changed.X_table_eyes = bench::PoseParameters{};
    if (part == CalibrationPart::head) changed.X_headbody_eyes = bench::PoseParameters{};
  }
  changed.subject_scale = 0.5;
  changed.records.at(CalibrationPart::viewport).estimate.reset();
  // EXPECT_TRUE, because a failure would print texts of some 100 kB.
  EXPECT_TRUE(bench::calibration_text(solve_again(bench, changed, "c.toml"), bench) ==
              bench::calibration_text(found, bench));
}

INSTANTIATE_TEST_SUITE_P(Benches, WholeProcedure, testing::ValuesIn(procedures()),
                         [](const auto& row) { return row.param.name; });

// The optional part functional, from bends of a virtual leg to the placements in the file.

const BenchFile& desk()
{
  static const BenchFile read = bench::read_bench_file(VRDA_JOBS "/bench-desk.toml");
  return read;
}

VirtualNoise palpated()
{
  VirtualNoise noise;
  noise.touch_mm = 3.0;
  return noise;
}

VirtualTruth truth()
{
  VirtualTruth truth = virtual_truth(desk(), 2);
  truth.joint = virtual_joint(truth, test::knee_curve(), palpated());
  return truth;
}

CalibrationSessionOptions options_of(std::vector<CalibrationPart> parts)
{
  return {std::move(parts), false, "2026-11-24", "c.toml", test::knee_curve()};
}

CalibrationSessionOptions functional()
{
  return options_of({CalibrationPart::functional});
}

/// Does all tasks of a session.
void do_all(CalibrationSession& session, VirtualOperator& person)
{
  while (session.task() != nullptr) person.do_task(session);
}

/// Probe, size and landmarks of both bones, computed once.
const Calibration& landmarks()
{
  static const Calibration done = [] {
    CalibrationSession session(desk(), bench::nominal_calibration(desk()),
                               options_of({CalibrationPart::probe, CalibrationPart::subject,
                                           CalibrationPart::femur, CalibrationPart::tibia}));
    VirtualOperator person(desk(), truth(), palpated());
    do_all(session, person);
    return session.calibration();
  }();
  return done;
}

/// The same with the part functional.
const Calibration& refined()
{
  static const Calibration done = [] {
    CalibrationSession session(desk(), landmarks(), functional());
    VirtualOperator person(desk(), truth(), palpated());
    do_all(session, person);
    EXPECT_EQ(person.n_refusals(), 0);
    return session.calibration();
  }();
  return done;
}

std::string text_of(const Calibration& calibration)
{
  return bench::calibration_text(calibration, desk());
}

TEST(Functional, IsDoneByNameOnlyAndWithAModel)
{
  for (const char* step : {"all", "person", "tracking"}) {
    const std::vector<CalibrationPart> parts = parts_of_step(step, desk());
    EXPECT_EQ(std::ranges::count(parts, CalibrationPart::functional), 0) << step;
  }
  EXPECT_EQ(parts_of_step("functional", desk()), std::vector<CalibrationPart>{CalibrationPart::functional});
  CalibrationSessionOptions without = functional();
  without.joint.reset();
  EXPECT_THAT(test::input_error([&] { CalibrationSession(desk(), landmarks(), without); }),
              test::refuses({.field = "--model"}));
  EXPECT_THAT(test::input_error(
                  [&] { CalibrationSession(desk(), bench::nominal_calibration(desk()), functional()); }),
              test::refuses({.field = "functional", .found = "femur"}));
  // One body has no moving leg.
  EXPECT_THAT(test::input_error([] { parts_of_step("functional", test::bench()); }),
              test::refuses({.field = "STEP", .found = "functional"}));
}

TEST(Functional, PlacesBothBonesNearerTheTruth)
{
  const JointError error = joint_error(refined(), truth());
  EXPECT_LT(error.functional_mm, error.by_landmarks_mm);
  const CalibrationRecord& record = refined().records.at(CalibrationPart::functional);
  ASSERT_TRUE(record.estimate);
  EXPECT_EQ(record.marks.size(), 4u);
  EXPECT_EQ(record.date, "2026-11-24");
  EXPECT_EQ(record.estimate->names.size(), 12u);
  EXPECT_EQ(record.estimate->residuals.size(), 4u);  // a held-out error of each bend
  // Both bones depend on each other.
  EXPECT_GT(record.estimate->covariance.topRightCorner(6, 6).norm(), 0.0);
  // The bench uses the placements.
  for (const CalibrationPart part : {CalibrationPart::femur, CalibrationPart::tibia}) {
    const auto role = static_cast<std::size_t>(role_of(part));
    const double shift_mm = record.estimate->values[part == CalibrationPart::femur ? 0 : 6];
    EXPECT_NEAR(refined().X_body_model[role].shift_mm.x(), shift_mm, 1e-9);
    EXPECT_NE(refined().X_body_model[role].shift_mm, landmarks().X_body_model[role].shift_mm);
  }
}

TEST(Functional, FileInterruptionsAndSolvingAgainChangeNothing)
{
  const std::string text = text_of(refined());
  EXPECT_TRUE(text_of(bench::parse_calibration(text, "c.toml", desk())) == text);
  // Without the model: the record keeps its motion.
  EXPECT_TRUE(text_of(solve_again(desk(), refined(), "c.toml")) == text);
  Calibration begun = landmarks();
  int n_sessions = 0;
  for (bool is_done = false; !is_done; ++n_sessions) {
    CalibrationSession session(desk(), bench::parse_calibration(text_of(begun), "c.toml", desk()),
                               functional());
    VirtualOperator person(desk(), truth(), palpated());
    person.do_task(session);
    is_done = session.task() == nullptr;
    begun = session.calibration();
  }
  EXPECT_EQ(n_sessions, 4);
  EXPECT_TRUE(text_of(begun) == text);
}

TEST(Functional, ASmallBendIsRefusedAtOnceAndAlone)
{
  VirtualTruth stiff = truth();
  CalibrationSession session(desk(), landmarks(), functional());
  VirtualOperator person(desk(), truth(), palpated());
  person.do_task(session);
  EXPECT_THAT(session.progress().messages.front(), testing::HasSubstr("bend 1"));
  stiff.joint->curve.knots.resize(8);  // 21 degrees
  VirtualOperator other(desk(), stiff, palpated());
  other.do_task(session);
  EXPECT_TRUE(session.progress().has_error);
  EXPECT_THAT(session.progress().messages.front(), testing::HasSubstr("40 degrees"));
  EXPECT_EQ(session.progress().n_done, 1);
  EXPECT_EQ(session.task()->name, "bend 2");
}

TEST(Functional, AStartedPartIsNotCompletedWithAnotherModel)
{
  CalibrationSession session(desk(), landmarks(), functional());
  VirtualOperator person(desk(), truth(), palpated());
  person.do_task(session);
  CalibrationSessionOptions other = functional();
  other.joint->knots[3][0] += 0.5;
  EXPECT_THAT(test::input_error([&] { CalibrationSession(desk(), session.calibration(), other); }),
              test::refuses({.file = "c.toml", .field = "per_person.functional", .wanted = "--anew"}));
}

TEST(Functional, NewLandmarksOfOneBoneReplaceThePlacementsOfBoth)
{
  CalibrationSessionOptions again = options_of({CalibrationPart::femur});
  again.is_repeated = true;
  CalibrationSession session(desk(), refined(), again);
  VirtualOperator person(desk(), truth(), palpated());
  do_all(session, person);
  const Calibration& found = session.calibration();
  EXPECT_TRUE(found.records.at(CalibrationPart::functional).is_outdated);
  EXPECT_FALSE(is_done(found, CalibrationPart::functional));
  for (const CalibrationPart part : {CalibrationPart::femur, CalibrationPart::tibia}) {
    const auto role = static_cast<std::size_t>(role_of(part));
    EXPECT_NEAR(found.X_body_model[role].shift_mm.x(), found.records.at(part).estimate->values[0], 1e-9);
  }
}

}  // namespace vrda::calibration::procedure_test
