#include "show/series_renderer.hpp"

#include <algorithm>
#include <utility>

#include "core/text.hpp"
#include "model/frames.hpp"
#include "view/camera.hpp"

namespace vrda::show {
namespace {

/// The viewport of view `row` of `n` views tiled side by side.
view::Viewport column(const view::Viewport& area, std::size_t row, std::size_t n)
{
  const auto edge = [&](std::size_t i) {
    return static_cast<int>(static_cast<std::size_t>(area.width) * i / n);
  };
  return {edge(row), area.y, edge(row + 1) - edge(row), area.height};
}

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

}  // namespace

std::unique_ptr<view::Renderer> warm_renderer(const ShowOptions& options)
{
  // The size of the job is not known yet.
  const view::PictureSize size = options.size.empty() ? view::PictureSize{} : view::parsed_size(options.size);
  std::unique_ptr<view::Renderer> renderer =
      view::make_offscreen_renderer({size.width, size.height, options.samples > 0 ? options.samples : 4});
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

SeriesRenderer::SeriesRenderer(const ShowOptions& options, const store::MotionModel& model,
                               const PosedSet& set, const std::vector<store::JointPose>& poses,
                               std::unique_ptr<view::Renderer> renderer)
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
  if (options.appearance.layers != view::AppearanceOptions{}.layers)
    require_layers(options.file, wanted_, joint_.layers().available());
  area_ = {0, 0, look_.size.width, look_.size.height};
  make_interface(model, set, poses);
  renderer_->resize(look_.size.width, look_.size.height);
  single_ = cameras_for(poses, aspect_of(area_));
  tiled_ = cameras_for(poses, aspect_of(column(area_, 0, look_.views.size())));
  renderer_->load(joint_.scene());
  if (gui_) renderer_->load(gui_->font());
}

/// The warnings of a model whose poses are not doubtful belong to the numbers.
void SeriesRenderer::make_interface(const store::MotionModel& model, const PosedSet& set,
                                    const std::vector<store::JointPose>& poses)
{
  const auto is_doubtful = [&](const store::JointPose& pose) {
    return view::doubt_text(pose, doubts_.at(pose), "")[0] != 0;
  };
  const bool is_doubtful_drawn = set.has_gaps && (std::ranges::any_of(poses, is_doubtful) ||
                                                  std::ranges::any_of(set.played, is_doubtful));
  if (!options_.has_numbers && !wanted_.has(view::Layer::labels) && !is_doubtful_drawn) return;
  view::GuiOptions interface;
  interface.title = model.title;
  interface.sets = {set.name};
  interface.joint = model.joint;
  interface.has_doubtful_poses = is_doubtful_drawn;
  if (options_.has_numbers || is_doubtful_drawn) interface.warnings = view::model_warnings(model);
  if (set.has_gaps) remark_ = view::default_motion_remark(model, set.name);
  gui_.emplace(interface);
  area_ = gui_->free_area(look_.size.width, look_.size.height, {}, false);
}

std::vector<view::Camera> SeriesRenderer::cameras_for(const std::vector<store::JointPose>& poses,
                                                      double aspect)
{
  view::FrameOptions frame_options;
  frame_options.aspect = aspect;
  std::vector<view::CameraFit> fits;
  for (const view::CameraView& view : look_.views) fits.emplace_back(view.R_world_camera, frame_options);
  for (const store::JointPose& pose : poses) {
    const std::vector<Eigen::Vector3d> points = joint_.framed_points(pose, options_.framing);
    for (view::CameraFit& fit : fits) fit.include(points);
  }
  std::vector<view::Camera> cameras;
  cameras.reserve(fits.size());
  for (std::size_t k = 0; k < fits.size(); ++k)
    cameras.push_back(view::placed_camera(fits[k], look_.views[k], look_.zoom));
  return cameras;
}

const view::Overlay* SeriesRenderer::overlay_for(const store::JointPose& pose)
{
  if (!gui_) return nullptr;
  view::GuiFrame frame;
  frame.width = look_.size.width;
  frame.height = look_.size.height;
  if (options_.has_numbers) frame.key = view::colour_key(joint_.layers(), wanted_);
  if (wanted_.has(view::Layer::labels)) frame.labels = joint_.labels(shots_);
  view::PlayerRange range;
  range.is_varus_free = set_.motion.is_varus_free();
  view::Readout readout = joint_.readout(set_, pose, doubts_.at(pose));
  if (!has_gaps_) {
    readout.gap = {};
    readout.doubt = nullptr;
  }
  if (!remark_.empty()) readout.message = remark_.c_str();
  readout.is_varus_balanced = !options_.varus_deg.has_value();
  view::PlayerState state;
  state.shows_numbers = options_.has_numbers;
  return &gui_->static_overlay(frame, state, range, readout);
}

const view::Image& SeriesRenderer::drawn(const store::JointPose& pose)
{
  joint_.show(set_.motion, pose, wanted_);
  for (view::Shot& shot : shots_) shot.camera = view::with_depth_range(shot.camera, joint_.scene());
  return renderer_->draw(joint_.scene(), shots_, overlay_for(pose));
}

const view::Image& SeriesRenderer::draw_single(std::size_t view, const store::JointPose& pose)
{
  shots_.assign({view::Shot{single_[view], area_}});
  return drawn(pose);
}

const view::Image& SeriesRenderer::draw_tiled(const store::JointPose& pose)
{
  shots_.clear();
  for (std::size_t view = 0; view < look_.views.size(); ++view) {
    view::Shot& shot = shots_.emplace_back(view::Shot{tiled_[view], column(area_, view, look_.views.size())});
    shot.camera.aspect = aspect_of(shot.viewport);
  }
  return drawn(pose);
}

}  // namespace vrda::show
