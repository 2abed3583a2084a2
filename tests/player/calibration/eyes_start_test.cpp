#include "calibration/eyes_fit.hpp"

#include <gtest/gtest.h>

#include <random>

namespace vrda::eyes_start_test {

EyePair some_eyes()
{
  EyePair eyes;
  for (Eye* eye : {&eyes.left, &eyes.right}) {
    eye->sight_px = eye->distortion.centre_px = {320.0, 240.0};
    eye->distance_px = 870.0;
    eye->pixel_aspect = eye->distortion.pixel_aspect = 1.02;
    eye->distortion.k1 = 0.1;
  }
  set_ipd(eyes, 64.0);
  return eyes;
}

Pose random_pose(std::mt19937_64& random)
{
  std::normal_distribution<double> any;
  Pose X = Pose::Identity();
  X.linear() =
      Eigen::Quaterniond(any(random), any(random), any(random), any(random)).normalized().toRotationMatrix();
  X.translation() = 300.0 * Eigen::Vector3d(any(random), any(random), any(random));
  return X;
}

TEST(EyesStart, FindsEyesInAnyAttitudeNearEnoughForTheFit)
{
  // The fit takes a guess within 20 degrees and half a metre; sights that are off by 3 px and half a pixel of
  // noise turn the answer by less than a degree and shift it by some percent of a metre.
  constexpr double most_deg = 5.0, most_mm = 60.0;
  std::mt19937_64 random(11);
  std::uniform_real_distribution<double> part(-1.0, 1.0);
  std::normal_distribution<double> noise;
  for (int trial = 0; trial < 60; ++trial) {
    const EyePair eyes = some_eyes();
    EyePair true_eyes = eyes;
    for (Eye* eye : {&true_eyes.left, &true_eyes.right})
      eye->sight_px += 3.0 * Eigen::Vector2d(noise(random), noise(random));
    const Pose X_carrier_eyes = random_pose(random);
    std::vector<BullseyeMark> marks;
    for (int k = 0; k < 9; ++k) {
      const double z_mm = -750.0 + 250.0 * part(random);
      const Eigen::Vector3d p_eyes_mm(-0.25 * z_mm * part(random), -0.2 * z_mm * part(random), z_mm);
      for (const bool is_right : {false, true}) {
        const Eye& eye = is_right ? true_eyes.right : true_eyes.left;
        BullseyeMark mark;
        mark.is_right = is_right;
        mark.p_carrier_mm = X_carrier_eyes * p_eyes_mm;
        mark.drawn_px = drawn_px(eye, p_eyes_mm) + 0.5 * Eigen::Vector2d(noise(random), noise(random));
        marks.push_back(mark);
      }
    }
    const Pose found = eyes_start(marks, eyes);
    const Eigen::Quaterniond apart(Eigen::Matrix3d(found.linear().transpose() * X_carrier_eyes.linear()));
    EXPECT_LT(apart.angularDistance(Eigen::Quaterniond::Identity()) * 180.0 / 3.14159265358979, most_deg);
    EXPECT_LT((found.translation() - X_carrier_eyes.translation()).norm(), most_mm);
  }
}

TEST(EyesStart, OfTwoMarksIsNowhere)
{
  EXPECT_TRUE(eyes_start(std::vector<BullseyeMark>(2), some_eyes()).isApprox(Pose::Identity()));
}

}  // namespace vrda::eyes_start_test
