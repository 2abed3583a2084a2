#include "guide/words.hpp"

#include "guide/optics_tasks.hpp"
#include "guide/solve_eyes.hpp"
#include "guide/solve_part.hpp"
#include "settings/settings_text.hpp"

namespace vrda {
namespace {

/// What a careful eye reaches at a line's side, and a usual eye.
constexpr double usual_noise_px = 0.5;

std::string expected_eyepoint(const BenchFile& bench, const Calibration& calibration)
{
  const Eyepoint usual{Eye().distance_px, calibration.image_distance_mm};
  const Eigen::Vector2d sd = expected_eyepoint_sd(rectangles_of(bench.calibration), usual, usual_noise_px);
  return "With these rectangles and half a pixel of noise an eye's distance will be known to about +-" +
         rounded_text(2.0 * sd.x(), 1) + " px, its depth to +-" + rounded_text(2.0 * sd.y(), 1) +
         " mm. Rectangles further apart in depth make it better.";
}

}  // namespace

std::vector<std::string> words_before(CalibrationPart part, const BenchFile& bench,
                                      const Calibration& calibration)
{
  if (part == CalibrationPart::eyepoints) return {expected_eyepoint(bench, calibration)};
  return {};
}

std::vector<std::string> words_after(CalibrationPart part, const Estimate& estimate)
{
  std::vector<std::string> words{std::string(name_of(part)) + " is done:"};
  const std::vector<std::string> lines = lines_of(estimate);
  words.insert(words.end(), lines.begin(), lines.end());
  return words;
}

}  // namespace vrda
