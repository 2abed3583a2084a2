#include "follow/run_state.hpp"

#include "core/error.hpp"
#include "core/number_text.hpp"

namespace vrda {
const std::vector<std::string>& step_choice_names()
{
  static const std::vector<std::string> names{"stable", "contact", "all"};
  return names;
}

RunState::RunState(const MotionModel& model, StepChoice choice)
    : choice_(choice),
      title_(model.title),
      flexion_deg_(model.flexion_deg),
      varus_deg_(model.varus_deg),
      status_(GridB::Constant(model.status.rows(), model.status.cols(), status_pending))
{
}

bool RunState::is_chosen(const SeenStep& step) const
{
  switch (choice_) {
    case StepChoice::stable:
      return step.kind == SeenKind::cell && step.status == StepStatus::stable;
    case StepChoice::contact:
      return step.kind == SeenKind::move ? step.in_contact : step.status == StepStatus::stable;
    case StepChoice::all:
      return true;
  }
  throw InternalError("a choice of steps chooses");
}

bool RunState::take(const SeenStep& step)
{
  // Of steps with varus left free the number counts starts.
  const bool is_at_cell = step.key.kind <= StepKind::row;
  if (is_at_cell) current_ = GridCell{step.key.flexion, step.key.varus};
  if (step.kind == SeenKind::cell) {
    std::int8_t& status = status_(step.key.flexion, step.key.varus);
    n_done_ += status == status_pending ? 1 : 0;
    status = static_cast<std::int8_t>(step.status);
  }
  if (!is_chosen(step)) return false;
  shown_ = step;
  ++n_shown_;
  return true;
}

void RunState::finish(const MotionModel& result)
{
  status_ = result.status;
  n_done_ = static_cast<int>((status_ != status_pending).count());
  current_.reset();
  shown_.reset();
  is_finished_ = true;
}

std::string RunState::counts() const
{
  const std::string text = std::to_string(n_done_) + "/" + std::to_string(status_.size()) + " attitudes";
  return is_finished_ ? text + ", finished" : text;
}

std::string RunState::place() const
{
  if (!current_) return {};
  return "flexion " + shortest(flexion_deg_[static_cast<std::size_t>(current_->flexion)]) + ", varus " +
         shortest(varus_deg_[static_cast<std::size_t>(current_->varus)]);
}

RunPanel RunState::panel() const
{
  RunPanel panel{
      title_.empty() ? "untitled" : title_, {counts()}, flexion_deg_, varus_deg_, status_, current_};
  if (current_) panel.lines.push_back(place());
  return panel;
}

}  // namespace vrda
