/// The displayed state of a run, its panel, and its progress as text.
#pragma once

#include <chrono>
#include <iosfwd>
#include <optional>
#include <string>
#include <vector>

#include "model/step_record.hpp"
#include "show/run_watch.hpp"
#include "view/overlay_text.hpp"
#include "store/motion_model.hpp"

namespace vrda::show {

view::VertexColour colour_of(StepStatus status);

struct GridCell {
  Eigen::Index flexion = 0, varus = 0;
};

struct RunPanel {
  std::string title;
  std::vector<std::string> lines;  ///< below the title
  std::vector<double> flexion_deg, varus_deg;
  store::GridB status;
  std::optional<GridCell> current;  ///< outlined in the map
};

/// Draws the panel in `area`: the map of statuses (flexion downwards, varus to the right) and a legend with
/// the number of cells per status.
void add_panel(view::Overlay& overlay, const view::OverlayText& text, const view::Viewport& area,
               const RunPanel& panel);

/// Draws the name of a view on its tile.
void add_label(view::Overlay& overlay, const view::OverlayText& text, const view::Viewport& tile,
               const std::string& name);

/// Which steps of a run are shown; the grid is updated by all steps.
enum class StepChoice {
  stable,   ///< stable cells
  contact,  ///< also search moves in contact, which give a smooth motion (thesis 3.8)
  all       ///< every search move and probe
};

/// "stable", "contact", "all", in the order of the enum.
const std::vector<std::string>& step_choice_names();

class RunState {
 public:
  RunState(const store::MotionModel& model, StepChoice choice);

  /// Updates the grid. Returns true if the step is to be shown.
  bool add_step(const RunStep& step);
  /// Takes the grid of the result and clears the shown step.
  void finish(const store::MotionModel& result);

  const std::optional<RunStep>& shown() const { return shown_; }
  int n_shown() const { return n_shown_; }
  bool is_finished() const { return is_finished_; }
  int n_done() const { return n_done_; }
  int n_cells() const { return static_cast<int>(status_.size()); }
  std::string progress_text() const;     ///< "640/1911 attitudes"
  std::string current_attitude() const;  ///< "flexion 30, varus -4"; empty without a current cell
  /// Title, grid and current cell.
  RunPanel panel() const;

 private:
  bool is_chosen(const RunStep& step) const;

  StepChoice choice_;
  std::string title_;
  std::vector<double> flexion_deg_, varus_deg_;
  store::GridB status_;
  std::optional<RunStep> shown_;
  std::optional<GridCell> current_;
  int n_shown_ = 0, n_done_ = 0;
  bool is_finished_ = false;
};

/// Prints the progress of a followed run as lines of text.
class FollowProgress {
 public:
  FollowProgress(std::ostream& stream, bool is_quiet) : stream_(stream), is_quiet_(is_quiet) {}

  /// Restarts the rate measurement.
  void restart() { n_first_ = -1; }
  /// Updates the rate. Attitudes done before the first call are not counted.
  void update_rate(int n_done, int n_cells);
  /// "512/s, 0:02 left"; empty while unknown.
  const std::string& rate() const { return rate_; }

  /// Prints the state with the rate, at most every few seconds and only if it changed; `is_due` ignores the
  /// interval.
  void report_state(const RunState& state, int n_steps, bool is_due = false);
  void report_line(const std::string& line);

 private:
  std::ostream& stream_;
  bool is_quiet_;
  std::string rate_, last_;
  std::chrono::steady_clock::time_point said_, first_;
  int n_first_ = -1;
};

}  // namespace vrda::show
