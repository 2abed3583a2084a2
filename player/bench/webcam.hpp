/// A calibrated camera and its file (schemas/bench.md).
#pragma once

#include <cstdint>
#include <functional>
#include <iosfwd>
#include <memory>

#include "bench/bench_file.hpp"
#include "bench/body_sheet.hpp"

namespace vrda::bench {

/// Pinhole camera with the lens distortion of Brown (1966): k1, k2, p1, p2, k3.
struct Camera {
  int width = 640, height = 480;  ///< px
  Eigen::Vector2d focal_px = Eigen::Vector2d::Constant(600.0);
  Eigen::Vector2d centre_px{319.5, 239.5};  ///< pixel centres are at whole numbers
  std::array<double, 5> distortion{};
  double rms_px = 0.0;  ///< of the calibration
  int n_views = 0;
};

/// Throws InputError with file and key.
Camera read_camera(const std::string& path);
/// Text of the file; reading it gives equal numbers.
std::string camera_text(const Camera& camera);

/// A grey picture, row by row from the upper left.
struct GreyPicture {
  int width = 0, height = 0;
  std::vector<std::uint8_t> pixels;
};

// Calibration of a camera from pictures of the printed board (body_sheet.hpp).

/// Collects views of the board and fits the camera to them.
class CameraFit {
 public:
  /// `n_views`: enough.
  explicit CameraFit(int n_views = 20);
  ~CameraFit();

  /// Takes a picture if it shows the board differently from all earlier views. Returns the outcome:
  /// "view 3 of 20", or why it was left out.
  std::string take(const GreyPicture& picture);
  bool is_complete() const;

  /// Throws InputError naming `file` if the views cannot determine the camera: an error above 1 px, or a
  /// focal length known to less than 1 %.
  Camera camera(const std::string& file) const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

// Pictures of a camera, or of a film or a numbered sequence of files ("folder/picture_%03d.png") in its
// place; these repeat.

struct TimedPicture {
  GreyPicture picture;
  std::int64_t taken_ns = 0;  ///< steady clock; a camera's own stamp if it has one
  bool is_frozen = false;     ///< equal in every pixel to the one before: no camera's noise repeats
};

class PictureSource {
 public:
  /// Throws InputError if the device cannot be opened.
  explicit PictureSource(const CameraSettings& camera);
  ~PictureSource();

  /// Waits for the next picture. Throws InputError if none comes.
  TimedPicture next();

 private:
  struct State;
  std::unique_ptr<State> state_;
};

// Poses of the printed bodies in one grey picture of a calibrated camera.

enum class BodyState {
  seen,
  hidden,     ///< no marker visible
  ambiguous,  ///< too few markers to know the tilt: one, or two of a face far away
  misfit      ///< the markers do not fit the body: wrong fold, bent sheet, or a false marker
};
/// As in messages: "ambiguous".
const char* name_of(BodyState state);

struct FoundBody {
  BodyState state = BodyState::hidden;
  /// Camera axes: x right, y down, z forwards; mm. Valid if seen.
  Pose X_camera_body = Pose::Identity();
  int n_markers = 0;
  double rms_px = 0.0;  ///< distance of the corners from their projections
};

struct PoseFinderOptions {
  BodySheet sheet;
  std::size_t n_bodies = 2;
  /// Corners of a correct body are within 0.6 px at 1 m with blur and noise; a fold 30 degrees wrong gives
  /// more than 1 px. A wrong focal length or size of the markers changes the distance, not the fit.
  double most_rms_px = 1.0;
  double remembered_s = 0.5;  ///< the last pose resolves an ambiguous one for this long
};

class PoseFinder {
 public:
  PoseFinder(const Camera& camera, const PoseFinderOptions& options);
  ~PoseFinder();

  /// `time_s`: of the picture, ascending. Throws InputError if the picture's size is not the camera's.
  std::vector<FoundBody> find(const GreyPicture& picture, double time_s);

 private:
  struct State;
  std::unique_ptr<State> state_;
};

// Commands of `vrda-webcam`: track the printed bodies, print the sheets, calibrate the camera. Throw
// InputError.

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
