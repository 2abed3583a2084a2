/// The mode `body`: a body of markers measured with the bench's tracker.
#pragma once

#include <string>

#include "loop/loop.hpp"
#include "setup/bench_file.hpp"
#include "tracking/rigid_body.hpp"

namespace vrda {

struct MeasureBodyOptions {
  std::string role, bench;
  double seconds = 10.0;
  bool is_quiet = false;
};

/// Listens to the tracker and writes the body's lines for the bench file, with residual and expected error as
/// comments. Throws InputError, for markers that make no body too.
void measure_body(const MeasureBodyOptions& options, const Streams& streams);

/// The body that `frames` show, in the frame of the file's markers_mm where they stand there. Throws
/// InputError naming the bench file, the body and its markers.
BuiltBody body_from(const std::vector<MarkerRow>& frames, const BenchFile& bench, BodyRole role);

/// The lines.
std::string body_text(const BuiltBody& built, const BenchFile& bench, BodyRole role);

}  // namespace vrda
