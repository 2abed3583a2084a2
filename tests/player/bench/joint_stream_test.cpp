#include "bench/joint_stream.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>

#include "bench_samples.hpp"
#include "model/frames.hpp"

namespace vrda::joint_stream_test {

using test::ms_in_ns;

bench::Sample probe_sample(std::size_t tool, bench::ToolVisibility state, std::int64_t arrival_ns)
{
  bench::Sample sample;
  sample.kind = bench::SampleKind::tool_pose;
  sample.source = static_cast<std::uint16_t>(tool);
  sample.state = static_cast<std::uint8_t>(state);
  sample.arrival_ns = arrival_ns;
  sample.tool_pose = bench::place_of(test::some_pose(1));
  return sample;
}

TEST(JointStream, AProbeThatIsNoLongerSeenIsMarked)
{
  test::SmallBench bench(test::two_bodies_text() + "[calibration]\n");
  const std::vector<std::string>& tools = bench.bench.tracker->tools;
  const auto tool = static_cast<std::size_t>(std::ranges::find(tools, "probe") - tools.begin());
  ASSERT_LT(tool, tools.size());
  bench::ProbeTool probe(bench.bench, bench.calibration);
  const auto marks_at = [&](std::int64_t now_ns) {
    bench::StreamedFrame streamed;
    streamed.X_tracker_probe = probe.X_tracker_probe();
    streamed.probe = probe.status(now_ns);
    return bench::angles_text(streamed, Side::right, Eigen::Vector3d::Zero());
  };
  const auto names_probe = testing::HasSubstr("probe");
  EXPECT_THAT(marks_at(0), testing::Not(names_probe)) << "not used yet";
  probe.take(probe_sample(tool, bench::ToolVisibility::seen, ms_in_ns));
  EXPECT_TRUE(probe.X_tracker_probe());
  EXPECT_THAT(marks_at(ms_in_ns), testing::Not(names_probe));
  probe.take(probe_sample(tool, bench::ToolVisibility::missing, 2 * ms_in_ns));
  EXPECT_FALSE(probe.X_tracker_probe());
  EXPECT_THAT(marks_at(2001 * ms_in_ns), testing::HasSubstr("probe hidden for 2 s"));
  probe.take(probe_sample(tool, bench::ToolVisibility::seen, 2001 * ms_in_ns));
  EXPECT_THAT(marks_at(2001 * ms_in_ns), testing::Not(names_probe));
}

}  // namespace vrda::joint_stream_test
