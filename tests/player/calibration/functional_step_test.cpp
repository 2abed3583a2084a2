// The step `calibrate functional` on virtual legs, and the noise of virtual benches.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <functional>
#include <nlohmann/json.hpp>
#include <sstream>

#include "calibration/calibrate.hpp"
#include "store/motion_model.hpp"
#include "support/models.hpp"
#include "support/refusal.hpp"
#include "support/scratch.hpp"

namespace vrda::calibration::functional_step_test {

using testing::HasSubstr;

std::string report_of(const CalibrateOptions& options)
{
  std::ostringstream data, messages;
  EXPECT_EQ(calibrate(options, {data, messages}), CalibrateEnd::finished);
  return data.str();
}

InputError::Facts refusal(const CalibrateOptions& options)
{
  std::ostringstream data, messages;
  return test::input_error([&] { calibrate(options, {data, messages}); });
}

TEST(VirtualNoise, IsSetByName)
{
  const VirtualNoise noise = noise_of("touch_mm=5,model_deg=0.25");
  EXPECT_EQ(noise.touch_mm, 5.0);
  EXPECT_EQ(noise.model_deg, 0.25);
  EXPECT_EQ(noise.tracker_mm, VirtualNoise{}.tracker_mm);
  for (const char* list :
       {"touch=5", "touch_mm", "touch_mm=", "touch_mm=-1", "touch_mm=nan", "touch_mm=5 mm", ","}) {
    EXPECT_THAT(test::input_error([&] { noise_of(list); }), test::refuses({.file = "--noise"})) << list;
  }
}

class FunctionalStep : public testing::Test {
 protected:
  /// A model that rolls back by 10 mm and turns by 12 degrees while it bends by 90.
  std::string model(const std::function<void(store::MotionModel&)>& change = {}) const
  {
    test::ModelPlan plan;
    plan.motion = [](double flexion_deg, double) {
      const double share = flexion_deg / 90.0;
      return store::PoseCoordinates{-10.0 * share * share, 2.0 * share, 1.0, 12.0 * share};
    };
    store::MotionModel made = test::model_of(plan);
    test::add_bodies(made);
    if (change) change(made);
    store::write_motion_model(in_scratch("knee.h5"), made);
    return in_scratch("knee.h5");
  }
  CalibrateOptions legs(int n) const
  {
    CalibrateOptions made;
    made.step = "functional";
    made.is_virtual = made.is_headless = true;
    made.bench = VRDA_JOBS "/bench-desk.toml";
    made.model = model();
    made.n_benches = n;
    made.noise = "touch_mm=5,tracker_mm=0.3,tracker_deg=0.3";
    made.has_json = true;
    return made;
  }
  std::string in_scratch(const std::string& name) const { return (scratch_.path() / name).string(); }

  test::Scratch scratch_;
};

TEST_F(FunctionalStep, ReportsTheErrorsOfVirtualLegs)
{
  const nlohmann::json found = nlohmann::json::parse(report_of(legs(2)));
  EXPECT_EQ(found.at("joint").at("n"), 2);
  EXPECT_LT(found.at("joint").at("by_motion_mm").at("largest"),
            found.at("joint").at("by_landmarks_mm").at("largest"));
  int n = 0;
  for (const nlohmann::json& number : found.at("numbers")) n += number.at("part") == "functional" ? 1 : 0;
  EXPECT_EQ(n, 12);
  CalibrateOptions text = legs(2);
  text.has_json = false;
  EXPECT_THAT(report_of(text), HasSubstr("at least halved in "));
}

TEST_F(FunctionalStep, NeedsAMotionOfFlexion)
{
  CalibrateOptions without = legs(1);
  without.model.clear();
  EXPECT_THAT(refusal(without), test::refuses({.file = "--model"}));
  CalibrateOptions unsolved = legs(1);
  unsolved.model = model([](store::MotionModel& made) { test::unsolve(made, 3, 2); });
  unsolved.set = "raw";
  EXPECT_THAT(refusal(unsolved),
              test::refuses({.file = unsolved.model, .field = "flexion", .wanted = "--set"}));
  CalibrateOptions live = legs(0);
  live.is_virtual = false;
  EXPECT_THAT(refusal(live), test::refuses({.file = "--noise"}));
}

}  // namespace vrda::calibration::functional_step_test
