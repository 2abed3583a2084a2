#include "devices/tracker_talk.hpp"

#include <gtest/gtest.h>

namespace vrda::tracker_talk_test {

constexpr std::int64_t ms = 1'000'000;

TrackerSettings settings()
{
  TrackerSettings settings;
  settings.tools = {"Femur", "Tibia"};
  return settings;
}

IgtlMessage message(IgtlKind kind, const std::string& device, std::int64_t device_ns,
                    const std::vector<std::string>& tools)
{
  IgtlMessage message;
  message.kind = kind;
  message.device = device;
  message.device_ns = device_ns;
  for (const std::string& name : tools) message.tools.push_back({name});
  return message;
}

IgtlMessage femur(std::int64_t device_ns)
{
  return message(IgtlKind::transform, "Femur", device_ns, {"Femur"});
}

/// Tool and state of each sample, as "0 seen 1 stale".
std::string summary(const std::vector<Sample>& samples)
{
  static const char* const names[] = {"seen", "missing", "stale", "not_a_place"};
  std::string text;
  for (const Sample& sample : samples)
    text += std::to_string(sample.source) + " " + names[sample.state] + " ";
  if (!text.empty()) text.pop_back();
  return text;
}

TEST(ToolWatch, AClockThatStandsStillIsNothingNew)
{
  ToolWatch watch(100 * ms, 0);
  EXPECT_EQ(watch.hear(5, 10 * ms), ToolWatch::Heard::counts);
  for (int n = 2; n < 11; ++n) EXPECT_EQ(watch.hear(5, 10 * n * ms), ToolWatch::Heard::repeated);
  EXPECT_FALSE(watch.falls_stale(110 * ms - 1));
  EXPECT_TRUE(watch.falls_stale(110 * ms));
  EXPECT_FALSE(watch.falls_stale(210 * ms - 1));
  EXPECT_TRUE(watch.falls_stale(210 * ms)) << "it is said again";
  EXPECT_EQ(watch.hear(6, 215 * ms), ToolWatch::Heard::counts);
}

TEST(ToolWatch, AClockSetBackIsBelievedWhenItGoesOn)
{
  ToolWatch watch(100 * ms, 0);
  EXPECT_EQ(watch.hear(1000, 0), ToolWatch::Heard::counts);
  for (int n = 1; n < ToolWatch::n_to_believe; ++n) {
    EXPECT_EQ(watch.hear(500 + n, n * ms), ToolWatch::Heard::behind);
    EXPECT_EQ(watch.hear(500 + n, n * ms), ToolWatch::Heard::behind) << "a repeated stamp is no news";
  }
  EXPECT_EQ(watch.hear(600, 50 * ms), ToolWatch::Heard::counts);
  EXPECT_EQ(watch.hear(601, 51 * ms), ToolWatch::Heard::counts);
}

TEST(ToolWatch, AClockThatStumblesGoesOnFromWhereItWas)
{
  ToolWatch watch(100 * ms, 0);
  EXPECT_EQ(watch.hear(1000, 0), ToolWatch::Heard::counts);
  EXPECT_EQ(watch.hear(900, 1), ToolWatch::Heard::behind);
  EXPECT_EQ(watch.hear(1001, 2), ToolWatch::Heard::counts);
  for (int n = 0; n < 100; ++n)  // alternating stamps are not a clock
    EXPECT_EQ(watch.hear(n % 2 == 0 ? 500 : 400, 3 + n), ToolWatch::Heard::behind);
  EXPECT_TRUE(watch.falls_stale(100 * ms + 2));
}

TEST(ToolWatch, NoStampAlwaysCounts)
{
  ToolWatch watch(100 * ms, 0);
  for (int n = 0; n < 5; ++n) EXPECT_EQ(watch.hear(0, n), ToolWatch::Heard::counts);
}

TEST(TrackerTalk, PlacesCarryToolTimesAndPose)
{
  TrackerTalk talk(settings(), 0);
  IgtlMessage said = message(IgtlKind::tdata, "Tracker", 42, {"Other", "Tibia", "Femur"});
  said.tools[1].X_tracker_tool.translation() = Eigen::Vector3d(1.0, 2.0, 3.0);
  const std::vector<Sample> samples = talk.hear(said, 7);
  ASSERT_EQ(summary(samples), "0 seen 1 seen");
  EXPECT_EQ(samples[1].arrival_ns, 7);
  EXPECT_EQ(samples[1].device_ns, 42);
  EXPECT_EQ(Eigen::Vector3d(pose_of(samples[1].place).translation()), Eigen::Vector3d(1.0, 2.0, 3.0));
}

TEST(TrackerTalk, AToolLeftOutOfItsListIsMissing)
{
  TrackerTalk talk(settings(), 0);
  EXPECT_EQ(summary(talk.hear(message(IgtlKind::tdata, "Tracker", 1, {"Femur"}), 0)), "0 seen 1 missing")
      << "never heard of";
  EXPECT_EQ(summary(talk.hear(message(IgtlKind::tdata, "Tracker", 2, {"Femur", "Tibia"}), 1)),
            "0 seen 1 seen");
  EXPECT_EQ(summary(talk.hear(message(IgtlKind::tdata, "Second", 3, {"Stylus"}), 2)), "")
      << "another tracker's list";
  EXPECT_EQ(summary(talk.hear(message(IgtlKind::qtdata, "Tracker", 3, {}), 3)), "0 missing 1 missing");
  EXPECT_EQ(summary(talk.hear(femur(4), 4)), "0 seen");
  EXPECT_EQ(summary(talk.hear(message(IgtlKind::tdata, "Tracker", 5, {"Tibia"}), 5)), "1 seen")
      << "the femur has messages of its own";
}

TEST(TrackerTalk, AStatusOfAToolIsAboutIt)
{
  TrackerTalk talk(settings(), 0);
  IgtlMessage status = message(IgtlKind::status, "Tibia", 1, {});
  EXPECT_EQ(summary(talk.hear(status, 0)), "");
  EXPECT_EQ(trouble_of(status), "");
  status.code = 16;
  status.text = "not present";
  EXPECT_EQ(summary(talk.hear(status, 1)), "1 missing");
  EXPECT_EQ(trouble_of(status), "Tibia: status 16 (not present)");
  status.device = "Tracker";
  EXPECT_EQ(summary(talk.hear(status, 2)), "");
  IgtlMessage refusal = message(IgtlKind::tdata_started, "Tracker", 1, {});
  EXPECT_EQ(trouble_of(refusal), "Tracker: refuses to stream TDATA");
  refusal.code = 0;
  EXPECT_EQ(trouble_of(refusal), "");
}

TEST(TrackerTalk, WhatIsNoPlaceAndWhatIsMissingIsNoSilence)
{
  TrackerTalk talk(settings(), 0);
  IgtlMessage said = femur(1);
  said.tools[0].sight = IgtlSight::not_a_place;
  EXPECT_EQ(summary(talk.hear(said, 90 * ms)), "0 not_a_place");
  EXPECT_EQ(summary(talk.pass_time(110 * ms)), "1 stale");
  said.tools[0].sight = IgtlSight::missing;
  EXPECT_EQ(summary(talk.hear(said, 180 * ms)), "0 missing");
  EXPECT_EQ(summary(talk.pass_time(200 * ms)), "");
  EXPECT_EQ(summary(talk.pass_time(280 * ms)), "0 stale 1 stale");
}

TEST(TrackerTalk, AClockSetBackIsStaleUntilItIsBelieved)
{
  TrackerTalk talk(settings(), 0);
  EXPECT_EQ(summary(talk.hear(femur(1000), 0)), "0 seen");
  EXPECT_EQ(summary(talk.hear(femur(1000), 1)), "") << "nothing new";
  for (int n = 1; n < ToolWatch::n_to_believe; ++n) EXPECT_EQ(summary(talk.hear(femur(n), n)), "0 stale");
  EXPECT_EQ(summary(talk.hear(femur(100), 9)), "0 seen");
}

}  // namespace vrda::tracker_talk_test
