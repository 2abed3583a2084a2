// Practice on a virtual bench.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <sstream>

#include "calibration/calibrate.hpp"
#include "calibration/parts.hpp"
#include "calibration/truth.hpp"
#include "support/scratch.hpp"

namespace vrda::calibration::practice_test {

/// Each confirmed task ends with its distance from the truth. Above 10 px it must be done again.
TEST(Practice, ReportsTheErrorOfATask)
{
  const BenchFile bench = bench::parse_bench_file(virtual_bench_text(), "virtual bench");
  const double left = virtual_truth(bench, 1).edges_px[0].left;
  const std::vector<Task> tasks =
      calibration::tasks_of(CalibrationPart::viewport, bench, bench::nominal_calibration(bench));
  const double start = tasks.front().dials[0].value;
  const test::Scratch scratch;
  for (const int off_px : {0, 1, 5, 100}) {
    SCOPED_TRACE(off_px);
    CalibrateOptions wanted;
    wanted.step = "viewport";
    wanted.is_virtual = wanted.is_headless = true;
    const long n = std::lround(start - left) - off_px;
    wanted.script =
        scratch.write("keys.txt", "press Left " + std::to_string(n) + "\npress Enter\nwait 0.1\n").string();
    std::ostringstream data, messages, sentence;
    calibration::calibrate(wanted, {data, messages});
    sentence.precision(1);
    sentence << std::fixed << "viewport left eye, left edge, 1: You were "
             << std::abs(start - static_cast<double>(n) - left) << " px from the truth";
    EXPECT_THAT(messages.str(), testing::HasSubstr(sentence.str()));
    EXPECT_EQ(messages.str().find(": again") != std::string::npos, off_px > 10) << messages.str();
  }
}

}  // namespace vrda::calibration::practice_test
