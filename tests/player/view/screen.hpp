/// A virtual screen.
#pragma once

#include "support/process.hpp"
#include "support/scratch.hpp"
#include "view/image.hpp"

namespace vrda::test {

/// Polls for up to a minute, for busy machines.
bool comes_true(const std::function<bool()>& claim);

/// Starts Xvfb on a free display and sets DISPLAY. The destructor ends the server.
class Screen {
 public:
  Screen();
  ~Screen();
  Screen(const Screen&) = delete;
  Screen& operator=(const Screen&) = delete;

  /// The upper left part of the screen.
  view::Image picture(int width, int height) const;

 private:
  Scratch folder_;  // contains the screen's memory as a file
  Process server_;
};

}  // namespace vrda::test
