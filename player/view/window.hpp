/// A window with its input events and its renderer. Positions are in screen coordinates, sizes of images in
/// pixels, both from the upper left. Throws InputError naming the alternative if there is no screen or no
/// OpenGL.
#pragma once

#include <array>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "view/keys.hpp"
#include "view/renderer.hpp"

namespace vrda::view {

struct WindowOptions {
  int width = 1280;  ///< of the content area, in screen coordinates
  int height = 800;
  std::string title;
  int samples = 0;         ///< per pixel; 0: four with a graphics card, one with software rendering
  bool is_vsynced = true;  ///< `show` waits for vertical synchronisation
  bool is_resizable = true;
  /// The alternative named by error messages if there is no screen or no OpenGL.
  std::string alternative = "--offscreen DIR";
  /// Top left corner of the content area in screen coordinates; the window is then undecorated. Empty: placed
  /// by the desktop.
  std::optional<std::array<int, 2>> at;
};

/// Position in screen coordinates as in WindowOptions; width and height in pixels.
struct WindowGeometry {
  int x = 0, y = 0, width = 0, height = 0;

  bool operator==(const WindowGeometry&) const = default;
};

/// A monitor of the desktop: position in screen coordinates, size in pixels of its present mode.
struct Monitor {
  std::string name;
  WindowGeometry geometry;
  int refresh_hz = 0;
};

/// The connected monitors, the primary one first; empty without a display.
std::vector<Monitor> connected_monitors();

class Window {
 public:
  /// Throws InputError if there is no display or no OpenGL 3.3. One window at a time, on the main thread.
  explicit Window(const WindowOptions& options);
  ~Window();

  /// The renderer, of the size of the content area.
  Renderer& renderer();
  /// The events since the last call; valid until the next. Waits up to `wait_s` for an event.
  /// Allocates only for dropped files and for more than 1000 events at once.
  const std::vector<InputEvent>& events(double wait_s = 0.0);
  /// The first connected gamepad that GLFW knows; empty without one. Does not allocate.
  std::optional<Gamepad> gamepad() const;
  /// The files of the last drop.
  const std::vector<std::string>& dropped_files() const;
  /// Renders a frame and displays it.
  void show(const Scene& scene, std::span<const Shot> shots, const Overlay* overlay);
  /// Displays the last frame with another overlay; false as Renderer::present_again.
  bool show_again(const Overlay* overlay);

  /// The present position and size.
  WindowGeometry geometry() const;
  /// The connected monitors now.
  std::vector<Monitor> monitors() const;
  bool should_close() const;
  /// Without a graphics card.
  bool is_software_rendered() const;
  void close();  ///< sets should_close()
  void set_title(const std::string& title);
  void toggle_full_screen();
  /// The monitor's scale factor for text and controls.
  double content_scale() const;
  /// True while minimised: nothing needs drawing.
  bool is_iconified() const;

 private:
  class State;
  std::unique_ptr<State> state_;
};

}  // namespace vrda::view
