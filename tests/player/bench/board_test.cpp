// The board client against the real firmware behind a pseudo-terminal: as a part of this program, and as the
// machine code of an ATmega328P in simavr.
#include <gtest/gtest.h>
#include <unistd.h>

#include <atomic>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <optional>
#include <random>

#include "core/text.hpp"
#include "player/bench/avr_board.hpp"
#include "player/bench/waiting.hpp"
#include "support/refusal.hpp"
#include "support/scratch.hpp"

#include "bench/board.h"

namespace vrda::board_test {

using test::is_link, test::take_until, test::wait_until;

bench::BoardSettings settings_for(const std::string& path)
{
  bench::BoardSettings settings;
  settings.port = path;
  settings.retry_ms = 5.0;
  return settings;
}

/// Either board.
class AnyBoard {
 public:
  AnyBoard(const std::string& kind, const bench::PtyBoardOptions& options) : kind_(kind), options_(options)
  {
    plug();
  }
  std::string path() const { return avr_ ? avr_->path() : simulated_->path(); }
  /// Removes the terminal; a board that is plugged again starts again.
  void unplug()
  {
    simulated_.reset();
    avr_.reset();
  }
  void plug()
  {
    if (kind_ == "atmega328p") {
      avr_.emplace(test::AvrBoardOptions{options_});
    } else {
      simulated_.emplace(options_);
    }
  }

 private:
  std::string kind_;
  bench::PtyBoardOptions options_;
  std::optional<bench::PtyBoard> simulated_;
  std::optional<test::AvrBoard> avr_;
};

bool is_up(const bench::Sample& sample)
{
  return is_link(sample, bench::DeviceId::board, bench::LinkState::up);
}
bool is_closed(const bench::Sample& sample)
{
  return is_link(sample, bench::DeviceId::board, bench::LinkState::closed);
}

/// A board with a knob, a stage, and a line that can corrupt bytes.
class Board : public testing::Test {
 protected:
  bench::PtyBoardOptions options(const std::string& link)
  {
    bench::PtyBoardOptions options;
    options.link = link;
    options.potentiometer = [this] { return knob_.load(); };
    options.stage_count = [this] { return stage_.load(); };
    options.corrupt = [this](std::vector<std::uint8_t>& bytes) { spoil(bytes); };
    return options;
  }
  bool await_stage(int count, int flags)
  {
    return take_until(*devices_, seen_, [=](const bench::Sample& s) {
      return s.kind == bench::SampleKind::stage && s.count == count && s.state == flags;
    });
  }
  bool await_knob(int value)
  {
    return take_until(*devices_, seen_, [=](const bench::Sample& s) {
      return s.kind == bench::SampleKind::potentiometer && s.count == value;
    });
  }
  void start(const std::string& kind = "simulated")
  {
    board_.emplace(kind, options((scratch_.path() / "board").string()));
    connect(board_->path());
  }
  void connect(const std::string& path)
  {
    devices_.emplace(std::nullopt, settings_for(path));
    ASSERT_TRUE(take_until(*devices_, seen_, is_up));
  }
  bench::DeviceReport report() const { return devices_->report(bench::DeviceId::board); }
  void spoil(std::vector<std::uint8_t>& bytes)
  {
    const int n = n_sent_++;
    if (is_silent_) bytes.clear();
    if (drops_ && n % 7 == 3 && !bytes.empty())
      bytes.erase(bytes.begin() + n % static_cast<int>(bytes.size()));
    if (drops_ && n % 7 == 4) bytes.insert(bytes.begin(), {'n', 'o', 'i', 's', 'e', 0xA5, 0x5A});
    if (drops_ && n % 7 == 5) bytes.insert(bytes.begin(), {0xA5, 0x5A, 'P', 16, 0xFF});
    if (drops_ && n % 7 == 6 && bytes.size() > 5) bytes[5] ^= 0x10;
    if (says_version_ != 1 && bytes.size() == 11 && bytes[2] == 'V') {
      bytes[4] = static_cast<std::uint8_t>(says_version_);
      const std::uint16_t crc = crc16(&bytes[2], 7);
      bytes[9] = static_cast<std::uint8_t>(crc & 0xFF);
      bytes[10] = static_cast<std::uint8_t>(crc >> 8);
    }
  }

