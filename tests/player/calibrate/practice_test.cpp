// Practice on a virtual bench.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <sstream>

#include "calibrate/calibrate.hpp"
#include "calibration_tasks/task.hpp"
#include "gui/overlay_text.hpp"
#include "render/image.hpp"
#include "support/scratch.hpp"
#include "virtual_bench/truth.hpp"

namespace vrda::practice_test {

/// Whether the operator's area shows text of this colour; below is a diagram.
bool has_text(const scene::Texture& picture, const scene::VertexColour& colour)
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
  const bench_files::BenchFile bench =
      bench_files::parse_bench_file(virtual_bench::virtual_bench_text(), "virtual bench");
  const double left = virtual_bench::virtual_truth(bench, 1).edges_px[0].left;
  const double start = calibration_tasks::tasks_of(bench_files::CalibrationPart::viewport, bench,
                                                   bench_files::nominal_calibration(bench))
                           .front()
                           .dials[0]
                           .value;
  const test::Scratch scratch;
  for (const int off_px : {1, 5, 100}) {
    SCOPED_TRACE(off_px);
    const std::string name = std::to_string(off_px);
    calibrate::CalibrateOptions wanted;
    wanted.step = "viewport";
    wanted.is_virtual = wanted.is_headless = true;
    const long n = std::lround(start - left) - off_px;
    wanted.script =
        scratch.write(name + ".txt", "press Left " + std::to_string(n) + "\npress Enter\nwait 0.1\n")
            .string();
    wanted.pictures = (scratch.path() / name).string();
    std::ostringstream data, messages;
    calibrate::calibrate(wanted, {data, messages});
    EXPECT_EQ(messages.str().find(": again") != std::string::npos, off_px > 10) << messages.str();
    const scene::Texture picture = render::read_png_texture(wanted.pictures + "/task_0002.png");
    EXPECT_EQ(has_text(picture, gui::amber), off_px == 5);
    EXPECT_EQ(has_text(picture, gui::red), off_px == 100);
  }
}

}  // namespace vrda::practice_test
