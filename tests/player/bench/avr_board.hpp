/// The firmware for the ATmega328P in simavr, behind a pseudo-terminal: the real machine code with its serial
/// line, converter and interrupts. In: the firmware's ELF file, knob and stage. Units: counts of 5
/// micrometres.
#pragma once

#include "bench/simulated_devices.hpp"

namespace vrda::test {

struct AvrBoardOptions {
  /// As for the simulated board; the stage moves towards `stage_count` at `counts_a_second`.
  bench::PtyBoardOptions signals;
  int counts_a_second = 100'000;
  /// If not, the simulation runs as fast as the machine allows, else at most in real time.
  bool is_paced = true;
};

class AvrBoard {
 public:
  explicit AvrBoard(const AvrBoardOptions& options);
  ~AvrBoard();

  std::string path() const;
  /// Pulls the reset line; the stage stays where it is.
  void reset();
  /// Both signals change at once, as for a missed edge: a step over two states.
  void skip_state();
  double simulated_s() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace vrda::test
