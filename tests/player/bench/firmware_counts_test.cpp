// The machine code of the ATmega328P's firmware: encoder at 100,000 counts a second, converter and resets,
// against the player's board client. VRDA_FIRMWARE_SECONDS: simulated time of the long run (scripts/firmware:
// ten minutes).
#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <cstdlib>
#include <random>

#include "player/bench/avr_board.hpp"
#include "player/bench/waiting.hpp"
#include "support/scratch.hpp"

namespace vrda::firmware_counts_test {

double wanted_s()
{
  constexpr double usual_s = 20.0;
  const char* const given = std::getenv("VRDA_FIRMWARE_SECONDS");
  return given == nullptr ? usual_s : std::strtod(given, nullptr);
}

class Firmware : public testing::Test {
 protected:
  /// `is_paced`: in real time at most.
  void start(bool is_paced)
  {
    test::AvrBoardOptions options;
    options.is_paced = is_paced;
    options.signals.link = (scratch_.path() / "board").string();
    options.signals.potentiometer = [this] { return knob_.load(); };
    options.signals.stage_count = [this] { return stage_.load(); };
    board_.emplace(options);
    bench::BoardSettings settings;
    settings.port = board_->path();
    settings.retry_ms = 5.0;
    devices_.emplace(std::nullopt, settings);
    ASSERT_TRUE(await([](const bench::Sample& s) {
      return test::is_link(s, bench::DeviceId::board, bench::LinkState::up);
    }));
  }

  template <class Fits>
  bool await(Fits fits)
  {
    seen_.clear();
    return test::take_until(*devices_, seen_, fits);
  }
  testing::AssertionResult await_stage(int count, int flags)
  {
    const bool has_come = await([=](const bench::Sample& s) {
      return s.kind == bench::SampleKind::stage && s.count == count && s.state == flags;
    });
    if (has_come) return testing::AssertionSuccess();
    testing::AssertionResult missing = testing::AssertionFailure();
    missing << "wanted count " << count << " with flags " << flags << "; last of " << seen_.size()
            << " samples:";
    for (std::size_t k = seen_.size() - std::min<std::size_t>(seen_.size(), 20); k < seen_.size(); ++k)
      missing << "\n  kind " << static_cast<int>(seen_[k].kind) << ", count " << seen_[k].count << ", state "
              << static_cast<int>(seen_[k].state);
    return missing;
  }
  bool await_knob(int value)
  {
    return await([=](const bench::Sample& s) {
      return s.kind == bench::SampleKind::potentiometer && s.count == value;
    });
  }

  test::Scratch scratch_;
  std::atomic<int> knob_{512}, stage_{0};
  std::optional<test::AvrBoard> board_;
  std::optional<bench::Devices> devices_;
  std::vector<bench::Sample> seen_;
};

/// Sweeps over the stage's whole rail and reversals within a few counts, always at 100,000 counts a second;
/// after each motion the position must be exact. Readings and the knob go on meanwhile.
TEST_F(Firmware, LosesNoCountAtAHundredThousandASecond)
{
  start(false);
  ASSERT_TRUE(devices_->zero_stage());
  ASSERT_TRUE(await_stage(0, bench::stage_zeroed));
  std::mt19937 random(20);
  constexpr int rail_counts = 120'000;  // 60 cm
  constexpr double counts_a_second = 100'000.0;
  std::uniform_int_distribution<int> anywhere(-rail_counts / 2, rail_counts / 2), nearby(-40, 40);
  double counted = 0.0;
  int n_motions = 0;
  for (; board_->simulated_s() < wanted_s(); ++n_motions) {
    const int target = n_motions % 3 == 0 ? anywhere(random) : stage_ + nearby(random);
    counted += std::abs(target - stage_);
    stage_ = target;
    knob_ = n_motions % 1024;
    ASSERT_TRUE(await_stage(target, bench::stage_zeroed)) << n_motions;
    ASSERT_TRUE(await_knob(knob_)) << n_motions;
  }
  // At least a quarter of the time at full speed.
  EXPECT_GT(counted, 0.25 * counts_a_second * wanted_s());
  EXPECT_EQ(devices_->report(bench::DeviceId::board).n_refused, 0U);
  EXPECT_EQ(devices_->report(bench::DeviceId::board).n_connects, 1U);
  std::cout << n_motions << " motions, " << counted << " counts in " << board_->simulated_s()
            << " simulated s\n";
}

/// The reset line: position and zero are lost, and said so; the serial line stays open.
TEST_F(Firmware, AResetLosesThePositionAndSaysSo)
{
  start(true);
  ASSERT_TRUE(devices_->zero_stage());
  ASSERT_TRUE(await_stage(0, bench::stage_zeroed));
  stage_ = 700;
  ASSERT_TRUE(await_stage(700, bench::stage_zeroed));
  board_->reset();
  ASSERT_TRUE(await_stage(0, 0));
  stage_ = 650;
  EXPECT_TRUE(await_stage(-50, 0));
  ASSERT_TRUE(devices_->zero_stage());
  EXPECT_TRUE(await_stage(0, bench::stage_zeroed));
  EXPECT_EQ(devices_->report(bench::DeviceId::board).n_connects, 1U);
}

/// A step over two states has no direction: the count is marked as lost until the next zero.
TEST_F(Firmware, MarksALostCount)
{
  start(true);
  ASSERT_TRUE(devices_->zero_stage());
  ASSERT_TRUE(await_stage(0, bench::stage_zeroed));
  board_->skip_state();
  EXPECT_TRUE(await_stage(0, bench::stage_zeroed | bench::stage_lost_counts));
  ASSERT_TRUE(devices_->zero_stage());
  EXPECT_TRUE(await_stage(0, bench::stage_zeroed));
}

/// Every count of the converter, from end to end.
TEST_F(Firmware, ConvertsTheKnobFromEndToEnd)
{
  start(true);
  for (const int value : {0, 1, 2, 511, 512, 1022, 1023}) {
    knob_ = value;
    EXPECT_TRUE(await_knob(value)) << value;
  }
}

}  // namespace vrda::firmware_counts_test
