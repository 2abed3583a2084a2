/// Simulated micro-controller board: the real firmware behind a pseudo-terminal.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

namespace vrda::bench {

struct PtyBoardOptions {
  /// Symbolic link to the terminal, which keeps its name when the board is replugged; empty: no link.
  std::string link;
  /// 0 to 1023. This and the next are called in the board's thread.
  std::function<int()> potentiometer;
  /// Stage position in counts of 5 micrometres, with any offset; the board moves there edge by edge.
  std::function<int()> stage_count;
  /// Corrupts bytes on their way to the host; may be empty.
  std::function<void(std::vector<std::uint8_t>&)> corrupt;
};

/// Runs player/firmware in a thread, with two quadrature signals for the encoder.
class PtyBoard {
 public:
  /// Throws InputError if the terminal or the link cannot be created. The link of a board that was killed is
  /// replaced; that of a running board, of this or another process, and any other link or file is not.
  explicit PtyBoard(const PtyBoardOptions& options);
  ~PtyBoard();

  /// The path to open: the link, or the terminal itself.
  std::string path() const;

  /// Closes the terminal; the board's position is lost.
  void unplug();
  /// Opens a new terminal at the same link; the board restarts. Throws as the constructor does.
  void plug();
  /// Sends bytes that were not requested.
  void send_unrequested(const std::vector<std::uint8_t>& bytes);

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace vrda::bench
