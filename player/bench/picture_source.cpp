#include "bench/picture_source.hpp"

#include <chrono>
#include <opencv2/imgproc.hpp>
#include <opencv2/videoio.hpp>
#include <thread>

#include "core/error.hpp"

namespace vrda::bench {

using SteadyClock = std::chrono::steady_clock;

struct PictureSource::State {
  PictureSourceOptions options;
  cv::VideoCapture capture;
  bool is_camera = false;
  SteadyClock::time_point due = SteadyClock::now();
  std::vector<std::uint8_t> last;

  void open()
  {
    // A missing device costs a file look-up; OpenCV would try every backend.
    is_camera = options.device.starts_with("/dev/");
    capture.open(options.device, is_camera ? cv::CAP_V4L2 : cv::CAP_ANY);
    if (!capture.isOpened())
      throw InputError(
          {options.device, "", "no camera or no pictures", "a camera that no other program uses"});
    if (!is_camera) return;
    capture.set(cv::CAP_PROP_FRAME_WIDTH, options.width);
    capture.set(cv::CAP_PROP_FRAME_HEIGHT, options.height);
    capture.set(cv::CAP_PROP_FPS, options.rate_hz);
    // The newest picture instead of four old ones.
    capture.set(cv::CAP_PROP_BUFFERSIZE, 1);
  }

  /// Video4Linux stamps pictures with the steady clock; a stamp of another clock is not used.
  std::int64_t taken_ns() const
  {
    constexpr std::int64_t oldest_ns = 1'000'000'000;
    const std::int64_t now_ns = SteadyClock::now().time_since_epoch() / std::chrono::nanoseconds(1);
    if (!is_camera) return now_ns;
    const auto stamp_ns = static_cast<std::int64_t>(1e6 * capture.get(cv::CAP_PROP_POS_MSEC));
    return stamp_ns <= now_ns && now_ns - stamp_ns < oldest_ns ? stamp_ns : now_ns;
  }
};

PictureSource::PictureSource(const PictureSourceOptions& options) : state_(std::make_unique<State>())
{
  state_->options = options;
  state_->open();
}

PictureSource::~PictureSource() = default;

TimedPicture PictureSource::next()
{
  State& state = *state_;
  cv::Mat image;
  if (!state.is_camera) {
    std::this_thread::sleep_until(state.due);
    state.due += std::chrono::duration_cast<SteadyClock::duration>(
        std::chrono::duration<double>(1.0 / state.options.rate_hz));
  }
  if (!state.capture.read(image) && !state.is_camera) {
    state.open();
    state.capture.read(image);
  }
  if (image.empty())
    throw InputError({state.options.device, "", "no picture", "a camera that sends pictures"});
  TimedPicture taken;
  taken.taken_ns = state.taken_ns();
  cv::Mat grey;
  if (image.channels() == 1) {
    grey = image;
  } else {
    cv::cvtColor(image, grey, cv::COLOR_BGR2GRAY);
  }
  taken.picture.width = grey.cols;
  taken.picture.height = grey.rows;
  for (int row = 0; row < grey.rows; ++row)
    taken.picture.pixels.insert(taken.picture.pixels.end(), grey.ptr(row), grey.ptr(row) + grey.cols);
  taken.is_frozen = taken.picture.pixels == state.last;
  state.last = taken.picture.pixels;
  return taken;
}

}  // namespace vrda::bench
