#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "calibration/parts.hpp"
#include "player/calibration/trial.hpp"
#include "support/input_error.hpp"

namespace vrda::calibration::whole_procedure_test {

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

}  // namespace vrda::calibration::whole_procedure_test
