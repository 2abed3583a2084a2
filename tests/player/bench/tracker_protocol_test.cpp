#include "bench/protocols.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace vrda::tracker_protocol_test {

constexpr std::int64_t ms = 1'000'000;

bench::TrackerSettings settings()
{
  bench::TrackerSettings settings;
  settings.tools = {"Femur", "Tibia"};
  return settings;
}

bench::IgtlMessage message(bench::IgtlKind kind, const std::string& device, std::int64_t device_ns,
                           const std::vector<std::string>& tools)
{
  bench::IgtlMessage message;
  message.kind = kind;
  message.device = device;
  message.device_ns = device_ns;
  for (const std::string& name : tools) {
    message.tools.push_back({name});
    // A pose that is measured again with each stamp.
    message.tools.back().X_tracker_tool.translation().x() = 1e-6 * static_cast<double>(device_ns);
  }
  return message;
}

bench::IgtlMessage femur(std::int64_t device_ns)
{
  return message(bench::IgtlKind::transform, "Femur", device_ns, {"Femur"});
}

/// Tool and state of each sample, as "0 seen 1 stale".
std::string summary(const std::vector<bench::Sample>& samples)
{
  static const char* const names[] = {"seen", "missing", "stale", "not_a_place"};
  std::string text;
  for (const bench::Sample& sample : samples)
    text += std::to_string(sample.source) + " " + names[sample.state] + " ";
  if (!text.empty()) text.pop_back();
  return text;
}

TEST(TrackerProtocol, PlacesCarryToolTimesAndPose)
{
  bench::TrackerProtocol protocol(settings(), 0);
  bench::IgtlMessage said = message(bench::IgtlKind::tdata, "Tracker", 42, {"Other", "Tibia", "Femur"});
  said.tools[1].X_tracker_tool.translation() = Eigen::Vector3d(1.0, 2.0, 3.0);
  const std::vector<bench::Sample> samples = protocol.receive(said, 7);
  ASSERT_EQ(summary(samples), "0 seen 1 seen");
  EXPECT_EQ(samples[1].arrival_ns, 7);
  EXPECT_EQ(samples[1].device_ns, 42);
  EXPECT_EQ(Eigen::Vector3d(bench::pose_of(samples[1].tool_pose).translation()),
            Eigen::Vector3d(1.0, 2.0, 3.0));
}

TEST(TrackerProtocol, AToolLeftOutOfItsListIsMissing)
{
  bench::TrackerProtocol protocol(settings(), 0);
  EXPECT_EQ(summary(protocol.receive(message(bench::IgtlKind::tdata, "Tracker", 1, {"Femur"}), 0)),
            "0 seen 1 missing")
      << "never heard of";
  EXPECT_EQ(summary(protocol.receive(message(bench::IgtlKind::tdata, "Tracker", 2, {"Femur", "Tibia"}), 1)),
            "0 seen 1 seen");
  EXPECT_EQ(summary(protocol.receive(message(bench::IgtlKind::tdata, "Second", 3, {"Stylus"}), 2)), "")
      << "another tracker's list";
  EXPECT_EQ(summary(protocol.receive(message(bench::IgtlKind::qtdata, "Tracker", 3, {}), 3)),
            "0 missing 1 missing");
  EXPECT_EQ(summary(protocol.receive(femur(4), 4)), "0 seen");
  EXPECT_EQ(summary(protocol.receive(message(bench::IgtlKind::tdata, "Tracker", 5, {"Tibia"}), 5)), "1 seen")
      << "the femur has messages of its own";
}

TEST(TrackerProtocol, AStatusOfAToolIsAboutIt)
{
  bench::TrackerProtocol protocol(settings(), 0);
  bench::IgtlMessage status = message(bench::IgtlKind::status, "Tibia", 1, {});
  EXPECT_EQ(summary(protocol.receive(status, 0)), "");
  EXPECT_EQ(bench::error_text_of(status), "");
  status.code = 16;
  status.text = "not present";
  EXPECT_EQ(summary(protocol.receive(status, 1)), "1 missing");
  EXPECT_EQ(bench::error_text_of(status), "Tibia: status 16 (not present)");
  status.device = "Tracker";
  EXPECT_EQ(summary(protocol.receive(status, 2)), "");
  bench::IgtlMessage refusal = message(bench::IgtlKind::tdata_started, "Tracker", 1, {});
  EXPECT_EQ(bench::error_text_of(refusal), "Tracker: refuses to stream TDATA");
  refusal.code = 0;
  EXPECT_EQ(bench::error_text_of(refusal), "");
}

