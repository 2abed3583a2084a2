#include "view/window.hpp"

#define GLFW_INCLUDE_NONE
#include <GLFW/glfw3.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <limits>

#include "core/text.hpp"
#include "view/gl_context.hpp"

namespace vrda::view {
namespace {

/// Key of a GLFW key code.
Key key_of_code(int code)
{
  struct Named {
    int code;
    Key key;
  };
  constexpr std::array named{Named{GLFW_KEY_ESCAPE, Key::escape},   Named{GLFW_KEY_ENTER, Key::enter},
                             Named{GLFW_KEY_KP_ENTER, Key::enter},  Named{GLFW_KEY_BACKSPACE, Key::backspace},
                             Named{GLFW_KEY_UP, Key::up},           Named{GLFW_KEY_DOWN, Key::down},
                             Named{GLFW_KEY_LEFT, Key::left},       Named{GLFW_KEY_RIGHT, Key::right},
                             Named{GLFW_KEY_PAGE_UP, Key::page_up}, Named{GLFW_KEY_PAGE_DOWN, Key::page_down},
                             Named{GLFW_KEY_HOME, Key::home},       Named{GLFW_KEY_END, Key::end},
                             Named{GLFW_KEY_F1, Key::f1},           Named{GLFW_KEY_F2, Key::f2},
                             Named{GLFW_KEY_F3, Key::f3},           Named{GLFW_KEY_F4, Key::f4},
                             Named{GLFW_KEY_F5, Key::f5},           Named{GLFW_KEY_F6, Key::f6},
                             Named{GLFW_KEY_F7, Key::f7},           Named{GLFW_KEY_F8, Key::f8},
                             Named{GLFW_KEY_F11, Key::f11},         Named{GLFW_KEY_KP_SUBTRACT, key_of('-')},
                             Named{GLFW_KEY_KP_ADD, key_of('+')}};
  const auto found = std::ranges::find(named, code, &Named::code);
  if (found != named.end()) return found->key;
  return code >= ' ' && code < 127 ? static_cast<Key>(code) : Key::none;
}

constexpr std::size_t events_at_once = 1000;

// Typical desktop settings.
constexpr double double_click_s = 0.4, double_click_px = 6.0;

std::string last_error()
{
  const char* text = nullptr;
  glfwGetError(&text);
  return text == nullptr ? "no reason given" : text;
}

/// Initialises GLFW for the lifetime of a window.
class Library {
 public:
  explicit Library(const std::string& instead)
  {
    if (glfwInit() == GLFW_TRUE) return;
    const char* const display = std::getenv("DISPLAY");
    const bool is_named = display != nullptr && *display != '\0';
    throw InputError({"window", "display",
                      is_named ? "DISPLAY=" + std::string(display) + " (" + last_error() + ")" : "no DISPLAY",
                      "a screen: set DISPLAY, or use " + instead});
  }
  ~Library() { glfwTerminate(); }
  Library(const Library&) = delete;
  Library& operator=(const Library&) = delete;
};

/// Detects software rendering by the driver name of the current context; there four samples take three times
/// as long as one.
bool is_software_context()
{
  constexpr unsigned renderer_name = 0x1F01;  // GL_RENDERER
  const auto get_string =
      reinterpret_cast<const unsigned char* (*)(unsigned)>(glfwGetProcAddress("glGetString"));
  check(get_string != nullptr, "OpenGL has the function glGetString");
  const unsigned char* const given = get_string(renderer_name);
  const std::string name = given == nullptr ? "" : reinterpret_cast<const char*>(given);
  for (const char* const driver : {"llvmpipe", "softpipe", "swrast", "Software"}) {
    if (name.find(driver) != std::string::npos) return true;
  }
  return false;
}

/// Requires an initialised GLFW.
std::vector<Monitor> present_monitors()
{
  int n = 0;
  GLFWmonitor** const found = glfwGetMonitors(&n);
  std::vector<Monitor> monitors;
  for (int k = 0; k < n; ++k) {
    Monitor& monitor = monitors.emplace_back();
    monitor.name = glfwGetMonitorName(found[k]);
    glfwGetMonitorPos(found[k], &monitor.geometry.x, &monitor.geometry.y);
    const GLFWvidmode* const mode = glfwGetVideoMode(found[k]);
    if (mode == nullptr) continue;
    monitor.geometry.width = mode->width;
    monitor.geometry.height = mode->height;
    monitor.refresh_hz = mode->refreshRate;
  }
  return monitors;
}

class WindowContext final : public GlContext {
 public:
  explicit WindowContext(GLFWwindow* window) : window_(window) {}
  void make_current() override
  {
    if (glfwGetCurrentContext() != window_) glfwMakeContextCurrent(window_);
  }
  Function function(const char* name) override { return glfwGetProcAddress(name); }
  bool has_screen() const override { return true; }

