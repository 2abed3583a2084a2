#include "solve/sweep.hpp"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <condition_variable>
#include <exception>
#include <mutex>
#include <thread>

#include "core/error.hpp"
#include "solve/seeds.hpp"

namespace vrda::solve {
namespace {

std::int32_t column_nearest(const std::vector<double>& varus_rad, double target_rad)
{
  std::size_t nearest = 0;
  for (std::size_t j = 1; j < varus_rad.size(); ++j) {
    if (std::abs(varus_rad[j] - target_rad) < std::abs(varus_rad[nearest] - target_rad)) nearest = j;
  }
  return static_cast<std::int32_t>(nearest);
}

double varus_of(const Seed& seed)
{
  return seed.attitude ? seed.attitude->varus_rad : 0.0;
}

Seed moved(Seed seed, const SpineOffset& offset)
{
  seed.pose.theta_rad += offset.theta_rad;
  seed.pose.translation_mm.x() += offset.shift_x_mm;
  seed.pose.translation_mm.z() += offset.shift_z_mm;
  return seed;
}

// Bound on the propagations of equilibria; each pass that changes something lowers an energy.
constexpr std::int32_t max_passes = 20;
constexpr std::int32_t max_polish_rounds = 5;
// Number of the first step of a polish, above those of chains, restarts and propagations.
constexpr std::int32_t first_polish_number = 1000;
struct Stopped {};  // thrown and caught inside a worker to end it

class Sweep {
 public:
  Sweep(const SweepPlan& plan, const SolveStep& solve, const SweepHooks& hooks)
      : plan_(plan),
        solve_(solve),
        hooks_(hooks),
        n_flexion_(static_cast<std::int32_t>(plan.flexion_rad.size())),
        n_varus_(static_cast<std::int32_t>(plan.varus_rad.size())),
        path_rad_(path_of(plan)),
        n_path_(static_cast<std::int32_t>(path_rad_.size())),
        offsets_(spine_offsets(plan.n_restarts))
  {
    check(n_flexion_ > 0 && n_varus_ > 0, "sweep: an empty grid");
    check(!plan.is_varus_free || (plan.spine == SpineRule::free_varus && n_varus_ == 1),
          "sweep: free varus needs one column and a free spine");
    result_.cells.resize(plan.flexion_rad.size() * plan.varus_rad.size());
    result_.spine_column.assign(plan.flexion_rad.size(), -1);
    for (std::int32_t i = 0; i < n_flexion_; ++i) {
      for (std::int32_t j = 0; j < n_varus_; ++j) cell(i, j).key = {StepKind::row, i, j};
    }
    row_seeds_.resize(plan.flexion_rad.size());
    for (const double flexion_rad : plan.flexion_rad) {
      const auto at = std::lower_bound(path_rad_.begin(), path_rad_.end(), flexion_rad);
      check(at != path_rad_.end() && *at == flexion_rad, "sweep: the path contains the grid's flexions");
      path_row_.push_back(static_cast<std::int32_t>(at - path_rad_.begin()));
    }
    choose_rows();
    if (plan.spine != SpineRule::free_varus) return;
    result_.free_spine.resize(plan.flexion_rad.size());
    path_.resize(path_rad_.size());
    path_seeds_.resize(path_rad_.size());
    ends_.resize(path_rad_.size());
  }

  SweepResult run(int n_threads)
  {
    {
      std::vector<std::jthread> workers;
      for (int k = 0; k < std::max(1, n_threads); ++k) {
        workers.emplace_back([this, k] { work(k); });
      }
    }
    if (failure_) std::rethrow_exception(failure_);
    result_.is_complete = !is_stopped_;
    return std::move(result_);
  }

 private:
  void choose_rows()
  {
    flexions_.n_expected = path_rad_.size();
    is_chosen_.assign(plan_.flexion_rad.size(), plan_.rows ? 0 : 1);
    if (plan_.rows) {
      for (const std::int32_t i : *plan_.rows) {
        check(i >= 0 && i < n_flexion_ && is_chosen_[static_cast<std::size_t>(i)] == 0,
              "sweep: rows of the grid, each once");
        is_chosen_[static_cast<std::size_t>(i)] = 1;
      }
    }
    rows_.n_expected = plan_.rows ? plan_.rows->size() : plan_.flexion_rad.size();
  }

