#include "bench/pose_finder.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <opencv2/aruco.hpp>
#include <opencv2/calib3d.hpp>

#include "core/error.hpp"

namespace vrda::bench {

const char* name_of(BodyState state)
{
  return std::array{"seen", "hidden", "ambiguous", "misfit"}.at(static_cast<std::size_t>(state));
}

namespace {

/// Of refined corners under noise and blur.
constexpr double corner_sd_px = 0.3;
/// 2 degrees: beyond it the tilt of a body is too uncertain to be shown.
constexpr double most_rotation_sd_rad = 0.035;

/// What is visible of a body.
struct Sighting {
  std::vector<cv::Point3d> corners_body_mm;
  std::vector<cv::Point2d> corners_px;
  std::array<int, 2> n_on_face{};  ///< left, right
};

struct Candidate {
  cv::Mat rotation_vector, translation;
  double rms_px = 0.0, rotation_sd_rad = 0.0;
};

Pose pose_of(const Candidate& candidate)
{
  cv::Mat rotation;
  cv::Rodrigues(candidate.rotation_vector, rotation);
  Pose X = Pose::Identity();
  for (int r = 0; r < 3; ++r) {
    for (int c = 0; c < 3; ++c) X.matrix()(r, c) = rotation.at<double>(r, c);
    X.translation()(r) = candidate.translation.at<double>(r);
  }
  return X;
}

/// Standard deviation of the worst known direction of rotation for corners known to `sd_px`.
double rotation_sd_rad(const cv::Mat& jacobian, double sd_px)
{
  // Columns: rotation vector, translation.
  const cv::Mat J = jacobian.colRange(0, 6);
  const cv::Mat covariance = (J.t() * J).inv(cv::DECOMP_SVD);
  cv::Mat eigenvalues;
  cv::eigen(covariance(cv::Rect(0, 0, 3, 3)), eigenvalues);
  return sd_px * std::sqrt(eigenvalues.at<double>(0));
}

double angle_rad(const Pose& a, const Pose& b)
{
  return Eigen::AngleAxisd(a.linear().transpose() * b.linear()).angle();
}

}  // namespace

struct PoseFinder::State {
  Camera camera;
  PoseFinderOptions options;
  std::array<MarkerCorners, markers_a_body> markers;
  cv::Ptr<cv::aruco::Dictionary> dictionary;
  cv::Ptr<cv::aruco::DetectorParameters> detection;
  std::vector<cv::Ptr<cv::aruco::Board>> boards;  ///< of the bodies
  cv::Matx33d K;
  std::vector<double> distortion;
  struct Last {
    Pose X;
    double time_s = 0.0;
  };
  std::vector<std::optional<Last>> last;

