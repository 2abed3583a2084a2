// Practice on a virtual bench.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <sstream>

#include "calibration/calibrate.hpp"
#include "calibration/task.hpp"
#include "calibration/truth.hpp"
#include "support/scratch.hpp"
#include "view/image.hpp"
#include "view/overlay_text.hpp"

namespace vrda::practice_test {

/// Whether the operator's area shows text of this colour; below is a diagram.
bool has_text(const view::Texture& picture, const view::VertexColour& colour)
{
  constexpr int text_px = 180;
  for (int y = 0; y < text_px; ++y) {
    for (int x = 0; x < 640; ++x) {
      const std::size_t at = 3 * (static_cast<std::size_t>(y) * static_cast<std::size_t>(picture.width) +
                                  static_cast<std::size_t>(x));
      if (std::equal(colour.begin(), colour.begin() + 3,
                     picture.rgb.begin() + static_cast<std::ptrdiff_t>(at)))
        return true;
    }
  }
  return false;
}

/// Practice does not praise bad work: above 2 px the deviation is amber, above 10 px red, with what to do.
TEST(Practice, MarksALargeErrorAndSaysAgain)
{
  const bench::BenchFile bench = bench::parse_bench_file(calibration::virtual_bench_text(), "virtual bench");
  const double left = calibration::virtual_truth(bench, 1).edges_px[0].left;
  const double start =
      calibration::tasks_of(bench::CalibrationPart::viewport, bench, bench::nominal_calibration(bench))
          .front()
          .dials[0]
          .value;
  const test::Scratch scratch;
  for (const int off_px : {1, 5, 100}) {
    SCOPED_TRACE(off_px);
    const std::string name = std::to_string(off_px);
    calibration::CalibrateOptions wanted;
    wanted.step = "viewport";
    wanted.is_virtual = wanted.is_headless = true;
    const long n = std::lround(start - left) - off_px;
    wanted.script =
        scratch.write(name + ".txt", "press Left " + std::to_string(n) + "\npress Enter\nwait 0.1\n")
            .string();
    wanted.pictures = (scratch.path() / name).string();
    std::ostringstream data, messages;
    calibration::calibrate(wanted, {data, messages});
    EXPECT_EQ(messages.str().find(": again") != std::string::npos, off_px > 10) << messages.str();
    const view::Texture picture = view::read_png_texture(wanted.pictures + "/task_0002.png");
    EXPECT_EQ(has_text(picture, view::amber), off_px == 5);
    EXPECT_EQ(has_text(picture, view::red), off_px == 100);
  }
}

}  // namespace vrda::practice_test
