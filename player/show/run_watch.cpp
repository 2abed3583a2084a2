#include "show/run_watch.hpp"

#include <sys/stat.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <iterator>
#include <ostream>
#include <utility>

#include "core/text.hpp"
#include "core/units.hpp"
#include "show/loop.hpp"
#include "store/journal.hpp"
#include "store/solved_cells.hpp"

namespace vrda::show {
namespace {

bool is_cell(const StepKey& key)
{
  return key.kind == StepKind::spine || key.kind == StepKind::row;
}

RunStep seen(const StepRecord& step, RunStepKind kind)
{
  return {kind, step.key, step.status, false, {}, step.pose, step.contacts};
}

}  // namespace

RunWatch::RunWatch(const std::string& start_file, bool with_moves)
    : start_file_(start_file), output_(store::output_of_start_file(start_file)), with_moves_(with_moves)
{
  if (output_.empty()) {
    throw InputError({start_file, "name", "another name than that of a start file",
                      "OUTPUT.start.h5, which vrda run writes next to its output"});
  }
  // A finished run deletes its start file.
  RunUpdate unused;
  start_ = version_of(start_file_);
  if (start_) {
    begin(store::read_motion_model(start_file_), unused);
  } else if (std::optional<store::MotionModel> result = read_if_present(output_)) {
    begin(store::with_pending_cells(*result), unused);
    model_ = std::move(*result);
    phase_ = RunPhase::finished;
    n_done_ = n_cells();
  } else {
    throw InputError({start_file_, "", "no such file", "the start file of a run in progress"});
  }
}

RunUpdate RunWatch::poll()
{
  RunUpdate news;
  news.phase = phase_;
  if (phase_ == RunPhase::finished) return news;
  poll_start_file(news);
  find_journals();
  if (with_moves_) read_moves(news);
  read_steps(news);
  if (n_steps_ > 0) phase_ = RunPhase::running;
  if (!news.has_more) poll_result(news);
  news.phase = phase_;
  news.n_done = n_done_;
  news.n_steps = n_steps_;
  return news;
}

std::optional<RunWatch::Version> RunWatch::version_of(const std::string& path)
{
  struct stat facts {};
  if (stat(path.c_str(), &facts) != 0) return std::nullopt;
  return Version{facts.st_dev, facts.st_ino, static_cast<std::uint64_t>(facts.st_size),
                 std::int64_t{facts.st_mtim.tv_sec} * 1'000'000'000 + facts.st_mtim.tv_nsec};
}

// A file deleted between stat and read is not an error.
std::optional<store::MotionModel> RunWatch::read_if_present(const std::string& path)
{
  if (!version_of(path)) return std::nullopt;
  std::optional<store::MotionModel> model;
  const auto refused = catch_input_error([&] { model = store::read_motion_model(path); });
  if (refused && version_of(path)) throw InputError(*refused);
  return model;
}

void RunWatch::poll_start_file(RunUpdate& news)
{
  const std::optional<Version> version = version_of(start_file_);
  if (!version || version == start_) return;
  std::optional<store::MotionModel> model = read_if_present(start_file_);
  if (!model) return;
  start_ = version;
  begin(std::move(*model), news);
}

void RunWatch::begin(store::MotionModel model, RunUpdate& news)
{
  if ((model.status != status_pending).any()) {
    throw InputError({start_file_, "/status", "solved attitudes", "a start file: every attitude pending"});
  }
  store::require_grid(model, start_file_, "vrda-player follow");
  model_ = std::move(model);
  scale_ = model_.job.scaling && model_.job.scaling->keeps_steps ? model_.job.scaling->factor.x() : 1.0;
  start_over(news);
}

void RunWatch::start_over(RunUpdate& news)
{
  news.is_restarted = true;
  news.steps.clear();
  model_ = store::with_pending_cells(std::move(model_));
  cells_.assign(static_cast<std::size_t>(model_.status.size()), {});
  for (std::size_t c = 0; c < cells_.size(); ++c) {
    const auto n_varus = model_.varus_deg.size();
    cells_[c].key = {StepKind::row, static_cast<std::int32_t>(c / n_varus),
                     static_cast<std::int32_t>(c % n_varus)};
  }
  journals_.clear();
  key_.clear();
  move_journal_.reset();
  early_moves_.clear();
  seen_.clear();
  phase_ = RunPhase::waiting;
  n_done_ = n_steps_ = 0;
}

void RunWatch::find_journals()
{
  std::vector<std::string> paths = store::list_shard_journals_if_readable(output_);
  paths.push_back(store::journal_of(output_));
  paths.push_back(store::spine_journal_of(output_));
  for (const std::string& path : paths) journals_.try_emplace(path, store::journal_tail(path));
}

void RunWatch::read_steps(RunUpdate& news)
{
  // A restarted journal invalidates the steps of all journals: they are read again from the start.
  for (int attempt = 0; attempt < 2; ++attempt) {
    std::vector<core::TailUpdate> updates;
    updates.reserve(journals_.size());
    for (auto& [path, tail] : journals_) updates.push_back(tail.poll());
    if (take_all(updates, news)) return;
    start_over(news);
    find_journals();
  }
  news.has_more = true;
}

// Returns false if the steps read so far are obsolete. The most recently written journal determines the job;
// journals of another job are leftovers.
bool RunWatch::take_all(const std::vector<core::TailUpdate>& updates, RunUpdate& news)
{
  std::int64_t latest_ns = 0;
  std::string latest_key;
  std::size_t k = 0;
  for (const auto& [path, tail] : journals_) {
    const core::TailUpdate& update = updates[k++];
    if (update.is_restarted) return false;
    if (!update.file_exists || tail.key().empty() || update.changed_ns <= latest_ns) continue;
    latest_ns = update.changed_ns;
    latest_key = tail.key();
  }
  if (!latest_key.empty() && !key_.empty() && latest_key != key_) return false;
  if (key_.empty()) key_ = latest_key;
  k = 0;
  for (const auto& [path, tail] : journals_) {
    const core::TailUpdate& update = updates[k++];
    if (update.frames.empty()) continue;
    if (tail.key() != key_) {
      remark(path + ": found the journal of another job: ignored", news);
      continue;
    }
    news.has_more = news.has_more || update.has_more;
    for (const std::string& frame : update.frames) {
      const std::optional<StepRecord> record = core::value_of_bytes<StepRecord>(frame);
      if (record && is_in_grid(record->key)) {
        take(scale_ == 1.0 ? *record : scaled(*record, scale_), news);
      } else {
        remark(path + ": record: found no step of this grid: ignored", news);
      }
    }
  }
  return true;
}

bool RunWatch::is_in_grid(const StepKey& key) const
{
  if (key.flexion < 0 || key.flexion >= model_.status.rows()) return false;
  // With free varus, key.varus is the index of a start.
  return key.kind > StepKind::row || (key.varus >= 0 && key.varus < model_.status.cols());
}

void RunWatch::take(const StepRecord& step, RunUpdate& news)
{
  if (!seen_.insert(step.key).second) return;
  ++n_steps_;
  const auto moves = early_moves_.find(step.key);
  if (moves != early_moves_.end()) {
    take_moves(moves->second, news);
    early_moves_.erase(moves);
  }
  news.steps.push_back(seen(step, is_cell(step.key) ? RunStepKind::cell : RunStepKind::probe));
  news.steps.back().attitude = {rad_from_deg(model_.flexion_deg[static_cast<std::size_t>(step.key.flexion)]),
                                step.varus_rad};
  if (!is_cell(step.key)) return;
  store::set_cell(model_, step);
  if (step.key.kind == StepKind::spine) model_.is_spine(step.key.flexion, step.key.varus) = 1;
  const auto cell = static_cast<std::size_t>(step.key.flexion) * model_.varus_deg.size() +
                    static_cast<std::size_t>(step.key.varus);
  cells_[cell] = step;
  ++n_done_;
}

void RunWatch::read_moves(RunUpdate& news)
{
  if (!move_journal_) move_journal_.emplace(store::trace_journal_tail(store::trace_journal_of(output_)));
  const core::TailUpdate update = move_journal_->poll();
  if (update.is_restarted) early_moves_.clear();
  has_move_journal_ = has_move_journal_ || update.file_exists;
  if (!has_move_journal_ && n_steps_ > 0)
    remark(move_journal_->path() + ": no such file: only a run with --trace records search moves", news);
  news.has_more = news.has_more || update.has_more;
  for (const std::string& frame : update.frames) {
    std::optional<SearchTrace> search = core::value_of_bytes<SearchTrace>(frame);
    if (!search || !is_in_grid(search->key)) continue;
    // Moves are written before their step, but may become visible later on a network disk.
    if (seen_.count(search->key) > 0) {
      take_moves(*search, news);
    } else {
      early_moves_.insert_or_assign(search->key, std::move(*search));
    }
  }
}

void RunWatch::take_moves(const SearchTrace& search, RunUpdate& news)
{
  const auto i = static_cast<std::size_t>(search.key.flexion), j = static_cast<std::size_t>(search.key.varus);
  for (const SearchMove& move : search.moves) {
    StepRecord step;
    step.key = search.key;
    step.status = search.status;
    step.pose = move.pose;
    step.contacts = move.contacts;
    news.steps.push_back(seen(scaled(step, scale_), RunStepKind::move));
    news.steps.back().in_contact = move.in_contact;
    news.steps.back().attitude = {rad_from_deg(model_.flexion_deg[i]), rad_from_deg(model_.varus_deg[j])};
  }
}

// A result older than the start file belongs to an earlier run.
void RunWatch::poll_result(RunUpdate& news)
{
  const std::optional<Version> version = version_of(output_), start = version_of(start_file_);
  if (!version || version == result_ || (start && version->changed_ns < start->changed_ns)) return;
  std::optional<store::MotionModel> result = read_if_present(output_);
  if (!result) return;
  result_ = version;
  const bool is_own = result->job.resolved == model_.job.resolved;
  // Another job started and finished between two polls.
  const bool is_of_next = !is_own && !start && version->changed_ns >= start_->changed_ns;
  if (!(is_own || is_of_next) || (result->status == status_pending).any()) {
    remark(output_ + ": found the result of another job: ignored", news);
    return;
  }
  if (is_of_next) begin(store::with_pending_cells(*result), news);
  model_ = std::move(*result);
  phase_ = RunPhase::finished;
  n_done_ = n_cells();
}

void RunWatch::remark(const std::string& text, RunUpdate& news)
{
  if (remarks_made_.insert(text).second) news.remarks.push_back(text);
}

namespace {

template <typename T>
void append(std::vector<T>& all, std::vector<T>& more)
{
  all.insert(all.end(), std::make_move_iterator(more.begin()), std::make_move_iterator(more.end()));
}

}  // namespace

WatchThread::WatchThread(RunWatch watch, std::chrono::milliseconds pause)
    : watch_(std::move(watch)), pause_(pause), thread_([this] { run(); })
{
}

WatchThread::~WatchThread()
{
  {
    const std::lock_guard lock(mutex_);
    is_stopped_ = true;
  }
  wake_.notify_all();
  thread_.join();
}

void WatchThread::run()
{
  try {
    while (poll()) {
    }
  } catch (...) {
    const std::lock_guard lock(mutex_);
    failure_ = std::current_exception();
  }
}

// Returns false when there is nothing left to watch.
bool WatchThread::poll()
{
  RunUpdate news = watch_.poll();
  const bool is_finished = news.phase == RunPhase::finished;
  if (news.is_restarted || is_finished)
    news.model = std::make_shared<const store::MotionModel>(watch_.model());
  std::unique_lock lock(mutex_);
  RunUpdate& all = accumulated_;
  if (news.is_restarted) {
    all.is_restarted = true;
    all.steps.clear();
  }
  if (news.model) all.model = std::move(news.model);
  append(all.steps, news.steps);
  append(all.remarks, news.remarks);
  all.phase = news.phase;
  all.n_done = news.n_done;
  all.n_steps = news.n_steps;
  all.has_more = news.has_more;
  if (is_finished) return false;
  if (!news.has_more) wake_.wait_for(lock, pause_, [this] { return is_stopped_; });
  return !is_stopped_;
}

RunUpdate WatchThread::take()
{
  const std::lock_guard lock(mutex_);
  if (failure_) std::rethrow_exception(std::exchange(failure_, nullptr));
  RunUpdate next;
  next.has_more = accumulated_.has_more;
  next.phase = accumulated_.phase;
  next.n_done = accumulated_.n_done;
  next.n_steps = accumulated_.n_steps;
  return std::exchange(accumulated_, std::move(next));
}

}  // namespace vrda::show