  std::atomic<int> knob_{512}, stage_{0}, says_version_{1};
  std::atomic<bool> drops_{false}, is_silent_{false};
  std::atomic<int> n_sent_{0};
  test::Scratch scratch_;
  std::optional<AnyBoard> board_;
  std::optional<bench::Devices> devices_;
  std::vector<bench::Sample> seen_;
};

class BothBoards : public Board, public testing::WithParamInterface<std::string> {};

INSTANTIATE_TEST_SUITE_P(Kinds, BothBoards, testing::Values("simulated", "atmega328p"),
                         [](const auto& kind) { return kind.param; });

TEST_P(BothBoards, ReadKnobAndStage)
{
  start(GetParam());
  EXPECT_TRUE(await_knob(512));
  knob_ = 1023;
  EXPECT_TRUE(await_knob(1023));
  for (const int count : {1, -3, 20'000, -20'000, 0}) {
    stage_ = count;
    EXPECT_TRUE(await_stage(count, 0)) << count;
  }
  EXPECT_EQ(report().n_refused, 0U);
}

TEST_F(Board, LeavesLinksThatAreNotItsOwn)
{
  namespace fs = std::filesystem;
  const fs::path kept = scratch_.write("kept", "x"), link = scratch_.path() / "board";
  fs::create_symlink(kept, link);
  EXPECT_THAT(test::input_error([&] { const bench::PtyBoard board(options(link.string())); }),
              test::refuses({.field = link.string(), .found = kept.string()}));
  EXPECT_EQ(fs::read_symlink(link), kept);
  EXPECT_THAT(test::input_error([&] { const bench::PtyBoard board(options(kept.string())); }),
              test::refuses({.field = kept.string(), .found = "file"}));
  EXPECT_EQ(test::read_bytes(kept), "x");
  EXPECT_THROW(bench::PtyBoard(options((scratch_.path() / "no folder/board").string())), InputError);
  // A killed board leaves a link to a terminal; at the end another board may own the path.
  fs::remove(link);
  fs::create_symlink("/dev/pts/9999", link);
  {
    const bench::PtyBoard board(options(link.string()));
    EXPECT_NE(fs::read_symlink(link), "/dev/pts/9999");
    fs::remove(link);
    fs::create_symlink(kept, link);
  }
  EXPECT_EQ(fs::read_symlink(link), kept);
}

TEST_P(BothBoards, SetOnlyAStageThatIsUpToZero)
{
  start(GetParam());
  board_->unplug();
  EXPECT_TRUE(take_until(*devices_, seen_, is_closed));
  EXPECT_FALSE(devices_->zero_stage());
  board_->plug();
  bench::BoardSettings settings = settings_for(board_->path());
  settings.has_stage = false;
  devices_.emplace(std::nullopt, settings);
  EXPECT_TRUE(take_until(*devices_, seen_, is_up));
  EXPECT_FALSE(devices_->zero_stage());
  EXPECT_FALSE(bench::Devices(std::nullopt, std::nullopt).zero_stage());
}

TEST_P(BothBoards, ReconnectAtTheSameLinkAfterTheTerminalWasRemoved)
{
  start(GetParam());
  stage_ = 50;
  EXPECT_TRUE(await_stage(50, 0));
  board_->unplug();
  EXPECT_TRUE(take_until(*devices_, seen_, is_closed));
  EXPECT_TRUE(wait_until([&] { return report().error_message == "No such file or directory"; }));
  board_->plug();
  EXPECT_TRUE(take_until(*devices_, seen_, is_up));
  EXPECT_TRUE(await_stage(0, 0)) << "a restarted board has lost its position and its zero flag";
  stage_ = 60;
  EXPECT_TRUE(await_stage(10, 0));
}

TEST_P(BothBoards, LoseReadingsByNoiseAndDroppedBytesAndNothingElse)
{
  start(GetParam());
  drops_ = true;
  for (int value = 0; value < 100; ++value) {
    knob_ = value;
    ASSERT_TRUE(await_knob(value));
  }
  drops_ = false;
  EXPECT_GT(report().n_refused, 0U);
  EXPECT_EQ(report().n_connects, 1U);
  int n_wrong = 0;
  for (const bench::Sample& sample : seen_) {
    n_wrong += sample.kind == bench::SampleKind::stage && sample.count != 0 ? 1 : 0;
    n_wrong +=
        sample.kind == bench::SampleKind::potentiometer && sample.count > 99 && sample.count != 512 ? 1 : 0;
  }
  EXPECT_EQ(n_wrong, 0);
}

TEST_P(BothBoards, SayThatTheVersionIsAnother)
{
  says_version_ = 9;
  board_.emplace(GetParam(), options(""));
  devices_.emplace(std::nullopt, settings_for(board_->path()));
  EXPECT_TRUE(take_until(*devices_, seen_, is_closed));
  EXPECT_EQ(report().error_message, "found protocol version 9, wanted 1");
  says_version_ = 1;
  EXPECT_TRUE(take_until(*devices_, seen_, is_up));
  EXPECT_EQ(report().error_message, "");
}

TEST_P(BothBoards, AreReconnectedWhenTheyStopAnswering)
{
  start(GetParam());
  is_silent_ = true;
  EXPECT_TRUE(take_until(*devices_, seen_, is_closed));
  EXPECT_EQ(report().error_message, "found no answer for 1 s, wanted readings");
  is_silent_ = false;
  EXPECT_TRUE(take_until(*devices_, seen_, is_up));
  EXPECT_TRUE(await_knob(512));
}

TEST_F(Board, APortThatIsAFileIsReported)
{
  const bench::Devices devices(std::nullopt, settings_for(scratch_.write("file", "no terminal").string()));
  EXPECT_TRUE(wait_until([&] {
    return devices.report(bench::DeviceId::board).error_message == "Inappropriate ioctl for device";
  }));
}

double wanted_s()
{
  constexpr double usual_s = 8.0;
  const char* const given = std::getenv("VRDA_FIRMWARE_SECONDS");
  return given == nullptr ? usual_s : std::strtod(given, nullptr);
}

/// The machine code alone. VRDA_FIRMWARE_SECONDS: simulated time of the long run (scripts/firmware: ten
/// minutes).
class Firmware : public Board {
 protected:
  /// `is_paced`: in real time at most. The stage is set to zero.
  void start(bool is_paced)
  {
    test::AvrBoardOptions avr{options((scratch_.path() / "board").string())};
    avr.is_paced = is_paced;
    avr_.emplace(avr);
    connect(avr_->path());
    set_zero();
  }
  void set_zero()
  {
    ASSERT_TRUE(devices_->zero_stage());
    ASSERT_TRUE(await_stage(0, bench::stage_zeroed));
  }
  std::optional<test::AvrBoard> avr_;
};

/// Sweeps over the stage's whole rail and reversals within a few counts, always at 100,000 counts a second;
/// after each motion the position must be exact. Readings and the knob go on meanwhile.
TEST_F(Firmware, LosesNoCountAtAHundredThousandASecond)
{
  start(false);
  std::mt19937 random(20);
  constexpr int rail_counts = 120'000;  // 60 cm
  constexpr double counts_a_second = 100'000.0;
  std::uniform_int_distribution<int> anywhere(-rail_counts / 2, rail_counts / 2), nearby(-40, 40);
  double counted = 0.0;
  int n_motions = 0;
  for (; avr_->simulated_s() < wanted_s(); ++n_motions) {
    const int target = n_motions % 3 == 0 ? anywhere(random) : stage_ + nearby(random);
    counted += std::abs(target - stage_);
    stage_ = target;
    knob_ = n_motions % 1024;
    ASSERT_TRUE(await_stage(target, bench::stage_zeroed)) << n_motions;
    ASSERT_TRUE(await_knob(knob_)) << n_motions;
  }
  // At least a quarter of the time at full speed.
  EXPECT_GT(counted, 0.25 * counts_a_second * wanted_s());
  EXPECT_EQ(report().n_refused, 0U);
  EXPECT_EQ(report().n_connects, 1U);
  std::cout << n_motions << " motions, " << counted << " counts in " << avr_->simulated_s()
            << " simulated s\n";
}

/// The reset line: position and zero are lost, and said so; the serial line stays open.
TEST_F(Firmware, AResetLosesThePositionAndSaysSo)
{
  start(true);
  stage_ = 700;
  ASSERT_TRUE(await_stage(700, bench::stage_zeroed));
  avr_->reset();
  ASSERT_TRUE(await_stage(0, 0));
  stage_ = 650;
  EXPECT_TRUE(await_stage(-50, 0));
  set_zero();
  EXPECT_EQ(report().n_connects, 1U);
}

/// A step over two states has no direction: the count is marked as lost until the next zero.
TEST_F(Firmware, MarksALostCount)
{
  start(true);
  avr_->skip_state();
  EXPECT_TRUE(await_stage(0, bench::stage_zeroed | bench::stage_lost_counts));
  set_zero();
}

}  // namespace vrda::board_test
