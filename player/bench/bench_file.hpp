/// The [calibration] table of a bench file: equipment and number of repeats of the calibration.
#pragma once

#include "bench/devices.hpp"
#include "bench/simulation.hpp"
#include "view/eye.hpp"

namespace vrda::bench {

struct CalibrationRectangle {
  double width_mm = 0.0, depth_mm = 0.0;  ///< depth behind the plane of the first rectangle
};

struct CalibrationPoint {
  std::string name;
  Eigen::Vector3d p_model_mm = Eigen::Vector3d::Zero();  ///< canonical axes, as stored in the motion model
  bool is_target = false;                                ///< excluded from the fit
};

struct CalibrationLandmarks {
  std::string name;
  double model_mm = 0.0;  ///< distance between them in the model
};

/// Fewest marks of a fit of an eyepoint and of a distortion, and least range of their depths.
inline constexpr std::size_t least_rectangle_marks = 3;
inline constexpr double least_depth_range_mm = 1.0;
inline constexpr std::size_t least_grid_marks = 12;

struct FunctionalSettings {
  /// Initial noise of each tracked body: of each coordinate of its position, of the rotation about each axis.
  /// The fit estimates a common factor.
  double tracker_sd_mm = 0.3, tracker_sd_rad = rad_from_deg(0.3);
  /// Root mean square deviation of the subject's joint from the model along flexion: length, angle.
  double model_sd_mm = 1.0, model_sd_rad = rad_from_deg(2.0);
};

struct CalibrationSettings {
  bool is_present = false;  ///< the file contains the table

  int edge_repeats = 4;
  double screen_sd_mm = 0.1;  ///< of a ruler reading on the screen

  bool is_grid_adjusted = false;  ///< distortion = "adjust": a whole grid by coefficients; "marks": by node
  int grid_columns = 7, grid_rows = 5;
  int grid_repeats = 3;  ///< adjusted grids

  std::vector<CalibrationRectangle> rectangles = {{150, 0}, {200, 150}, {250, 300}, {300, 450}};
  int rectangle_repeats = 3;
  double alignment_sd_rad = rad_from_deg(0.3);  ///< of the display arms' line of sight about the table's Z
  double sight_sd_px = 3.0;                     ///< of the optical axis about the centre of the visible part

  bool has_pupillometer = true;
  double pupillometer_sd_mm = 0.5;
  double eye_height_sd_mm = 1.0;  ///< of the height difference of the eyes

  std::string probe = "probe";    ///< tracker tool with a pose
  std::string marker = "marker";  ///< tracker tool with a position, for the rails and the bull's-eyes
  int rail_samples = 200, pivot_samples = 300, hold_samples = 30;  ///< tracker samples: sweep, pivot, still
  int bullseyes = 9;

  bool is_model_adjusted =
      false;  ///< model = "adjust": pose by eye; "fiducials": points touched with the probe
  int model_repeats = 3;
  std::vector<CalibrationPoint> points;        ///< on the leg; on the femur with two bodies
  std::vector<CalibrationPoint> tibia_points;  ///< only with two bodies
  std::vector<CalibrationLandmarks> landmarks;

