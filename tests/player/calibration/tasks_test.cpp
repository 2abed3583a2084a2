#include "calibration/task.hpp"

#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <set>

#include "calibration/parts.hpp"
#include "calibration/session.hpp"
#include "player/calibration/trial.hpp"
#include "support/refusal.hpp"

namespace vrda::tasks_test {

std::vector<bench::BenchFile> benches()
{
  const std::string head = "[calibration]\n";
  return {test::virtual_bench(bench::HeadKind::stage), test::virtual_bench(bench::HeadKind::tracker),
          test::virtual_bench(bench::HeadKind::stage, head,
                              head + "distortion = \"adjust\"\nmodel = \"adjust\"\npupillometer = false\n"
                                     "bullseyes = 27\ngrid = [4, 6]\n")};
}

std::size_t lines_in(const std::string& text)
{
  return 1 + static_cast<std::size_t>(std::count(text.begin(), text.end(), '\n'));
}

TEST(CalibrationTasks, AreNamedOnceAndSayWhatIsWanted)
{
  std::set<calibration::TaskKind> kinds;
  for (const bench::BenchFile& bench : benches()) {
    const bench::Calibration nominal = bench::nominal_calibration(bench);
    for (const bench::CalibrationPart part : calibration::parts_of(bench)) {
      SCOPED_TRACE(bench::name_of(part));
      const std::vector<calibration::Task> tasks = calibration::tasks_of(part, bench, nominal);
      ASSERT_FALSE(tasks.empty());
      std::set<std::string> names;
      for (const calibration::Task& task : tasks) {
        SCOPED_TRACE(task.name);
        kinds.insert(task.kind);
        EXPECT_TRUE(names.insert(task.name).second);
        EXPECT_FALSE(task.instruction.empty());
        EXPECT_LE(lines_in(task.instruction), 3u);
        for (const calibration::Dial& dial : task.dials) {
          EXPECT_LE(dial.minimum, dial.value);
          EXPECT_LE(dial.value, dial.maximum);
          EXPECT_GT(dial.step, 0.0);
        }
        EXPECT_EQ(task.n_samples > 0, !task.tool.empty());
      }
    }
  }
  EXPECT_EQ(kinds.size(), 11u);
}

TEST(CalibrationParts, AreOnceABenchOrOnceAPerson)
{
  for (const bench::BenchFile& file : benches()) {
    std::vector<bench::CalibrationPart> both = calibration::parts_of_step("bench", file);
    EXPECT_EQ(both.back() < bench::CalibrationPart::eyepoints, true);
    const std::vector<bench::CalibrationPart> person = calibration::parts_of_step("person", file);
    EXPECT_EQ(person.front(), bench::CalibrationPart::eyepoints);
    both.insert(both.end(), person.begin(), person.end());
    EXPECT_EQ(both, calibration::parts_of_step("all", file));
  }
}

TEST(CalibrationTasks, AreAsManyAsTheBenchFileSays)
{
  const bench::BenchFile bench = test::virtual_bench(bench::HeadKind::stage);
  const bench::CalibrationSettings& c = bench.calibration;
  const bench::Calibration nominal = bench::nominal_calibration(bench);
  const auto n = [&](bench::CalibrationPart part) {
    return static_cast<int>(calibration::tasks_of(part, bench, nominal).size());
  };
  EXPECT_EQ(n(bench::CalibrationPart::viewport), 2 * (4 * c.edge_repeats + 2));
  EXPECT_EQ(n(bench::CalibrationPart::distortion), 2 * c.grid_columns * c.grid_rows);
  EXPECT_EQ(n(bench::CalibrationPart::eyepoints),
            2 * c.rectangle_repeats * static_cast<int>(c.rectangles.size()));
  EXPECT_EQ(n(bench::CalibrationPart::ipd), 5);
  EXPECT_EQ(n(bench::CalibrationPart::bullseye), 2 * c.bullseyes);
  EXPECT_EQ(n(bench::CalibrationPart::leg), static_cast<int>(c.points.size()));
  EXPECT_EQ(n(bench::CalibrationPart::subject), static_cast<int>(c.landmarks.size()));
}

TEST(CalibrationTasks, MarkersSpreadInEveryDirectionWithinTheFirstSix)
{
  std::set<std::array<int, 3>> all;
  for (int k = 0; k < 27; ++k) {
    const Eigen::Vector3i place = calibration::requested_marker_position(k);
    all.insert({place.x(), place.y(), place.z()});
  }
  EXPECT_EQ(all.size(), 27u);
  Eigen::Matrix3d spread = Eigen::Matrix3d::Zero();
  for (int k = 0; k < 6; ++k) {
    const Eigen::Vector3d place = calibration::requested_marker_position(k).cast<double>();
    spread += place * place.transpose();
  }
  // Six positions with five corners have a nearly isotropic scatter.
  EXPECT_GT(Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(spread).eigenvalues()[0], 2.0);
}

TEST(CalibrationTasks, RoundsAreThoseOfAnEyeARailOrThePart)
{
  const bench::BenchFile bench = test::virtual_bench(bench::HeadKind::stage);
  const bench::Calibration nominal = bench::nominal_calibration(bench);
  for (const bench::CalibrationPart part : calibration::parts_of(bench)) {
    const std::vector<calibration::Task> tasks = calibration::tasks_of(part, bench, nominal);
    const bool is_by_eye = part == bench::CalibrationPart::viewport ||
                           part == bench::CalibrationPart::distortion ||
                           part == bench::CalibrationPart::eyepoints;
    const bool is_halved = is_by_eye || part == bench::CalibrationPart::rails;
    const calibration::TaskGroup first = calibration::task_group_of(part, tasks, 0),
                                 last = calibration::task_group_of(part, tasks, tasks.size() - 1);
    EXPECT_EQ(first.begin, 0u);
    EXPECT_EQ(first.end, is_halved ? tasks.size() / 2 : tasks.size());
    EXPECT_EQ(last.begin, is_halved ? tasks.size() / 2 : 0u);
    EXPECT_EQ(last.end, tasks.size());
  }
}

using Parts = std::vector<bench::CalibrationPart>;

TEST(CalibrationParts, AreThoseThatMakeSenseOnTheBench)
{
  using enum bench::CalibrationPart;
  const std::vector<bench::BenchFile> files = benches();
  EXPECT_EQ(calibration::parts_of(files[0]),
            (Parts{viewport, distortion, rails, stop, probe, eyepoints, ipd, subject, bullseye, leg}));
  EXPECT_EQ(calibration::parts_of(files[1]),
            (Parts{viewport, distortion, probe, eyepoints, ipd, subject, head, leg}));
  EXPECT_EQ(calibration::parts_of(files[2]),
            (Parts{viewport, distortion, rails, stop, eyepoints, ipd, subject, bullseye, leg}));
  EXPECT_EQ(calibration::parts_of_step("tracking", files[0]), (Parts{rails, stop, probe, bullseye, leg}));
  EXPECT_EQ(calibration::parts_of_step("tracking", files[1]), (Parts{probe, leg}));
  EXPECT_EQ(calibration::parts_of_step("head", files[1]), Parts{head});
  EXPECT_EQ(calibration::parts_of_step("all", files[0]), calibration::parts_of(files[0]));
  bench::BenchFile two = files[0];
  two.leg = bench::LegKind::two_bodies;
  two.board.reset();
  EXPECT_EQ(calibration::parts_of_step("tracking", two), (Parts{rails, probe, bullseye, femur, tibia}));
  EXPECT_EQ(calibration::dependencies_of(bullseye, two), (Parts{rails, eyepoints, ipd}));
  EXPECT_EQ(calibration::dependencies_of(leg, files[2]), (Parts{subject, bullseye}));
  EXPECT_EQ(calibration::dependencies_of(leg, files[0]), (Parts{probe, subject}));
}

TEST(CalibrationParts, AnUnknownStepIsRefusedByName)
{
  const std::vector<bench::BenchFile> files = benches();
  const auto refused = [](const std::string& step, const bench::BenchFile& bench) {
    return test::input_error([&] { calibration::parts_of_step(step, bench); });
  };
  EXPECT_EQ(refused("viewprot", files[0]).found, "'viewprot'");
  EXPECT_THAT(refused("viewprot", files[0]),
              test::refuses({.field = "STEP", .found = "'viewprot'", .wanted = "bullseye"}));
  EXPECT_EQ(refused("head", files[0]).field, "STEP");
  EXPECT_EQ(refused("rails", files[1]).field, "STEP");
  bench::BenchFile without = files[0];
  without.calibration.landmarks.clear();
  EXPECT_EQ(refused("subject", without).field, "calibration.landmarks");
}

}  // namespace vrda::tasks_test
