/// The interface over the picture: numbers, timeline, controls, help.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "render/renderer.hpp"
#include "scene/joint_layers.hpp"
#include "view/gap_reading.hpp"
#include "view/player_state.hpp"

namespace vrda {

/// What does not change while a file is shown.
struct GuiOptions {
  std::string title;
  std::vector<std::string> sets;  ///< names as set_names() gives them, in the order of PlayerState::set
  double scale = 1.0;             ///< of text and controls; a monitor's content scale
};

/// The pointer, in pixels from the picture's top left corner.
struct GuiPointer {
  double x_px = -1.0, y_px = -1.0;
  bool is_left_down = false;
  double wheel = 0.0;  ///< notches since the last frame; up is positive
};

/// Numbers on screen.
struct Readout {
  JointPose pose;
  bool is_varus_balanced = false;
  GapReading gap;
  const char* message = nullptr;  ///< one line for a while: "picture written to ..."
};

/// What the colours of the layers shown mean; empty or null where nothing is to be said.
struct ColourKey {
  const Legend* gaps = nullptr;
  const Legend* strain = nullptr;
  std::span<const Label> axes;
};

/// `layers` must outlive the key.
ColourKey colour_key(const JointLayers& layers, const LayerSet& shown);

struct GuiFrame {
  int width = 0, height = 0;  ///< of the picture, pixels
  double elapsed_s = 0.0;     ///< since the last frame
  GuiPointer pointer;
  ColourKey key;
  bool has_controls = true;  ///< false: numbers and legends alone, as over a film
};

/// What the user did in this frame.
struct GuiAnswer {
  PlayerState state;
  Action action = Action::none;  ///< of a button, still to be done
};

class Gui {
 public:
  explicit Gui(const GuiOptions& options);
  ~Gui();
  Gui(const Gui&) = delete;
  Gui& operator=(const Gui&) = delete;

  /// For Renderer::load, once.
  const OverlayFont& font() const;

  /// One frame. Allocates nothing once every part was shown.
  GuiAnswer frame(const GuiFrame& frame, const PlayerState& state, const PlayerRange& range,
                  const Readout& readout);
  /// Numbers and legends alone, for a picture on its own; nothing can be pressed in it.
  const Overlay& still(GuiFrame frame, const PlayerState& state, const PlayerRange& range,
                       const Readout& readout);
  /// Of the last frame.
  const Overlay& overlay() const;
  /// The pointer is over a part of the interface, or was pressed there.
  bool wants_pointer() const;

  /// The part of the picture that neither panel nor timeline cover.
  Viewport free_area(int width, int height, const PlayerState& state, bool has_controls = true) const;

 private:
  struct Inner;
  std::unique_ptr<Inner> inner_;
};

/// "degree_6_recontacted" as people say it: "degree 6, recontacted".
std::string set_label(const std::string& set);

/// How often the interface library asked for memory since the program began: it has its own allocator, which
/// a count of operator new does not see.
std::uint64_t gui_allocations();

}  // namespace vrda
