#include "show/loop.hpp"

#include <fcntl.h>
#include <sys/mman.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <csignal>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <system_error>
#include <utility>
#include <vector>

#include "core/console.hpp"

namespace vrda::show {
namespace {

constexpr std::size_t longest_message = 600;  // bytes: a few lines of ffmpeg output

enum class Coding { mp4, webm, gif };

Coding coding_of(const std::string& path)
{
  const std::string ending = std::filesystem::path(path).extension().string();
  if (ending == ".mp4") return Coding::mp4;
  if (ending == ".webm") return Coding::webm;
  if (ending == ".gif") return Coding::gif;
  throw InputError({"--video", "", "\"" + path + "\"", "a name that ends in .mp4, .webm or .gif"});
}

/// Encoder arguments. Chroma subsampling requires even sizes, so odd ones are cropped. Colours are encoded
/// and tagged as BT.709, which players expect.
std::vector<std::string> coding_arguments(Coding coding)
{
  const std::string to_even_yuv =
      "crop=trunc(iw/2)*2:trunc(ih/2)*2,scale=out_color_matrix=bt709:out_range=tv,format=yuv420p";
  const std::vector<std::string> named{"-colorspace", "bt709", "-color_primaries", "bt709",
                                       "-color_trc",  "bt709", "-color_range",     "tv"};
  std::vector<std::string> arguments;
  switch (coding) {
    case Coding::mp4:
      // "medium" takes twice as long, for as large a file and 0.0007 of structural similarity.
      arguments = {"-vf",      to_even_yuv, "-c:v", "libx264",   "-preset",
                   "veryfast", "-crf",      "20",   "-movflags", "+faststart"};
      break;
    case Coding::webm:
      arguments = {"-vf", to_even_yuv, "-c:v", "libvpx-vp9", "-crf", "32", "-b:v", "0", "-cpu-used", "4"};
      break;
    case Coding::gif:
      return {"-vf", "split[a][b];[a]palettegen[p];[b][p]paletteuse=dither=bayer:bayer_scale=4", "-f", "gif"};
  }
  arguments.insert(arguments.end(), named.begin(), named.end());
  arguments.insert(arguments.end(), {"-f", coding == Coding::mp4 ? "mp4" : "webm"});
  return arguments;
}

std::vector<std::string> arguments_for(const VideoOptions& options, const std::string& path)
{
  const std::string size = std::to_string(options.width) + "x" + std::to_string(options.height);
  const std::string rate = std::to_string(options.frames_per_s);
  // Without -xerror, a disk that fills up at the end is not reported.
  std::vector<std::string> arguments{
      "ffmpeg",   "-nostdin",      "-hide_banner", "-loglevel",   "error",     "-xerror",       "-y", "-f",
      "rawvideo", "-pixel_format", "rgba",         "-video_size", size,        "-framerate",    rate, "-i",
      "pipe:0",   "-fflags",       "+bitexact",    "-flags:v",    "+bitexact", "-map_metadata", "-1"};
  const std::vector<std::string> coding = coding_arguments(coding_of(options.path));
  arguments.insert(arguments.end(), coding.begin(), coding.end());
  arguments.push_back("file:" + path);
  return arguments;
}

[[noreturn]] void refuse(const std::string& path, const std::string& found)
{
  throw InputError({path, "--video", found, "a video written by ffmpeg"});
}

Publication begun(const std::string& path)
{
  std::string holder;
  std::optional<Publication> publication = Publication::begin(
      path, "vrda-player", {[&](const std::string& found) { holder = found; }, [] { return true; }});
  if (!publication) throw InputError({path, "--video", holder + ", which is writing it", "another name"});
  return std::move(*publication);
}

}  // namespace

void require_video_name(const std::string& path)
{
  coding_of(path);
}

VideoFile::VideoFile(const VideoOptions& options)
    : options_(options),
      unfinished_path_(resolve_links(options.path) + ".part"),
      publication_(begun(options.path))
{
  require_video_name(options.path);
  constexpr std::string_view binary("\0", 1);  // every video is binary
  require_same_file_type(options.path, binary);
  start();
}

VideoFile::~VideoFile()
{
  stop();
}

void VideoFile::start()
{
  std::array<int, 2> ends{};
  // A socket rather than a pipe: writing after ffmpeg has ended then returns an error instead of raising
  // SIGPIPE.
  if (socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, ends.data()) != 0)
    refuse(options_.path, std::strerror(errno));
  frames_ = ends[0];
  messages_ = memfd_create("ffmpeg", MFD_CLOEXEC);
  const StartedProcess started = start_process(arguments_for(options_, unfinished_path_),
                                               {.in = ends[1], .out = messages_, .err = messages_});
  close(ends[1]);
  ffmpeg_ = started.pid;
  if (started.error == 0) return;
  stop();
  if (started.error == ENOENT)
    throw InputError({"--video", "", "no ffmpeg on the PATH", "ffmpeg installed, or images without --video"});
  refuse(options_.path, std::strerror(started.error));
}

