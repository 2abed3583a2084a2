/// The user interface over the scene: readouts, timeline, controls, help. In: the player's state (rad, mm)
/// and pointer events (px from the upper left). Out: the user's changes of that state; displayed angles are
/// in degrees.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "model/coordinates.hpp"
#include "view/labels.hpp"
#include "view/overlay_text.hpp"
#include "view/player_state.hpp"
#include "view/readings.hpp"
#include "view/renderer.hpp"
#include "view/scene.hpp"
#include "view/structures.hpp"

namespace vrda::view {

/// Constant while a file is shown.
struct GuiOptions {
  std::string title;
  std::vector<std::string> sets;  ///< from set_names(); PlayerState::set is an index into them
  double scale = 1.0;             ///< of text and controls: the monitor's content scale
  std::string reference = "femur", moving = "tibia";  ///< names of the bodies on screen
  std::string joint = "knee";                         ///< kind, whose words the numbers have
  std::vector<std::string> warnings = {};             ///< of the model, above the picture
  bool has_doubtful_poses = false;                    ///< leaves room for Readout::doubt
  bool has_differences = false;                       ///< leaves room for GuiFrame::differences
  std::vector<std::string> verdicts = {};             ///< of `sets`, one sentence each; or empty
  RotationPlots rotations = {};                       ///< of `sets`
  std::string remark = {};                            ///< on one set
  std::optional<std::size_t> remarked_set = {};
};

/// The pointer, in pixels from the top left corner of the window.
struct GuiPointer {
  double x_px = -1.0, y_px = -1.0;
  bool is_left_down = false;
  double wheel = 0.0;  ///< notches since the last frame; up is positive
};

/// The displayed numbers.
struct Readout {
  store::JointPose pose;
  bool is_varus_balanced = false;
  std::optional<ClinicalCoordinates> joint = std::nullopt;  ///< of a solved pose
  /// The joint's own angles, if those of the attitude are about turned axes and the pose is solved.
  std::optional<ClinicalCoordinates> clinical = std::nullopt;
  GapReading gap;
  const char* doubt = nullptr;    ///< what is wrong with the pose, or null
  const char* message = nullptr;  ///< temporary message, or null
};

/// Legends of the visible layers; null or empty if not applicable.
struct ColourKey {
  const Legend* gaps = nullptr;
  const Legend* strain = nullptr;
  std::span<const Label> axes;
};

/// `layers` must outlive the key.
ColourKey colour_key(const JointLayers& layers, const LayerSet& shown);

/// What is known of the highlighted structure besides its name.
struct StructureCard {
  std::array<char, 200> reading{};    ///< of a bundle, zero-terminated; empty for others
  std::span<const CurveLine> strain;  ///< of a bundle, percent; empty for others
  double now = 0.0;                   ///< position in the curve, from 0 to 1
};

/// Plots of a second joint minus the first.
struct Differences {
  struct Plot {
    std::string title;  ///< with the unit
    std::vector<CurveLine> lines;
  };
  std::vector<Plot> plots;
  double first_flexion_rad = 0.0, last_flexion_rad = 0.0;
  std::array<const char*, 2> captions{"", ""};  ///< of the first and the second joint at the shown pose
};

/// The list of structures, which the interface changes.
struct StructureList {
  const std::vector<Structure>& structures;
  Looks& looks;
  StructureCard card;
  double section_range_mm = 60.0;  ///< to both sides of the rotation centre
};

struct GuiFrame {
  int width = 0, height = 0;  ///< of the window, pixels
  double elapsed_s = 0.0;     ///< since the last frame
  GuiPointer pointer;
  ColourKey key;
  std::span<const ScreenLabel> labels;  ///< of the joint
  std::span<const MarkedSpan> marks;    ///< on the timeline
  StructureList* list = nullptr;        ///< null: none
  const Differences* differences = nullptr;
  bool has_controls = true;  ///< false: only readouts and legends, as for a video
};

/// The user's changes in this frame.
struct GuiResult {
  PlayerState state;
  Action action = Action::none;  ///< of a pressed button, not yet applied
};

class Gui {
 public:
  explicit Gui(const GuiOptions& options);
  ~Gui();

  /// For Renderer::load, once and after a change of scale.
  const OverlayFont& font() const;
  /// For a monitor of another content scale; true if it changes the size of the text.
  bool set_scale(double scale);

  /// Builds one frame. Allocates nothing once every part was shown.
  GuiResult frame(const GuiFrame& frame, const PlayerState& state, const PlayerRange& range,
                  const Readout& readout);
  /// Builds the overlay of an image: readouts and legends without controls.
  const Overlay& static_overlay(GuiFrame frame, const PlayerState& state, const PlayerRange& range,
                                const Readout& readout);
  /// Closes an open menu in the next frame; false if none is open.
  bool close_menu();
  /// The overlay of the last frame.
  const Overlay& overlay() const;

  /// The area of the window not covered by warnings, differences, panel and timeline.
  Viewport free_area(int width, int height, const PlayerState& state, bool has_controls = true) const;

 private:
  void open(const GuiOptions& options);

  struct Inner;
  std::unique_ptr<Inner> inner_;
};

/// Number of allocations by the interface library since program start; it bypasses operator new.
std::uint64_t gui_allocation_count();

}  // namespace vrda::view
