#include "audit/attitude_rows.hpp"

#include <algorithm>
#include <atomic>
#include <exception>
#include <memory>
#include <mutex>
#include <thread>

#include "core/units.hpp"

namespace vrda {
namespace {

std::shared_ptr<const AuditScene> scene_along(const MotionModel& model, const Eigen::Vector3d& delta)
{
  const Side side = model.side == "left" ? Side::left : Side::right;
  return std::make_shared<const AuditScene>(make_audit_scene(
      model.reference.contact.mesh, model.moving.contact.mesh, {side, model.rotation_centre_mm, delta}));
}

/// A thread's meter, kept until another Delta is asked for.
class MeterOfRow {
 public:
  MeterOfRow(const MotionModel& model, std::shared_ptr<const AuditScene> scene) : model_(model)
  {
    use(std::move(scene));
  }
  PoseMeter& along(const Eigen::Vector3d& delta)
  {
    if (scene_->frame.delta != delta) use(scene_along(model_, delta));
    return *meter_;
  }

 private:
  void use(std::shared_ptr<const AuditScene> scene)
  {
    meter_.reset();
    scene_ = std::move(scene);
    meter_ = std::make_unique<PoseMeter>(*scene_);
  }

  const MotionModel& model_;
  std::shared_ptr<const AuditScene> scene_;
  std::unique_ptr<PoseMeter> meter_;
};

}  // namespace

std::vector<double> refined(const std::vector<double>& axis_deg, int refine)
{
  std::vector<double> result;
  for (std::size_t i = 0; i + 1 < axis_deg.size(); ++i) {
    for (int k = 0; k < refine; ++k)
      result.push_back(axis_deg[i] + (axis_deg[i + 1] - axis_deg[i]) * k / refine);
  }
  result.push_back(axis_deg.back());
  return result;
}

void for_each_row(const MotionModel& model, const Motion& motion, const std::vector<double>& flexion_deg,
                  int n_threads, const std::function<void(std::size_t, PoseMeter&)>& measure)
{
  const auto delta_at = [&](std::size_t row) { return motion.delta(rad_from_deg(flexion_deg[row])); };
  const std::shared_ptr<const AuditScene> first = scene_along(model, delta_at(0));
  std::atomic<std::size_t> next = 0;
  std::exception_ptr failure;
  std::mutex failure_mutex;
  const auto work = [&] {
    try {
      MeterOfRow meters(model, first);
      for (std::size_t row = next++; row < flexion_deg.size(); row = next++)
        measure(row, meters.along(delta_at(row)));
    } catch (...) {
      const std::lock_guard lock(failure_mutex);
      if (!failure) failure = std::current_exception();
    }
  };
  const int n_useful = std::min(n_threads, static_cast<int>(flexion_deg.size()));
  std::vector<std::jthread> workers;
  for (int k = 1; k < n_useful; ++k) workers.emplace_back(work);
  work();
  workers.clear();
  if (failure) std::rethrow_exception(failure);
}

}  // namespace vrda
