/// The mode `calibrate`.
#pragma once

#include "app/calibrate_options.hpp"
#include "app/show.hpp"

namespace vrda {

enum class CalibrateEnd {
  finished,
  left  ///< before all that was asked for is done; the file holds what is
};

/// Throws InputError for everything a user can put right before it begins.
CalibrateEnd calibrate(const CalibrateOptions& options, const ShowStreams& streams);

}  // namespace vrda
