#include "sweep/sweep.hpp"

#include <algorithm>
#include <cmath>
#include <condition_variable>
#include <exception>
#include <limits>
#include <mutex>
#include <thread>

#include "core/error.hpp"

namespace vrda {
namespace {

std::int32_t column_nearest_zero(const std::vector<double>& varus_rad)
{
  std::size_t nearest = 0;
  for (std::size_t j = 1; j < varus_rad.size(); ++j) {
    if (std::abs(varus_rad[j]) < std::abs(varus_rad[nearest])) nearest = j;
  }
  return static_cast<std::int32_t>(nearest);
}

struct Stopped {};  // thrown inside a worker to leave the graph; never leaves this file

class Sweep {
 public:
  Sweep(const SweepPlan& plan, const SolveStep& solve, const SweepHooks& hooks)
      : plan_(plan),
        solve_(solve),
        hooks_(hooks),
        n_flexion_(static_cast<std::int32_t>(plan.flexion_rad.size())),
        n_varus_(static_cast<std::int32_t>(plan.varus_rad.size()))
  {
    check(n_flexion_ > 0 && n_varus_ > 0, "sweep: an empty grid");
    result_.cells.resize(plan.flexion_rad.size() * plan.varus_rad.size());
    result_.spine_column.assign(plan.flexion_rad.size(), -1);
    for (std::int32_t i = 0; i < n_flexion_; ++i) {
      for (std::int32_t j = 0; j < n_varus_; ++j) cell(i, j).key = {StepKind::row, i, j};
    }
    row_seeds_.resize(plan.flexion_rad.size());
  }

  SweepResult run(int n_threads)
  {
    {
      std::vector<std::jthread> workers;
      for (int k = 0; k < std::max(1, n_threads); ++k) {
        workers.emplace_back([this, k] { work(k == 0); });
      }
    }
    if (failure_) std::rethrow_exception(failure_);
    result_.is_complete = std::none_of(result_.cells.begin(), result_.cells.end(),
                                       [](const StepRecord& r) { return r.status == StepStatus::pending; });
    return std::move(result_);
  }

 private:
  StepRecord& cell(std::int32_t i, std::int32_t j)
  {
    return result_.cells[static_cast<std::size_t>(i) * plan_.varus_rad.size() + static_cast<std::size_t>(j)];
  }

