/// Configuration of a bench: display, tracker, board, tracked bodies and input mapping.
#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "bench/calibration_settings.hpp"
#include "core/units.hpp"
#include "bench/devices.hpp"
#include "view/viewport.hpp"
#include "bench/script.hpp"

namespace vrda::bench {

struct DisplaySettings {
  int width = 1280, height = 1024;  ///< frame buffer size, px
  view::Layout layout = view::Layout::quarters;
  view::EyeWindows windows;  ///< from the layout unless the file sets them
  double refresh_hz = 60.0;
  /// Top left corner of the frame buffer on the desktop, px; empty: an ordinary window.
  std::optional<std::array<int, 2>> at;
  std::vector<std::string> outputs;  ///< names of the monitors that display the frame buffer; instead of `at`
  view::Reflection reflection;     ///< of what each window displays, for a mirror in front of the eye
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
inline constexpr std::size_t n_body_roles = 4;
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
  std::array<std::optional<BodySettings>, n_body_roles> bodies;  ///< for the roles that leg and head require
  /// Tools in order: those of the bodies, then with [calibration] the probe and the marker; each once.
  std::optional<bench::TrackerSettings> tracker;
  std::optional<CameraSettings> camera;  ///< the tracker is a webcam
  CalibrationSettings calibration;
  std::optional<bench::BoardSettings> board;
  double stage_mm_per_count = 0.005;
  std::string potentiometer;  ///< parameter it drives; "selected": the one chosen by keys; empty: none
  FilterSettings filter;
  std::string simulation_address = "127.0.0.1";  ///< numeric listening address of `vrda-player simulate`
  bench::SimulationScript
      simulation;              ///< what `vrda-player simulate` plays, with the bodies and tools above
  double prediction_ms = 0.0;  ///< initial prediction time of tracked bodies; 0: no prediction
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
