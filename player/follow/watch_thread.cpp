#include "follow/watch_thread.hpp"

#include <iterator>
#include <utility>

namespace vrda {
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
    while (look()) {
    }
  } catch (...) {
    const std::lock_guard lock(mutex_);
    failure_ = std::current_exception();
  }
}

// False when there is nothing to look at any more.
bool WatchThread::look()
{
  WatchNews news = watch_.look();
  const bool is_finished = watch_.phase() == RunPhase::finished;
  std::shared_ptr<const MotionModel> model;
  if (news.is_anew || is_finished) model = std::make_shared<const MotionModel>(watch_.model());
  std::unique_lock lock(mutex_);
  if (news.is_anew) {
    arrivals_.is_anew = true;
    arrivals_.steps.clear();
  }
  if (model) arrivals_.model = std::move(model);
  append(arrivals_.steps, news.steps);
  append(arrivals_.remarks, news.remarks);
  arrivals_.phase = watch_.phase();
  arrivals_.n_done = watch_.n_done();
  arrivals_.n_steps = watch_.n_steps();
  arrivals_.is_caught_up = !news.has_more;
  if (is_finished) return false;
  if (!news.has_more) wake_.wait_for(lock, pause_, [this] { return is_stopped_; });
  return !is_stopped_;
}

WatchArrivals WatchThread::take()
{
  const std::lock_guard lock(mutex_);
  if (failure_) std::rethrow_exception(std::exchange(failure_, nullptr));
  WatchArrivals taken = std::move(arrivals_);
  arrivals_ = {};
  arrivals_.phase = taken.phase;
  arrivals_.n_done = taken.n_done;
  arrivals_.n_steps = taken.n_steps;
  arrivals_.is_caught_up = taken.is_caught_up;
  return taken;
}

}  // namespace vrda
