/// Watches a run in progress through its files: start file, journals, result.
#pragma once

#include <Eigen/Core>

#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <exception>
#include <iosfwd>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <set>
#include <string>
#include <thread>
#include <vector>

#include "core/framed_file.hpp"
#include "model/step_record.hpp"
#include "store/motion_model.hpp"
#include "view/camera.hpp"
#include "view/overlay_text.hpp"
#include "view/player_state.hpp"
#include "view/renderer.hpp"

namespace vrda::show {

enum class RunStepKind {
  cell,   ///< a grid cell was solved
  probe,  ///< a step outside the grid: a candidate for the spine, a rotation band
  move    ///< a search move that leads to a cell or probe
};

/// A step of a run. Lengths are at the subject's scale.
struct RunStep {
  RunStepKind kind = RunStepKind::cell;
  StepKey key;                              ///< for a move: the key of its step
  StepStatus status = StepStatus::pending;  ///< for a move: the status of its step
  bool in_contact = false;                  ///< moves only
  Attitude attitude;
  MovingPose pose;                      ///< in the solver frame S
  std::vector<ContactRecord> contacts;  ///< in the solver frame S
};

enum class RunPhase {
  waiting,  ///< no step yet
  running,
  finished  ///< the result exists
};

/// What a run has that it had not before.
struct RunUpdate {
  bool is_restarted = false;              ///< the run was restarted: discard all earlier steps
  bool has_more = false;                  ///< more data is available: poll again at once
  std::vector<RunStep> steps = {};        ///< in journal order; moves before their step
  std::vector<std::string> remarks = {};  ///< messages for the user, each reported once
  /// Of a WatchThread: the start file's model of a restarted run, or the result of a finished one; else null.
  std::shared_ptr<const store::MotionModel> model = nullptr;
  RunPhase phase = RunPhase::waiting;
  int n_done = 0, n_steps = 0;  ///< so far: cells, and all steps in the journals
};

/// The state of one run. Read-only; any file but the start file may be missing, torn or rewritten at any
/// poll.
class RunWatch {
 public:
  /// `start_file`: OUTPUT.start.h5. Throws InputError if the name has another form, or if neither a valid
  /// start file nor a valid result OUTPUT exists.
  explicit RunWatch(const std::string& start_file, bool with_moves = false);

  /// Reads the data added since the last poll; returns no news once finished. Throws InputError for a damaged
  /// start file or result.
  RunUpdate poll();

  /// The start file's model with the cells solved so far; once finished, the result.
  const store::MotionModel& model() const { return model_; }
  /// One record per cell in grid order; pending if unsolved. All pending if the result existed from the
  /// start.
  const std::vector<StepRecord>& cells() const { return cells_; }
  RunPhase phase() const { return phase_; }
  const std::string& output() const { return output_; }
  int n_cells() const { return static_cast<int>(cells_.size()); }
  int n_done() const { return n_done_; }    ///< cells
  int n_steps() const { return n_steps_; }  ///< cells and probes in the journals

 private:
  /// Identifies the content of a path.
  struct Version {
    std::uint64_t device = 0, inode = 0, n_bytes = 0;
    std::int64_t changed_ns = 0;
    bool operator==(const Version&) const = default;
  };
  static std::optional<Version> version_of(const std::string& path);
  static std::optional<store::MotionModel> read_if_present(const std::string& path);

  void poll_start_file(RunUpdate& news);
  void poll_result(RunUpdate& news);
  void begin(store::MotionModel pending, RunUpdate& news);
  void start_over(RunUpdate& news);
  void find_journals();
  void read_moves(RunUpdate& news);
  void read_steps(RunUpdate& news);
  bool take_all(const std::vector<core::TailUpdate>& updates, RunUpdate& news);
  void take(const StepRecord& step, RunUpdate& news);
  void take_moves(const SearchTrace& search, RunUpdate& news);
  bool is_in_grid(const StepKey& key) const;
  void remark(const std::string& text, RunUpdate& news);

  std::string start_file_, output_;
  bool with_moves_;
  std::optional<Version> start_, result_;  // as last read
  store::MotionModel model_;
  double scale_ = 1.0;  // subject's length over solved length
  std::vector<StepRecord> cells_;
  std::map<std::string, core::FrameTail> journals_;
  std::string key_;  // of the journals in use
  std::optional<core::FrameTail> move_journal_;
  bool has_move_journal_ = false;               // it existed at some poll
  std::map<StepKey, SearchTrace> early_moves_;  // moves of steps not yet read
  std::set<StepKey> seen_;
  RunPhase phase_ = RunPhase::waiting;
  int n_done_ = 0, n_steps_ = 0;
  std::set<std::string> remarks_made_;
};

class WatchThread {
 public:
  /// Polls until the run is finished, with a `pause` whenever all data was read.
  WatchThread(RunWatch watch, std::chrono::milliseconds pause);
  ~WatchThread();

  /// All that came since the last call. Never blocks on a file. Rethrows once the exception that ended the
  /// thread.
  RunUpdate take();

 private:
  void run();
  bool poll();

  RunWatch watch_;  // used only by the thread
  std::chrono::milliseconds pause_;
  std::mutex mutex_;  // guards the members below
  std::condition_variable wake_;
  RunUpdate accumulated_{.has_more = true};
  std::exception_ptr failure_;
  bool is_stopped_ = false;
  std::thread thread_;
};

// The displayed state of a run, its panel, and its progress as text.

view::VertexColour colour_of(StepStatus status);

struct GridCell {
  Eigen::Index flexion = 0, varus = 0;
};

/// The attitudes of a run.
struct RunGrid {
  std::string title;
  std::vector<double> flexion_deg, varus_deg;
  store::GridB status;
  std::optional<GridCell> current;  ///< outlined in the map
};

/// Draws the panel in `area`: the title, `lines`, the map of statuses (flexion downwards, varus to the right)
/// and a legend with the number of cells per status.
void add_panel(view::Overlay& overlay, const view::OverlayText& text, const view::Viewport& area,
               const RunGrid& grid, const std::vector<std::string>& lines);

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
  int n_cells() const { return static_cast<int>(grid_.status.size()); }
  std::string progress_text() const;     ///< "640/1911 attitudes"
  std::string current_attitude() const;  ///< "flexion 30, varus -4"; empty without a current cell
  const RunGrid& grid() const { return grid_; }

 private:
  bool is_chosen(const RunStep& step) const;

  StepChoice choice_;
  RunGrid grid_;
  std::optional<RunStep> shown_;
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

// Tiled views of one joint.

using view::CameraView;

/// Divides `area` into `n` tiles, row by row, as large as possible at an aspect near 4:3.
std::vector<view::Viewport> tiles(std::size_t n, const view::Viewport& area);

/// One camera per tile, fitted to the points, with the field of view divided by `zoom`.
std::vector<view::Shot> fitted_shots(const std::vector<CameraView>& views,
                                     const std::vector<view::Viewport>& areas,
                                     const std::vector<Eigen::Vector3d>& points_world_mm, double zoom);

}  // namespace vrda::show