 private:
  GLFWwindow* window_;
};

struct CloseWindow {
  void operator()(GLFWwindow* window) const { glfwDestroyWindow(window); }
};

std::unique_ptr<GLFWwindow, CloseWindow> opened_window(const WindowOptions& options)
{
  glfwDefaultWindowHints();
  glfwWindowHint(GLFW_CONTEXT_VERSION_MAJOR, 3);
  glfwWindowHint(GLFW_CONTEXT_VERSION_MINOR, 3);
  glfwWindowHint(GLFW_OPENGL_PROFILE, GLFW_OPENGL_CORE_PROFILE);
  glfwWindowHint(GLFW_OPENGL_FORWARD_COMPAT, GLFW_TRUE);
  // The renderer has its own frame buffer with depth and samples.
  glfwWindowHint(GLFW_DEPTH_BITS, 0);
  glfwWindowHint(GLFW_STENCIL_BITS, 0);
  glfwWindowHint(GLFW_SRGB_CAPABLE, GLFW_TRUE);
  glfwWindowHint(GLFW_RESIZABLE, options.is_resizable ? GLFW_TRUE : GLFW_FALSE);
  glfwWindowHint(GLFW_DECORATED, options.at ? GLFW_FALSE : GLFW_TRUE);
  // Positioned before it is shown, so that the desktop keeps the position.
  glfwWindowHint(GLFW_VISIBLE, options.at ? GLFW_FALSE : GLFW_TRUE);
  std::unique_ptr<GLFWwindow, CloseWindow> window(
      glfwCreateWindow(options.width, options.height, options.title.c_str(), nullptr, nullptr));
  if (window == nullptr)
    throw InputError(
        {"window", "OpenGL", last_error(), "a driver with OpenGL 3.3, or " + options.alternative});
  if (options.at) {
    glfwSetWindowPos(window.get(), (*options.at)[0], (*options.at)[1]);
    glfwShowWindow(window.get());
  }
  return window;
}

class GlfwWindow final : public Window {
 public:
  explicit GlfwWindow(const WindowOptions& options)
      : library_(options.alternative), window_(opened_window(options))
  {
    events_.reserve(events_at_once);
    glfwMakeContextCurrent(window_.get());
    glfwSwapInterval(options.is_vsynced ? 1 : 0);
    is_software_ = is_software_context();
    RenderOptions render;
    render.samples = options.samples > 0 ? options.samples : is_software_ ? 1 : 4;
    render.coarseness_px = moving_coarseness_px;
    render.has_deferred_levels = true;
    glfwGetFramebufferSize(window_.get(), &render.width, &render.height);
    renderer_ = make_gl_renderer(std::make_unique<WindowContext>(window_.get()), render);
    glfwSetWindowUserPointer(window_.get(), this);
    listen_to_mouse();
    listen_to_keys();
    listen_to_window();
  }

