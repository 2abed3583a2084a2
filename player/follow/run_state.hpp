/// What of a run is on screen: behind the watch by as many steps as are still to be shown.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "follow/run_panel.hpp"
#include "follow/run_watch.hpp"

namespace vrda {

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

}  // namespace vrda
