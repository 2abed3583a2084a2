/// One search of a trace as a sequence of poses.
#pragma once

#include <string>
#include <vector>

#include "store/surfaces.hpp"
#include "store/trace.hpp"

namespace vrda::store {

struct FilmOptions {
  store::AttitudeFilter cell;  ///< default: the spine cell of the first flexion
  bool contact_only = false;   ///< omit the seed and moves without contact (thesis 3.8)
  int every = 1;               ///< keep every Nth frame and the last
};

struct Film {
  Attitude attitude;
  std::vector<PoseCoordinates> frames;  ///< the seed, then the moves in order
};

/// Returns the search whose result is the requested cell of the motion model. Throws InputError naming `file`
/// if the search is missing or no frame remains.
Film film_of(const store::Trace& trace, const std::string& file, const FilmOptions& options);

}  // namespace vrda::store