  StepRecord& cell(std::int32_t i, std::int32_t j)
  {
    return result_.cells[static_cast<std::size_t>(i) * plan_.varus_rad.size() + static_cast<std::size_t>(j)];
  }

  // The first worker solves the spine and releases each row; all solve released rows. With a free spine all
  // first run the restarts of each flexion, then the first propagates the lowest equilibria.
  void work(int worker)
  {
    try {
      if (worker == 0) solve_spine();
      if (plan_.spine == SpineRule::free_varus) {
        while (const std::optional<std::int32_t> flexion = next_of(flexions_)) {
          restart(*flexion, worker);
          count_restarted();
        }
        if (worker == 0 && wait_for_restarts()) propagate_lower_equilibria();
      }
      while (const std::optional<std::int32_t> row = next_of(rows_)) {
        if (plan_.spine == SpineRule::free_varus) start_row(*row, worker);
        solve_row(*row, worker);
      }
    } catch (const Stopped&) {
      is_stopped_ = true;
      end_early(nullptr);
    } catch (...) {
      end_early(std::current_exception());
    }
  }

  void end_early(const std::exception_ptr& failure)
  {
    const std::lock_guard lock(mutex_);
    if (failure && !failure_) failure_ = failure;
    is_ended_ = true;
    changed_.notify_all();
  }

  // Whether another worker was stopped or failed, for example on a full disk.
  bool is_ended()
  {
    const std::lock_guard lock(mutex_);
    return is_ended_;
  }

  // Rows in the order of their release.
  struct Queue {
    std::vector<std::int32_t> ready;
    std::size_t n_taken = 0;
    std::size_t n_expected = 0;
  };

  void release(Queue& queue, std::int32_t row)
  {
    const std::lock_guard lock(mutex_);
    queue.ready.push_back(row);
    changed_.notify_all();
  }

  void release_row(std::int32_t row)
  {
    if (is_chosen_[static_cast<std::size_t>(row)] != 0) release(rows_, row);
  }

  std::optional<std::int32_t> next_of(Queue& queue)
  {
    std::unique_lock lock(mutex_);
    changed_.wait(lock, [&] {
      return is_ended_ || queue.n_taken < queue.ready.size() || queue.n_taken == queue.n_expected;
    });
    if (is_ended_ || queue.n_taken == queue.n_expected) return std::nullopt;
    return queue.ready[queue.n_taken++];
  }

  void count_restarted()
  {
    const std::lock_guard lock(mutex_);
    ++n_restarted_;
    changed_.notify_all();
  }

  // False when another worker was stopped or failed.
  bool wait_for_restarts()
  {
    std::unique_lock lock(mutex_);
    changed_.wait(lock, [&] { return is_ended_ || n_restarted_ == n_path_; });
    return !is_ended_;
  }

  std::optional<StepRecord> recalled(const StepKey& key) const
  {
    return hooks_.recall ? hooks_.recall(key) : std::nullopt;
  }

  StepRecord solved(const StepTask& task)
  {
    if (is_ended() || (hooks_.is_stopped && hooks_.is_stopped())) throw Stopped{};
    StepRecord record = solve_(task);
    record.key = task.key;
    return record;
  }

  StepRecord kept(StepRecord record)
  {
    if (hooks_.keep) hooks_.keep(record);
    return record;
  }

  StepRecord step(const StepTask& task)
  {
    if (std::optional<StepRecord> known = recalled(task.key)) return *known;
    return kept(solved(task));
  }

  // Whether other steps may start from it.
  bool is_usable(const StepRecord& record) const
  {
    return record.status == StepStatus::stable &&
           (!plan_.is_in_joint || plan_.is_in_joint(record.pose, path_row_of(record.key)));
  }

