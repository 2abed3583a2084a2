#include "show/show.hpp"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <memory>
#include <ostream>
#include <span>
#include <utility>

#include "core/text.hpp"
#include "model/frames.hpp"
#include "show/joint_view.hpp"
#include "store/motion.hpp"
#include "store/read_separately.hpp"
#include "store/trace.hpp"
#include "view/camera.hpp"
#include "view/gui.hpp"
#include "view/image.hpp"
#include "view/renderer.hpp"

namespace vrda::show {
namespace {

// Pictures of a series of poses: one fixed camera a view, so that they are comparable.

double aspect_of(const view::Viewport& viewport)
{
  return static_cast<double>(viewport.width) / viewport.height;
}

void require_layers(const std::string& file, const view::LayerSet& wanted, const view::LayerSet& available)
{
  for (const std::string& name : view::layer_names()) {
    const view::Layer layer = *view::layer_named(name);
    if (wanted.has(layer) && !available.has(layer))
      throw InputError({file, "--layers", name, "a layer for which the model has data"});
  }
}

/// Three triangles, one per material (bone, cartilage, meniscus).
Body sample_body()
{
  Body body;
  body.name = "sample";
  Mesh& mesh = body.contact.mesh;
  mesh.vertices_mm.resize(9, 3);
  mesh.triangles.resize(3, 3);
  body.contact.component = {0, 1, 2};
  for (int c = 0; c < 3; ++c) {
    body.components.push_back({std::to_string(c), c == 0 ? "bone" : c == 1 ? "cartilage" : "meniscus"});
    mesh.vertices_mm.middleRows<3>(3 * c) << c, 0, 0, c + 1, 0, 1, c, 1, 2;
    mesh.triangles.row(c) << 3 * c, 3 * c + 1, 3 * c + 2;
  }
  return body;
}

/// The set of the motion model that the poses belong to.
struct PosedSet {
  std::string name;      ///< one of set_names(model)
  bool has_gaps = true;  ///< false for intermediate search poses, which have no gap data
  std::span<const store::JointPose> played = {};  ///< of a video
};

/// Returns a renderer of the size in `options` whose shaders are compiled: it has drawn triangles with the
/// materials of bone, cartilage and meniscus. Shader compilation dominates the time to the first frame.
/// Throws InputError like make_offscreen_renderer and apply_appearance.
std::unique_ptr<view::Renderer> warm_renderer(const ShowOptions& options)
{
  // The size of the job is not known yet.
  const view::PictureSize size = options.size.empty() ? view::PictureSize{} : view::parsed_size(options.size);
  std::unique_ptr<view::Renderer> renderer =
      view::make_offscreen_renderer({size.width, size.height, options.samples > 0 ? options.samples : 4,
                                     options.folder.empty() ? view::moving_coarseness_px : 0.0});
  view::Scene scene = view::scene_of(sample_body(), sample_body(), Eigen::Vector3d::Zero());
  view::place(scene, {});
  view::CameraFit fit(view::view_rotation(view::View::oblique, Side::right));
  fit.include(view::framed_points(scene, view::Framing::all));
  view::AppearanceOptions look = options.appearance;
  look.see_through.clear();  // the names of the model's objects are not known yet
  look.hidden.clear();
  view::apply_appearance(scene, look);
  renderer->load(scene);
  const view::Shot shot{view::with_depth_range(fit.camera(), scene),
                        {0, 0, 16, 12}};  // few pixels: only shader compilation matters
  renderer->draw(scene, {&shot, 1}, nullptr);
  return renderer;
}

/// Renders a series of poses with one fixed camera per view.
class SeriesRenderer {
 public:
  /// `model` and `options` must outlive it; `renderer` has the size given in `options`. The cameras are
  /// fitted to all of `poses`, which are solved.
  SeriesRenderer(const ShowOptions& options, const store::MotionModel& model, const PosedSet& set,
                 const std::vector<store::JointPose>& poses, std::unique_ptr<view::Renderer> renderer)
      : options_(options),
        look_(resolved_pictures(options, model)),
        set_(model, set.name),
        has_gaps_(set.has_gaps),
        doubts_(model),
        joint_(model, look_.appearance, options.backdrop),
        wanted_(view::parsed_layers(options.appearance.layers)),
        renderer_(std::move(renderer))
  {
    joint_.fixed_object = options.fixed_object;
    joint_.scene().section = view::plane_of(options.section);
    if (options.state) joint_.use(*options.state);
    if (options.other.is_wanted()) other_.emplace(model, options.other, look_.appearance, options.backdrop);
    if (!options.state && options.appearance.layers != view::AppearanceOptions{}.layers)
      require_layers(options.file, wanted_, joint_.layers().available());
    area_ = {0, 0, look_.size.width, look_.size.height};
    make_interface(model, set, poses);
    renderer_->resize(look_.size.width, look_.size.height);
    place_shots(area_, {});
    single_ = cameras_for(poses, aspect_of(shots_[0].viewport));
    shots_.clear();
    place_shots(column(area_, 0, look_.views.size()), {});
    tiled_ = cameras_for(poses, aspect_of(shots_[0].viewport));
    place(poses.front());
    renderer_->load(joint_.scene());
    if (gui_) renderer_->load(gui_->font());
  }

