#include "calibration/task.hpp"

#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <set>

#include "calibration/parts.hpp"
#include "calibration/session.hpp"
#include "player/calibration/trial.hpp"
#include "support/refusal.hpp"

namespace vrda::calibration::tasks_test {

std::vector<BenchFile> benches()
{
  const std::string head = "[calibration]\n";
  return {test::virtual_bench(HeadKind::stage), test::virtual_bench(HeadKind::tracker),
          test::virtual_bench(HeadKind::stage, head,
                              head + "distortion = \"adjust\"\nmodel = \"adjust\"\npupillometer = false\n"
                                     "bullseyes = 27\ngrid = [4, 6]\n")};
}

std::size_t lines_in(const std::string& text)
{
  return 1 + static_cast<std::size_t>(std::count(text.begin(), text.end(), '\n'));
}

TEST(CalibrationTasks, AreNamedOnceAndSayWhatIsWanted)
{
  std::set<const TaskKind*> kinds;
  for (const BenchFile& bench : benches()) {
    const Calibration nominal = bench::nominal_calibration(bench);
    for (const CalibrationPart part : parts_of(bench)) {
      SCOPED_TRACE(bench::name_of(part));
      const std::vector<Task> tasks = tasks_of(part, bench, nominal);
      ASSERT_FALSE(tasks.empty());
      std::set<std::string> names;
      for (const Task& task : tasks) {
        SCOPED_TRACE(task.name);
        kinds.insert(task.kind);
        EXPECT_TRUE(names.insert(task.name).second);
        EXPECT_FALSE(task.instruction.empty());
        EXPECT_LE(lines_in(task.instruction), 3u);
        for (const Dial& dial : task.dials) {
          EXPECT_LE(dial.minimum, dial.value);
          EXPECT_LE(dial.value, dial.maximum);
          EXPECT_GT(dial.step, 0.0);
        }
        EXPECT_EQ(task.n_samples > 0, !task.tool.empty());
      }
    }
  }
  EXPECT_EQ(kinds.size(), 14u);
}

TEST(CalibrationParts, AreOnceABenchOrOnceAPerson)
{
  for (const BenchFile& file : benches()) {
    std::vector<CalibrationPart> both = parts_of_step("bench", file);
    EXPECT_EQ(both.back() < CalibrationPart::eyepoints, true);
    const std::vector<CalibrationPart> person = parts_of_step("person", file);
    EXPECT_EQ(person.front(), CalibrationPart::eyepoints);
    both.insert(both.end(), person.begin(), person.end());
    EXPECT_EQ(both, parts_of_step("all", file));
  }
}

TEST(CalibrationTasks, MarkersSpreadInEveryDirectionWithinTheFirstSix)
{
  std::set<std::array<int, 3>> all;
  for (int k = 0; k < 27; ++k) {
    const Eigen::Vector3i place = requested_marker_position(k);
    all.insert({place.x(), place.y(), place.z()});
  }
  EXPECT_EQ(all.size(), 27u);
  Eigen::Matrix3d spread = Eigen::Matrix3d::Zero();
  for (int k = 0; k < 6; ++k) {
    const Eigen::Vector3d place = requested_marker_position(k).cast<double>();
    spread += place * place.transpose();
  }
  // Six positions with five corners have a nearly isotropic scatter.
  EXPECT_GT(Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(spread).eigenvalues()[0], 2.0);
}

TEST(CalibrationTasks, RoundsAreThoseOfAnEyeARailOrThePart)
{
  const BenchFile bench = test::virtual_bench(HeadKind::stage);
  const Calibration nominal = bench::nominal_calibration(bench);
  for (const CalibrationPart part : parts_of(bench)) {
    const std::vector<Task> tasks = tasks_of(part, bench, nominal);
    const bool is_by_eye = part == CalibrationPart::viewport || part == CalibrationPart::distortion ||
                           part == CalibrationPart::eyepoints;
    const bool is_halved = is_by_eye || part == CalibrationPart::rails;
    const TaskGroup first = task_group_of(part, tasks, 0),
                    last = task_group_of(part, tasks, tasks.size() - 1);
    EXPECT_EQ(first.begin, 0u);
    EXPECT_EQ(first.end, is_halved ? tasks.size() / 2 : tasks.size());
    EXPECT_EQ(last.begin, is_halved ? tasks.size() / 2 : 0u);
    EXPECT_EQ(last.end, tasks.size());
  }
}

using Parts = std::vector<CalibrationPart>;

TEST(CalibrationParts, AreThoseThatMakeSenseOnTheBench)
{
  using enum CalibrationPart;
  const std::vector<BenchFile> files = benches();
  EXPECT_EQ(parts_of(files[0]),
            (Parts{viewport, distortion, rails, stop, probe, eyepoints, ipd, subject, bullseye, leg}));
  EXPECT_EQ(parts_of(files[1]), (Parts{viewport, distortion, probe, eyepoints, ipd, subject, head, leg}));
  EXPECT_EQ(parts_of(files[2]),
            (Parts{viewport, distortion, rails, stop, eyepoints, ipd, subject, bullseye, leg}));
  EXPECT_EQ(parts_of_step("tracking", files[0]), (Parts{rails, stop, probe, bullseye, leg}));
  EXPECT_EQ(parts_of_step("tracking", files[1]), (Parts{probe, leg}));
  EXPECT_EQ(parts_of_step("head", files[1]), Parts{head});
  EXPECT_EQ(parts_of_step("all", files[0]), parts_of(files[0]));
  BenchFile two = files[0];
  two.leg = LegKind::two_bodies;
  two.board.reset();
  EXPECT_EQ(parts_of_step("tracking", two), (Parts{rails, probe, bullseye, femur, tibia}));
  EXPECT_EQ(dependencies_of(bullseye, two), (Parts{rails, eyepoints, ipd}));
  EXPECT_EQ(dependencies_of(leg, files[2]), (Parts{subject, bullseye}));
  EXPECT_EQ(dependencies_of(leg, files[0]), (Parts{probe, subject}));
}

TEST(CalibrationParts, AnUnknownStepIsRefusedByName)
{
  const std::vector<BenchFile> files = benches();
  const auto refused = [](const std::string& step, const BenchFile& bench) {
    return test::input_error([&] { parts_of_step(step, bench); });
  };
  EXPECT_EQ(refused("viewprot", files[0]).found, "'viewprot'");
  EXPECT_THAT(refused("viewprot", files[0]),
              test::refuses({.field = "STEP", .found = "'viewprot'", .wanted = "bullseye"}));
  EXPECT_EQ(refused("head", files[0]).field, "STEP");
  EXPECT_EQ(refused("rails", files[1]).field, "STEP");
  BenchFile without = files[0];
  without.calibration.landmarks.clear();
  EXPECT_EQ(refused("subject", without).field, "calibration.landmarks");
}

}  // namespace vrda::calibration::tasks_test