  // The first worker solves the spine and announces each row; all of them take rows in order.
  void work(bool solves_spine)
  {
    try {
      if (solves_spine) solve_spine();
      while (const std::optional<std::int32_t> row = next_row()) solve_row(*row);
    } catch (const Stopped&) {
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
    row_ready_.notify_all();
  }

  // Another worker was stopped or failed: what a full disk cannot keep need not be solved.
  bool is_ended()
  {
    const std::lock_guard lock(mutex_);
    return is_ended_;
  }

  std::optional<std::int32_t> next_row()
  {
    std::unique_lock lock(mutex_);
    row_ready_.wait(lock, [this] { return is_ended_ || next_row_ < n_ready_ || next_row_ == n_flexion_; });
    if (is_ended_ || next_row_ == n_flexion_) return std::nullopt;
    return next_row_++;
  }

  StepRecord step(const StepKey& key, const MovingPose& seed)
  {
    if (hooks_.recall) {
      if (std::optional<StepRecord> known = hooks_.recall(key)) return *known;
    }
    if (is_ended() || (hooks_.is_stopped && hooks_.is_stopped())) throw Stopped{};
    StepRecord record = solve_(key,
                               {plan_.flexion_rad[static_cast<std::size_t>(key.flexion)],
                                plan_.varus_rad[static_cast<std::size_t>(key.varus)]},
                               seed);
    record.key = key;
    if (hooks_.keep) hooks_.keep(record);
    return record;
  }

  void solve_spine()
  {
    MovingPose seed = plan_.initial;
    std::int32_t column = column_nearest_zero(plan_.varus_rad);
    for (std::int32_t i = 0; i < n_flexion_; ++i) {
      StepRecord chosen = balanced_cell(i, column, seed);
      const bool is_known =
          hooks_.recall && hooks_.recall({StepKind::spine, i, chosen.key.varus}).has_value();
      chosen.key.kind = StepKind::spine;
      if (hooks_.keep && !is_known) hooks_.keep(chosen);
      column = chosen.key.varus;
      if (chosen.status == StepStatus::stable) seed = chosen.pose;
      const std::lock_guard lock(mutex_);
      cell(i, column) = chosen;
      result_.spine_column[static_cast<std::size_t>(i)] = column;
      row_seeds_[static_cast<std::size_t>(i)] = seed;
      n_ready_ = i + 1;
      row_ready_.notify_all();
    }
  }

  // Walks from `column` towards the better balance until it worsens; every cell is seeded by the one before.
  StepRecord balanced_cell(std::int32_t flexion, std::int32_t column, const MovingPose& seed)
  {
    StepRecord best = step({StepKind::spine_probe, flexion, column}, seed);
    if (!plan_.has_compartments) return best;
    const StepRecord start = best;
    for (const std::int32_t direction : {+1, -1}) {
      StepRecord here = start;
      while (const std::optional<StepRecord> next = neighbour(here, direction, seed)) {
        if (!is_better_balanced(*next, here)) break;
        here = *next;
      }
      if (is_better_balanced(here, best)) best = here;
      // The way down was on this side: the other one only grows.
      if (best.key.varus != start.key.varus) break;
    }
    return best;
  }

  std::optional<StepRecord> neighbour(const StepRecord& from, std::int32_t direction, const MovingPose& seed)
  {
    const std::int32_t column = from.key.varus + direction;
    if (column < 0 || column >= n_varus_) return std::nullopt;
    return step({StepKind::spine_probe, from.key.flexion, column},
                from.status == StepStatus::stable ? from.pose : seed);
  }

  void solve_row(std::int32_t i)
  {
    const std::int32_t spine = result_.spine_column[static_cast<std::size_t>(i)];
    for (const std::int32_t direction : {+1, -1}) {
      // The nearest solved cell inward; the spine's own seed where even its cell failed.
      MovingPose seed = row_seeds_[static_cast<std::size_t>(i)];
      for (std::int32_t j = spine + direction; j >= 0 && j < n_varus_; j += direction) {
        StepRecord record = step({StepKind::row, i, j}, seed);
        if (record.status == StepStatus::stable) seed = record.pose;
        cell(i, j) = std::move(record);
      }
    }
  }

  const SweepPlan& plan_;
  const SolveStep& solve_;
  const SweepHooks& hooks_;
  const std::int32_t n_flexion_;
  const std::int32_t n_varus_;
  SweepResult result_;
  std::vector<MovingPose> row_seeds_;

  std::mutex mutex_;  // guards all below; cells and seeds of a row are handed over under it
  std::condition_variable row_ready_;
  std::int32_t n_ready_ = 0;
  std::int32_t next_row_ = 0;
  bool is_ended_ = false;
  std::exception_ptr failure_;
};

}  // namespace

double imbalance_mm(const StepRecord& record)
{
  const double difference = std::abs(record.gap_medial_mm - record.gap_lateral_mm);
  const bool is_known = record.status == StepStatus::stable && std::isfinite(difference);
  return is_known ? difference : std::numeric_limits<double>::infinity();
}

bool is_better_balanced(const StepRecord& a, const StepRecord& b)
{
  const bool a_touches = a.status == StepStatus::stable && a.contact_medial && a.contact_lateral;
  const bool b_touches = b.status == StepStatus::stable && b.contact_medial && b.contact_lateral;
  if (a_touches != b_touches) return a_touches;
  if (a_touches) return a.pose.translation_mm.y() > b.pose.translation_mm.y();
  return imbalance_mm(a) < imbalance_mm(b);
}

SweepResult sweep(const SweepPlan& plan, const SolveStep& solve, const SweepHooks& hooks, int n_threads)
{
  return Sweep(plan, solve, hooks).run(n_threads);
}

}  // namespace vrda
