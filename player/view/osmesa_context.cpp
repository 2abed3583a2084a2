// An OpenGL context in memory on the processor, by OSMesa.
#include "view/gl_context.hpp"

#include <GL/osmesa.h>

#include <array>

#include "core/error.hpp"

namespace vrda::view {
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
