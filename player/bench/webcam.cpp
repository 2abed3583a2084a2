#include "bench/webcam.hpp"

#include <opencv2/aruco.hpp>
#include <opencv2/aruco/charuco.hpp>
#include <opencv2/calib3d.hpp>
#include <opencv2/imgproc.hpp>
#include <opencv2/videoio.hpp>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <map>
#include <sstream>
#include <thread>

#include "bench/igtl_message.hpp"
#include "bench/toml_table.hpp"
#include "core/files.hpp"
#include "core/schema.hpp"
#include "core/text.hpp"

namespace vrda::bench {

const core::DocumentSchema& camera_schema();  // schemas/camera.schema.json

namespace {

template <typename Visit, typename AnyCamera, typename Numbers>
void visit_camera(const Visit& visit, AnyCamera& camera, Numbers& distortion)
{
  visit("width", camera.width);
  visit("height", camera.height);
  visit("focal_px", camera.focal_px);
  visit("centre_px", camera.centre_px);
  visit("distortion", distortion, "k1, k2, p1, p2, k3");
  visit("rms_px", camera.rms_px);
  visit("views", camera.n_views);
}

}  // namespace

Camera read_camera(const std::string& path)
{
  const std::string text =
      core::read_document_text(path, "a camera calibration (vrda-webcam calibrate writes it)");
  const core::Document document = camera_schema().read(text, path);
  Camera camera;
  std::vector<double> distortion;
  visit_camera(TableReader(document.root), camera, distortion);
  std::ranges::copy(distortion, camera.distortion.begin());
  return camera;
}

std::string camera_text(const Camera& camera)
{
  std::ostringstream text;
  text << "# Written by vrda-webcam calibrate; valid for this camera, picture size and focus.\n";
  visit_camera(TableWriter(text), camera, camera.distortion);
  return text.str();
}

namespace {

constexpr std::size_t least_corners = 12;  ///< half of the board's 24
/// A view whose corners moved less than this on average adds no information.
constexpr double least_motion_px = 20.0;

}  // namespace

struct CameraFit::State {
  int n_views = 0;
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

CameraFit::CameraFit(int n_views) : state_(std::make_unique<State>())
{
  state_->n_views = n_views;
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
  return "view " + std::to_string(state.ids.size()) + " of " + std::to_string(state.n_views);
}

bool CameraFit::is_complete() const
{
  return static_cast<int>(state_->ids.size()) >= state_->n_views;
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
    throw InputError({file, "", "an error of " + short_decimal(camera.rms_px, 2) + " px",
                      "at most 1 px: a flat board, no motion blur, fixed focus"});
  const double focal_share =
      std::max(sd.at<double>(0) / camera.focal_px.x(), sd.at<double>(1) / camera.focal_px.y());
  if (!(focal_share <= most_focal_share))
    throw InputError({file, "", "a focal length known to " + short_decimal(100.0 * focal_share, 1) + " %",
                      "1 %: tilt the board more"});
  return camera;
}

using SteadyClock = std::chrono::steady_clock;

struct PictureSource::State {
  CameraSettings options;
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

PictureSource::PictureSource(const CameraSettings& camera) : state_(std::make_unique<State>())
{
  state_->options = camera;
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
  const Eigen::Vector2d &f = camera.focal_px, &c = camera.centre_px;
  state_->K = cv::Matx33d(f.x(), 0.0, c.x(), 0.0, f.y(), c.y(), 0.0, 0.0, 1.0);
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

namespace {

BenchFile read_bench(const std::string& path)
{
  BenchFile bench = read_bench_file(path, MarkerPositions::optional);
  if (!bench.camera) throw InputError({path, "tracker", "a server", "tracker = \"aruco\""});
  return bench;
}

std::string text_of(const IgtlMessage& message)
{
  const std::vector<std::uint8_t> bytes = bytes_of(message);
  return {bytes.begin(), bytes.end()};
}

IgtlMessage tdata_of(const std::vector<FoundBody>& bodies, const std::vector<std::string>& tools,
                     std::int64_t taken_ns)
{
  IgtlMessage message;
  message.kind = IgtlKind::tdata;
  // States that the listed bodies are visible: those of a still film do not jitter.
  message.header_version = 2;
  message.device = "webcam";
  message.device_ns = taken_ns;
  for (std::size_t k = 0; k < bodies.size(); ++k) {
    const bool is_misfit = bodies[k].state == BodyState::misfit;
    if (bodies[k].state != BodyState::seen && !is_misfit) continue;
    message.tools.push_back(
        {tools[k], is_misfit ? ToolVisibility::invalid_pose : ToolVisibility::seen, bodies[k].X_camera_body});
  }
  return message;
}

}  // namespace

void track(const std::string& bench_path, const ByteSink& sink)
{
  const BenchFile bench = read_bench(bench_path);
  const Camera camera = read_camera(bench.camera->calibration);
  const std::vector<std::string>& tools = bench.tracker->tools;
  PoseFinderOptions options;
  options.n_bodies = tools.size();
  options.sheet = {bench.camera->marker_mm, bench.camera->fold_rad};
  PoseFinder finder(camera, options);
  PictureSource source(*bench.camera);
  for (bool goes_on = true; goes_on;) {
    const TimedPicture taken = source.next();
    if (taken.is_frozen) continue;
    const double time_s = static_cast<double>(taken.taken_ns) * s_per_ns;
    goes_on = sink(text_of(tdata_of(finder.find(taken.picture, time_s), tools, taken.taken_ns)));
  }
}

std::string error_message(const std::string& text)
{
  IgtlMessage message;
  message.kind = IgtlKind::status;
  message.device = "webcam";
  constexpr int igtl_unknown_error = 2;
  message.code = igtl_unknown_error;
  message.text = text;
  return text_of(message);
}

void write_sheets(const std::string& bench_path, const std::string& pdf)
{
  const BenchFile bench = read_bench(bench_path);
  Publication::begin(pdf, "vrda-webcam")->publish(sheets_pdf(bench.tracker->tools));
}

void calibrate(const CalibrateOptions& options, std::ostream& messages)
{
  const BenchFile bench = read_bench(options.bench);
  const std::string output = options.output.empty() ? bench.camera->calibration : options.output;
  PictureSource source(*bench.camera);
  CameraFit fit(options.n_views);
  std::string last;
  const auto end = std::chrono::steady_clock::now() + std::chrono::duration<double>(options.seconds);
  while (!fit.is_complete() && std::chrono::steady_clock::now() < end) {
    const std::string said = fit.take(source.next().picture);
    if (said != last) messages << said << std::endl;
    last = said;
  }
  const Camera camera = fit.camera(output);
  Publication::begin(output, "vrda-webcam")->publish(camera_text(camera));
  messages << output << ": focal length " << short_decimal(camera.focal_px.x(), 1) << " px, error "
           << short_decimal(camera.rms_px, 2) << " px in " << camera.n_views << " views\n";
}

}  // namespace vrda::bench
