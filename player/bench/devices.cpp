#include "bench/devices.hpp"

#include <boost/asio/io_context.hpp>

#include <thread>

#include "bench/clients.hpp"

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

namespace {

std::string peer_of(const TrackerSettings& settings)
{
  if (!settings.program.empty()) return settings.program.front();
  const bool is_ipv6 = settings.host.find(':') != std::string::npos;
  return (is_ipv6 ? "[" + settings.host + "]" : settings.host) + ":" + std::to_string(settings.port);
}

}  // namespace

struct Devices::State {
  State(const std::optional<TrackerSettings>& tracker_, const std::optional<BoardSettings>& board_)
      : tracker_outlet(DeviceId::tracker, tracker_ ? peer_of(*tracker_) : "", queue, clock),
        board_outlet(DeviceId::board, board_ ? board_->port : "", queue, clock)
  {
    if (tracker_) tracker.emplace(io, *tracker_, tracker_outlet);
    if (board_) board.emplace(io, *board_, board_outlet);
    has_stage = board_ && board_->has_stage;
    thread = std::thread([this] { io.run(); });
  }

  ~State()
  {
    io.stop();
    thread.join();
  }

  ArrivalClock clock;
  SampleQueue queue;
  DeviceOutput tracker_outlet, board_outlet;
  boost::asio::io_context io{1};  // outlives the clients, whose handlers it holds
  std::optional<TrackerClient> tracker;
  std::optional<BoardClient> board;
  bool has_stage = false;
  std::thread thread;
};

Devices::Devices(const std::optional<TrackerSettings>& tracker_settings,
                 const std::optional<BoardSettings>& board_settings)
    : state_(std::make_unique<State>(tracker_settings, board_settings))
{
}

Devices::~Devices() = default;

bool Devices::take(Sample& sample)
{
  return state_->queue.take(sample);
}

std::int64_t Devices::now_ns() const
{
  return state_->clock.now_ns();
}

bool Devices::zero_stage()
{
  if (!state_->has_stage || state_->board_outlet.report().link != LinkState::up) return false;
  state_->board->zero_stage();
  return true;
}

DeviceReport Devices::report(DeviceId device) const
{
  return device == DeviceId::tracker ? state_->tracker_outlet.report() : state_->board_outlet.report();
}

}  // namespace vrda::bench
