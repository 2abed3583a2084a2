/// Watches a run in progress through its files: start file, journals, result.
#pragma once

#include <Eigen/Core>

#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <exception>
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

}  // namespace vrda::show
