#include "show/pictures.hpp"

#include <array>
#include <utility>

#include "core/error.hpp"
#include "scene/camera.hpp"

namespace vrda {
namespace {

/// The viewport of view `row` of `n` views tiled side by side.
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
      throw InputError({file, "--layers", name, "a layer for which the model has data"});
  }
}

/// Three boxes, one per material (bone, cartilage, meniscus).
Body sample_body()
{
  Body body;
  body.name = "sample";
  // The bits of k are the coordinates of corner k; faces are counter-clockwise seen from outside.
  constexpr std::array<std::array<int, 3>, 12> faces{{{0, 2, 3},
                                                      {0, 3, 1},
                                                      {4, 5, 7},
                                                      {4, 7, 6},
                                                      {0, 1, 5},
                                                      {0, 5, 4},
                                                      {2, 6, 7},
                                                      {2, 7, 3},
                                                      {0, 4, 6},
                                                      {0, 6, 2},
                                                      {1, 3, 7},
                                                      {1, 7, 5}}};
  Mesh& mesh = body.contact.mesh;
  mesh.vertices_mm.resize(24, 3);
  mesh.triangles.resize(36, 3);
  for (int c = 0; c < 3; ++c) {
    body.components.push_back({std::to_string(c), c == 0 ? "bone" : c == 1 ? "cartilage" : "meniscus"});
    for (int k = 0; k < 8; ++k)
      mesh.vertices_mm.row(8 * c + k) << (k & 1) + 2.0 * c, (k & 2) / 2, (k & 4) / 4;
    for (int t = 0; t < 12; ++t) {
      const std::array<int, 3>& face = faces[static_cast<std::size_t>(t)];
      mesh.triangles.row(12 * c + t) << 8 * c + face[0], 8 * c + face[1], 8 * c + face[2];
      body.contact.component.push_back(c);
    }
  }
  return body;
}

}  // namespace

std::unique_ptr<Renderer> warm_renderer(const ShowOptions& options)
{
  const PictureSize size = parsed_size(options.size);
  std::unique_ptr<Renderer> renderer = make_offscreen_renderer({size.width, size.height, options.samples});
  Scene scene = scene_of(sample_body(), sample_body(), Eigen::Vector3d::Zero());
  place(scene, {});
  CameraFit fit(view_rotation(View::oblique, Side::right));
  fit.include(framed_points(scene, Framed::all));
  dress(scene, options.look);  // after fitting, since it may hide bodies
  renderer->load(scene);
  const Shot shot{with_depth_range(fit.camera(), scene),
                  {0, 0, 16, 12}};  // few pixels: only shader compilation matters
  renderer->draw(scene, {&shot, 1}, nullptr);
  return renderer;
}

PictureMaker::PictureMaker(const ShowOptions& options, const MotionModel& model, const PosedSet& set,
                           const std::vector<JointPose>& poses, std::unique_ptr<Renderer> renderer)
    : options_(options),
      views_(parsed_views(options.views)),
      size_(parsed_size(options.size)),
      side_(model.side == "left" ? Side::left : Side::right),
      motion_(model, set.name),
      gaps_(model, set.name),
      has_gaps_(set.has_gaps),
      scene_(scene_of(model.reference, model.moving, model.rotation_centre_mm)),
      layers_(model, scene_),
      renderer_(std::move(renderer))
{
  check(!scene_.drawables.empty(), "a validated motion model has triangles");
  scene_.background = background_of(options.backdrop);
  dress(scene_, options.look);
  wanted_ = parsed_layers(options.look.layers);
  require_layers(options.file, wanted_, layers_.available());
  const Viewport whole{0, 0, size_.width, size_.height};
  single_ = cameras_for(poses, aspect_of(whole));
  tiled_ = cameras_for(poses, aspect_of(column(size_, 0, views_.size())));
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