  const ResolvedPictures& look() const { return look_; }

  /// Of a pose that is not solved only the fixed object is drawn, with the reason.
  /// Renders one view (index into look().views) at full size. The result is valid until the next call.
  const view::Image& draw_single(std::size_t view, const store::JointPose& pose)
  {
    shots_.clear();
    place_shots(area_, single_[view]);
    return drawn(pose);
  }

  /// Renders all views side by side. The result is valid until the next call.
  const view::Image& draw_tiled(const store::JointPose& pose, const std::function<void()>& meanwhile);
  /// Prepares the scene for the next draw.
  void place(const store::JointPose& pose)
  {
    joint_.show(set_.motion, pose, wanted_);
    if (other_) other_->show(joint_, pose, varus_rad(), wanted_);
  }

 private:
  std::optional<double> varus_rad() const
  {
    return options_.varus_deg ? std::optional(rad_from_deg(*options_.varus_deg)) : std::nullopt;
  }

  /// Appends those of one view.
  void place_shots(const view::Viewport& area, const view::Camera& camera)
  {
    if (other_)
      other_->add_shots(shots_, camera, area);
    else
      shots_.push_back({camera, area});
  }

  /// The warnings of a model whose poses are not doubtful belong to the numbers.
  void make_interface(const store::MotionModel& model, const PosedSet& set,
                      const std::vector<store::JointPose>& poses)
  {
    const auto is_doubtful = [&](const store::JointPose& pose) {
      return view::doubt_text(pose, doubts_.at(pose), "")[0] != 0;
    };
    const bool is_doubtful_drawn = set.has_gaps && (std::ranges::any_of(poses, is_doubtful) ||
                                                    std::ranges::any_of(set.played, is_doubtful));
    if (!options_.has_numbers && !wanted_.has(view::Layer::labels) && !is_doubtful_drawn && !other_) return;
    view::GuiOptions interface;
    interface.title = model.title;
    interface.sets = {set.name};
    interface.joint = model.joint;
    interface.has_doubtful_poses = is_doubtful_drawn;
    interface.has_differences = other_.has_value();
    if (options_.has_numbers) {
      interface.verdicts = view::verdict_sentences(model, interface.sets);
      interface.rotations = view::rotation_plots(model, interface.sets);
    }
    if (options_.has_numbers || is_doubtful_drawn) interface.warnings = view::model_warnings(model);
    if (set.has_gaps && options_.has_numbers) interface.remark = view::default_motion_remark(model, set.name);
    interface.remarked_set = 0;
    gui_.emplace(interface);
    area_ = gui_->free_area(look_.size.width, look_.size.height, {}, false);
  }

