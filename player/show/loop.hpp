/// The main loop of every mode, and where its frames go: a window, image files, a video encoded by the
/// external program ffmpeg, which is optional.
#pragma once

#include <signal.h>
#include <sys/types.h>

#include <chrono>
#include <cstdint>
#include <functional>
#include <iosfwd>
#include <memory>
#include <optional>
#include <span>
#include <string>

#include "core/files.hpp"
#include "core/process.hpp"
#include "core/text.hpp"
#include "view/image.hpp"
#include "view/keys.hpp"
#include "view/renderer.hpp"
#include "view/window.hpp"

namespace vrda::show {

struct VideoOptions {
  std::string path;  ///< .mp4, .webm or .gif; the suffix selects the encoding
  int width = 0, height = 0;
  int frames_per_s = 25;
};

/// Throws InputError for an unknown suffix.
void require_video_name(const std::string& path);

/// Sends frames to ffmpeg through a socket; the output is published as `path` when complete. Throws
/// InputError for an unknown suffix, if another process writes the video, if ffmpeg is not installed, or if
/// it fails (with its error output).
class VideoFile {
 public:
  explicit VideoFile(const VideoOptions& options);
  /// Without `finish`, deletes the incomplete file.
  ~VideoFile();
  VideoFile(const VideoFile&) = delete;
  VideoFile& operator=(const VideoFile&) = delete;

  /// Adds a frame of the size in the options.
  void add(const view::Image& image);
  void finish();

 private:
  void start();
  void stop();
  [[noreturn]] void fail(const ProcessEnd& end);
  ProcessEnd wait_for_ffmpeg();

  VideoOptions options_;
  std::string unfinished_path_;  ///< beside the target of a link
  Publication publication_;
  pid_t ffmpeg_ = -1;
  int frames_ = -1;    ///< local end of the socket
  int messages_ = -1;  ///< ffmpeg's output, a file in memory
};

// Output of a mode's frames: a window, memory, image files and a video; or none.

/// The content of one frame.
struct Frame {
  const view::Scene& scene;
  std::span<const view::Shot> shots;
  const view::Overlay* overlay = nullptr;
};

class Sink {
 public:
  /// No output: nothing is drawn.
  Sink() = default;
  /// Throws InputError if there is no display.
  explicit Sink(const view::WindowOptions& options) : window_(view::open_window(options)) {}
  explicit Sink(const view::RenderOptions& options) : memory_(view::make_offscreen_renderer(options)) {}

  bool has_output() const { return window_ || memory_; }
  /// Null without a window.
  view::Window* window() const { return window_.get(); }
  /// Requires has_output().
  view::Renderer& renderer() const { return window_ ? window_->renderer() : *memory_; }
  bool is_closed() const { return window_ && window_->should_close(); }
  /// The window is minimised: nothing needs drawing.
  bool is_hidden() const { return window_ && window_->is_iconified(); }
  std::span<const view::InputEvent> events(double wait_s);

  /// Sets the folder for recorded frames. Throws InputError, naming `option`, if it cannot be created.
  void record_images(const std::string& folder, const std::string& option);
  void record_video(const VideoOptions& options) { video_ = std::make_unique<VideoFile>(options); }
  bool is_recording() const { return !folder_.empty() || video_; }

  /// Displays the frame; returns when it is complete.
  void show(const Frame& frame);
  /// Displays the last frame with another overlay; false as Renderer::present_again.
  bool show_again(const view::Overlay* overlay);
  /// Draws the frame `n_video` times to the video and to file `name` in the folder; returns the path, empty
  /// without a folder or name.
  std::string record(const Frame& frame, const std::string& name, std::int64_t n_video = 1);
  /// Completes the video.
  void finish();

 private:
  std::unique_ptr<view::Window> window_;
  std::unique_ptr<view::Renderer> memory_;
  std::string folder_;
  std::unique_ptr<VideoFile> video_;
};

/// Creates the folder given by `option`. Throws InputError if it is not writable.
void make_folder(const std::string& folder, const std::string& option);

/// "task_0012": the number zero-padded to `width` digits, so that names sort.
std::string padded_name(const std::string& stem, std::size_t number, std::size_t width);

/// Runs `write` with the first of name_of(1), name_of(2), ... that does not exist, and returns that name. Two
/// processes never get the same one: an empty file takes the name first. Throws InputError if that fails.
std::string write_with_free_name(const std::function<std::string(std::size_t)>& name_of,
                                 const std::function<void(const std::string&)>& write);

/// "2 frames", "1 frame"
std::string count_text(std::size_t n, const std::string& what);

// The main loop: waits for input events, a due frame or a stop signal, and calls the mode.

/// Blocks SIGINT, SIGTERM and SIGHUP during its lifetime; threads started meanwhile inherit the mask.
class StopSignals {
 public:
  StopSignals();
  ~StopSignals();
  StopSignals(const StopSignals&) = delete;
  StopSignals& operator=(const StopSignals&) = delete;

  /// Waits until `due` for a signal; returns true if one has arrived.
  bool wait_until(std::chrono::steady_clock::time_point due);

 private:
  sigset_t signals_{}, before_{};
  bool has_come_ = false;
};

/// The key press of an event; empty for other events and unused keys.
std::optional<view::KeyPress> key_press_of(const view::InputEvent& event);

/// The output streams of a mode.
struct Streams {
  std::ostream& data;      ///< machine-readable output: one path per line
  std::ostream& messages;  ///< messages for the user
};

/// The period from the start of a round to that of the next.
struct RoundTime {
  double s = 0.0;
  /// With a window, input starts the next round at once. Otherwise rounds have a fixed period; after an
  /// overrun the next starts at once, and at most one missed round is caught up.
  bool is_ended_by_input = true;
};

/// State, input handling and drawing of a mode. Each round calls take for all events, advance, then draw.
class Mode {
 public:
  virtual ~Mode() = default;
  virtual bool is_over() const = 0;
  virtual RoundTime round_time() const = 0;
  virtual void take(const view::InputEvent& event) = 0;
  virtual void advance(double elapsed_s) = 0;
  virtual void draw() = 0;
};

/// Runs until the mode is over, the window of `sink` is closed or a signal arrives. `stop` must be
/// constructed before the mode starts threads.
void run_loop(Mode& mode, Sink& sink, StopSignals& stop);

/// Runs `work` and returns a caught InputError (a full disk, an invalid file); empty on success.
std::optional<InputError> catch_input_error(const std::function<void()>& work);

}  // namespace vrda::show
