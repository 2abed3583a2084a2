/// Where OpenGL comes from: the only part that differs between off-screen and window.
#pragma once

namespace vrda {

/// An OpenGL 3.3 core context.
class GlContext {
 public:
  using Function = void (*)();

  virtual ~GlContext() = default;
  /// Makes it the calling thread's context.
  virtual void make_current() = 0;
  /// Address of an OpenGL function, or null.
  virtual Function function(const char* name) = 0;
  /// Whether frame buffer 0 is somewhere to be seen.
  virtual bool has_screen() const { return false; }
};

}  // namespace vrda
