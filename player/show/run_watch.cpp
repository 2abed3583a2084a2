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
#include "store/motion_model.hpp"
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
  if (phase_ == RunPhase::finished) return news;
  poll_start_file(news);
  find_journals();
  if (with_moves_) read_moves(news);
  read_steps(news);
  if (n_steps_ > 0) phase_ = RunPhase::running;
  if (!news.has_more) poll_result(news);
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
  const auto refused = show::catch_input_error([&] { model = store::read_motion_model(path); });
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
  const bool is_finished = watch_.phase() == RunPhase::finished;
  std::shared_ptr<const store::MotionModel> model;
  if (news.is_restarted || is_finished) model = std::make_shared<const store::MotionModel>(watch_.model());
  std::unique_lock lock(mutex_);
  if (news.is_restarted) {
    accumulated_.is_restarted = true;
    accumulated_.steps.clear();
  }
  if (model) accumulated_.model = std::move(model);
  append(accumulated_.steps, news.steps);
  append(accumulated_.remarks, news.remarks);
  accumulated_.phase = watch_.phase();
  accumulated_.n_done = watch_.n_done();
  accumulated_.n_steps = watch_.n_steps();
  accumulated_.is_caught_up = !news.has_more;
  if (is_finished) return false;
  if (!news.has_more) wake_.wait_for(lock, pause_, [this] { return is_stopped_; });
  return !is_stopped_;
}

AccumulatedUpdate WatchThread::take()
{
  const std::lock_guard lock(mutex_);
  if (failure_) std::rethrow_exception(std::exchange(failure_, nullptr));
  AccumulatedUpdate taken = std::move(accumulated_);
  accumulated_ = {};
  accumulated_.phase = taken.phase;
  accumulated_.n_done = taken.n_done;
  accumulated_.n_steps = taken.n_steps;
  accumulated_.is_caught_up = taken.is_caught_up;
  return taken;
}

namespace {

using view::faint, view::ink, view::margin_px, view::paper;

constexpr view::VertexColour frame_colour{255, 255, 255, 255};
constexpr float largest_cell_px = 48.0F;
constexpr float ruled_from_px = 5.0F;  // smaller cells are drawn without gaps

std::string label_of(StepStatus status)
{
  std::string words = name_of(status);
  std::replace(words.begin(), words.end(), '_', ' ');
  return words;
}

/// Position of the map and size of its cells.
struct MapLayout {
  float left_px = 0.0F, top_px = 0.0F, cell_width_px = 0.0F, cell_height_px = 0.0F;

  view::OverlayBox cell(Eigen::Index i, Eigen::Index j) const
  {
    const float x = left_px + cell_width_px * static_cast<float>(j);
    const float y = top_px + cell_height_px * static_cast<float>(i);
    return {x, y, x + cell_width_px, y + cell_height_px};
  }
};

class PanelDrawing {
 public:
  PanelDrawing(view::Overlay& overlay, const view::OverlayText& text, const view::Viewport& area,
               const RunPanel& panel)
      : overlay_(overlay),
        text_(text),
        panel_(panel),
        left_px_(static_cast<float>(area.x) + margin_px),
        right_px_(static_cast<float>(area.x + area.width) - margin_px),
        y_px_(static_cast<float>(area.y) + margin_px),
        bottom_px_(static_cast<float>(area.y + area.height) - margin_px)
  {
    text_.add_area(overlay_, view::overlay_box(area), paper);
  }

  void draw()
  {
    add_line(panel_.title, ink);
    for (const std::string& line : panel_.lines) add_line(line, faint);
    y_px_ += 0.5F * text_.line_px();
    const float legend_px = text_.line_px() * static_cast<float>(std::size(all_step_statuses));
    draw_map(bottom_px_ - legend_px - text_.line_px());
    y_px_ = bottom_px_ - legend_px;
    for (const StepStatus status : all_step_statuses) add_legend(status);
  }

 private:
  void add_line(const std::string& words, const view::VertexColour& colour)
  {
    text_.add_text(overlay_, left_px_, y_px_, text_.fitted(words, right_px_ - left_px_), colour);
    y_px_ += text_.line_px();
  }