void VideoFile::stop()
{
  if (frames_ >= 0) close(frames_);
  frames_ = -1;
  if (ffmpeg_ > 0) {
    kill(ffmpeg_, SIGTERM);
    wait_for_ffmpeg();
  }
  if (messages_ >= 0) close(messages_);
  messages_ = -1;
  std::error_code gone;
  std::filesystem::remove(unfinished_path_, gone);
}

ProcessEnd VideoFile::wait_for_ffmpeg()
{
  return wait_for_process(std::exchange(ffmpeg_, -1));
}

void VideoFile::fail(const ProcessEnd& end)
{
  std::array<char, longest_message> buffer{};
  const ssize_t n = pread(messages_, buffer.data(), buffer.size(), 0);
  std::string message(buffer.data(), n > 0 ? static_cast<std::size_t>(n) : 0);
  while (!message.empty() && (message.back() == '\n' || message.back() == ' ')) message.pop_back();
  stop();
  const std::string how =
      end.signal == 0 ? "exit code " + std::to_string(end.exit_code) : "signal " + std::to_string(end.signal);
  refuse(options_.path, "ffmpeg ended with " + how + (message.empty() ? "" : ": " + message));
}

void VideoFile::add(const view::Image& image)
{
  check(image.width == options_.width && image.height == options_.height,
        "all frames of a video have the same size");
  const std::uint8_t* left = image.rgba.data();
  std::size_t n_left = image.rgba.size();
  while (n_left > 0) {
    const ssize_t n = send(frames_, left, n_left, MSG_NOSIGNAL);
    if (n < 0 && errno == EINTR) continue;
    if (n < 0) {
      close(frames_);
      frames_ = -1;
      fail(wait_for_ffmpeg());
    }
    left += n;
    n_left -= static_cast<std::size_t>(n);
  }
}

void VideoFile::finish()
{
  close(frames_);
  frames_ = -1;
  const ProcessEnd end = wait_for_ffmpeg();
  if (end.exit_code != 0) fail(end);
  publication_.publish_written(unfinished_path_);
}

std::span<const view::InputEvent> Sink::events(double wait_s)
{
  if (!window_) return {};
  return window_->events(wait_s);
}

void Sink::record_images(const std::string& folder, const std::string& option)
{
  make_folder(folder, option);
  folder_ = folder;
}

void Sink::show(const Frame& frame)
{
  if (is_hidden()) return;
  if (window_) {
    window_->show(frame.scene, frame.shots, frame.overlay);
  } else if (memory_) {
    memory_->present(frame.scene, frame.shots, frame.overlay);
  }
}

bool Sink::show_again(const view::Overlay* overlay)
{
  if (!has_output()) return false;
  return is_hidden() || (window_ ? window_->show_again(overlay) : memory_->present_again(overlay));
}

std::string Sink::record(const Frame& frame, const std::string& name, std::int64_t n_video)
{
  const view::Image& image = renderer().draw(frame.scene, frame.shots, frame.overlay);
  for (std::int64_t k = 0; video_ && k < n_video; ++k) video_->add(image);
  if (folder_.empty() || name.empty()) return {};
  std::string path = (std::filesystem::path(folder_) / name).string();
  view::write_png(image, path);
  return path;
}

void Sink::finish()
{
  if (video_) video_->finish();
}

void make_folder(const std::string& folder, const std::string& option)
{
  std::error_code error;
  std::filesystem::create_directories(folder, error);
  if (error || !std::filesystem::is_directory(folder)) {
    throw InputError({folder, option, error ? error.message() : "not a folder", "a writable folder"});
  }
}