  StepRecord grid_step(const StepKey& key, const std::vector<Seed>& seeds, int worker)
  {
    if (std::optional<StepRecord> known = recalled(key)) return *known;
    StepTask task;
    task.key = key;
    task.attitude = {plan_.flexion_rad[static_cast<std::size_t>(key.flexion)],
                     plan_.varus_rad[static_cast<std::size_t>(key.varus)]};
    task.path_row = path_row_of(key);
    task.worker = worker;
    return kept(solve_from_seeds(
        task, seeds, plan_.max_seed_step_rad, [this](const StepTask& part) { return solved(part); },
        [this](const StepRecord& record) { return is_usable(record); }));
  }

  // Only the steps of the free spine have keys along the path.
  std::int32_t path_row_of(const StepKey& key) const
  {
    return key.kind == StepKind::free_spine ? key.flexion : path_row_[static_cast<std::size_t>(key.flexion)];
  }

  Seed seed_of(const StepRecord& record) const
  {
    const std::int32_t row = path_row_of(record.key);
    const double flexion_rad =
        record.coordinates ? record.flexion_rad : path_rad_[static_cast<std::size_t>(row)];
    return {record.pose, Attitude{flexion_rad, record.varus_rad}, row};
  }

  StepRecord free_step(const StepKey& key, const Seed& seed, int worker, int band = 0)
  {
    StepTask task;
    task.key = key;
    task.path_row = path_row_of(key);
    task.attitude = {path_rad_[static_cast<std::size_t>(task.path_row)], varus_of(seed)};
    task.seed = seed.pose;
    task.seed_attitude = seed.attitude;
    task.seed_path_row = seed.path_row;
    task.is_varus_free = true;
    task.band = band;
    if (key.kind == StepKind::free_spine) task.known = &ends_[static_cast<std::size_t>(key.flexion)];
    task.is_measured = plan_.is_varus_free && !plan_.measures_chosen && band == 0;  // it may become a cell
    task.worker = worker;
    return step(task);
  }

  void solve_spine()
  {
    if (plan_.spine == SpineRule::free_varus) return solve_free_spine();
    Seed seed{plan_.initial, {}, 0};
    std::int32_t column = column_nearest(plan_.varus_rad, 0.0);
    for (std::int32_t i = 0; i < n_flexion_; ++i) {
      const StepRecord chosen = kept_as_spine(balanced_cell(i, column, seed));
      column = chosen.key.varus;
      if (is_usable(chosen)) seed = seed_of(chosen);
      cell(i, column) = chosen;
      result_.spine_column[static_cast<std::size_t>(i)] = column;
      row_seeds_[static_cast<std::size_t>(i)] = seed;
      release_row(i);
    }
  }

  // Keeps a step that was solved under another key also as the spine's cell.
  StepRecord kept_as_spine(StepRecord chosen)
  {
    chosen.key.kind = StepKind::spine;
    if (hooks_.keep && !recalled(chosen.key)) hooks_.keep(chosen);
    return chosen;
  }

  bool is_better_cell(const StepRecord& a, const StepRecord& b) const
  {
    return is_usable(a) != is_usable(b) ? is_usable(a) : is_better_balanced(a, b);
  }

  // Walks from `column` towards better balance until it worsens; each cell is seeded by the previous one.
  StepRecord balanced_cell(std::int32_t flexion, std::int32_t column, const Seed& seed)
  {
    StepRecord best = grid_step({StepKind::spine_probe, flexion, column}, seeds_from(plan_, seed), 0);
    if (plan_.spine == SpineRule::nearest_zero) return best;
    const StepRecord start = best;
    for (const std::int32_t direction : {+1, -1}) {
      StepRecord here = start;
      while (const std::optional<StepRecord> next = neighbour(here, direction, seed)) {
        if (!is_better_cell(*next, here)) break;
        here = *next;
      }
      if (is_better_cell(here, best)) best = here;
      // The imbalance decreases on this side, so it grows on the other.
      if (best.key.varus != start.key.varus) break;
    }
    return best;
  }

  std::optional<StepRecord> neighbour(const StepRecord& from, std::int32_t direction, const Seed& seed)
  {
    const std::int32_t column = from.key.varus + direction;
    if (column < 0 || column >= n_varus_) return std::nullopt;
    return grid_step({StepKind::spine_probe, from.key.flexion, column},
                     seeds_from(plan_, is_usable(from) ? seed_of(from) : seed), 0);
  }

