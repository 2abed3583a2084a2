// The fits of the calibration need NLopt: with an optimiser that returns its start they are reported by name.
#include <gmock/gmock.h>

#include "support/messages.hpp"
#include "support/process.hpp"
#include "support/scratch.hpp"

namespace vrda::test::idle_optimiser_test {

/// The simulated operator's step of a calibration; `arguments`: the file it is written to.
Ended calibrate(const std::string& step, const char* library, const std::vector<std::string>& arguments)
{
  Command command{VRDA_PLAYER_PROGRAM, {"calibrate", step, "--virtual", "--headless", "--anew"}, {}, {}};
  command.arguments.insert(command.arguments.end(), arguments.begin(), arguments.end());
  // The address sanitizer's library must otherwise be loaded first.
  command.environment = {{"LD_PRELOAD", library}, {"ASAN_OPTIONS", "verify_asan_link_order=0"}};
  return run(command);
}

void expect_refused(const Ended& ended, const std::string& fit)
{
  EXPECT_EQ(ended.exit_code, 2);
  EXPECT_THAT(ended.err, reports("", {fit, "iteration limit"}));
}

TEST(IdleOptimiser, EndsACalibrationAtItsFits)
{
  const Scratch scratch;
  const std::vector<std::string> file = {"--calibration", (scratch.path() / "calibration.toml").string()};
  for (const char* step : {"viewport", "distortion", "eyepoints"}) {
    const Ended whole = calibrate(step, "", file);
    EXPECT_EQ(whole.exit_code, 0) << whole.err;
  }
  expect_refused(calibrate("eyepoints", VRDA_IDLE_NLOPT, file), "an eyepoint fit");
  expect_refused(calibrate("all", VRDA_IDLE_NLOPT, {}), "a grid fit");
}

}  // namespace vrda::test::idle_optimiser_test
