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
  virtual ~Window() = default;

  /// The renderer, of the size of the content area.
  virtual Renderer& renderer() = 0;
  /// The events since the last call; valid until the next. Waits up to `wait_s` for an event.
  /// Allocates only for dropped files and for more than 1000 events at once.
  virtual const std::vector<InputEvent>& events(double wait_s = 0.0) = 0;
  /// The first connected gamepad that GLFW knows; empty without one. Does not allocate.
  virtual std::optional<Gamepad> gamepad() const = 0;
  /// The files of the last drop.
  virtual const std::vector<std::string>& dropped_files() const = 0;
  /// Renders a frame and displays it.
  virtual void show(const Scene& scene, std::span<const Shot> shots, const Overlay* overlay) = 0;
  /// Displays the last frame with another overlay; false as Renderer::present_again.
  virtual bool show_again(const Overlay* overlay) = 0;

  /// The present position and size.
  virtual WindowGeometry geometry() const = 0;
  /// The connected monitors now.
  virtual std::vector<Monitor> monitors() const = 0;
  virtual bool should_close() const = 0;
  /// Without a graphics card.
  virtual bool is_software_rendered() const = 0;
  virtual void close() = 0;  ///< sets should_close()
  virtual void set_title(const std::string& title) = 0;
  virtual bool is_full_screen() const = 0;
  virtual void toggle_full_screen() = 0;
  /// The monitor's scale factor for text and controls.
  virtual double content_scale() const = 0;
  /// True while minimised: nothing needs drawing.
  virtual bool is_iconified() const = 0;
};

/// Opens a window. Throws InputError if there is no display or no OpenGL 3.3. One window at a time, on the
/// main thread.
std::unique_ptr<Window> open_window(const WindowOptions& options);

}  // namespace vrda::view
