#include "app/show.hpp"

#include <cmath>
#include <filesystem>
#include <ostream>
#include <system_error>
#include <vector>

#include "app/arguments.hpp"
#include "core/error.hpp"
#include "motion/poses.hpp"
#include "render/png_file.hpp"
#include "render/renderer.hpp"
#include "scene/camera.hpp"
#include "scene/scene.hpp"
#include "store/motion_model_file.hpp"

namespace vrda {
namespace {

constexpr double default_steps = 6.0;  // seven stills, 15 degrees apart over 0 to 90

/// Two attitudes nearer than this are one still.
constexpr double same_angle_rad = rad_from_deg(1e-6);

std::string chosen_set(const MotionModel& model, const ShowOptions& options)
{
  const std::vector<std::string> names = set_names(model);
  if (options.set.empty()) return names.front();
  std::string known;
  for (const std::string& name : names) {
    if (name == options.set) return name;
    known += (known.empty() ? "" : ", ") + name;
  }
  throw InputError({options.file, "--set", options.set, known});
}

void make_folder(const std::string& folder)
{
  std::error_code error;
  std::filesystem::create_directories(folder, error);
  if (error || !std::filesystem::is_directory(folder)) {
    throw InputError(
        {folder, "--offscreen", error ? error.message() : "no folder", "a folder that can be written"});
  }
}

/// Angles as people read them: the label without padding.
std::string plain(double angle_rad)
{
  const double angle_deg = deg_from_rad(angle_rad);
  std::string text = angle_label(angle_deg, {});
  const std::size_t first = text.find_first_not_of("-0");
  const bool is_whole_zero = first == std::string::npos || text[first] == '.';
  const std::string digits =
      is_whole_zero ? "0" + (first == std::string::npos ? "" : text.substr(first)) : text.substr(first);
  return (text[0] == '-' ? "-" : "") + digits;
}

struct Plan {
  std::vector<JointPose> poses;  ///< one a still of each view, solved
  int n_unsolved = 0;
};

std::vector<Attitude> wanted_attitudes(const Motion& motion, const ShowOptions& options)
{
  const double first_deg = deg_from_rad(motion.first_flexion_rad()),
               last_deg = deg_from_rad(motion.last_flexion_rad());
  AngleRange range{first_deg, last_deg, last_deg > first_deg ? (last_deg - first_deg) / default_steps : 1.0};
  if (options.flexion) range = parsed_angles("--flexion", *options.flexion);
  std::vector<Attitude> attitudes;
  for (const double flexion_deg : angles_deg(range)) {
    const double flexion_rad = rad_from_deg(flexion_deg);
    const double varus_rad =
        options.varus_deg ? rad_from_deg(*options.varus_deg) : motion.balanced_varus_rad(flexion_rad);
    attitudes.push_back({flexion_rad, varus_rad});
  }
  return attitudes;
}

/// Clamped by more than what converting degrees to radians and back leaves.
bool is_beyond(double wanted_rad, double used_rad)
{
  return std::abs(wanted_rad - used_rad) > same_angle_rad;
}

void tell_clamped(const Motion& motion, const JointPose& pose, const Attitude& wanted, std::ostream& talk)
{
  if (pose.is_flexion_clamped && is_beyond(wanted.flexion_rad, pose.attitude.flexion_rad)) {
    talk << "flexion " << plain(wanted.flexion_rad) << " lies outside the measured "
         << plain(motion.first_flexion_rad()) << " to " << plain(motion.last_flexion_rad())
         << " degrees: drawn at " << plain(pose.attitude.flexion_rad) << "\n";
  }
  if (pose.is_varus_clamped && is_beyond(wanted.varus_rad, pose.attitude.varus_rad)) {
    talk << "varus " << plain(wanted.varus_rad) << " lies outside the measured "
         << plain(motion.first_varus_rad()) << " to " << plain(motion.last_varus_rad())
         << " degrees: drawn at " << plain(pose.attitude.varus_rad) << "\n";
  }
}

Plan plan_of(const Motion& motion, const ShowOptions& options, std::ostream& talk)
{
  Plan plan;
  std::optional<double> last_flexion_rad, last_told_varus_rad;
  for (const Attitude& wanted : wanted_attitudes(motion, options)) {
    JointPose pose = motion.at(wanted);
    // The varus is told once: it is the same for every flexion when it was given.
    if (last_told_varus_rad == wanted.varus_rad) pose.is_varus_clamped = false;
    tell_clamped(motion, pose, wanted, talk);
    if (pose.is_varus_clamped) last_told_varus_rad = wanted.varus_rad;
    const double flexion_rad = pose.attitude.flexion_rad;
    if (last_flexion_rad && flexion_rad - *last_flexion_rad < same_angle_rad) continue;
    last_flexion_rad = flexion_rad;
    if (pose.status == PoseStatus::solved) {
      plan.poses.push_back(pose);
      continue;
    }
    ++plan.n_unsolved;
    talk << "flexion " << plain(flexion_rad) << ", varus " << plain(pose.attitude.varus_rad)
         << ": no picture, a cell around it is not solved (" << name_of(pose.status) << ")\n";
  }
  return plan;
}

/// One camera a view, with room for the joint at every pose.
std::vector<Camera> cameras_for(Scene& scene, const std::vector<JointFrames>& frames,
                                std::vector<CameraFit> fits)
{
  for (const JointFrames& placed : frames) {
    place(scene, placed);
    const std::vector<Eigen::Vector3d> points = points_within(scene, joint_sphere(scene));
    for (CameraFit& fit : fits) fit.include(points);
  }
  std::vector<Camera> cameras;
  cameras.reserve(fits.size());
  for (const CameraFit& fit : fits) cameras.push_back(fit.camera());
  return cameras;
}

void write_stills(const ShowOptions& options, const MotionModel& model, const std::vector<JointPose>& poses,
                  std::ostream& data)
{
  const std::vector<std::string> views = parsed_views(options.views);
  const PictureSize size = parsed_size(options.size);
  Scene scene = scene_of(model.reference, model.moving, model.rotation_centre_mm);
  check(!scene.drawables.empty(), "a motion model that was read has triangles");
  scene.background = background_of(options.backdrop);
  FrameOptions frame_options;
  frame_options.aspect = static_cast<double>(size.width) / size.height;
  const Side side = model.side == "left" ? Side::left : Side::right;
  std::vector<CameraFit> fits;
  fits.reserve(views.size());
  for (const std::string& view : views)
    fits.emplace_back(view_rotation(*view_named(view), side), frame_options);
  std::vector<JointFrames> frames;
  frames.reserve(poses.size());
  for (const JointPose& pose : poses) frames.push_back(frames_of(pose, options.held));
  const std::vector<Camera> cameras = cameras_for(scene, frames, std::move(fits));
  const std::unique_ptr<Renderer> renderer = make_offscreen_renderer({size.width, size.height});
  renderer->load(scene);
  make_folder(options.folder);
  std::vector<double> all_flexion_deg;
  all_flexion_deg.reserve(poses.size());
  for (const JointPose& pose : poses) all_flexion_deg.push_back(deg_from_rad(pose.attitude.flexion_rad));
  for (std::size_t v = 0; v < views.size(); ++v) {
    for (std::size_t i = 0; i < poses.size(); ++i) {
      place(scene, frames[i]);
      const std::string name =
          views[v] + "_flexion_" + angle_label(all_flexion_deg[i], all_flexion_deg) + ".png";
      const std::string path = (std::filesystem::path(options.folder) / name).string();
      write_png(renderer->draw(scene, with_depth_range(cameras[v], scene)), path);
      data << path << std::endl;
    }
  }
}

}  // namespace

ShowSummary show(const ShowOptions& options, const ShowStreams& streams)
{
  if (options.folder.empty()) {
    throw InputError({"show", "--offscreen", "nothing",
                      "a folder for the pictures (a window is not available in this version)"});
  }
  const std::size_t n_views = parsed_views(options.views).size();
  parsed_size(options.size);
  const MotionModel model = read_motion_model(options.file);
  const std::string set = chosen_set(model, options);
  const Motion motion(model, set);
  const Plan plan = plan_of(motion, options, streams.talk);
  const ShowSummary summary{static_cast<int>(plan.poses.size() * n_views), plan.n_unsolved};
  if (!options.varus_deg && !motion.has_spine()) {
    streams.talk << "no balanced cell is solved: varus " << plain(motion.balanced_varus_rad(0.0))
                 << " for every flexion\n";
  }
  if (plan.poses.empty()) return summary;
  write_stills(options, model, plan.poses, streams.data);
  if (!options.is_quiet) {
    streams.talk << options.file << ": " << (model.title.empty() ? "untitled" : model.title) << ", set "
                 << set << ", " << plan.poses.size() << (plan.poses.size() == 1 ? " attitude" : " attitudes")
                 << ", " << summary.n_stills << (summary.n_stills == 1 ? " picture" : " pictures") << "\n";
  }
  return summary;
}

}  // namespace vrda
