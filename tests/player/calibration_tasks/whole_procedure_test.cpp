#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "calibration_tasks/parts.hpp"
#include "calibration_tasks/solve_part.hpp"
#include "support/input_error.hpp"
#include "trial.hpp"

namespace vrda::whole_procedure_test {

using test::Trial;

struct Procedure {
  std::string name;
  bench_files::HeadKind head = bench_files::HeadKind::stage;
  std::string changed, into;  ///< replaced text of the bench file
};

const std::string calibration_head = "[calibration]\n";

/// Covers every kind of task.
const std::vector<Procedure>& procedures()
{
  static const std::vector<Procedure> all{
      {"OnAStage", bench_files::HeadKind::stage, "", ""},
      {"Tracked", bench_files::HeadKind::tracker, "", ""},
      {"GridsAndPlacesAdjusted", bench_files::HeadKind::stage, calibration_head,
       calibration_head + "distortion = \"adjust\"\nmodel = \"adjust\"\npupillometer = false\n"}};
  return all;
}

class WholeProcedure : public testing::TestWithParam<Procedure> {
 protected:
  const bench_files::BenchFile bench =
      test::virtual_bench(GetParam().head, GetParam().changed, GetParam().into);
};

TEST_P(WholeProcedure, EveryPartIsDoneAndTheFileReads)
{
  Trial trial(bench);
  trial.do_all();
  const bench_files::Calibration& found = trial.session->calibration();
  for (const bench_files::CalibrationPart part : calibration_tasks::parts_of(bench)) {
    SCOPED_TRACE(bench_files::name_of(part));
    ASSERT_TRUE(calibration_tasks::is_done(found, part));
    EXPECT_EQ(found.records.at(part).date, "2026-11-22");
  }
  const std::string text = bench_files::calibration_text(found, bench);
  EXPECT_TRUE(bench_files::calibration_text(bench_files::parse_calibration(text, "c.toml", bench), bench) ==
              text);
  EXPECT_LT(text.size(), 400000u);
}

TEST(WholeProcedureOfTheExample, IsDone)
{
  const bench_files::BenchFile desk = bench_files::read_bench_file(VRDA_JOBS "/bench-desk.toml");
  Trial trial(desk);
  trial.do_all();
  for (const bench_files::CalibrationPart part : calibration_tasks::parts_of_step("all", desk)) {
    SCOPED_TRACE(bench_files::name_of(part));
    EXPECT_TRUE(calibration_tasks::is_done(trial.session->calibration(), part));
  }
  for (const bench_files::CalibrationPart part :
       {bench_files::CalibrationPart::femur, bench_files::CalibrationPart::tibia,
        bench_files::CalibrationPart::subject})
    EXPECT_FALSE(trial.record(part).marks.empty()) << bench_files::name_of(part);
}

TEST_P(WholeProcedure, AnInterruptionAfterEveryMarkChangesNoByte)
{
  Trial through(bench);
  through.do_all();
  Trial interrupted(bench);
  const calibration_tasks::CalibrationSessionOptions options = test::options_of(bench);
  int n = 0;
  while (interrupted.session->task() != nullptr) {
    interrupted.do_task();
    const std::string file = bench_files::calibration_text(interrupted.session->calibration(), bench);
    interrupted.session = std::make_unique<calibration_tasks::CalibrationSession>(
        bench, bench_files::parse_calibration(file, "c.toml", bench), options);
    ++n;
  }
  EXPECT_GT(n, 50);
  EXPECT_TRUE(bench_files::calibration_text(interrupted.session->calibration(), bench) ==
              bench_files::calibration_text(through.session->calibration(), bench));
}

TEST_P(WholeProcedure, SolvingAgainGivesTheSameWhateverWasChangedByHand)
{
  Trial trial(bench);
  trial.do_all();
  const bench_files::Calibration& found = trial.session->calibration();
  bench_files::Calibration changed = found;
  changed.eyes.left.distance_px += 3.0;
  changed.eyes.right.distortion.k1 += 0.1;
  changed.eyes.right.position_head_mm.x() += 2.0;
  for (const bench_files::CalibrationPart part : calibration_tasks::parts_of(bench)) {
    if (part == bench_files::CalibrationPart::rails) changed.X_tracker_table.shift_mm.x() += 10.0;
    if (part == bench_files::CalibrationPart::bullseye) changed.X_table_eyes = tracking::PoseParameters{};
    if (part == bench_files::CalibrationPart::head) changed.X_headbody_eyes = tracking::PoseParameters{};
  }
  changed.subject_scale = 0.5;
  changed.records.at(bench_files::CalibrationPart::viewport).estimate.reset();
  // EXPECT_TRUE, because a failure would print texts of some 100 kB.
  EXPECT_TRUE(bench_files::calibration_text(calibration_tasks::solve_again(bench, changed, "c.toml"),
                                            bench) == bench_files::calibration_text(found, bench));
}

INSTANTIATE_TEST_SUITE_P(Benches, WholeProcedure, testing::ValuesIn(procedures()),
                         [](const auto& row) { return row.param.name; });

}  // namespace vrda::whole_procedure_test