  std::vector<view::Camera> cameras_for(const std::vector<store::JointPose>& poses, double aspect)
  {
    view::FrameOptions frame_options;
    frame_options.aspect = aspect;
    std::vector<view::CameraFit> fits;
    for (const view::CameraView& view : look_.views) fits.emplace_back(view.R_world_camera, frame_options);
    for (const store::JointPose& pose : poses) {
      const std::vector<Eigen::Vector3d> points = joint_.framed_points(pose, options_.framing);
      for (view::CameraFit& fit : fits) fit.include(points);
      if (!other_) continue;
      const std::vector<Eigen::Vector3d> more =
          other_->framed_points(pose, varus_rad(), joint_.fixed_object, options_.framing);
      for (view::CameraFit& fit : fits) fit.include(more);
    }
    std::vector<view::Camera> cameras;
    cameras.reserve(fits.size());
    for (std::size_t k = 0; k < fits.size(); ++k) {
      cameras.push_back(view::placed_camera(fits[k], look_.views[k], look_.zoom));
      if (options_.state && options_.state->place)
        cameras.back() = placed(cameras.back(), *options_.state->place);
    }
    return cameras;
  }

  const view::Overlay* overlay_for(const store::JointPose& pose)
  {
    if (!gui_) return nullptr;
    view::GuiFrame frame;
    frame.width = look_.size.width;
    frame.height = look_.size.height;
    if (options_.has_numbers) frame.key = view::colour_key(joint_.layers(), wanted_);
    if (wanted_.has(view::Layer::labels))
      frame.labels = other_ ? other_->labels(joint_, shots_) : joint_.labels(shots_);
    if (other_) frame.differences = &other_->differences(set_.motion, varus_rad());
    view::PlayerRange range;
    range.is_varus_free = set_.motion.is_varus_free();
    view::Readout readout = joint_.readout(set_, pose, doubts_.at(pose));
    if (!has_gaps_) {
      readout.gap = {};
      readout.doubt = nullptr;
    }
    readout.is_varus_balanced = !options_.varus_deg.has_value();
    view::PlayerState state;
    state.shows_numbers = options_.has_numbers;
    return &gui_->static_overlay(frame, state, range, readout);
  }

  const view::Image& drawn(const store::JointPose& pose, const std::function<void()>& meanwhile = {})
  {
    place(pose);
    for (view::Shot& shot : shots_) shot.camera = view::with_depth_range(shot.camera, joint_.scene());
    return renderer_->draw(joint_.scene(), shots_, overlay_for(pose), meanwhile);
  }