  Renderer& renderer() override { return *renderer_; }
  const std::vector<InputEvent>& events(double wait_s) override
  {
    events_.clear();
    if (wait_s > 0.0) {
      glfwWaitEventsTimeout(wait_s);
    } else {
      glfwPollEvents();
    }
    int width = 0, height = 0;
    glfwGetFramebufferSize(window(), &width, &height);
    // A minimised window has no area.
    if (width > 0 && height > 0) renderer_->resize(width, height);
    return events_;
  }
  std::optional<Gamepad> gamepad() const override
  {
    GLFWgamepadstate state{};
    for (int k = GLFW_JOYSTICK_1; k <= GLFW_JOYSTICK_LAST; ++k) {
      if (glfwJoystickIsGamepad(k) == GLFW_FALSE || glfwGetGamepadState(k, &state) == GLFW_FALSE) continue;
      const auto has = [&](int button) { return state.buttons[button] == GLFW_PRESS; };
      return Gamepad{has(GLFW_GAMEPAD_BUTTON_A),
                     has(GLFW_GAMEPAD_BUTTON_B),
                     has(GLFW_GAMEPAD_BUTTON_Y),
                     has(GLFW_GAMEPAD_BUTTON_LEFT_BUMPER),
                     has(GLFW_GAMEPAD_BUTTON_RIGHT_BUMPER),
                     has(GLFW_GAMEPAD_BUTTON_DPAD_UP),
                     has(GLFW_GAMEPAD_BUTTON_DPAD_DOWN),
                     has(GLFW_GAMEPAD_BUTTON_DPAD_LEFT),
                     has(GLFW_GAMEPAD_BUTTON_DPAD_RIGHT),
                     static_cast<double>(state.axes[GLFW_GAMEPAD_AXIS_LEFT_X]),
                     static_cast<double>(state.axes[GLFW_GAMEPAD_AXIS_LEFT_Y])};
    }
    return std::nullopt;
  }
  const std::vector<std::string>& dropped_files() const override { return dropped_; }
  void show(const Scene& scene, std::span<const Shot> shots, const Overlay* overlay) override
  {
    renderer_->present(scene, shots, overlay);
    glfwSwapBuffers(window());
  }
  bool show_again(const Overlay* overlay) override
  {
    if (!renderer_->present_again(overlay)) return false;
    glfwSwapBuffers(window());
    return true;
  }
  WindowGeometry geometry() const override
  {
    WindowGeometry place;
    glfwGetWindowPos(window(), &place.x, &place.y);
    glfwGetFramebufferSize(window(), &place.width, &place.height);
    return place;
  }
  std::vector<Monitor> monitors() const override { return present_monitors(); }
  bool should_close() const override { return glfwWindowShouldClose(window()) == GLFW_TRUE; }
  void close() override { glfwSetWindowShouldClose(window(), GLFW_TRUE); }
  void set_title(const std::string& title) override { glfwSetWindowTitle(window(), title.c_str()); }
  bool is_full_screen() const override { return glfwGetWindowMonitor(window()) != nullptr; }
  void toggle_full_screen() override
  {
    GLFWwindow* const window = window_.get();
    std::array<int, 4>& place = place_;
    if (is_full_screen()) {
      glfwSetWindowMonitor(window, nullptr, place[0], place[1], place[2], place[3], GLFW_DONT_CARE);
      return;
    }
    GLFWmonitor* const monitor = glfwGetPrimaryMonitor();
    const GLFWvidmode* const mode = monitor == nullptr ? nullptr : glfwGetVideoMode(monitor);
    if (mode == nullptr) return;
    glfwGetWindowPos(window, &place[0], &place[1]);
    glfwGetWindowSize(window, &place[2], &place[3]);
    glfwSetWindowMonitor(window, monitor, 0, 0, mode->width, mode->height, mode->refreshRate);
  }
  double content_scale() const override
  {
    float x = 1.0F, y = 1.0F;
    glfwGetWindowContentScale(window(), &x, &y);
    return std::max(x, y);
  }
  bool is_software_rendered() const override { return is_software_; }
  bool is_iconified() const override { return glfwGetWindowAttrib(window(), GLFW_ICONIFIED) == GLFW_TRUE; }

 private:
  GLFWwindow* window() const { return window_.get(); }
  static GlfwWindow& of(GLFWwindow* window)
  {
    return *static_cast<GlfwWindow*>(glfwGetWindowUserPointer(window));
  }

  /// Called by GLFW, so it must not throw.
  void add(InputEvent event) noexcept
  {
    event.x_px = x_px_;
    event.y_px = y_px_;
    const bool is_same_motion =
        event.kind == InputKind::motion && !events_.empty() && events_.back().kind == InputKind::motion;
    if (is_same_motion) {
      events_.back() = event;
    } else {
      events_.push_back(event);
    }
  }

  static void set_modifiers(InputEvent& event, int modifiers)
  {
    event.has_shift = (modifiers & GLFW_MOD_SHIFT) != 0;
    event.has_control = (modifiers & GLFW_MOD_CONTROL) != 0;
  }

