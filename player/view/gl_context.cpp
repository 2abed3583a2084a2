// An OpenGL context without a screen, by EGL.
#include "view/gl_context.hpp"

// Excludes the types of window systems.
#define EGL_NO_X11
#include <EGL/egl.h>
#include <EGL/eglext.h>
#include <GL/osmesa.h>

#include <array>
#include <string>

#include "core/text.hpp"

namespace vrda::view {
namespace {

bool has_extension(EGLDisplay display, const std::string& name)
{
  const char* const all = eglQueryString(display, EGL_EXTENSIONS);
  return all != nullptr && (" " + std::string(all) + " ").find(" " + name + " ") != std::string::npos;
}

/// An initialised display, or EGL_NO_DISPLAY.
EGLDisplay opened_display(EGLenum platform, void* device)
{
  const auto get_display =
      reinterpret_cast<PFNEGLGETPLATFORMDISPLAYEXTPROC>(eglGetProcAddress("eglGetPlatformDisplayEXT"));
  if (get_display == nullptr) return EGL_NO_DISPLAY;
  const EGLDisplay display = get_display(platform, device, nullptr);
  if (display == EGL_NO_DISPLAY || eglInitialize(display, nullptr, nullptr) == EGL_FALSE)
    return EGL_NO_DISPLAY;
  return display;
}

EGLDisplay display_of_first_device()
{
  const auto query_devices =
      reinterpret_cast<PFNEGLQUERYDEVICESEXTPROC>(eglGetProcAddress("eglQueryDevicesEXT"));
  if (query_devices == nullptr) return EGL_NO_DISPLAY;
  std::array<EGLDeviceEXT, 8> devices{};
  EGLint n_devices = 0;
  if (query_devices(static_cast<EGLint>(devices.size()), devices.data(), &n_devices) == EGL_FALSE)
    n_devices = 0;
  for (EGLint i = 0; i < n_devices; ++i) {
    const EGLDisplay display = opened_display(EGL_PLATFORM_DEVICE_EXT, devices[static_cast<std::size_t>(i)]);
    if (display != EGL_NO_DISPLAY) return display;
  }
  return EGL_NO_DISPLAY;
}

EGLDisplay display_without_screen()
{
  EGLDisplay display = EGL_NO_DISPLAY;
  if (has_extension(EGL_NO_DISPLAY, "EGL_MESA_platform_surfaceless"))
    display = opened_display(EGL_PLATFORM_SURFACELESS_MESA, EGL_DEFAULT_DISPLAY);
  if (display == EGL_NO_DISPLAY && has_extension(EGL_NO_DISPLAY, "EGL_EXT_platform_device"))
    display = display_of_first_device();
  return display;
}

class EglContext final : public GlContext {
 public:
  EglContext() : display_(display_without_screen())
  {
    const auto refuse = [](const char* found, const char* wanted) {
      throw InputError({"libEGL", "context", found, wanted});
    };
    if (display_ == EGL_NO_DISPLAY)
      refuse("no surfaceless display", "EGL_MESA_platform_surfaceless or EGL_EXT_platform_device");
    if (!has_extension(display_, "EGL_KHR_surfaceless_context") ||
        !has_extension(display_, "EGL_KHR_no_config_context"))
      refuse("no context without a surface", "EGL_KHR_surfaceless_context and EGL_KHR_no_config_context");
    constexpr EGLint profile = EGL_CONTEXT_OPENGL_PROFILE_MASK, core = EGL_CONTEXT_OPENGL_CORE_PROFILE_BIT;
    constexpr std::array wanted{
        EGL_CONTEXT_MAJOR_VERSION, 3, EGL_CONTEXT_MINOR_VERSION, 3, profile, core, EGL_NONE};
    if (eglBindAPI(EGL_OPENGL_API) == EGL_TRUE)
      context_ = eglCreateContext(display_, EGL_NO_CONFIG_KHR, EGL_NO_CONTEXT, wanted.data());
    if (context_ == EGL_NO_CONTEXT) refuse("no OpenGL 3.3 core profile", "a driver with OpenGL 3.3");
  }
  ~EglContext() override
  {
    // The display stays initialised, since other contexts of the process may use it.
    if (eglGetCurrentContext() == context_)
      eglMakeCurrent(display_, EGL_NO_SURFACE, EGL_NO_SURFACE, EGL_NO_CONTEXT);
    eglDestroyContext(display_, context_);
  }
  EglContext(const EglContext&) = delete;
  EglContext& operator=(const EglContext&) = delete;

  void make_current() override
  {
    const EGLBoolean done = eglMakeCurrent(display_, EGL_NO_SURFACE, EGL_NO_SURFACE, context_);
    check(done == EGL_TRUE, "an EGL context can be made current");
  }
  Function function(const char* name) override { return eglGetProcAddress(name); }

 private:
  EGLDisplay display_;
  EGLContext context_ = EGL_NO_CONTEXT;
};

}  // namespace

std::unique_ptr<GlContext> make_egl_context()
{
  return std::make_unique<EglContext>();
}

// An OpenGL context in memory on the processor, by OSMesa.

namespace {

class OsmesaContext final : public GlContext {
 public:
  OsmesaContext()
  {
    // Pairs of name and value.
    constexpr int wanted[][2] = {{OSMESA_FORMAT, OSMESA_RGBA},
                                 {OSMESA_DEPTH_BITS, 0},
                                 {OSMESA_STENCIL_BITS, 0},
                                 {OSMESA_ACCUM_BITS, 0},
                                 {OSMESA_PROFILE, OSMESA_CORE_PROFILE},
                                 {OSMESA_CONTEXT_MAJOR_VERSION, 3},
                                 {OSMESA_CONTEXT_MINOR_VERSION, 3},
                                 {0, 0}};
    context_ = OSMesaCreateContextAttribs(*wanted, nullptr);
    if (context_ == nullptr) {
      throw InputError(
          {"libOSMesa", "context", "no OpenGL 3.3 core profile", "Mesa 22 or later with llvmpipe"});
    }
  }
  ~OsmesaContext() override { OSMesaDestroyContext(context_); }
  OsmesaContext(const OsmesaContext&) = delete;
  OsmesaContext& operator=(const OsmesaContext&) = delete;

  void make_current() override
  {
    if (OSMesaGetCurrentContext() == context_) return;
    const GLboolean done =
        OSMesaMakeCurrent(context_, pixels_.data(), GL_UNSIGNED_BYTE, int{side}, int{side});
    check(done == GL_TRUE, "an OSMesa context can be made current");
  }
  Function function(const char* name) override { return OSMesaGetProcAddress(name); }

 private:
  static constexpr std::size_t side = 4;  // pixels; required by OSMesa, never drawn to
  OSMesaContext context_ = nullptr;
  std::array<unsigned char, side * side * 4> pixels_{};
};

}  // namespace

std::unique_ptr<GlContext> make_osmesa_context()
{
  return std::make_unique<OsmesaContext>();
}

}  // namespace vrda::view