std::string padded_name(const std::string& stem, std::size_t number, std::size_t width)
{
  std::string digits = std::to_string(number);
  digits.insert(0, width - std::min(width, digits.size()), '0');
  return stem + digits;
}

std::string write_with_free_name(const std::function<std::string(std::size_t)>& name_of,
                                 const std::function<void(const std::string&)>& write)
{
  for (std::size_t number = 1;; ++number) {
    const std::string name = name_of(number);
    const OpenFile reserved(open(name.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666));
    if (!reserved.is_open() && errno == EEXIST) continue;
    if (!reserved.is_open())
      throw InputError({name, "", std::strerror(errno), "a folder that exists and can be written"});
    try {
      write(name);
    } catch (...) {
      std::remove(name.c_str());
      throw;
    }
    return name;
  }
}

std::string count_text(std::size_t n, const std::string& what)
{
  return std::to_string(n) + " " + what + (n == 1 ? "" : "s");
}

// The main loop.

StopSignals::StopSignals()
{
  sigemptyset(&signals_);
  for (const int signal : stop_signals()) sigaddset(&signals_, signal);
  pthread_sigmask(SIG_BLOCK, &signals_, &before_);
}

// Consumes pending signals, so that unblocking them does not end the program.
StopSignals::~StopSignals()
{
  const timespec none{};
  while (sigtimedwait(&signals_, nullptr, &none) > 0) {
  }
  pthread_sigmask(SIG_SETMASK, &before_, nullptr);
}

bool StopSignals::wait_until(std::chrono::steady_clock::time_point due)
{
  if (has_come_) return true;
  const std::chrono::nanoseconds left = due - std::chrono::steady_clock::now();
  const std::int64_t ns = std::max<std::int64_t>(0, left.count());
  const timespec wait{ns / 1'000'000'000, ns % 1'000'000'000};
  has_come_ = sigtimedwait(&signals_, nullptr, &wait) > 0;
  return has_come_;
}

std::optional<view::KeyPress> key_press_of(const view::InputEvent& event)
{
  if (event.kind != view::InputKind::key_press || event.key == view::Key::none) return std::nullopt;
  const bool is_question = event.key == view::key_of('/') && event.has_shift;
  return view::KeyPress{is_question ? view::key_of('?') : event.key, event.has_shift, event.has_control};
}

namespace {

using Clock = std::chrono::steady_clock;

constexpr double longest_s = 10.0;  // limits the elapsed time after the machine was suspended

Clock::duration duration_of(double s)
{
  return std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(s));
}

/// Timing of rounds.
class Rounds {
 public:
  /// Waits for the next round and passes the events to the mode; returns false after a stop signal.
  bool next(Mode& mode, Sink& sink, StopSignals& stop)
  {
    const RoundTime time = mode.round_time();
    const bool is_by_input = time.is_ended_by_input && sink.window() != nullptr;
    const Clock::duration period = duration_of(time.s);
    due_ += period;
    if (due_ + period < Clock::now()) due_ = Clock::now();
    if (stop.wait_until(is_by_input ? Clock::now() : due_)) return false;
    const std::chrono::duration<double> left = due_ - Clock::now();
    for (const view::InputEvent& event : sink.events(is_by_input ? std::max(0.0, left.count()) : 0.0))
      mode.take(event);
    if (is_by_input) due_ = Clock::now();
    return true;
  }
  /// Time since the previous round.
  double elapsed_s()
  {
    const std::chrono::duration<double> elapsed = Clock::now() - began_;
    began_ = Clock::now();
    return std::min(elapsed.count(), longest_s);
  }

 private:
  Clock::time_point began_ = Clock::now(), due_ = began_;
};

}  // namespace

void run_loop(Mode& mode, Sink& sink, StopSignals& stop)
{
  Rounds rounds;
  while (!mode.is_over() && !sink.is_closed() && rounds.next(mode, sink, stop)) {
    mode.advance(rounds.elapsed_s());
    mode.draw();
  }
}

std::optional<InputError> catch_input_error(const std::function<void()>& work)
{
  try {
    work();
    return std::nullopt;
  } catch (const InputError& error) {
    return error;
  }
}

}  // namespace vrda::show