  void draw_map(float bottom_px)
  {
    const auto n_flexion = static_cast<float>(panel_.status.rows());
    const auto n_varus = static_cast<float>(panel_.status.cols());
    const float label_px = 1.3F * std::max(text_.width_px("flexion"), text_.width_px("-180"));
    MapLayout place;
    place.left_px = left_px_ + label_px;
    place.top_px = y_px_ + 2.0F * text_.line_px();
    place.cell_width_px = std::min((right_px_ - place.left_px) / n_varus, largest_cell_px);
    place.cell_height_px = std::min((bottom_px - place.top_px) / n_flexion, largest_cell_px);
    if (place.cell_width_px <= 0.0F || place.cell_height_px <= 0.0F) return;  // no room for the map
    draw_cells(place);
    label_flexion(place);
    label_varus(place);
  }

  void draw_cells(const MapLayout& place)
  {
    const float gap_px = std::min(place.cell_width_px, place.cell_height_px) >= ruled_from_px ? 1.0F : 0.0F;
    for (Eigen::Index i = 0; i < panel_.status.rows(); ++i) {
      for (Eigen::Index j = 0; j < panel_.status.cols(); ++j) {
        view::OverlayBox box = place.cell(i, j);
        box.right_px -= gap_px;
        box.bottom_px -= gap_px;
        text_.add_area(overlay_, box, colour_of(static_cast<StepStatus>(panel_.status(i, j))));
      }
    }
    if (panel_.current) frame_cell(place.cell(panel_.current->flexion, panel_.current->varus));
  }

  void frame_cell(const view::OverlayBox& box)
  {
    constexpr float line_px = 2.0F;
    const view::OverlayBox out{box.left_px - line_px, box.top_px - line_px, box.right_px + line_px,
                               box.bottom_px + line_px};
    text_.add_area(overlay_, {out.left_px, out.top_px, out.right_px, box.top_px}, frame_colour);
    text_.add_area(overlay_, {out.left_px, box.bottom_px, out.right_px, out.bottom_px}, frame_colour);
    text_.add_area(overlay_, {out.left_px, box.top_px, box.left_px, box.bottom_px}, frame_colour);
    text_.add_area(overlay_, {box.right_px, box.top_px, out.right_px, box.bottom_px}, frame_colour);
  }

  void label_flexion(const MapLayout& place)
  {
    const auto n = static_cast<Eigen::Index>(panel_.flexion_deg.size());
    const float step_px = std::max(place.cell_height_px, 1.0F);
    const auto every = static_cast<Eigen::Index>(std::ceil(1.6F * text_.line_px() / step_px));
    for (Eigen::Index i = 0; i < n; i += every) {
      const std::string words = shortest_decimal(panel_.flexion_deg[static_cast<std::size_t>(i)]);
      const float y = place.cell(i, 0).top_px + 0.5F * (place.cell_height_px - text_.line_px());
      text_.add_text(overlay_, place.left_px - text_.width_px(words) - 6.0F, y, words, faint);
    }
    text_.add_text(overlay_, left_px_, place.top_px - 2.0F * text_.line_px(), "flexion", faint);
  }

  void label_varus(const MapLayout& place)
  {
    const auto n = static_cast<Eigen::Index>(panel_.varus_deg.size());
    float widest_px = 0.0F;
    for (const double varus_deg : panel_.varus_deg)
      widest_px = std::max(widest_px, text_.width_px(shortest_decimal(varus_deg) + " "));
    auto every = static_cast<Eigen::Index>(std::ceil(1.3F * widest_px / place.cell_width_px));
    // Prefer intervals that label both ends and the middle.
    while (n > 1 && every < n - 1 && (n - 1) % every != 0) ++every;
    for (Eigen::Index j = 0; j < n; j += every) {
      const std::string words = shortest_decimal(panel_.varus_deg[static_cast<std::size_t>(j)]);
      const float x = place.cell(0, j).left_px + 0.5F * (place.cell_width_px - text_.width_px(words));
      text_.add_text(overlay_, x, place.top_px - text_.line_px(), words, faint);
    }
    text_.add_text(overlay_, place.left_px, place.top_px - 2.0F * text_.line_px(), "varus, degrees", faint);
  }