/// The states at the end of three periods of 150 ms: the tibia is absent, the clock does not advance,
/// silence.
std::string course(bench::IgtlKind kind)
{
  bench::TrackerProtocol protocol(settings(), 0);
  const bool is_list = kind == bench::IgtlKind::tdata || kind == bench::IgtlKind::qtdata;
  std::vector<std::string> state{"none", "none"};
  std::string text;
  const auto take = [&](const std::vector<bench::Sample>& samples) {
    for (const bench::Sample& sample : samples) state[sample.source] = summary({sample}).substr(2);
  };
  const auto send = [&](std::int64_t now_ms, const std::vector<std::string>& tools, std::int64_t stamp) {
    if (is_list) take(protocol.receive(message(kind, "Tracker", stamp, tools), now_ms * ms));
    for (const std::string& tool : tools)
      if (!is_list) take(protocol.receive(message(kind, tool, stamp, {tool}), now_ms * ms));
    take(protocol.stale_samples(now_ms * ms));
  };
  for (std::int64_t now_ms = 10; now_ms <= 900; now_ms += 10) {
    const std::int64_t phase = (now_ms - 1) / 150;
    const bool is_whole = phase % 2 == 0;
    if (phase < 5) {
      send(now_ms,
           is_whole || phase != 1 ? std::vector<std::string>{"Femur", "Tibia"}
                                  : std::vector<std::string>{"Femur"},
           phase == 3 ? 450 : now_ms);
    } else {
      take(protocol.stale_samples(now_ms * ms));
    }
    if (now_ms % 150 == 0) text += state[0] + " " + state[1] + "; ";
  }
  return text;
}

TEST(TrackerProtocol, AbsentAndStaleMeanTheSameForEveryType)
{
  for (const bench::IgtlKind kind : {bench::IgtlKind::transform, bench::IgtlKind::position,
                                     bench::IgtlKind::tdata, bench::IgtlKind::qtdata}) {
    SCOPED_TRACE(static_cast<int>(kind));
    EXPECT_EQ(course(kind), "seen seen; seen missing; seen seen; stale stale; seen seen; stale stale; ");
  }
}

TEST(TrackerProtocol, AFrozenListIsStaleForAToolThatItLacks)
{
  bench::TrackerProtocol protocol(settings(), 0);
  EXPECT_EQ(summary(protocol.receive(message(bench::IgtlKind::tdata, "Tracker", 1, {"Femur"}), 0)),
            "0 seen 1 missing");
  EXPECT_EQ(summary(protocol.receive(message(bench::IgtlKind::tdata, "Tracker", 1, {"Femur"}), 50 * ms)), "");
  EXPECT_EQ(summary(protocol.stale_samples(100 * ms)), "0 stale 1 stale");
}

/// One message of the femur every 10 ms from `from_ms`, with advancing stamps; the state of the last sample.
std::string last_state(bench::TrackerProtocol& protocol, bench::IgtlMessage said, std::int64_t from_ms,
                       std::int64_t n, bool is_jittering)
{
  std::string state;
  for (std::int64_t k = 0; k < n; ++k) {
    said.device_ns = (from_ms + 10 * k + 1) * ms;
    if (is_jittering) said.tools[0].X_tracker_tool.translation().y() = 0.01 * static_cast<double>(k % 7);
    state = summary(protocol.receive(said, (from_ms + 10 * k) * ms));
  }
  return state;
}