  int bends = 4, bend_samples = 300;  ///< functional: motions of the leg, tracker samples of each
  /// functional: noise of a tracked body, and deviation of the subject's joint from the model
  FunctionalSettings functional;
};

// Configuration of a bench: display, tracker, board, tracked bodies and input mapping.

struct DisplaySettings {
  int width = 1280, height = 1024;  ///< frame buffer size, px
  view::Layout layout = view::Layout::quarters;
  view::EyeWindows windows;  ///< from the layout unless the file sets them
  double refresh_hz = 60.0;
  /// Top left corner of the frame buffer on the desktop, px; empty: an ordinary window.
  std::optional<std::array<int, 2>> at;
  std::vector<std::string> outputs;  ///< names of the monitors that display the frame buffer; instead of `at`
  view::Reflection reflection;       ///< of what each window displays, for a mirror in front of the eye
  bool is_half_width = false;        ///< the display draws each pixel twice as wide as high
};

enum class LegKind {
  rigid,      ///< one body (the thesis's mannequin); flexion and varus are parameters
  two_bodies  ///< femur and tibia are tracked; flexion and varus are measured
};
enum class HeadKind {
  stage,   ///< moves along the parallax stage
  tracker  ///< tracked by a body on the display
};

/// What a tracked body is attached to.
enum class BodyRole { leg, femur, tibia, head };
inline constexpr std::array body_roles{BodyRole::leg, BodyRole::femur, BodyRole::tibia, BodyRole::head};
inline constexpr std::size_t n_body_roles = body_roles.size();
/// A value for each role.
template <typename Value>
struct ByRole : std::array<Value, n_body_roles> {
  using std::array<Value, n_body_roles>::operator[];
  constexpr Value& operator[](BodyRole role) { return (*this)[static_cast<std::size_t>(role)]; }
  constexpr const Value& operator[](BodyRole role) const { return (*this)[static_cast<std::size_t>(role)]; }
};
/// Key of the role in files and its name on screen: "femur".
const char* name_of(BodyRole role);

/// A tracked body: one tool with a pose, or several markers with positions.
struct BodySettings {
  std::string tool;                              ///< empty: markers
  std::vector<std::string> markers;              ///< tracker tools, one per marker
  std::vector<Eigen::Vector3d> markers_body_mm;  ///< positions in the body frame; empty: not measured yet
  double marker_interval_ms = 0.0;               ///< time between the firing of successive markers
};

/// One-Euro filter of the leg angles.
struct FilterSettings {
  bool is_on = true;
  double least_cutoff_hz = 1.5;
  double slope = 0.3 * deg_from_rad(1.0);  ///< cutoff increase, Hz per rad/s
};

/// The webcam of `tracker = "aruco"` (room webcam).
struct CameraSettings {
  std::string device;             ///< or a film, or a numbered sequence of pictures
  int width = 640, height = 480;  ///< px
  double rate_hz = 30.0;
  std::string calibration;  ///< camera file; relative to the bench file in it, to the process here
  double marker_mm = 40.0, fold_rad = rad_from_deg(90.0);  ///< of the printed bodies
};

struct BenchFile {
  std::string path, title;
  std::string text;  ///< whole file, stored in recordings
  DisplaySettings display;
  LegKind leg = LegKind::two_bodies;
  HeadKind head = HeadKind::stage;
  ByRole<std::optional<BodySettings>> bodies;  ///< for the roles that leg and head require
  /// Tools in order: those of the bodies, then with [calibration] the probe and the marker; each once.
  std::optional<TrackerSettings> tracker;
  std::optional<CameraSettings> camera;  ///< the tracker is a webcam
  CalibrationSettings calibration;
  std::optional<BoardSettings> board;
  double stage_mm_per_count = 0.005;
  std::string potentiometer;  ///< parameter it drives; "selected": the one chosen by keys; empty: none
  FilterSettings filter;
  std::string simulation_address = "127.0.0.1";  ///< numeric listening address of `vrda-player simulate`
  SimulationScript simulation;  ///< what `vrda-player simulate` plays, with the bodies and tools above
  double prediction_ms = 0.0;   ///< initial prediction time of tracked bodies; 0: no prediction
};

/// Number of tracker tools of a body: 1, or the number of its markers.
std::size_t n_tools(const BodySettings& body);
/// Index of the first tracker tool of a role.
std::size_t first_tool_index(const BenchFile& bench, BodyRole role);

/// Whether a body of markers must contain the marker positions.
enum class MarkerPositions { required, optional };

/// Reads a bench file (schemas/bench.md). Throws InputError with file and key.
BenchFile read_bench_file(const std::string& path, MarkerPositions places = MarkerPositions::required);
/// The same from the file's text; `path` is used in errors.
BenchFile parse_bench_file(const std::string& text, const std::string& path,
                           MarkerPositions places = MarkerPositions::required);

}  // namespace vrda::bench