  void add_legend(StepStatus status)
  {
    const auto n = (panel_.status == static_cast<std::int8_t>(status)).count();
    const float side_px = 0.7F * text_.line_px(), top_px = y_px_ + 0.1F * text_.line_px();
    text_.add_area(overlay_, {left_px_, top_px, left_px_ + side_px, top_px + side_px}, colour_of(status));
    text_.add_text(overlay_, left_px_ + 1.2F * text_.line_px(), y_px_,
                   std::to_string(n) + " " + label_of(status), n > 0 ? ink : faint);
    y_px_ += text_.line_px();
  }

  view::Overlay& overlay_;
  const view::OverlayText& text_;
  const RunPanel& panel_;
  float left_px_, right_px_, y_px_, bottom_px_;
};

}  // namespace

// Colour-blind safe palette. Source: Okabe and Ito (2008), Color universal design.
view::VertexColour colour_of(StepStatus status)
{
  // In the order of StepStatus, from pending (-1) on.
  constexpr std::array<view::VertexColour, 7> colours{{{58, 63, 71, 255},
                                                       {0, 158, 115, 255},
                                                       {86, 180, 233, 255},
                                                       {213, 94, 0, 255},
                                                       {240, 228, 66, 255},
                                                       {204, 121, 167, 255},
                                                       {0, 114, 178, 255}}};
  return colours.at(static_cast<std::size_t>(static_cast<int>(status) + 1));
}

void add_panel(view::Overlay& overlay, const view::OverlayText& text, const view::Viewport& area,
               const RunPanel& panel)
{
  PanelDrawing(overlay, text, area, panel).draw();
}

void add_label(view::Overlay& overlay, const view::OverlayText& text, const view::Viewport& tile,
               const std::string& name)
{
  const float left_px = static_cast<float>(tile.x) + margin_px;
  const float top_px = static_cast<float>(tile.y) + 0.5F * margin_px;
  const view::OverlayBox plate{left_px - 0.5F * margin_px, top_px,
                               left_px + text.width_px(name) + 0.5F * margin_px, top_px + text.line_px()};
  text.add_area(overlay, plate, {paper[0], paper[1], paper[2], 150});
  text.add_text(overlay, left_px, top_px + 0.1F * text.line_px(), name, ink);
}

const std::vector<std::string>& step_choice_names()
{
  static const std::vector<std::string> names{"stable", "contact", "all"};
  return names;
}

RunState::RunState(const store::MotionModel& model, StepChoice choice)
    : choice_(choice),
      title_(model.title),
      flexion_deg_(model.flexion_deg),
      varus_deg_(model.varus_deg),
      status_(store::GridB::Constant(model.status.rows(), model.status.cols(), status_pending))
{
}

bool RunState::is_chosen(const RunStep& step) const
{
  switch (choice_) {
    case StepChoice::stable:
      return step.kind == RunStepKind::cell && step.status == StepStatus::stable;
    case StepChoice::contact:
      return step.kind == RunStepKind::move ? step.in_contact : step.status == StepStatus::stable;
    case StepChoice::all:
      return true;
  }
  throw InternalError("unknown step choice");
}

bool RunState::add_step(const RunStep& step)
{
  // For steps with free varus, key.varus is the index of a start, not of a cell.
  const bool is_at_cell = step.key.kind <= StepKind::row;
  if (is_at_cell) current_ = GridCell{step.key.flexion, step.key.varus};
  if (step.kind == RunStepKind::cell) {
    std::int8_t& status = status_(step.key.flexion, step.key.varus);
    n_done_ += status == status_pending ? 1 : 0;
    status = static_cast<std::int8_t>(step.status);
  }
  if (!is_chosen(step)) return false;
  shown_ = step;
  ++n_shown_;
  return true;
}

void RunState::finish(const store::MotionModel& result)
{
  status_ = result.status;
  n_done_ = static_cast<int>((status_ != status_pending).count());
  current_.reset();
  shown_.reset();
  is_finished_ = true;
}

std::string RunState::progress_text() const
{
  const std::string text = std::to_string(n_done_) + "/" + std::to_string(status_.size()) + " attitudes";
  return is_finished_ ? text + ", finished" : text;
}

