/// What the bench consists of: its display, tracker and board, and which input drives what.
#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "devices/devices.hpp"
#include "optics/viewport.hpp"
#include "setup/calibration_settings.hpp"
#include "simulation/script.hpp"

namespace vrda {

struct DisplaySettings {
  int width = 1280, height = 1024;  ///< of the frame buffer, px
  Layout layout = Layout::quarters;
  EyeWindows windows;  ///< those of the layout, or as the file has them
  double refresh_hz = 60.0;
  /// Of the frame buffer's top left corner, px of the desktop; nothing: an ordinary window.
  std::optional<std::array<int, 2>> at;
};

enum class LegKind {
  rigid,      ///< the thesis's mannequin: one body; the angle comes from a parameter
  two_bodies  ///< femur and tibia are tracked: flexion and varus come from them
};
enum class HeadKind {
  stage,   ///< on the parallax stage, along one line
  tracker  ///< a body on the display
};

/// Bodies by what they are fastened to.
enum class BodyRole { leg, femur, tibia, head };
inline constexpr std::size_t n_body_roles = 4;
const char* name_of(BodyRole role);

/// A tool that the tracker gives the pose of, or markers that it gives the positions of.
struct BodySettings {
  std::string tool;                              ///< empty: markers
  std::vector<std::string> markers;              ///< tools of the tracker, labelled
  std::vector<Eigen::Vector3d> markers_body_mm;  ///< where they are on the body; empty: not measured yet
  double marker_interval_ms = 0.0;               ///< they fire one after another, that far apart
};

/// One-Euro filter of the leg's angles.
struct FilterSettings {
  bool is_on = true;
  double least_cutoff_hz = 1.5;
  double slope = 0.3;  ///< Hz of cutoff for each degree a second
};

struct BenchFile {
  std::string path, title;
  std::string text;  ///< whole, for recordings
  DisplaySettings display;
  LegKind leg = LegKind::two_bodies;
  HeadKind head = HeadKind::stage;
  std::array<std::optional<BodySettings>, n_body_roles> bodies;  ///< of the roles that leg and head want
  /// Its tools: those of the bodies, in order, each once; with [calibration] its probe and marker behind
  /// them.
  std::optional<TrackerSettings> tracker;
  CalibrationSettings calibration;
  std::optional<BoardSettings> board;
  double stage_mm_per_count = 0.005;
  std::string potentiometer;  ///< the parameter it drives, "selected": the one keys select; empty: none
  FilterSettings filter;
  std::string simulation_address = "127.0.0.1";  ///< that `vrda-player simulate` listens on: a number
  SimulationScript simulation;  ///< what `vrda-player simulate` plays; bodies and tools as above
  double prediction_ms = 0.0;   ///< how far ahead tracked bodies are predicted at first; 0: not
};

/// The tracker's tools of a body: itself, or its markers.
std::size_t n_tools(const BodySettings& body);
/// Row of the tracker's tools where those of a role begin.
std::size_t first_tool_of(const BenchFile& bench, BodyRole role);

/// Whether a body of markers has to say where they are on it.
enum class MarkerPlaces { needed, may_be_missing };

/// Reads a TOML file as schemas/bench.md describes it. Throws InputError naming file and key.
BenchFile read_bench_file(const std::string& path, MarkerPlaces places = MarkerPlaces::needed);
/// The same from the text of a file; `path` is for errors.
BenchFile parsed_bench_file(const std::string& text, const std::string& path,
                            MarkerPlaces places = MarkerPlaces::needed);

}  // namespace vrda
