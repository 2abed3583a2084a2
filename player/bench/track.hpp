/// Commands of `vrda-webcam`: track the printed bodies, print the sheets, calibrate the camera. Throw
/// InputError.
#pragma once

#include <functional>
#include <iosfwd>
#include <string>

namespace vrda::bench {

/// Takes the bytes of OpenIGTLink messages; false ends the tracking.
using ByteSink = std::function<bool(const std::string& bytes)>;

/// Sends a TDATA message a picture with the bodies that are seen, under the names of the bench file's tools,
/// until the sink ends it. Time stamps are those of the pictures, steady clock. A body whose markers do not
/// fit has an invalid pose. A frozen picture sends nothing.
void track(const std::string& bench, const ByteSink& sink);

/// A STATUS message with an error, for the reader of track().
std::string error_message(const std::string& text);

/// The sheets of the bench file's bodies as a PDF file.
void write_sheets(const std::string& bench, const std::string& pdf);

struct CalibrateOptions {
  std::string bench;
  std::string output;  ///< empty: the bench file's camera.calibration
  int n_views = 20;
  double seconds = 300.0;  ///< at most
};

/// Takes views of the board until they are enough, then writes the camera's file.
void calibrate(const CalibrateOptions& options, std::ostream& messages);

}  // namespace vrda::bench
