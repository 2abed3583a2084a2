/// Where a mode's frames go: a window, memory, pictures and a film; or nowhere.
#pragma once

#include <memory>
#include <span>
#include <string>

#include "loop/video_file.hpp"
#include "render/renderer.hpp"
#include "render/window.hpp"

namespace vrda {

/// What is drawn in a round.
struct Frame {
  const Scene& scene;
  std::span<const Shot> shots;
  const Overlay* overlay = nullptr;
};

class Sink {
 public:
  /// Nowhere: nothing is drawn.
  Sink() = default;
  /// Throws InputError where there is no display.
  explicit Sink(const WindowOptions& options) : window_(std::make_unique<Window>(options)) {}
  explicit Sink(const RenderOptions& options) : memory_(make_offscreen_renderer(options)) {}

  bool is_anywhere() const { return window_ || memory_; }
  /// Nothing where there is none.
  Window* window() const { return window_.get(); }
  /// Of a sink that is somewhere.
  Renderer& renderer() const { return window_ ? window_->renderer() : *memory_; }
  bool is_closed() const { return window_ && window_->should_close(); }
  /// An icon, or a window that is behind: nothing needs drawing.
  bool is_hidden() const { return window_ && window_->is_iconified(); }
  std::span<const InputEvent> events(double wait_s);

  /// Frames that are kept go there, too. Throws InputError where it cannot be made.
  void keep_pictures(const std::string& folder, const std::string& option);
  void keep_film(const VideoOptions& options) { film_ = std::make_unique<VideoFile>(options); }
  bool keeps() const { return !folder_.empty() || film_; }

  /// Returns when the frame is finished.
  void show(const Frame& frame);
  /// Draws the frame into the film, and into a file of the folder; returns the file's path.
  std::string keep(const Frame& frame, const std::string& name);
  /// Ends the film.
  void finish();

 private:
  std::unique_ptr<Window> window_;
  std::unique_ptr<Renderer> memory_;
  std::string folder_;
  std::unique_ptr<VideoFile> film_;
};

/// Makes the folder that `option` names. Throws InputError.
void make_folder(const std::string& folder, const std::string& option);

/// "task_0012": numbers padded so that names sort.
std::string numbered(const std::string& stem, std::size_t number, std::size_t width);

/// "2 frames", "1 frame"
std::string counted(std::size_t n, const std::string& what);

}  // namespace vrda
