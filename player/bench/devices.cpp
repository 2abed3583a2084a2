#include "bench/devices.hpp"

#include <boost/asio/io_context.hpp>
#include <thread>

#include "bench/clients.hpp"
#include "bench/device_output.hpp"

namespace vrda::bench {
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
