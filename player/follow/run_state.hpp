/// What of a run is on screen, its panel, and the same in lines of text.
#pragma once

#include <chrono>
#include <iosfwd>
#include <optional>
#include <string>
#include <vector>

#include "core/step_record.hpp"
#include "follow/run_watch.hpp"
#include "gui/overlay_text.hpp"
#include "store/motion_model.hpp"

namespace vrda {

VertexColour colour_of(StepStatus status);

struct GridCell {
  Eigen::Index flexion = 0, varus = 0;
};

struct RunPanel {
  std::string title;
  std::vector<std::string> lines;  ///< under the title
  std::vector<double> flexion_deg, varus_deg;
  GridB status;
  std::optional<GridCell> current;  ///< framed
};

/// The panel in its part of the picture: flexion downwards, varus to the right, a colour a status with the
/// number of cells that have it.
void add_panel(Overlay& overlay, const OverlayText& text, const Viewport& area, const RunPanel& panel);

/// The name of a view over its tile.
void add_label(Overlay& overlay, const OverlayText& text, const Viewport& tile, const std::string& name);

/// Which steps of a run are shown; all of them fill in the grid.
enum class StepChoice {
  stable,   ///< cells that found their rest
  contact,  ///< the moves in contact too, which play as a smooth motion (thesis 3.8)
  all       ///< every modelling step and probe
};

/// "stable", "contact", "all", in the order of the enum.
const std::vector<std::string>& step_choice_names();

class RunState {
 public:
  RunState(const MotionModel& model, StepChoice choice);

  /// Whether the step is one to show.
  bool take(const SeenStep& step);
  /// The result's grid; no step is shown any more.
  void finish(const MotionModel& result);

  const std::optional<SeenStep>& shown() const { return shown_; }
  int n_shown() const { return n_shown_; }
  bool is_finished() const { return is_finished_; }
  int n_done() const { return n_done_; }
  int n_cells() const { return static_cast<int>(status_.size()); }
  std::string counts() const;  ///< "640/1911 attitudes"
  std::string place() const;   ///< "flexion 30, varus -4", or nothing
  /// Title, grid and the cell in hand.
  RunPanel panel() const;

 private:
  bool is_chosen(const SeenStep& step) const;

  StepChoice choice_;
  std::string title_;
  std::vector<double> flexion_deg_, varus_deg_;
  GridB status_;
  std::optional<SeenStep> shown_;
  std::optional<GridCell> current_;
  int n_shown_ = 0, n_done_ = 0;
  bool is_finished_ = false;
};

/// How far a followed run is, in lines of text.
class FollowProgress {
 public:
  FollowProgress(std::ostream& stream, bool is_quiet) : stream_(stream), is_quiet_(is_quiet) {}

  /// The run began anew: its rate does too.
  void begin_again() { n_first_ = -1; }
  /// The run has done that many of its attitudes. Those of the first time do not count for the rate.
  void note(int n_done, int n_cells);
  /// "512/s, 0:02 left", or nothing while it is not known.
  const std::string& rate() const { return rate_; }

  /// Of the state, with the rate; every few seconds, and only when something came.
  void say_state(const RunState& state, int n_steps, bool is_due = false);
  void say(const std::string& line);

 private:
  std::ostream& stream_;
  bool is_quiet_;
  std::string rate_, last_;
  std::chrono::steady_clock::time_point said_, first_;
  int n_first_ = -1;
};

}  // namespace vrda
