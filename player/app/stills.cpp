#include "app/stills.hpp"

#include <filesystem>
#include <limits>
#include <ostream>
#include <system_error>

#include "app/arguments.hpp"
#include "core/error.hpp"
#include "render/png_file.hpp"
#include "render/renderer.hpp"
#include "scene/camera.hpp"
#include "scene/joint_layers.hpp"
#include "scene/scene.hpp"

namespace vrda {
namespace {

void make_folder(const std::string& folder)
{
  std::error_code error;
  std::filesystem::create_directories(folder, error);
  if (error || !std::filesystem::is_directory(folder)) {
    throw InputError(
        {folder, "--offscreen", error ? error.message() : "no folder", "a folder that can be written"});
  }
}

/// What the picture must have room for, as placed.
std::vector<Eigen::Vector3d> framed_points(const Scene& scene, Framed framed)
{
  constexpr double everywhere_mm = std::numeric_limits<double>::infinity();
  return points_within(
      scene, framed == Framed::all ? Sphere{Eigen::Vector3d::Zero(), everywhere_mm} : joint_sphere(scene));
}

/// One camera a view, with room for what is framed at every pose.
std::vector<Camera> cameras_for(Scene& scene, const std::vector<JointFrames>& frames, Framed framed,
                                std::vector<CameraFit> fits)
{
  for (const JointFrames& placed : frames) {
    place(scene, placed);
    const std::vector<Eigen::Vector3d> points = framed_points(scene, framed);
    for (CameraFit& fit : fits) fit.include(points);
  }
  std::vector<Camera> cameras;
  cameras.reserve(fits.size());
  for (const CameraFit& fit : fits) cameras.push_back(fit.camera());
  return cameras;
}

std::vector<CameraFit> fits_for(const std::vector<std::string>& views, const PictureSize& size, Side side)
{
  FrameOptions frame_options;
  frame_options.aspect = static_cast<double>(size.width) / size.height;
  std::vector<CameraFit> fits;
  fits.reserve(views.size());
  for (const std::string& view : views)
    fits.emplace_back(view_rotation(*view_named(view), side), frame_options);
  return fits;
}

void require_layers(const ShowOptions& options, const LayerSet& wanted, const LayerSet& available)
{
  for (const std::string& name : layer_names()) {
    const Layer layer = *layer_named(name);
    if (wanted.has(layer) && !available.has(layer))
      throw InputError({options.file, "--layers", name, "a layer that the model has something for"});
  }
}

}  // namespace

void write_stills(const ShowOptions& options, const MotionModel& model, const Motion& motion,
                  const std::vector<Still>& stills, std::ostream& data)
{
  const std::vector<std::string> views = parsed_views(options.views);
  const PictureSize size = parsed_size(options.size);
  Scene scene = scene_of(model.reference, model.moving, model.rotation_centre_mm);
  check(!scene.drawables.empty(), "a motion model that was read has triangles");
  JointLayers layers(model, scene);
  scene.background = background_of(options.backdrop);
  dress(scene, options.look);
  const LayerSet wanted = parsed_layers(options.look.layers);
  require_layers(options, wanted, layers.available());
  std::vector<JointFrames> frames;
  frames.reserve(stills.size());
  for (const Still& still : stills) frames.push_back(frames_of(still.pose, options.held));
  const Side side = model.side == "left" ? Side::left : Side::right;
  const std::vector<Camera> cameras = cameras_for(scene, frames, options.framed, fits_for(views, size, side));
  const std::unique_ptr<Renderer> renderer = make_offscreen_renderer({size.width, size.height});
  renderer->load(scene);
  make_folder(options.folder);
  for (std::size_t v = 0; v < views.size(); ++v) {
    for (std::size_t i = 0; i < stills.size(); ++i) {
      place(scene, frames[i]);
      layers.update(scene, motion, {stills[i].pose, frames[i], wanted});
      const std::string name = views[v] + "_" + stills[i].label + ".png";
      const std::string path = (std::filesystem::path(options.folder) / name).string();
      write_png(renderer->draw(scene, with_depth_range(cameras[v], scene)), path);
      data << path << std::endl;
    }
  }
}

}  // namespace vrda