  std::vector<Sighting> sightings(const GreyPicture& picture) const;
  std::vector<Candidate> candidates(const Sighting& sighting) const;
  std::optional<std::size_t> choice(const std::vector<Candidate>& fits, const std::optional<Last>& before,
                                    double time_s) const;
  FoundBody found(const Sighting& sighting, const std::optional<Last>& before, double time_s) const;
  void rate(const Sighting& sighting, Candidate& candidate) const;
};

PoseFinder::PoseFinder(const Camera& camera, const PoseFinderOptions& options)
    : state_(std::make_unique<State>())
{
  check(options.n_bodies <= most_bodies, "the dictionary has markers for 12 bodies");
  state_->camera = camera;
  state_->options = options;
  state_->markers = marker_corners_mm(options.sheet);
  state_->dictionary = cv::aruco::getPredefinedDictionary(cv::aruco::DICT_4X4_50);
  state_->detection = cv::aruco::DetectorParameters::create();
  // A larger window reaches the marker's cells, which are 3 to 4 px wide at 1 m: 0.7 to 1.1 instead of 0.3
  // px.
  state_->detection->cornerRefinementMethod = cv::aruco::CORNER_REFINE_SUBPIX;
  state_->detection->cornerRefinementWinSize = 2;
  state_->detection->perspectiveRemovePixelPerCell = 8;
  state_->K = {camera.focal_px.x(),
               0.0,
               camera.centre_px.x(),
               0.0,
               camera.focal_px.y(),
               camera.centre_px.y(),
               0.0,
               0.0,
               1.0};
  state_->distortion.assign(camera.distortion.begin(), camera.distortion.end());
  state_->last.resize(options.n_bodies);
  std::vector<std::vector<cv::Point3f>> corners;
  for (const MarkerCorners& marker : state_->markers) {
    corners.emplace_back();
    for (const Eigen::Vector3d& p : marker)
      corners.back().emplace_back(static_cast<float>(p.x()), static_cast<float>(p.y()),
                                  static_cast<float>(p.z()));
  }
  for (std::size_t body = 0; body < options.n_bodies; ++body) {
    const int first = static_cast<int>(markers_a_body * body);
    state_->boards.push_back(cv::aruco::Board::create(
        corners, state_->dictionary, std::vector<int>{first, first + 1, first + 2, first + 3}));
  }
}

PoseFinder::~PoseFinder() = default;

std::vector<Sighting> PoseFinder::State::sightings(const GreyPicture& picture) const
{
  // OpenCV reads the pixels only.
  const cv::Mat image(picture.height, picture.width, CV_8UC1,
                      const_cast<std::uint8_t*>(picture.pixels.data()));
  std::vector<std::vector<cv::Point2f>> corners, rejected;
  std::vector<int> ids;
  cv::aruco::detectMarkers(image, dictionary, corners, ids, detection, rejected);
  // Quadrangles whose cells were not read, but where the visible markers of a body expect one: at 1 m with
  // blur this finds half of the markers.
  constexpr float most_distance_px = 8.0F, error_correction = 3.0F;
  for (const cv::Ptr<cv::aruco::Board>& board : boards)
    cv::aruco::refineDetectedMarkers(image, board, corners, ids, rejected, K, distortion, most_distance_px,
                                     error_correction, true, cv::noArray(), detection);
  std::vector<Sighting> sightings(options.n_bodies);
  for (std::size_t k = 0; k < ids.size(); ++k) {
    const auto id = static_cast<std::size_t>(ids[k]);
    if (id / markers_a_body >= options.n_bodies) continue;
    Sighting& sighting = sightings[id / markers_a_body];
    const std::size_t marker = id % markers_a_body;
    ++sighting.n_on_face[marker % 2];
    for (std::size_t corner = 0; corner < 4; ++corner) {
      const Eigen::Vector3d& p = markers[marker][corner];
      sighting.corners_body_mm.emplace_back(p.x(), p.y(), p.z());
      sighting.corners_px.emplace_back(corners[k][corner]);
    }
  }
  return sightings;
}

void PoseFinder::State::rate(const Sighting& sighting, Candidate& candidate) const
{
  std::vector<cv::Point2d> projected;
  cv::Mat jacobian;
  cv::projectPoints(sighting.corners_body_mm, candidate.rotation_vector, candidate.translation, K, distortion,
                    projected, jacobian);
  double sum = 0.0;
  for (std::size_t k = 0; k < projected.size(); ++k) {
    const cv::Point2d off = projected[k] - sighting.corners_px[k];
    sum += off.dot(off);
  }
  candidate.rms_px = std::sqrt(sum / static_cast<double>(projected.size()));
  candidate.rotation_sd_rad = rotation_sd_rad(jacobian, corner_sd_px);
}

/// The poses that fit, best first: two for the points of one plane, else one.
std::vector<Candidate> PoseFinder::State::candidates(const Sighting& sighting) const
{
  const bool is_plane = sighting.n_on_face[0] == 0 || sighting.n_on_face[1] == 0;
  std::vector<cv::Mat> rotations, translations;
  cv::solvePnPGeneric(sighting.corners_body_mm, sighting.corners_px, K, distortion, rotations, translations,
                      false, is_plane ? cv::SOLVEPNP_IPPE : cv::SOLVEPNP_SQPNP);
  std::vector<Candidate> found;
  for (std::size_t k = 0; k < rotations.size(); ++k) {
    Candidate candidate{rotations[k], translations[k]};
    cv::solvePnPRefineLM(sighting.corners_body_mm, sighting.corners_px, K, distortion,
                         candidate.rotation_vector, candidate.translation);
    rate(sighting, candidate);
    const double z_mm = candidate.translation.at<double>(2);
    if (std::isfinite(candidate.rms_px) && z_mm > 0.0) found.push_back(candidate);
  }
  std::ranges::sort(found, {}, &Candidate::rms_px);
  return found;
}

/// The only fit, the clearly better one, or the one nearer to the last pose.
std::optional<std::size_t> PoseFinder::State::choice(const std::vector<Candidate>& fits,
                                                     const std::optional<Last>& before, double time_s) const
{
  // Both tilts of a plane seen from the front are the same.
  constexpr double clear_ratio = 4.0, same_rad = 0.02, longest_turn_rad = 0.5;
  if (fits.size() < 2 || fits[1].rms_px > clear_ratio * fits[0].rms_px ||
      angle_rad(pose_of(fits[0]), pose_of(fits[1])) < same_rad)
    return 0;
  if (!before || time_s - before->time_s > options.remembered_s) return std::nullopt;
  const std::array<double, 2> turns{angle_rad(before->X, pose_of(fits[0])),
                                    angle_rad(before->X, pose_of(fits[1]))};
  const std::size_t nearer = turns[1] < turns[0] ? 1 : 0;
  if (turns[nearer] > longest_turn_rad) return std::nullopt;
  return nearer;
}

FoundBody PoseFinder::State::found(const Sighting& sighting, const std::optional<Last>& before,
                                   double time_s) const
{
  FoundBody body;
  body.n_markers = sighting.n_on_face[0] + sighting.n_on_face[1];
  if (body.n_markers == 0) return body;
  body.state = BodyState::ambiguous;
  // One marker's two tilts differ by less than its noise.
  if (body.n_markers == 1) return body;
  const std::vector<Candidate> fits = candidates(sighting);
  if (!fits.empty()) body.rms_px = fits[0].rms_px;
  if (fits.empty() || fits[0].rms_px > options.most_rms_px) {
    body.state = BodyState::misfit;
    return body;
  }
  const std::optional<std::size_t> chosen = choice(fits, before, time_s);
  if (!chosen || fits[*chosen].rotation_sd_rad > most_rotation_sd_rad) return body;
  body.state = BodyState::seen;
  body.X_camera_body = pose_of(fits[*chosen]);
  body.rms_px = fits[*chosen].rms_px;
  return body;
}

std::vector<FoundBody> PoseFinder::find(const GreyPicture& picture, double time_s)
{
  const Camera& camera = state_->camera;
  if (picture.width != camera.width || picture.height != camera.height) {
    const auto size = [](int width, int height) {
      return std::to_string(width) + " x " + std::to_string(height);
    };
    throw InputError({"camera", "", "pictures of " + size(picture.width, picture.height),
                      size(camera.width, camera.height) + ", for which the camera is calibrated"});
  }
  std::vector<FoundBody> bodies;
  const std::vector<Sighting> sightings = state_->sightings(picture);
  for (std::size_t k = 0; k < sightings.size(); ++k) {
    bodies.push_back(state_->found(sightings[k], state_->last[k], time_s));
    if (bodies.back().state == BodyState::seen) state_->last[k] = {bodies.back().X_camera_body, time_s};
  }
  return bodies;
}

}  // namespace vrda::bench