std::string RunState::current_attitude() const
{
  if (!current_) return {};
  return "flexion " + shortest_decimal(flexion_deg_[static_cast<std::size_t>(current_->flexion)]) +
         ", varus " + shortest_decimal(varus_deg_[static_cast<std::size_t>(current_->varus)]);
}

RunPanel RunState::panel() const
{
  RunPanel panel{
      title_.empty() ? "untitled" : title_, {progress_text()}, flexion_deg_, varus_deg_, status_, current_};
  if (current_) panel.lines.push_back(current_attitude());
  return panel;
}

namespace {

using std::chrono::steady_clock;

constexpr std::chrono::seconds between_lines{2};

std::string progress_line(const RunState& state, int n_steps, const std::string& rate)
{
  if (n_steps == 0 && !state.is_finished()) return "waiting for the first step";
  std::string line = state.progress_text();
  if (state.n_done() == 0) line += ", " + std::to_string(n_steps) + " steps of the spine";
  for (const std::string& more : {state.current_attitude(), rate}) line += more.empty() ? "" : ", " + more;
  return line;
}

}  // namespace

void FollowProgress::update_rate(int n_done, int n_cells)
{
  if (n_first_ < 0) {
    n_first_ = n_done;
    first_ = steady_clock::now();
  }
  rate_.clear();
  const double seconds = std::chrono::duration<double>(steady_clock::now() - first_).count();
  const int n_new = n_done - n_first_;
  if (n_new <= 0 || seconds <= 0.0) return;
  const double rate = n_new / seconds;
  const auto left_s = std::lround((n_cells - n_done) / rate);
  char text[80];
  std::snprintf(text, sizeof text, "%.3g/s, %ld:%02ld left", rate, left_s / 60, left_s % 60);
  rate_ = text;
}

void FollowProgress::report_state(const RunState& state, int n_steps, bool is_due)
{
  if (!is_due && steady_clock::now() - said_ < between_lines) return;
  const std::string line = progress_line(state, n_steps, state.is_finished() ? "" : rate_);
  if (line != last_) report_line(line);
}

void FollowProgress::report_line(const std::string& line)
{
  last_ = line;
  said_ = steady_clock::now();
  if (!is_quiet_) stream_ << line << std::endl;
}

namespace {

constexpr int border_px = 2;  // between tiles
constexpr double usual_aspect = 4.0 / 3.0;

}  // namespace

std::vector<view::Viewport> tiles(std::size_t n, const view::Viewport& area)
{
  check(n > 0, "there is at least one view");
  const auto count = static_cast<int>(n);
  int n_columns = 1;
  double best = 0.0;
  for (int columns = 1; columns <= count; ++columns) {
    const int rows = (count + columns - 1) / columns;
    const double size = std::min(1.0 * area.width / columns, usual_aspect * area.height / rows);
    if (size <= best) continue;
    best = size;
    n_columns = columns;
  }
  const int n_rows = (count + n_columns - 1) / n_columns;
  std::vector<view::Viewport> all;
  for (int k = 0; k < count; ++k) {
    const int row = k / n_columns, column = k % n_columns;
    // The last row's tiles share its width.
    const int columns = row + 1 < n_rows ? n_columns : count - row * n_columns;
    const int left = area.width * column / columns, right = area.width * (column + 1) / columns;
    const int top = area.height * row / n_rows, bottom = area.height * (row + 1) / n_rows;
    all.push_back({area.x + left, area.y + top, std::max(1, right - left - border_px),
                   std::max(1, bottom - top - border_px)});
  }
  return all;
}

std::vector<view::Shot> fitted_shots(const std::vector<CameraView>& views,
                                     const std::vector<view::Viewport>& areas,
                                     const std::vector<Eigen::Vector3d>& points_world_mm, double zoom)
{
  check(views.size() == areas.size(), "each view has a tile");
  std::vector<view::Shot> shots;
  for (std::size_t k = 0; k < views.size(); ++k) {
    view::FrameOptions options;
    options.aspect = 1.0 * areas[k].width / areas[k].height;
    view::CameraFit fit(views[k].R_world_camera, options);
    fit.include(points_world_mm);
    shots.push_back({view::placed_camera(fit, views[k], zoom), areas[k]});
  }
  return shots;
}

}  // namespace vrda::show