  const ShowOptions& options_;
  ResolvedPictures look_;
  PlayedSet set_;
  bool has_gaps_ = true;
  view::DoubtReader doubts_;
  JointView joint_;
  std::optional<Comparison> other_;
  view::LayerSet wanted_;
  std::unique_ptr<view::Renderer> renderer_;
  std::optional<view::Gui> gui_;  ///< with --numbers, labels or doubtful poses
  view::Viewport area_;           ///< of the picture, below the warnings
  std::vector<view::Camera> single_, tiled_;
  std::vector<view::Shot> shots_;
};

const view::Image& SeriesRenderer::draw_tiled(const store::JointPose& pose,
                                              const std::function<void()>& meanwhile)
{
  shots_.clear();
  for (std::size_t view = 0; view < look_.views.size(); ++view)
    place_shots(column(area_, view, look_.views.size()), tiled_[view]);
  for (view::Shot& shot : shots_) shot.camera.aspect = aspect_of(shot.viewport);
  return drawn(pose, meanwhile);
}

// What is drawn.

constexpr std::size_t n_default_images = 7;   // of a sequence of frames
constexpr double default_steps = 6.0;         // seven images, 15 degrees apart over 0 to 90
constexpr double default_speed_deg_s = 30.0;  // an examiner's slow bending of a knee
constexpr int default_frames_per_s = 25, most_frames_per_s = 120;  // usual limit of screens

/// Attitudes closer than this share one image.
constexpr double same_angle_rad = rad_from_deg(1e-6);

/// What is drawn.
struct Plan {
  std::vector<store::JointPose> poses;  ///< one image per view each, or one frame of a video
  int n_unsolved = 0;                   ///< attitudes or frames, of a video intervals
};

view::AngleRange wanted_range(const store::Motion& motion, const ShowOptions& options)
{
  if (options.flexion) return view::parsed_angles("--flexion", *options.flexion);
  const double first_deg = deg_from_rad(motion.first_flexion_rad()),
               last_deg = deg_from_rad(motion.last_flexion_rad());
  return {first_deg, last_deg, last_deg > first_deg ? (last_deg - first_deg) / default_steps : 1.0};
}

std::vector<Attitude> wanted_attitudes(const store::Motion& motion, const ShowOptions& options,
                                       const view::AngleRange& range)
{
  std::vector<Attitude> attitudes;
  for (const double flexion_deg : view::angles_deg(range)) {
    const double flexion_rad = rad_from_deg(flexion_deg);
    const double varus_rad =
        options.varus_deg ? rad_from_deg(*options.varus_deg) : motion.balanced_varus_rad(flexion_rad);
    attitudes.push_back({flexion_rad, varus_rad});
  }
  return attitudes;
}

/// Collects the solved poses. Reports clamped angles, and unsolved attitudes if the plan is for images.
Plan plan_of(const store::Motion& motion, const ShowOptions& options, bool reports_unsolved,
             std::ostream& messages)
{
  Plan plan;
  std::optional<double> last_flexion_rad, reported_varus_rad;
  for (const Attitude& wanted : wanted_attitudes(motion, options, wanted_range(motion, options))) {
    store::JointPose pose = motion.at(wanted);
    // A varus given by option is the same for every flexion: it is reported once.
    if (reported_varus_rad == wanted.varus_rad) pose.is_varus_clamped = false;
    view::report_clamped(motion, pose, wanted, "drawn", messages);
    if (pose.is_varus_clamped) reported_varus_rad = wanted.varus_rad;
    const double flexion_rad = pose.attitude.flexion_rad;
    if (last_flexion_rad && flexion_rad - *last_flexion_rad < same_angle_rad) continue;
    last_flexion_rad = flexion_rad;
    if (pose.status == store::PoseStatus::solved) {
      plan.poses.push_back(pose);
      continue;
    }
    if (!reports_unsolved) continue;
    ++plan.n_unsolved;
    messages << "flexion " << view::plain_label(flexion_rad) << ", varus "
             << view::plain_label(pose.attitude.varus_rad) << ": no image, a neighbouring cell is unsolved ("
             << core::name_of(pose.status) << ")\n";
  }
  return plan;
}

int frames_per_s(const ShowOptions& options)
{
  return options.frames_per_s.value_or(default_frames_per_s);
}

/// Options of a grid with a sequence of frames, and the reverse.
void require_own_options(const store::Motion& motion, const ShowOptions& options)
{
  if (!motion.is_sequence()) {
    if (options.frame)
      throw InputError({options.file, "--key", *options.frame, "--flexion: the model is a grid"});
    return;
  }
  const std::pair<const char*, bool> grid_options[] = {{"--flexion", options.flexion.has_value()},
                                                       {"--varus", options.varus_deg.has_value()},
                                                       {"--speed", options.speed_deg_s.has_value()}};
  for (const auto& [option, is_given] : grid_options)
    if (is_given)
      throw InputError(
          {options.file, option, "a sequence of frames", "--key A:B:STEP of " + motion.key_name()});
}

/// The requested keys; by default `n` frames evenly over the sequence.
std::vector<double> wanted_keys(const store::Motion& motion, const ShowOptions& options, std::size_t n)
{
  if (options.frame) return view::angles_deg(view::parsed_angles("--key", *options.frame));
  const std::vector<double>& keys = motion.keys();
  std::vector<double> wanted;
  const std::size_t n_wanted = std::min(n, keys.size());
  for (std::size_t k = 0; k < n_wanted; ++k)
    wanted.push_back(keys[n_wanted == 1 ? 0 : k * (keys.size() - 1) / (n_wanted - 1)]);
  return wanted;
}

bool is_solved(const store::JointPose& pose)
{
  return pose.status == store::PoseStatus::solved;
}

/// The solved poses of a sequence; for a video also those that are not. Reports keys beyond its ends and
/// frames without a pose.
Plan plan_of_frames(const store::Motion& motion, const std::vector<double>& keys, bool is_video,
                    std::ostream& messages)
{
  Plan plan;
  for (const double key : keys) {
    const store::JointPose pose = motion.at_frame(key);
    if (pose.is_flexion_clamped) {
      messages << "--key: found " << shortest_decimal(key) << ", wanted "
               << shortest_decimal(motion.keys().front()) << " to " << shortest_decimal(motion.keys().back())
               << ": drawn at " << shortest_decimal(pose.key) << "\n";
    }
    if (!plan.poses.empty() && plan.poses.back().key == pose.key) continue;
    if (is_solved(pose)) {
      plan.poses.push_back(pose);
    } else {
      if (is_video) plan.poses.push_back(pose);
      ++plan.n_unsolved;
      const bool is_frame = std::binary_search(motion.keys().begin(), motion.keys().end(), pose.key);
      messages << motion.key_name() << " " << shortest_decimal(pose.key) << (is_video ? ": " : ": no image, ")
               << (is_frame ? "the" : "a neighbouring") << " frame has no pose"
               << (is_video ? ", the video shows only the fixed object" : "") << "\n";
    }
  }
  if (std::ranges::none_of(plan.poses, is_solved)) plan.poses.clear();
  return plan;
}

/// Keys of a video of all frames: in real time over time_s, else one frame each.
std::vector<double> video_keys(const store::Motion& motion, const ShowOptions& options)
{
  const std::vector<double>& keys = motion.keys();
  if (options.frame || motion.key_name() != "time_s") return wanted_keys(motion, options, keys.size());
  const double n_frames = std::floor((keys.back() - keys.front()) * frames_per_s(options) + 1e-9);
  if (!(n_frames < 100000.0)) return keys;
  std::vector<double> wanted;
  for (int k = 0; k <= static_cast<int>(n_frames); ++k)
    wanted.push_back(std::min(keys.front() + static_cast<double>(k) / frames_per_s(options), keys.back()));
  return wanted;
}

/// Parts of the names of images, VIEW_label.png: the key or the flexion of each pose.
std::vector<std::string> labels_of(const std::vector<store::JointPose>& poses)
{
  const bool is_sequence = !poses.empty() && !std::isnan(poses.front().key);
  std::vector<double> numbers;
  for (const store::JointPose& pose : poses)
    numbers.push_back(is_sequence ? pose.key : deg_from_rad(pose.attitude.flexion_rad));
  std::vector<std::string> labels;
  for (const double number : numbers)
    labels.push_back((is_sequence ? "frame_" : "flexion_") + view::angle_label(number, numbers));
  return labels;
}

void require_trace_options(const ShowOptions& options)
{
  if (options.every < 1) view::refuse_option("--every", std::to_string(options.every), "1 or more");
  if (!options.trace.empty() && !options.set.empty())
    view::refuse_option("--set", options.set, "no --set: a trace contains its own poses");
  if (!options.trace.empty()) return;
  if (options.contact_only) view::refuse_option("--contact-only", "no --trace", "--trace FILE with it");
  if (options.every != 1) view::refuse_option("--every", "no --trace", "--trace FILE with it");
}

store::FilmOptions film_options(const ShowOptions& options)
{
  store::FilmOptions film;
  film.contact_only = options.contact_only;
  film.every = options.every;
  film.cell.varus_deg = options.varus_deg;
  if (!options.flexion) return film;
  const view::AngleRange range = view::parsed_angles("--flexion", *options.flexion);
  if (range.first_deg != range.last_deg)
    throw InputError({"--flexion", "", *options.flexion, "one angle: --trace shows one cell"});
  film.cell.flexion_deg = range.first_deg;
  return film;
}

/// The motion at the requested speed, with unsolved attitudes; each interval of these is reported. Empty if
/// no attitude is solved.
Plan played_motion(const store::Motion& motion, const ShowOptions& options, std::ostream& messages)
{
  view::AngleRange range = wanted_range(motion, options);
  range.step_deg = options.speed_deg_s.value_or(default_speed_deg_s) / frames_per_s(options);
  Plan film;
  std::optional<double> first_rad;
  double last_rad = 0.0;
  const auto report_interval = [&] {
    if (!first_rad) return;
    ++film.n_unsolved;
    messages << "flexion " << view::plain_label(*first_rad);
    if (last_rad > *first_rad) messages << " to " << view::plain_label(last_rad);
    messages << ": neighbouring cells are unsolved, the video shows only the fixed object\n";
    first_rad.reset();
  };
  for (const Attitude& wanted : wanted_attitudes(motion, options, range)) {
    const store::JointPose pose = motion.at(wanted);
    film.poses.push_back(pose);
    if (pose.status == store::PoseStatus::solved) {
      report_interval();
      continue;
    }
    last_rad = pose.attitude.flexion_rad;
    if (!first_rad) first_rad = last_rad;
  }
  report_interval();
  if (std::ranges::none_of(film.poses, is_solved)) film.poses.clear();
  return film;
}

/// Writes one image per view and pose into the folder, and one path per line to `data`.
void write_images(const ShowOptions& options, SeriesRenderer& maker,
                  const std::vector<store::JointPose>& poses, const std::vector<std::string>& labels,
                  std::ostream& data)
{
  make_folder(options.folder, "--offscreen");
  const std::vector<view::CameraView>& views = maker.look().views;
  for (std::size_t v = 0; v < views.size(); ++v) {
    for (std::size_t k = 0; k < poses.size(); ++k) {
      std::string name = views[v].name + "_" + labels[k] + ".png";
      std::ranges::replace(name, ' ', '_');
      const std::string path = (std::filesystem::path(options.folder) / name).string();
      view::write_png(maker.draw_single(v, poses[k]), path);
      data << path << std::endl;
    }
  }
}

void write_video(const ShowOptions& options, SeriesRenderer& maker, std::vector<store::JointPose> poses,
                 const Streams& streams)
{
  // First and last frame appear once, so that looped playback does not pause there.
  if (options.is_to_and_fro) {
    for (std::size_t i = poses.size() - 1; i-- > 1;) poses.push_back(poses[i]);
  }
  const view::PictureSize size = maker.look().size;
  VideoFile video({options.video, size.width, size.height, frames_per_s(options)});
  // While a frame is drawn the last one is encoded and the next one is placed.
  const view::Image* last = nullptr;
  for (std::size_t k = 0; k < poses.size(); ++k) {
    last = &maker.draw_tiled(poses[k], [&] {
      if (last != nullptr) video.add(*last);
      if (k + 1 < poses.size()) maker.place(poses[k + 1]);
    });
  }
  video.add(*last);
  video.finish();
  streams.data << options.video << std::endl;
  if (!options.is_quiet) {
    streams.messages << options.video << ": " << count_text(poses.size(), "frame") << ", "
                     << frames_per_s(options) << " per second\n";
  }
}

void require_video_options(const ShowOptions& options)
{
  if (options.video.empty()) {
    const std::pair<const char*, bool> unused[] = {{"--fps", options.frames_per_s.has_value()},
                                                   {"--speed", options.speed_deg_s.has_value()},
                                                   {"--to-and-fro", options.is_to_and_fro}};
    for (const auto& [option, is_given] : unused)
      if (is_given) view::refuse_option(option, "no --video", "--video FILE with it");
    return;
  }
  require_video_name(options.video);
  if (frames_per_s(options) < 1 || frames_per_s(options) > most_frames_per_s)
    throw InputError({"--fps", "", std::to_string(frames_per_s(options)), "1 to 120"});
  if (options.speed_deg_s && !(*options.speed_deg_s >= 0.1 && *options.speed_deg_s <= 3600.0))
    throw InputError({"--speed", "", std::to_string(*options.speed_deg_s), "0.1 to 3600 degrees per second"});
}

ShowSummary show_trace(const ShowOptions& options, const store::MotionModel& model,
                       std::unique_ptr<view::Renderer> renderer, const Streams& streams)
{
  store::require_grid(model, options.file, "a trace");
  const store::FilmOptions chosen = film_options(options);
  const store::Trace trace = store::read_trace(options.trace);
  store::require_trace_matches_model(trace, options.trace, model, options.file);
  const store::Film film = store::film_of(trace, options.trace, chosen);
  const store::Motion motion(model, "raw");
  // Numbers have four digits or more, so that names sort in order.
  const std::size_t n_digits = std::max<std::size_t>(4, std::to_string(film.frames.size() - 1).size());
  std::vector<store::JointPose> poses;
  std::vector<std::string> labels;
  for (const store::PoseCoordinates& frame : film.frames) {
    labels.push_back(padded_name("frame_", poses.size(), n_digits));
    poses.push_back(motion.joint_pose(film.attitude, frame));
  }
  SeriesRenderer maker(options, model, {"raw", false}, poses, std::move(renderer));
  if (!options.folder.empty()) write_images(options, maker, poses, labels, streams.data);
  if (!options.video.empty()) write_video(options, maker, poses, streams);
  const std::size_t n_images = options.folder.empty() ? 0 : poses.size() * maker.look().views.size();
  if (!options.is_quiet) {
    streams.messages << options.trace << ": search at flexion "
                     << view::plain_label(film.attitude.flexion_rad) << ", varus "
                     << view::plain_label(film.attitude.varus_rad) << ", "
                     << count_text(poses.size(), "frame") << ", " << count_text(n_images, "image") << "\n";
  }
  return {static_cast<int>(n_images), 0};
}

ShowSummary show_poses(const ShowOptions& options, const store::MotionModel& model,
                       std::unique_ptr<view::Renderer> renderer, const Streams& streams)
{
  const std::string set = store::chosen_set(model, options.file, options.set);
  if (const store::DefaultMotion shown = store::default_motion(model);
      shown.set == set && !shown.reason.empty())
    streams.messages << options.file << ": " << set << " is shown; " << shown.reason << "\n";
  const store::Motion motion(model, set);
  const bool has_images = !options.folder.empty(), has_video = !options.video.empty();
  const bool is_played = has_video && (options.speed_deg_s || !options.flexion);
  require_own_options(motion, options);
  const Plan plan =
      motion.is_sequence()
          ? plan_of_frames(motion, wanted_keys(motion, options, n_default_images), false, streams.messages)
          : plan_of(motion, options, has_images || !is_played, streams.messages);
  Plan film;
  if (motion.is_sequence() && has_video) {
    film = plan_of_frames(motion, video_keys(motion, options), true, streams.messages);
  } else if (is_played) {
    film = played_motion(motion, options, streams.messages);
  }
  // One frame per angle; also the fallback if no attitude of the played motion is solved.
  if (film.poses.empty()) film.poses = plan.poses;
  const std::size_t n_views = has_images ? resolved_pictures(options, model).views.size() : 0;
  const ShowSummary summary{static_cast<int>(plan.poses.size() * n_views), plan.n_unsolved + film.n_unsolved};
  if (!motion.is_sequence() && !options.varus_deg && !motion.has_spine()) {
    streams.messages << "no spine cell is solved: varus " << view::plain_label(motion.balanced_varus_rad(0.0))
                     << " is used for every flexion\n";
  }
  std::vector<store::JointPose> framed = plan.poses.empty() ? film.poses : plan.poses;
  if (framed.empty()) return summary;
  std::erase_if(framed, [](const store::JointPose& pose) { return !is_solved(pose); });
  SeriesRenderer maker(options, model, {set, true, film.poses}, framed, std::move(renderer));
  if (has_images) write_images(options, maker, plan.poses, labels_of(plan.poses), streams.data);
  if (has_video) write_video(options, maker, film.poses, streams);
  if (!options.is_quiet) {
    streams.messages << options.file << ": " << (model.title.empty() ? "untitled" : model.title) << ", set "
                     << set;
    if (has_images)
      streams.messages << ", " << count_text(plan.poses.size(), "attitude") << ", "
                       << count_text(plan.poses.size() * n_views, "image");
    streams.messages << "\n";
  }
  return summary;
}

}  // namespace

ResolvedPictures resolved_pictures(const PictureOptions& options, const store::MotionModel& model,
                                   const char* own_views)
{
  const view::JobViews job = view::job_views(model.job.resolved);
  const Side side = side_named(model.side);
  ResolvedPictures look;
  look.appearance = options.appearance;
  if (!options.has_mode && job.render == "wire") look.appearance.mode = view::DrawMode::wire;
  if (options.views.empty()) {
    look.views = view::camera_views(job, side);
    look.zoom = job.zoom;
  }
  if (look.views.empty()) {
    for (const std::string& name : view::parsed_views(options.views.empty() ? own_views : options.views))
      look.views.push_back(view::named_view(name, *view::view_named(name), side));
  }
  if (options.size.empty() && view::has_usable_size(job)) {
    look.size = {job.width_px, job.height_px};
  } else {
    look.size = view::parsed_size(options.size.empty() ? "1280x960" : options.size);
  }
  return look;
}

namespace {

/// The options with what `--view` and `--section` say.
ShowOptions with_state(ShowOptions options)
{
  if (!options.section_text.empty())
    options.section = view::parsed_section("--section", options.section_text);
  if (options.view.empty()) return options;
  options.state = read_view_state(options.view);
  const ViewState& state = *options.state;
  options.set = state.set;
  options.flexion = shortest_decimal(state.flexion_deg);
  options.varus_deg = state.varus_deg;
  options.fixed_object = state.fixed;
  options.views = state.view;
  options.framing = state.whole ? view::Framing::all : view::Framing::joint;
  options.section = state.section;
  std::string layers = "ligaments";
  const auto add = [&](view::Layer layer) { layers += "," + view::name_of(layer); };
  if (state.labels) add(view::Layer::labels);
  if (state.band) add(view::Layer::band);
  for (const auto& [id, look] : state.structures) {
    if (id == view::gap_structure && look.is_visible) add(view::Layer::gap_map);
    if (id == view::paths_structure && look.is_visible) add(view::Layer::contact_paths);
  }
  options.appearance.layers = layers;
  return options;
}

}  // namespace

ShowSummary show(const ShowOptions& given, const Streams& streams)
{
  ShowOptions options = with_state(given);
  if (!options.views.empty()) view::parsed_views(options.views);
  if (!options.size.empty()) view::parsed_size(options.size);
  view::parsed_layers(options.appearance.layers);
  require_trace_options(options);
  require_video_options(options);
  if (options.varus_deg) view::require_angle("--varus", *options.varus_deg);
  if (options.other.varus_deg) view::require_angle("--other-varus", *options.other.varus_deg);
  if (options.other.is_over && !options.other.is_wanted())
    view::refuse_option("--overlay", "one joint", "a second model, --other-set, --other-varus or --without");
  if (options.other.is_wanted() && !options.trace.empty())
    view::refuse_option("--trace", options.trace, "no comparison: it shows one search");
  store::SeparateModelRead reading(options.file);
  const bool has_window = options.folder.empty() && options.video.empty();
  std::unique_ptr<view::Renderer> renderer = has_window ? nullptr : warm_renderer(options);
  store::MotionModel model = reading.model();
  if (!options.other.file.empty()) {
    store::SeparateModelRead other(options.other.file);
    options.other.model = std::make_shared<const store::MotionModel>(other.model());
  }
  if (options.state) require_of_model(*options.state, options.view, model);
  if (has_window) {
    const std::string set = store::chosen_set(model, options.file, options.set);
    require_own_options(store::Motion(model, set), options);
    show_in_window(options, std::move(model), set);
    return {};
  }
  return options.trace.empty() ? show_poses(options, model, std::move(renderer), streams)
                               : show_trace(options, model, std::move(renderer), streams);
}

}  // namespace vrda::show
