#include "bench/camera_fit.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <opencv2/aruco/charuco.hpp>
#include <opencv2/calib3d.hpp>

#include "core/error.hpp"
#include "show/settings_text.hpp"
#include "bench/body_sheet.hpp"

namespace vrda::bench {

namespace {

constexpr std::size_t least_corners = 12;  ///< half of the board's 24
/// A view whose corners moved less than this on average adds no information.
constexpr double least_motion_px = 20.0;

}  // namespace

struct CameraFit::State {
  CameraFitOptions options;
  cv::Ptr<cv::aruco::Dictionary> dictionary = cv::aruco::getPredefinedDictionary(cv::aruco::DICT_5X5_50);
  cv::Ptr<cv::aruco::CharucoBoard> board =
      cv::aruco::CharucoBoard::create(board_columns, board_rows, static_cast<float>(board_square_mm),
                                      static_cast<float>(board_marker_mm), dictionary);
  cv::Size size;
  std::vector<cv::Mat> corners, ids;  ///< a view each

  double motion_px(std::size_t view, const cv::Mat& new_corners, const cv::Mat& new_ids) const
  {
    std::map<int, cv::Point2f> known;
    for (int k = 0; k < ids[view].rows; ++k) known[ids[view].at<int>(k)] = corners[view].at<cv::Point2f>(k);
    double sum = 0.0;
    int n = 0;
    for (int k = 0; k < new_ids.rows; ++k) {
      const auto at = known.find(new_ids.at<int>(k));
      if (at == known.end()) continue;
      sum += cv::norm(at->second - new_corners.at<cv::Point2f>(k));
      ++n;
    }
    return n == 0 ? least_motion_px : sum / n;
  }
};

CameraFit::CameraFit(const CameraFitOptions& options) : state_(std::make_unique<State>())
{
  state_->options = options;
}

CameraFit::~CameraFit() = default;

std::string CameraFit::take(const GreyPicture& picture)
{
  State& state = *state_;
  const cv::Mat image(picture.height, picture.width, CV_8UC1,
                      const_cast<std::uint8_t*>(picture.pixels.data()));
  std::vector<std::vector<cv::Point2f>> markers;
  std::vector<int> marker_ids;
  cv::aruco::detectMarkers(image, state.dictionary, markers, marker_ids);
  if (marker_ids.empty()) return "no board";
  cv::Mat corners, ids;
  cv::aruco::interpolateCornersCharuco(markers, marker_ids, image, state.board, corners, ids);
  if (static_cast<std::size_t>(ids.rows) < least_corners)
    return std::to_string(ids.rows) + " of 24 corners visible: show more of the board";
  for (std::size_t view = 0; view < state.ids.size(); ++view) {
    if (state.motion_px(view, corners, ids) < least_motion_px)
      return "same view as before: move and tilt the board";
  }
  state.size = image.size();
  state.corners.push_back(corners);
  state.ids.push_back(ids);
  return "view " + std::to_string(state.ids.size()) + " of " + std::to_string(state.options.n_views);
}

bool CameraFit::is_complete() const
{
  return static_cast<int>(state_->ids.size()) >= state_->options.n_views;
}

Camera CameraFit::camera(const std::string& file) const
{
  const State& state = *state_;
  constexpr std::size_t least_views = 5;
  if (state.ids.size() < least_views)
    throw InputError({file, "", std::to_string(state.ids.size()) + " views of the board",
                      "at least 5, tilted by about 30 degrees in all directions"});
  cv::Mat K, distortion, rotations, translations, sd, pose_sd, errors;
  Camera camera;
  camera.rms_px =
      cv::aruco::calibrateCameraCharuco(state.corners, state.ids, state.board, state.size, K, distortion,
                                        rotations, translations, sd, pose_sd, errors, cv::CALIB_FIX_K3);
  camera.width = state.size.width;
  camera.height = state.size.height;
  camera.focal_px = {K.at<double>(0, 0), K.at<double>(1, 1)};
  camera.centre_px = {K.at<double>(0, 2), K.at<double>(1, 2)};
  for (int k = 0; k < 5; ++k) camera.distortion[static_cast<std::size_t>(k)] = distortion.at<double>(k);
  camera.n_views = static_cast<int>(state.ids.size());
  constexpr double most_rms_px = 1.0, most_focal_share = 0.01;
  if (!(camera.rms_px <= most_rms_px))
    throw InputError({file, "", "an error of " + show::rounded_text(camera.rms_px, 2) + " px",
                      "at most 1 px: a flat board, no motion blur, fixed focus"});
  const double focal_share =
      std::max(sd.at<double>(0) / camera.focal_px.x(), sd.at<double>(1) / camera.focal_px.y());
  if (!(focal_share <= most_focal_share))
    throw InputError({file, "",
                      "a focal length known to " + show::rounded_text(100.0 * focal_share, 1) + " %",
                      "1 %: tilt the board more"});
  return camera;
}

}  // namespace vrda::bench
