/// A screen without a monitor.
#pragma once

#include "render/image.hpp"
#include "support/process.hpp"
#include "support/scratch.hpp"

namespace vrda::test {

/// Xvfb on a free display; DISPLAY names it from then on. The destructor ends the server it started.
class Screen {
 public:
  Screen();
  ~Screen();
  Screen(const Screen&) = delete;
  Screen& operator=(const Screen&) = delete;

  /// The upper left part of what is on it.
  Image picture(int width, int height) const;

 private:
  Scratch folder_;  // with the screen's memory as a file
  Process server_;
};

}  // namespace vrda::test
