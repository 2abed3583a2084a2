// The board client against the real firmware behind a pseudo-terminal: as a part of this program, and as the
// machine code of an ATmega328P in simavr.
#include <gtest/gtest.h>
#include <unistd.h>

#include <atomic>
#include <filesystem>
#include <fstream>
#include <optional>

#include "bench/simulated_devices.hpp"
#include "core/text.hpp"
#include "player/bench/avr_board.hpp"
#include "player/bench/waiting.hpp"
#include "support/refusal.hpp"
#include "support/scratch.hpp"

#include "bench/board.h"

namespace vrda::board_test {

using test::is_link;
using test::take_until;
using test::wait_until;

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
  AnyBoard(const std::string& kind, const bench::PtyBoardOptions& options)
  {
    if (kind == "atmega328p") {
      avr_.emplace(test::AvrBoardOptions{options});
    } else {
      simulated_.emplace(options);
    }
  }
  std::string path() const { return avr_ ? avr_->path() : simulated_->path(); }
  void unplug() { avr_ ? avr_->unplug() : simulated_->unplug(); }
  void plug() { avr_ ? avr_->plug() : simulated_->plug(); }
  void send_unrequested(const std::vector<std::uint8_t>& bytes)
  {
    avr_ ? avr_->send_unrequested(bytes) : simulated_->send_unrequested(bytes);
  }

 private:
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
    devices_.emplace(std::nullopt, settings_for(board_->path()));
    ASSERT_TRUE(take_until(*devices_, seen_, is_up));
  }
  void spoil(std::vector<std::uint8_t>& bytes)
  {
    const int n = n_sent_++;
    if (is_silent_) bytes.clear();
    if (drops_ && n % 7 == 3 && !bytes.empty())
      bytes.erase(bytes.begin() + n % static_cast<int>(bytes.size()));
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
  EXPECT_EQ(devices_->report(bench::DeviceId::board).n_refused, 0U);
}

TEST_F(Board, LeavesLinksThatAreNotItsOwn)
{
  namespace fs = std::filesystem;
  const fs::path kept = scratch_.write("kept", "x"), link = scratch_.path() / "board";
  fs::create_symlink(kept, link);
  EXPECT_THAT(test::input_error([&] { const bench::PtyBoard board(options(link.string())); }),
              test::refuses({.field = link.string(), .found = kept.string()}));
  EXPECT_EQ(fs::read_symlink(link), kept);
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

TEST_P(BothBoards, SetTheStageToZero)
{
  start(GetParam());
  stage_ = 300;
  EXPECT_TRUE(await_stage(300, 0));
  EXPECT_TRUE(devices_->zero_stage());
  EXPECT_TRUE(await_stage(0, bench::stage_zeroed));
  stage_ = 200;
  EXPECT_TRUE(await_stage(-100, bench::stage_zeroed));
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
  EXPECT_TRUE(wait_until(
      [&] { return devices_->report(bench::DeviceId::board).error_message == "No such file or directory"; }));
  board_->plug();
  EXPECT_TRUE(take_until(*devices_, seen_, is_up));
  EXPECT_TRUE(await_stage(0, 0)) << "a restarted board has lost its position and its zero flag";
  stage_ = 60;
  EXPECT_TRUE(await_stage(10, 0));
}

TEST_F(Board, ASecondBoardAtTheSameLinkIsFound)
{
  start();
  board_.reset();
  EXPECT_TRUE(take_until(*devices_, seen_, is_closed));
  board_.emplace("simulated", options((scratch_.path() / "board").string()));
  EXPECT_TRUE(take_until(*devices_, seen_, is_up));
  EXPECT_TRUE(await_knob(512));
}

TEST_P(BothBoards, LoseReadingsByNoiseAndDroppedBytesAndNothingElse)
{
  start(GetParam());
  drops_ = true;
  board_->send_unrequested({'n', 'o', 'i', 's', 'e', 0xA5, 0x5A});
  for (int value = 0; value < 100; ++value) {
    knob_ = value;
    ASSERT_TRUE(await_knob(value));
  }
  drops_ = false;
  EXPECT_GT(devices_->report(bench::DeviceId::board).n_refused, 0U);
  EXPECT_EQ(devices_->report(bench::DeviceId::board).n_connects, 1U);
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
  EXPECT_EQ(devices_->report(bench::DeviceId::board).error_message, "found protocol version 9, wanted 1");
  says_version_ = 1;
  EXPECT_TRUE(take_until(*devices_, seen_, is_up));
  EXPECT_EQ(devices_->report(bench::DeviceId::board).error_message, "");
}

TEST_P(BothBoards, AreReconnectedWhenTheyStopAnswering)
{
  start(GetParam());
  is_silent_ = true;
  EXPECT_TRUE(take_until(*devices_, seen_, is_closed));
  EXPECT_EQ(devices_->report(bench::DeviceId::board).error_message,
            "found no answer for 1 s, wanted readings");
  is_silent_ = false;
  EXPECT_TRUE(take_until(*devices_, seen_, is_up));
  EXPECT_TRUE(await_knob(512));
}

TEST_F(Board, SaysWhyAPortCannotBeOpened)
{
  bench::BoardSettings settings;
  settings.port = (scratch_.path() / "none").string();
  settings.retry_ms = 1.0;
  const bench::Devices none(std::nullopt, settings);
  EXPECT_TRUE(wait_until(
      [&] { return none.report(bench::DeviceId::board).error_message == "No such file or directory"; }));
  settings.port = (scratch_.path() / "file").string();
  std::ofstream(settings.port) << "no terminal";
  const bench::Devices file(std::nullopt, settings);
  EXPECT_TRUE(wait_until(
      [&] { return file.report(bench::DeviceId::board).error_message == "Inappropriate ioctl for device"; }));
}

TEST_F(Board, AFileIsNotReplacedByALink)
{
  const std::string path = (scratch_.path() / "file").string();
  std::ofstream(path) << "precious";
  EXPECT_THAT(test::input_error([&] { bench::PtyBoard board(options(path)); }),
              test::refuses({.field = path, .found = "file"}));
  EXPECT_TRUE(std::filesystem::is_regular_file(path));
  EXPECT_THROW(bench::PtyBoard(options((scratch_.path() / "no folder/board").string())), InputError);
}

}  // namespace vrda::board_test