  static InputEvent event_of(InputKind kind)
  {
    InputEvent event;
    event.kind = kind;
    return event;
  }

  void moved(double x, double y)
  {
    int width = 1, height = 1;
    glfwGetWindowSize(window(), &width, &height);
    x_px_ = width > 0 ? x * renderer_->width() / width : x;
    y_px_ = height > 0 ? y * renderer_->height() / height : y;
    add(event_of(InputKind::motion));
  }

  void clicked(int button, int action, int modifiers)
  {
    if (button > GLFW_MOUSE_BUTTON_MIDDLE) return;
    InputEvent event = event_of(action == GLFW_PRESS ? InputKind::press : InputKind::release);
    event.button = button == GLFW_MOUSE_BUTTON_LEFT    ? MouseButton::left
                   : button == GLFW_MOUSE_BUTTON_RIGHT ? MouseButton::right
                                                       : MouseButton::middle;
    set_modifiers(event, modifiers);
    if (event.kind == InputKind::press) {
      const double now_s = glfwGetTime();
      const bool is_near =
          std::abs(x_px_ - click_x_px_) < double_click_px && std::abs(y_px_ - click_y_px_) < double_click_px;
      const bool is_second = is_near && button == clicked_button_ && now_s - clicked_s_ < double_click_s;
      event.n_clicks = is_second ? 2 : 1;
      // A third click counts as a first one.
      clicked_s_ = is_second ? -std::numeric_limits<double>::infinity() : now_s;
      clicked_button_ = button;
      click_x_px_ = x_px_;
      click_y_px_ = y_px_;
    }
    add(event);
  }

  void listen_to_mouse()
  {
    glfwSetCursorPosCallback(window(), [](GLFWwindow* w, double x, double y) { of(w).moved(x, y); });
    glfwSetMouseButtonCallback(window(), [](GLFWwindow* w, int button, int action, int modifiers) {
      of(w).clicked(button, action, modifiers);
    });
    glfwSetScrollCallback(window(), [](GLFWwindow* w, double, double y) {
      InputEvent event = event_of(InputKind::wheel);
      event.wheel = y;
      of(w).add(event);
    });
    glfwSetCursorEnterCallback(window(), [](GLFWwindow* w, int) { of(w).add(event_of(InputKind::redraw)); });
  }

  void listen_to_keys()
  {
    glfwSetKeyCallback(window(), [](GLFWwindow* w, int key, int /*code*/, int action, int modifiers) {
      InputEvent event = event_of(action == GLFW_RELEASE ? InputKind::key_release : InputKind::key_press);
      event.key = key_of_code(key);
      set_modifiers(event, modifiers);
      of(w).add(event);
    });
  }

  void listen_to_window()
  {
    glfwSetFramebufferSizeCallback(window(),
                                   [](GLFWwindow* w, int, int) { of(w).add(event_of(InputKind::redraw)); });
    glfwSetWindowFocusCallback(window(), [](GLFWwindow* w, int has_focus) {
      of(w).add(event_of(has_focus == GLFW_TRUE ? InputKind::redraw : InputKind::focus_lost));
    });
    glfwSetDropCallback(window(), [](GLFWwindow* w, int n_files, const char** files) noexcept {
      of(w).dropped_.assign(files, files + n_files);
      of(w).add(event_of(InputKind::drop));
    });
  }

  Library library_;
  std::unique_ptr<GLFWwindow, CloseWindow> window_;
  bool is_software_ = false;
  std::unique_ptr<Renderer> renderer_;
  std::vector<InputEvent> events_;
  std::vector<std::string> dropped_;
  std::array<int, 4> place_{};  // before full screen: x, y, width, height
  double x_px_ = 0.0, y_px_ = 0.0;
  double click_x_px_ = 0.0, click_y_px_ = 0.0;
  double clicked_s_ = -std::numeric_limits<double>::infinity();
  int clicked_button_ = -1;
};

}  // namespace

std::vector<Monitor> connected_monitors()
{
  if (glfwInit() == GLFW_FALSE) return {};
  std::vector<Monitor> monitors = present_monitors();
  glfwTerminate();
  return monitors;
}

std::unique_ptr<Window> open_window(const WindowOptions& options)
{
  return std::make_unique<GlfwWindow>(options);
}

}  // namespace vrda::view
