// The main loop, with a mode that counts its rounds.
#include "show/loop.hpp"

#include <gtest/gtest.h>

#include <chrono>
#include <csignal>
#include <vector>

#include "support/input_error.hpp"
#include "support/scratch.hpp"

namespace vrda::show::loop_test {

using Clock = std::chrono::steady_clock;

struct Counted final : Mode {
  bool is_over() const override { return n_drawn == n_rounds; }
  RoundTime round_time() const override { return time; }
  void take(const view::InputEvent&) override { ++n_events; }
  void advance(double elapsed_s) override
  {
    EXPECT_EQ(elapsed.size(), static_cast<std::size_t>(n_drawn)) << "advance precedes draw";
    elapsed.push_back(elapsed_s);
  }
  void draw() override
  {
    if (++n_drawn == signal_in) raise(SIGTERM);
  }

  RoundTime time;
  int n_rounds = 0, n_drawn = 0, n_events = 0, signal_in = -1;
  std::vector<double> elapsed;
};

double run(Counted& mode)
{
  Sink nowhere;
  StopSignals stop;
  const Clock::time_point begun = Clock::now();
  run_loop(mode, nowhere, stop);
  return std::chrono::duration<double>(Clock::now() - begun).count();
}

TEST(Loop, Rounds)
{
  for (const bool is_ended_by_input : {false, true}) {
    Counted mode;
    mode.time = {0.02, is_ended_by_input};
    mode.n_rounds = 5;
    // Rounds never start early; without a window no input ends one.
    EXPECT_GE(run(mode), 5 * 0.02);
    double sum_s = 0.0;
    for (const double s : mode.elapsed) sum_s += s;
    EXPECT_GE(sum_s, 5 * 0.02 - 1e-3);
    EXPECT_EQ(mode.n_drawn, 5);
    EXPECT_EQ(mode.n_events, 0);
  }
}

TEST(Loop, Signal)
{
  Counted mode;
  mode.n_rounds = 1000;
  mode.signal_in = 3;
  run(mode);
  EXPECT_EQ(mode.n_drawn, 3);
}

TEST(Attempt, CatchesInputErrorsOnly)
{
  EXPECT_FALSE(catch_input_error([] {}));
  const auto refused = catch_input_error([] { throw InputError({"a.h5", "key", "nothing", "something"}); });
  ASSERT_TRUE(refused);
  EXPECT_EQ(refused->facts().field, "key");
  EXPECT_THROW(catch_input_error([] { check(false, "an internal error"); }), InternalError);
}

TEST(Sink, RecordedImages)
{
  const test::Scratch scratch;
  Sink sink(view::RenderOptions{32, 24, 1});
  EXPECT_FALSE(sink.is_recording());
  const std::string folder = (scratch.path() / "new" / "pictures").string();
  sink.record_images(folder, "--pictures");
  EXPECT_TRUE(sink.is_recording());
  const view::Scene nothing;
  sink.renderer().load(nothing);
  sink.show({nothing, {}});
  EXPECT_TRUE(std::filesystem::is_empty(folder)) << "show() writes no file";
  EXPECT_EQ(sink.record({nothing, {}}, "a.png"), folder + "/a.png");
  EXPECT_TRUE(std::filesystem::exists(folder + "/a.png"));
  const std::string file = scratch.write("file", "").string();
  EXPECT_EQ(test::input_error([&] { sink.record_images(file, "--pictures"); }).field, "--pictures");
}

TEST(FreeName, TwoWriters)
{
  const test::Scratch scratch;
  const auto name_of = [&](std::size_t number) { return (scratch.path() / std::to_string(number)).string(); };
  std::string other;
  // The second writer begins while the first one has its name and has written nothing.
  const std::string name = write_with_free_name(
      name_of, [&](const std::string&) { other = write_with_free_name(name_of, [](const std::string&) {}); });
  EXPECT_EQ(name, name_of(1));
  EXPECT_EQ(other, name_of(2));
  const auto fail = [](const std::string&) { throw InputError({"a", "", "b", "c"}); };
  EXPECT_THROW(write_with_free_name(name_of, fail), InputError);
  EXPECT_FALSE(std::filesystem::exists(name_of(3)));
}

}  // namespace vrda::show::loop_test
