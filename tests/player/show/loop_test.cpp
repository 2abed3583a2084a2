// The main loop, with a mode that counts its rounds, and the sinks of its frames.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>
#include <chrono>
#include <csignal>
#include <cstdlib>
#include <future>
#include <random>
#include <vector>

#include "core/text.hpp"
#include "show/loop.hpp"
#include "support/input_error.hpp"
#include "support/process.hpp"
#include "support/refusal.hpp"
#include "support/scratch.hpp"
#include "support/small_disk.hpp"

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

using testing::HasSubstr;

view::Image plain_image(int width, int height, std::uint8_t red)
{
  view::Image image{width, height, {}};
  for (int i = 0; i < width * height; ++i) image.rgba.insert(image.rgba.end(), {red, 40, 200, 255});
  return image;
}

/// Replaces PATH during a test.
class Path {
 public:
  explicit Path(const std::string& path) : before_(std::getenv("PATH")) { setenv("PATH", path.c_str(), 1); }
  ~Path() { setenv("PATH", before_.c_str(), 1); }
  Path(const Path&) = delete;
  Path& operator=(const Path&) = delete;

 private:
  std::string before_;
};

class Video : public testing::Test {
 protected:
  std::string path(const std::string& name) const { return (scratch_.path() / name).string(); }
  /// Installs a script named ffmpeg.
  void pretend(const std::string& script) const
  {
    std::filesystem::permissions(scratch_.write("ffmpeg", "#!/bin/sh\n" + script),
                                 std::filesystem::perms::owner_all);
  }
  std::size_t n_files() const
  {
    const std::filesystem::directory_iterator files(scratch_.path()), none;
    return static_cast<std::size_t>(std::distance(files, none));
  }
  InputError refusal(const VideoOptions& options) const
  {
    try {
      VideoFile video(options);
      for (int i = 0; i < 400; ++i) video.add(plain_image(options.width, options.height, 9));
      video.finish();
    } catch (const InputError& error) {
      return error;
    }
    ADD_FAILURE() << "accepted";
    return InputError({});
  }

  test::Scratch scratch_;
};

TEST_F(Video, EveryFormat)
{
  struct Row {
    const char* name;
    std::size_t n_pixels;  // odd sizes lose a row and a column, except in GIF
  };
  for (const auto& [name, n_pixels] :
       {Row{"film.mp4", 64 * 48}, Row{"film.webm", 64 * 48}, Row{"film.gif", 65 * 49}}) {
    SCOPED_TRACE(name);
    VideoFile video({path(name), 65, 49, 10});
    for (int i = 0; i < 12; ++i) video.add(plain_image(65, 49, static_cast<std::uint8_t>(20 * i)));
    video.finish();
    const test::Ended decoded = test::run(
        {"/usr/bin/ffmpeg",
         {"-v", "error", "-i", path(name), "-f", "rawvideo", "-pix_fmt", "rgb24", path("raw"), "-y"},
         {},
         {}});
    ASSERT_EQ(decoded.exit_code, 0) << decoded.err;
    const std::string raw = test::read_bytes(path("raw"));
    const std::size_t frame_bytes = 3 * n_pixels;
    ASSERT_EQ(raw.size(), 12 * frame_bytes);
    for (std::size_t i = 0; i < 12; ++i) {
      // Lossy coding changes colours by a few codes.
      EXPECT_NEAR(static_cast<unsigned char>(raw[i * frame_bytes + 3 * (n_pixels / 2)]),
                  20.0 * static_cast<double>(i), 12.0);
    }
  }
}

// A full disk is an error in each form and the old film stays.
TEST_F(Video, FullDisk)
{
  if (!test::mount_refusal().empty()) GTEST_SKIP() << test::mount_refusal();
  constexpr std::uintmax_t n_bytes = 16384;
  const test::SmallDisk disk(scratch_.path(), n_bytes);
  for (const char* name : {"film.mp4", "film.webm", "film.gif"}) {
    SCOPED_TRACE(name);
    const std::string before("\0the film before", 16);
    scratch_.write(name, before);
    // Noise is incompressible; the disk fills up before the end, for some formats only at the end.
    std::mt19937 random(3);
    view::Image image = plain_image(160, 120, 0);
    EXPECT_THROW(
        {
          VideoFile video({path(name), 160, 120, 25});
          for (int i = 0; i < 40; ++i) {
            for (std::uint8_t& byte : image.rgba) byte = static_cast<std::uint8_t>(random());
            video.add(image);
          }
          video.finish();
        },
        InputError);
    EXPECT_EQ(test::read_bytes(path(name)), before);
    EXPECT_EQ(n_files(), 1u);
    std::filesystem::remove(path(name));
  }
}

TEST_F(Video, NameWhenComplete)
{
  {
    VideoFile video({path("film.mp4"), 64, 48, 25});
    for (int i = 0; i < 3; ++i) video.add(plain_image(64, 48, 100));
    EXPECT_FALSE(std::filesystem::exists(path("film.mp4")));
  }
  EXPECT_EQ(n_files(), 0u);
}

/// A pipe stays a pipe; its reader gets the film.
TEST_F(Video, APipeGetsTheFilm)
{
  const std::string pipe = path("film.mp4");
  ASSERT_EQ(mkfifo(pipe.c_str(), 0600), 0);
  std::future<std::string> read = std::async(std::launch::async, [&] { return test::read_bytes(pipe); });
  VideoFile video({pipe, 64, 48, 25});
  for (int i = 0; i < 3; ++i) video.add(plain_image(64, 48, 100));
  video.finish();
  EXPECT_TRUE(std::filesystem::is_fifo(pipe));
  EXPECT_THAT(read.get(), HasSubstr("ftyp"));
}

TEST_F(Video, WithoutFfmpegItSaysSo)
{
  const Path empty(scratch_.path().string());
  const InputError error = refusal({path("film.mp4"), 64, 48, 25});
  EXPECT_EQ(error.facts().file, "--video");
  EXPECT_THAT(error.facts().found, HasSubstr("no ffmpeg"));
  EXPECT_THAT(error.facts().wanted, HasSubstr("ffmpeg installed"));
}

TEST_F(Video, FfmpegError)
{
  pretend("echo 'the disk is full' >&2\nexit 7\n");
  const Path here(scratch_.path().string());
  const InputError error = refusal({path("film.mp4"), 640, 480, 25});
  EXPECT_THAT(error.facts().found, HasSubstr("exit code 7"));
  EXPECT_THAT(error.facts().found, HasSubstr("the disk is full"));
  EXPECT_EQ(n_files(), 1u);
}

}  // namespace vrda::show::loop_test
