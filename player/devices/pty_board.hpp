/// The micro-controller's board that is none: its firmware behind a pseudo-terminal.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

namespace vrda {

struct PtyBoardOptions {
  /// A symbolic link to the terminal, which stays the same when the board returns; empty: none.
  std::string link;
  /// 0 to 1023. This and the next are called in the board's thread.
  std::function<int()> potentiometer;
  /// The stage's place in counts of 5 micrometres, of any begin; it gets there edge by edge.
  std::function<int()> stage_count;
  /// What the line does to the bytes on their way; may be empty.
  std::function<void(std::vector<std::uint8_t>&)> spoil;
};

/// Runs player/firmware in a thread of its own: what the real board runs, with two square signals for the
/// encoder.
class PtyBoard {
 public:
  /// Throws InputError where no terminal or link can be made; a link to a terminal that is in the way is
  /// replaced, any other link and a file are not.
  explicit PtyBoard(const PtyBoardOptions& options);
  ~PtyBoard();
  PtyBoard(const PtyBoard&) = delete;
  PtyBoard& operator=(const PtyBoard&) = delete;

  /// What to open: the link, or the terminal itself.
  std::string path() const;

  /// Pulls the plug: the terminal is gone, and the board's position with it.
  void unplug();
  /// A new terminal, at the same link; the board starts anew. Throws as the constructor does.
  void plug();
  /// Bytes that nobody asked for.
  void say(const std::vector<std::uint8_t>& bytes);

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace vrda