/// What a server does with a hidden tool in header version 1: it repeats the last pose, or sends the
/// identity.
TEST(TrackerProtocol, ATrackedPoseThatFreezesIsHiddenUnlessTheServerStatesIt)
{
  struct Row {
    const char* name;
    bool has_jittered, becomes_identity, is_stated;
    const char *after_400_ms, *after_600_ms, *note;
  };
  for (const Row& row :
       {Row{"frozen", true, false, false, "0 seen", "0 stale", "taken as hidden"},
        Row{"identity", true, true, false, "0 seen", "0 stale", "taken as hidden"},
        Row{"identity from the start", false, true, false, "0 seen", "0 stale", "taken as hidden"},
        Row{"fixed from the start", false, false, false, "0 seen", "0 seen", "have not changed"},
        Row{"stated as seen", true, false, true, "0 seen", "0 seen", "the server states"},
        Row{"fixed and stated", false, false, true, "0 seen", "0 seen", nullptr}}) {
    for (const bench::IgtlKind kind : {bench::IgtlKind::transform, bench::IgtlKind::position,
                                       bench::IgtlKind::tdata, bench::IgtlKind::qtdata}) {
      SCOPED_TRACE(row.name);
      bench::TrackerProtocol protocol(settings(), 0);
      bench::IgtlMessage said = message(kind, "Femur", 1, {"Femur"});
      said.tools[0].is_stated = row.is_stated;
      said.tools[0].X_tracker_tool.translation() = Eigen::Vector3d(10.0, 20.0, 30.0);
      last_state(protocol, said, 0, row.has_jittered ? 100 : 0, true);
      EXPECT_TRUE(protocol.notes().empty());
      if (row.becomes_identity) said.tools[0].X_tracker_tool.setIdentity();
      EXPECT_THAT(last_state(protocol, said, 1000, 40, false), testing::StartsWith(row.after_400_ms));
      EXPECT_THAT(last_state(protocol, said, 1400, 20, false), testing::StartsWith(row.after_600_ms));
      EXPECT_THAT(protocol.notes(), row.note == nullptr
                                        ? testing::Matcher<std::vector<std::string>>(testing::IsEmpty())
                                        : testing::ElementsAre(testing::HasSubstr(row.note)));
      EXPECT_THAT(last_state(protocol, said, 1600, 3, true), testing::StartsWith("0 seen"));
      EXPECT_TRUE(protocol.notes().empty());
    }
  }
}

/// 3 s of a moving tool at 30 Hz, with stamps that do not follow it.
TEST(TrackerProtocol, StampsThatDoNotFollowThePosesAreReplacedByArrivals)
{
  struct Row {
    const char* name;
    std::int64_t (*stamp_ms)(std::int64_t now_ms);
    int least_seen;  ///< of 90
    bool uses_stamps;
    const char* note;
  };
  for (const Row& row :
       {Row{"good", [](std::int64_t t) { return t; }, 90, true, nullptr},
        Row{"since the start", [](std::int64_t t) { return t - 999; }, 90, true, nullptr},
        Row{"ahead", [](std::int64_t t) { return t + 3'600'000; }, 90, true, nullptr},
        Row{"zero", [](std::int64_t) { return std::int64_t{0}; }, 90, false, "no time stamps"},
        Row{"same", [](std::int64_t) { return std::int64_t{1000}; }, 80, false, "do not advance"},
        Row{"whole seconds", [](std::int64_t t) { return t / 1000 * 1000; }, 80, false, "do not advance"},
        Row{"tenths", [](std::int64_t t) { return t / 100 * 100; }, 70, false, "do not advance"},
        Row{"each twice", [](std::int64_t t) { return t / 66 * 66; }, 70, false, "do not advance"},
        Row{"back and forth", [](std::int64_t t) { return t % 2 == 0 ? t : t - 500; }, 70, false,
            "do not advance"},
        Row{"set back", [](std::int64_t t) { return t < 2500 ? t : t - 1500; }, 80, true, "went back"}}) {
    SCOPED_TRACE(row.name);
    bench::TrackerProtocol protocol(settings(), 0);
    int n_seen = 0;
    std::int64_t stamp_ns = 0;
    for (std::int64_t k = 0; k < 90; ++k) {
      const std::int64_t now_ms = 1000 + 33 * k;
      bench::IgtlMessage said = femur(row.stamp_ms(now_ms) * ms);
      said.tools[0].X_tracker_tool.translation().x() = static_cast<double>(k);
      for (const bench::Sample& sample : protocol.receive(said, now_ms * ms)) {
        n_seen += sample.is(bench::ToolVisibility::seen) ? 1 : 0;
        stamp_ns = sample.device_ns;
      }
    }
    EXPECT_GE(n_seen, row.least_seen);
    EXPECT_EQ(stamp_ns != 0, row.uses_stamps);
    EXPECT_THAT(protocol.notes(), row.note == nullptr
                                      ? testing::Matcher<std::vector<std::string>>(testing::IsEmpty())
                                      : testing::ElementsAre(testing::HasSubstr(row.note)));
  }
}

}  // namespace vrda::tracker_protocol_test
