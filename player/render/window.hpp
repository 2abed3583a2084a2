/// A window on a screen, what happens in it, and the renderer that draws into it.
#pragma once

#include <array>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "render/renderer.hpp"

namespace vrda {

struct WindowOptions {
  int width = 1280;  ///< of the area drawn to, in screen coordinates
  int height = 800;
  std::string title;
  int samples = 0;         ///< a pixel; 0: four with a graphics card, one where the processor draws
  bool is_vsynced = true;  ///< `show` waits for the screen
  bool is_resizable = true;
  /// What a message offers where there is no screen or no OpenGL.
  std::string instead = "--offscreen DIR";
  /// Top left corner of the area drawn to, in screen coordinates of the desktop: a window without a frame,
  /// there. Without, the desktop places it.
  std::optional<std::array<int, 2>> at;
};

/// Where a window is, as WindowOptions has it; width and height in pixels.
struct WindowPlace {
  int x = 0, y = 0, width = 0, height = 0;
};

/// A key by the character on it in the US layout (capitals: 'A', '1', ' '), or one of these.
enum NamedKey : int {
  key_escape = 256,
  key_enter,
  key_tab,
  key_backspace,
  key_insert,
  key_delete,
  key_right,
  key_left,
  key_down,
  key_up,
  key_page_up,
  key_page_down,
  key_home,
  key_end,
  key_f1 = 290,        ///< the other eleven follow
  key_keypad_0 = 320,  ///< the other nine follow
  key_keypad_enter = 335,
  key_shift = 340,
  key_control,
  key_alt,
  key_super,
  key_right_shift,
  key_right_control,
  key_right_alt,
  key_right_super
};

enum class MouseButton { left, right, middle };

enum class InputKind {
  motion,     ///< x_px, y_px
  press,      ///< button, n_clicks
  release,    ///< button
  wheel,      ///< wheel_x, wheel_y: notches, to the right and away from the hand
  key_press,  ///< key; again while it is held
  key_release,
  character,  ///< of text as typed
  resize,     ///< the renderer has its new size already
  focus_gained,
  focus_lost,
  left_window,  ///< the pointer is outside
  close,
  drop  ///< of files: `Window::dropped_files`
};

/// Positions are pixels of the picture from its top left corner, whatever the kind.
struct InputEvent {
  InputKind kind = InputKind::motion;
  double x_px = 0.0, y_px = 0.0;
  double wheel_x = 0.0, wheel_y = 0.0;
  MouseButton button = MouseButton::left;
  int n_clicks = 1;  ///< 2 for the second of a double click
  int key = 0;
  char32_t character = 0;
  bool has_shift = false, has_control = false, has_alt = false, has_super = false;
};

class Window {
 public:
  /// Throws InputError when there is no display or no OpenGL 3.3. One window at a time, on the main thread.
  explicit Window(const WindowOptions& options);
  ~Window();
  Window(const Window&) = delete;
  Window& operator=(const Window&) = delete;

  /// As large as the area drawn to.
  Renderer& renderer();
  /// What happened since the last call; valid until the next. Waits for something for up to `wait_s`.
  /// Allocates nothing but for dropped files and more than 1000 events at once.
  const std::vector<InputEvent>& events(double wait_s = 0.0);
  /// Of the last drop.
  const std::vector<std::string>& dropped_files() const;
  /// Draws a frame and brings it to the screen.
  void show(const Scene& scene, std::span<const Shot> shots, const Overlay* overlay);

  /// Asks the desktop.
  WindowPlace place() const;
  bool should_close() const;
  void close();  ///< from now on it should
  void set_title(const std::string& title);
  bool is_full_screen() const;
  void toggle_full_screen();
  /// How much larger than on an ordinary screen letters should be.
  double content_scale() const;
  /// Whether it can be seen at all: nothing needs drawing while it is an icon.
  bool is_iconified() const;

  /// Text other programs may paste, or have copied.
  std::string clipboard() const;
  void set_clipboard(const std::string& text);

 private:
  class State;
  std::unique_ptr<State> state_;
};

}  // namespace vrda
