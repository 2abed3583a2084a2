/// What a search tells those who watch it: the rooms solve, journal, store and app pass it on.
/// Frame S and its units: core/frames.hpp.
#pragma once

#include <cstdint>
#include <vector>

#include "core/frames.hpp"
#include "core/step_record.hpp"

namespace vrda {

/// The values are those of the trace file and its journal.
enum class MoveKind : std::uint8_t {
  retreat = 0,    ///< against Delta, out of an overlap
  approach = 1,   ///< along Delta
  bisect = 2,     ///< a trial on the way of the approach, rotation or translation that is told next
  rotate = 3,     ///< about Delta
  translate = 4,  ///< across Delta
};

inline constexpr MoveKind all_move_kinds[] = {MoveKind::retreat, MoveKind::approach, MoveKind::bisect,
                                              MoveKind::rotate, MoveKind::translate};

const char* name_of(MoveKind kind);

/// One modelling step. Each iteration has one move in contact, the approach that ends in the touch; an
/// iteration in which nothing is in the way has no move at all.
struct SearchMove {
  std::int32_t iteration = 0;  ///< 0: the retreat from the seed
  MoveKind kind = MoveKind::approach;
  MovingPose pose;                   ///< after the move; of a bisection's trial, where it was tried
  double translation_step_mm = 0.0;  ///< in force; of a move in contact, after cycle detection
  double rotation_step_rad = 0.0;
  bool collides = false;                ///< a trial that was blocked
  bool is_cycle = false;                ///< in contact at an earlier pose, within both resolutions
  bool in_contact = false;              ///< the approach has ended
  std::vector<ContactRecord> contacts;  ///< of a move in contact: those that predict the next motion
};

/// One search, from the seed to its end.
struct SearchTrace {
  StepKey key;
  MovingPose seed;
  StepStatus status = StepStatus::pending;
  std::vector<SearchMove> moves;
};

}  // namespace vrda
