/// A run as it computes, seen from its files alone: the start file, the journals, the result.
#pragma once

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

#include "core/step_record.hpp"
#include "journal/frame_tail.hpp"
#include "store/motion_model.hpp"

namespace vrda {

enum class SeenKind {
  cell,   ///< a cell of the grid is done
  probe,  ///< a step that is no cell: a spine looks for its cell, a band is tried
  move    ///< a modelling step on the way to one of these
};

/// What a run did. Lengths are the subject's.
struct SeenStep {
  SeenKind kind = SeenKind::cell;
  StepKey key;                              ///< of a move: of the step that it leads to
  StepStatus status = StepStatus::pending;  ///< of a move too
  bool in_contact = false;                  ///< of a move
  Attitude attitude;
  MovingPose pose;                      ///< in S
  std::vector<ContactRecord> contacts;  ///< in S
};

enum class RunPhase {
  waiting,  ///< no step yet
  running,
  finished  ///< the result is there
};

struct WatchNews {
  bool is_anew = false;              ///< the run began anew: what was seen before counts no more
  bool has_more = false;             ///< look again at once
  std::vector<SeenStep> steps;       ///< in the order of the journals; moves before their step
  std::vector<std::string> remarks;  ///< each is made once
};

/// What one run has come to. Reads only; any file but the first may be absent, torn or rewritten at any look.
class RunWatch {
 public:
  /// `start_file`: OUTPUT.start.h5. Throws InputError when the name is not of that form, and when neither it
  /// nor OUTPUT is what a run leaves there.
  explicit RunWatch(const std::string& start_file, bool with_moves = false);

  /// Reads what came since the last look; nothing any more once finished. Throws InputError of a start file
  /// or a result that is there and damaged.
  WatchNews look();

  /// The start file's model with the cells solved so far; once finished, the result.
  const MotionModel& model() const { return model_; }
  /// One a cell, in the order of the grid; pending where not solved. Of a result that was there from the
  /// beginning all pending.
  const std::vector<StepRecord>& cells() const { return cells_; }
  RunPhase phase() const { return phase_; }
  const std::string& output() const { return output_; }
  int n_cells() const { return static_cast<int>(cells_.size()); }
  int n_done() const { return n_done_; }    ///< cells
  int n_steps() const { return n_steps_; }  ///< cells and probes in the journals

 private:
  /// Which content a path leads to.
  struct Version {
    std::uint64_t device = 0, inode = 0, n_bytes = 0;
    std::int64_t changed_ns = 0;
    bool operator==(const Version&) const = default;
  };
  static std::optional<Version> version_of(const std::string& path);
  static std::optional<MotionModel> read_if_there(const std::string& path);

  void look_at_start(WatchNews& news);
  void look_at_result(WatchNews& news);
  void begin(MotionModel pending, WatchNews& news);
  void start_over(WatchNews& news);
  void find_journals();
  void read_moves(WatchNews& news);
  void read_steps(WatchNews& news);
  bool take_all(const std::vector<TailNews>& looks, WatchNews& news);
  void take(const StepRecord& step, WatchNews& news);
  void take_moves(const SearchTrace& search, WatchNews& news);
  bool is_in_grid(const StepKey& key) const;
  void remark(const std::string& text, WatchNews& news);

  std::string start_file_, output_;
  bool with_moves_;
  std::optional<Version> start_, result_;  // as last read
  MotionModel model_;
  double scale_ = 1.0;  // of the subject over what was solved
  std::vector<StepRecord> cells_;
  std::map<std::string, FrameTail> journals_;
  std::string key_;  // of the journals that count
  std::optional<FrameTail> move_journal_;
  bool has_move_journal_ = false;               // ever had
  std::map<StepKey, SearchTrace> early_moves_;  // of steps still to come
  std::set<StepKey> seen_;
  RunPhase phase_ = RunPhase::waiting;
  int n_done_ = 0, n_steps_ = 0;
  std::set<std::string> remarks_made_;
};

/// What came since it was last asked for.
struct WatchArrivals {
  bool is_anew = false;  ///< as in WatchNews
  /// The plan of the run that began anew, or the result of one that is finished; else nothing.
  std::shared_ptr<const MotionModel> model;
  std::vector<SeenStep> steps;
  std::vector<std::string> remarks;
  RunPhase phase = RunPhase::waiting;
  int n_done = 0, n_steps = 0;
  bool is_caught_up = false;  ///< with all that there was when it was last looked
};

class WatchThread {
 public:
  /// Looks until the run is finished, `pause` after each time that nothing is left to read.
  WatchThread(RunWatch watch, std::chrono::milliseconds pause);
  ~WatchThread();
  WatchThread(const WatchThread&) = delete;
  WatchThread& operator=(const WatchThread&) = delete;

  /// Never waits for a file. Rethrows, once, what ended the thread.
  WatchArrivals take();

 private:
  void run();
  bool look();

  RunWatch watch_;  // of the thread alone
  std::chrono::milliseconds pause_;
  std::mutex mutex_;  // guards what follows
  std::condition_variable wake_;
  WatchArrivals arrivals_;
  std::exception_ptr failure_;
  bool is_stopped_ = false;
  std::thread thread_;
};

}  // namespace vrda
