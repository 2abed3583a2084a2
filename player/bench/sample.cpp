#include "bench/sample.hpp"

namespace vrda::bench {

Pose pose_of(const ToolPose& place)
{
  const double* q = place.rotation;
  Pose X = Pose::Identity();
  X.linear() = Eigen::Quaterniond(q[0], q[1], q[2], q[3]).normalized().toRotationMatrix();
  X.translation() = Eigen::Vector3d(place.position_mm[0], place.position_mm[1], place.position_mm[2]);
  return X;
}

ToolPose place_of(const Pose& pose)
{
  const Eigen::Quaterniond q = Eigen::Quaterniond(Eigen::Matrix3d(pose.linear())).normalized();
  const Eigen::Vector3d p = pose.translation();
  return {{p.x(), p.y(), p.z()}, {q.w(), q.x(), q.y(), q.z()}};
}

namespace {

/// One of a periodic series, of which a single one may be dropped.
bool is_reading(const Sample& sample)
{
  if (sample.kind == SampleKind::tool_pose) return sample.is(ToolVisibility::seen);
  return sample.kind != SampleKind::link;
}

}  // namespace

bool SampleQueue::stage(const Sample& sample)
{
  const std::uint64_t n_waiting = n_staged_ - n_taken_.load(std::memory_order_acquire);
  if (n_waiting >= (is_reading(sample) ? capacity - n_reserved : capacity)) return false;
  slots_[n_staged_ % capacity] = sample;
  ++n_staged_;
  return true;
}

void SampleQueue::publish()
{
  n_put_.store(n_staged_, std::memory_order_release);
}

bool SampleQueue::put(const Sample& sample)
{
  const bool has_room = stage(sample);
  publish();
  return has_room;
}

bool SampleQueue::take(Sample& sample)
{
  const std::uint64_t n_taken = n_taken_.load(std::memory_order_relaxed);
  if (n_taken == n_put_.load(std::memory_order_acquire)) return false;
  sample = slots_[n_taken % capacity];
  n_taken_.store(n_taken + 1, std::memory_order_release);
  return true;
}

}  // namespace vrda::bench
