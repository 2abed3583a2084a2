/// Keys from a file instead of a hand, for trials that nobody attends.
#pragma once

#include <string>
#include <vector>

#include "view/keys.hpp"

namespace vrda {

struct ScriptLine {
  KeyPress press;
  int n_presses = 0;    ///< 0: it waits
  double wait_s = 0.0;  ///< of the loop, before the next line
};

/// "press Right 12", "press Shift+Left 3", "press Enter", "wait 0.5"; behind # nothing counts. Keys are
/// letters, digits, Enter, Backspace, Escape, Space, Left, Right, Up, Down, with Shift+ or Control+ or both.
/// Throws InputError naming `path` and the line.
std::vector<ScriptLine> parsed_key_script(const std::string& text, const std::string& path);

/// Gives the keys as time goes on.
class KeyScript {
 public:
  explicit KeyScript(std::vector<ScriptLine> lines) : lines_(std::move(lines)) {}

  /// What is pressed at `now_s` of the loop: of one line at a time, so that each is answered before the next.
  /// Valid until the next call.
  const std::vector<KeyPress>& keys(double now_s);
  bool is_over() const { return next_ == lines_.size(); }

 private:
  std::vector<ScriptLine> lines_;
  std::vector<KeyPress> keys_;
  std::size_t next_ = 0;
  double begun_s_ = -1.0;  ///< of the wait under way; below 0: none
};

}  // namespace vrda