  // One chain up the flexions and one back down; the second releases the flexions for restarts.
  void solve_free_spine()
  {
    Seed seed{plan_.initial, {}, 0};
    for (std::int32_t i = 0; i < n_path_; ++i) {
      const StepRecord record = free_step({StepKind::free_spine, i, 0}, seed, 0);
      if (record.status == StepStatus::stable) seed = seed_of(record);
      ends_[static_cast<std::size_t>(i)].push_back(record);
    }
    for (std::int32_t i = n_path_; i-- > 0;) {
      path_seeds_[static_cast<std::size_t>(i)] = seed;
      const StepRecord record = free_step({StepKind::free_spine, i, 1}, seed, 0);
      if (record.status == StepStatus::stable) seed = seed_of(record);
      ends_[static_cast<std::size_t>(i)].push_back(record);
      release(flexions_, i);
    }
  }

  // Starts rotated and shifted from the lower result of both chains.
  void restart(std::int32_t i, int worker)
  {
    const auto row = static_cast<std::size_t>(i);
    const StepRecord lower = select_lowest(ends_[row]).chosen;
    const Seed from = lower.status == StepStatus::stable ? seed_of(lower) : path_seeds_[row];
    for (std::size_t k = 0; k < offsets_.size(); ++k) {
      const StepKey key{StepKind::free_spine, i, static_cast<std::int32_t>(k) + 2};
      ends_[row].push_back(free_step(key, moved(from, offsets_[k]), worker));
    }
    path_[row] = select_lowest(ends_[row]);
    polish(i, worker);
  }

  // Facets make equilibria a fraction of a degree apart: small offsets from the lowest one, until none leads
  // to a lower one.
  void polish(std::int32_t i, int worker)
  {
    const auto row = static_cast<std::size_t>(i);
    std::int32_t number = first_polish_number;
    bool is_lower = !offsets_.empty() && path_[row].chosen.status == StepStatus::stable;
    for (std::int32_t round = 0; is_lower && round < max_polish_rounds; ++round) {
      const StepRecord from = path_[row].chosen;
      for (const SpineOffset& offset : polish_offsets()) {
        ends_[row].push_back(
            free_step({StepKind::free_spine, i, number++}, moved(seed_of(from), offset), worker));
      }
      path_[row] = select_lowest(ends_[row]);
      is_lower = path_[row].chosen.key != from.key;
    }
  }

  // An equilibrium found at one flexion may lead to a lower one at its neighbours: up the flexions and down
  // again, each flexion starts from its neighbour's equilibrium, once and then whenever that has changed.
  void propagate_lower_equilibria()
  {
    std::vector<std::int8_t> is_new_upward(path_rad_.size(), 1), is_new_downward = is_new_upward;
    const auto try_neighbour = [&](std::int32_t from, std::int32_t to, std::int32_t number,
                                   std::vector<std::int8_t>& is_new) {
      const bool is_tried = is_new[static_cast<std::size_t>(from)] == 0;
      is_new[static_cast<std::size_t>(from)] = 0;
      if (is_tried || !propagate(from, to, number)) return false;
      is_new_upward[static_cast<std::size_t>(to)] = is_new_downward[static_cast<std::size_t>(to)] = 1;
      return true;
    };
    bool is_changed = true;
    for (std::int32_t pass = 0; is_changed && pass < max_passes; ++pass) {
      is_changed = false;
      for (std::int32_t i = 1; i < n_path_; ++i)
        is_changed |= try_neighbour(i - 1, i, 2 * pass, is_new_upward);
      for (std::int32_t i = n_path_ - 1; i-- > 0;)
        is_changed |= try_neighbour(i + 1, i, 2 * pass + 1, is_new_downward);
    }
    for (std::int32_t i = 0; i < n_flexion_; ++i) {
      const auto row = static_cast<std::size_t>(i), path_row = static_cast<std::size_t>(path_row_[row]);
      result_.free_spine[row] = path_[path_row];
      row_seeds_[row] = path_seeds_[path_row];
      release_row(i);
    }
  }

