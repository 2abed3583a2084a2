#include "player/view/screen.hpp"

#include <cctype>
#include <chrono>
#include <cstdlib>
#include <sstream>
#include <stdexcept>
#include <string>
#include <thread>

namespace vrda::test {

bool comes_true(const std::function<bool()>& claim)
{
  for (int i = 0; i < 600; ++i) {
    if (claim()) return true;
    std::this_thread::sleep_for(std::chrono::milliseconds(100));
  }
  return false;
}
namespace {

/// The display number that the server writes once it listens; empty until then.
std::string display_number(const std::string& said)
{
  std::istringstream lines(said);
  for (std::string line; std::getline(lines, line) && !lines.eof();) {
    if (!line.empty() && line.find_first_not_of("0123456789") == std::string::npos) return line;
  }
  return {};
}

}  // namespace

Screen::Screen()
    : server_({"/usr/bin/Xvfb",
               {"-displayfd", "2", "-screen", "0", "1280x1024x24", "-nolisten", "tcp", "-noreset", "-fbdir",
                folder_.path().string()},
               {},
               {}})
{
  // Takes a second on an idle machine; waits up to a minute.
  comes_true([&] { return !display_number(server_.said()).empty() || !server_.is_running(); });
  const std::string number = display_number(server_.said());
  if (number.empty()) throw std::runtime_error("Xvfb does not start: " + server_.said());
  setenv("DISPLAY", (":" + number).c_str(), 1);
}

Screen::~Screen()
{
  unsetenv("DISPLAY");
}

// The file is in the form of xwd: a header of big-endian 32-bit numbers, colours of 12 bytes, then rows of
// pixels of 32 bits, blue first.
view::Image Screen::picture(int width, int height) const
{
  const std::string bytes = read_bytes(folder_.path() / "Xvfb_screen0");
  const auto byte = [&](std::size_t i) { return static_cast<std::uint8_t>(bytes.at(i)); };
  const auto number = [&](std::size_t i) {
    return std::size_t{byte(4 * i)} << 24 | std::size_t{byte(4 * i + 1)} << 16 |
           std::size_t{byte(4 * i + 2)} << 8 | std::size_t{byte(4 * i + 3)};
  };
  const std::size_t first = number(0) + 12 * number(19), stride = number(12);
  view::Image image{width, height, {}};
  for (std::size_t y = 0; y < static_cast<std::size_t>(height); ++y) {
    for (std::size_t x = 0; x < static_cast<std::size_t>(width); ++x) {
      const std::size_t i = first + y * stride + 4 * x;
      image.rgba.insert(image.rgba.end(), {byte(i + 2), byte(i + 1), byte(i), 255});
    }
  }
  return image;
}

}  // namespace vrda::test
