#include "bench/bench_run.hpp"

#include <gtest/gtest.h>

#include "bench_samples.hpp"

namespace vrda::recorded_motion_test {

/// Two samples per picture, with a delay of 3 ms.
bench::Recording recording_of(const Pose& start, const bench::Screw& a_second)
{
  bench::Recording recording;
  for (int k = 0; k < 100; ++k) {
    bench::RecordedFrame& picture = recording.frames.emplace_back();
    picture.now_ns = (20 * k + 20) * test::ms_in_ns;
    for (const int ms : {20 * k, 20 * k + 10}) {
      picture.samples.push_back(test::place_sample(0, test::moved(start, a_second, 0.001 * ms),
                                                   (5000 + ms) * test::ms_in_ns, (ms + 3) * test::ms_in_ns));
    }
  }
  return recording;
}

TEST(RecordedMotion, IsEveryPoseAtItsTime)
{
  const bench::Screw a_second{{0.5, -0.8, 0.3}, {200.0, -100.0, 50.0}};
  const Pose start = test::some_pose(3);
  const bench::BenchFile bench = test::SmallBench(test::rigid_text()).bench;
  const bench::Recording recording = recording_of(start, a_second);
  const std::vector<bench::TimedPose> motion = bench::recorded_motion(recording, bench, bench::BodyRole::leg);
  ASSERT_EQ(motion.size(), 200u);
  for (std::size_t k = 0; k < motion.size(); ++k) {
    EXPECT_NEAR(motion[k].time_s, 0.01 * static_cast<double>(k) + 0.003, 1e-9);
    EXPECT_LT(test::distance_of(motion[k].X, test::moved(start, a_second, 0.01 * static_cast<double>(k))),
              1e-9);
  }
  EXPECT_TRUE(bench::recorded_motion(recording, bench, bench::BodyRole::tibia).empty());
  // A constant twist is predicted exactly; the held pose has the error of the motion during the horizon.
  const std::vector<bench::BodyPrediction> predictions = bench::recorded_predictions(recording, bench);
  ASSERT_EQ(predictions.size(), 3u);
  EXPECT_EQ(predictions[1].horizon_ms, 33.0);
  EXPECT_LT(predictions[1].error.shift_mm.predicted.percentile_95, 1e-6);
  EXPECT_GT(predictions[1].error.shift_mm.held.rms, 1.0);
  EXPECT_NE(bench::prediction_text(predictions).find("leg after 33 ms"), std::string::npos);
}

}  // namespace vrda::recorded_motion_test