  // Whether a lower equilibrium was found.
  bool propagate(std::int32_t from, std::int32_t to, std::int32_t number)
  {
    const StepRecord& source = path_[static_cast<std::size_t>(from)].chosen;
    FreeSpineStep& target = path_[static_cast<std::size_t>(to)];
    if (source.status != StepStatus::stable) return false;
    const StepKey key{StepKind::free_spine, to, static_cast<std::int32_t>(offsets_.size()) + 2 + number};
    std::vector<StepRecord>& ends = ends_[static_cast<std::size_t>(to)];
    ends.push_back(free_step(key, seed_of(source), 0));
    const StepKey before = target.chosen.key;
    target = select_lowest(ends);
    return target.chosen.key != before;
  }

  // Solves the band of the flexion and the grid's cell nearest to its free equilibrium.
  void start_row(std::int32_t i, int worker)
  {
    const auto row = static_cast<std::size_t>(i);
    FreeSpineStep& free = result_.free_spine[row];
    const bool is_stable = free.chosen.status == StepStatus::stable;
    if (plan_.has_band && is_stable) {
      free.band_low = free_step({StepKind::band, i, 0}, seed_of(free.chosen), worker, -1);
      free.band_high = free_step({StepKind::band, i, 1}, seed_of(free.chosen), worker, +1);
    }
    if (is_stable) row_seeds_[row] = seed_of(free.chosen);
    const std::int32_t column = column_nearest(plan_.varus_rad, varus_of(row_seeds_[row]));
    cell(i, column) = plan_.is_varus_free && !plan_.measures_chosen
                          ? spine_cell_of(free.chosen, i)
                          : grid_step({StepKind::spine, i, column}, {row_seeds_[row]}, worker);
    if (cell(i, column).status == StepStatus::stable) row_seeds_[row] = seed_of(cell(i, column));
    result_.spine_column[row] = column;
  }

  StepRecord spine_cell_of(StepRecord chosen, std::int32_t flexion)
  {
    chosen.key.flexion = flexion;
    chosen.key.varus = 0;
    return kept_as_spine(chosen);
  }

  void solve_row(std::int32_t i, int worker)
  {
    const std::int32_t spine = result_.spine_column[static_cast<std::size_t>(i)];
    for (const std::int32_t direction : {+1, -1}) {
      // The nearest usable cell inward; the spine's own seed if even its cell is not usable.
      Seed seed = row_seeds_[static_cast<std::size_t>(i)];
      for (std::int32_t j = spine + direction; j >= 0 && j < n_varus_; j += direction) {
        StepRecord record = grid_step({StepKind::row, i, j}, seeds_from(plan_, seed), worker);
        if (is_usable(record)) seed = seed_of(record);
        cell(i, j) = std::move(record);
      }
    }
  }

  const SweepPlan& plan_;
  const SolveStep& solve_;
  const SweepHooks& hooks_;
  const std::int32_t n_flexion_;
  const std::int32_t n_varus_;
  const std::vector<double> path_rad_;
  const std::int32_t n_path_;
  std::vector<std::int32_t> path_row_;  // [n_flexion] of the grid's flexions
  const std::vector<SpineOffset> offsets_;
  // A row's entries are written by the spine before its row is released, then by the row's worker only.
  SweepResult result_;
  std::vector<Seed> row_seeds_;
  std::vector<std::int8_t> is_chosen_;  // [n_flexion] whether the row is solved
  std::vector<FreeSpineStep> path_;     // [n_path] of a free spine, like the next two
  std::vector<Seed> path_seeds_;
  std::vector<std::vector<StepRecord>> ends_;  // results of all starts

  std::mutex mutex_;  // guards the members below and orders the workers' access to a row's data
  std::condition_variable changed_;
  Queue flexions_;  // released for restarts
  Queue rows_;      // released for their cells
  std::int32_t n_restarted_ = 0;
  bool is_ended_ = false;
  std::atomic<bool> is_stopped_ = false;
  std::exception_ptr failure_;
};

}  // namespace

SweepResult sweep(const SweepPlan& plan, const SolveStep& solve, const SweepHooks& hooks, int n_threads)
{
  return Sweep(plan, solve, hooks).run(n_threads);
}

}  // namespace vrda::solve
