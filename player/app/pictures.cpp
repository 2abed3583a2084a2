#include "app/pictures.hpp"

#include <limits>

#include "core/error.hpp"
#include "scene/camera.hpp"

namespace vrda {
namespace {

/// What the picture must have room for, as placed.
std::vector<Eigen::Vector3d> framed_points(const Scene& scene, Framed framed)
{
  constexpr double everywhere_mm = std::numeric_limits<double>::infinity();
  return points_within(
      scene, framed == Framed::all ? Sphere{Eigen::Vector3d::Zero(), everywhere_mm} : joint_sphere(scene));
}

/// The part of the picture of the `row`th of `n` views side by side; together they cover it.
Viewport column(const PictureSize& size, std::size_t row, std::size_t n)
{
  const auto edge = [&](std::size_t i) {
    return static_cast<int>(static_cast<std::size_t>(size.width) * i / n);
  };
  return {edge(row), 0, edge(row + 1) - edge(row), size.height};
}

double aspect_of(const Viewport& viewport)
{
  return static_cast<double>(viewport.width) / viewport.height;
}

void require_layers(const std::string& file, const LayerSet& wanted, const LayerSet& available)
{
  for (const std::string& name : layer_names()) {
    const Layer layer = *layer_named(name);
    if (wanted.has(layer) && !available.has(layer))
      throw InputError({file, "--layers", name, "a layer that the model has something for"});
  }
}

}  // namespace

PictureMaker::PictureMaker(const ShowOptions& options, const MotionModel& model, const PosedSet& set,
                           const std::vector<JointPose>& poses)
    : options_(options),
      views_(parsed_views(options.views)),
      size_(parsed_size(options.size)),
      side_(model.side == "left" ? Side::left : Side::right),
      motion_(model, set.name),
      gaps_(model, set.name),
      has_gaps_(set.has_gaps),
      scene_(scene_of(model.reference, model.moving, model.rotation_centre_mm)),
      layers_(model, scene_)
{
  check(!scene_.drawables.empty(), "a motion model that was read has triangles");
  scene_.background = background_of(options.backdrop);
  dress(scene_, options.look);
  wanted_ = parsed_layers(options.look.layers);
  require_layers(options.file, wanted_, layers_.available());
  const Viewport whole{0, 0, size_.width, size_.height};
  single_ = cameras_for(poses, aspect_of(whole));
  tiled_ = cameras_for(poses, aspect_of(column(size_, 0, views_.size())));
  renderer_ = make_offscreen_renderer({size_.width, size_.height, options.samples});
  renderer_->load(scene_);
  if (!options.has_numbers) return;
  gui_.emplace(GuiOptions{model.title, {set.name}, 1.0});
  renderer_->load(gui_->font());
}

std::vector<Camera> PictureMaker::cameras_for(const std::vector<JointPose>& poses, double aspect)
{
  FrameOptions frame_options;
  frame_options.aspect = aspect;
  std::vector<CameraFit> fits;
  for (const std::string& view : views_)
    fits.emplace_back(view_rotation(*view_named(view), side_), frame_options);
  for (const JointPose& pose : poses) {
    place(scene_, frames_of(pose, options_.held));
    const std::vector<Eigen::Vector3d> points = framed_points(scene_, options_.framed);
    for (CameraFit& fit : fits) fit.include(points);
  }
  std::vector<Camera> cameras;
  cameras.reserve(fits.size());
  for (const CameraFit& fit : fits) cameras.push_back(fit.camera());
  return cameras;
}

const Overlay* PictureMaker::overlay_for(const JointPose& pose)
{
  if (!gui_) return nullptr;
  GuiFrame frame;
  frame.width = size_.width;
  frame.height = size_.height;
  frame.key = colour_key(layers_, wanted_);
  PlayerRange range;
  range.is_varus_free = motion_.is_varus_free();
  Readout readout;
  readout.pose = pose;
  readout.is_varus_balanced = !options_.varus_deg.has_value();
  if (has_gaps_) readout.gap = gaps_.at(pose.attitude);
  return &gui_->still(frame, {}, range, readout);
}

const Image& PictureMaker::drawn(const JointPose& pose)
{
  const JointFrames frames = frames_of(pose, options_.held);
  place(scene_, frames);
  layers_.update(scene_, motion_, {pose, frames, wanted_});
  for (Shot& shot : shots_) shot.camera = with_depth_range(shot.camera, scene_);
  return renderer_->draw(scene_, shots_, overlay_for(pose));
}

const Image& PictureMaker::single(std::size_t view, const JointPose& pose)
{
  shots_.assign({Shot{single_[view], {0, 0, size_.width, size_.height}}});
  return drawn(pose);
}

const Image& PictureMaker::tiled(const JointPose& pose)
{
  shots_.clear();
  for (std::size_t view = 0; view < views_.size(); ++view) {
    Shot& shot = shots_.emplace_back(Shot{tiled_[view], column(size_, view, views_.size())});
    shot.camera.aspect = aspect_of(shot.viewport);
  }
  return drawn(pose);
}

}  // namespace vrda
