/// One search of a trace as a row of poses.
#pragma once

#include <string>
#include <vector>

#include "motion/surfaces.hpp"
#include "store/trace.hpp"

namespace vrda {

struct FilmOptions {
  AttitudeFilter cell;        ///< default: the spine's cell, at the first flexion
  bool contact_only = false;  ///< leave out the seed and the moves that are not in contact (thesis 3.8)
  int every = 1;              ///< only every so many; the last always
};

struct Film {
  Attitude attitude;
  std::vector<PoseNumbers> frames;  ///< the seed, then the moves in their order
};

/// The search that ended in the motion model at the cell asked for. `file` is for errors: InputError when
/// there is no such search, or when nothing of it is left.
Film film_of(const Trace& trace, const std::string& file, const FilmOptions& options);

}  // namespace vrda
