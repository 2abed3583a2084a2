#include "show/run_screen.hpp"

#include <algorithm>

#include "core/error.hpp"
#include "model/side.hpp"
#include "core/units.hpp"
#include "view/scene.hpp"

namespace vrda::show {
namespace {

constexpr std::size_t usual_contacts = 32;  // initial capacity; most steps have fewer than ten

}  // namespace

RunScene::RunScene(const store::MotionModel& model, const RunSceneOptions& options)
    : options_(options),
      scene_(view::scene_of(model, model.rotation_centre_mm)),
      raw_(model, "raw"),
      frame_{side_named(model.side), model.rotation_centre_mm, model.delta},
      scale_(view::marker_scale(model))
{
  for (Eigen::Index i = 0; i < model.push.delta.rows(); ++i)
    deltas_.emplace_back(model.push.delta.row(i).transpose());
  scene_.background = view::background_of(options.backdrop);
  if (options.apply_appearance) options.apply_appearance(scene_);
  shown_bodies_ = view::shown_drawables(scene_);
  points_.emplace(scene_, view::Layer::contacts, view::ParentFrame::world, "contacts");
  arrows_.emplace(scene_, view::Layer::normals, view::ParentFrame::world, "contact normals");
  layers_.emplace(model, scene_);
  reserve_markers(usual_contacts);
  place_bodies(raw_.joint_pose({rad_from_deg(model.flexion_deg.front()), 0.0}, {}), raw_, layers_of_step());
}

void RunScene::show(const RunStep& step)
{
  SolverFrame frame = frame_;
  frame.delta = deltas_[static_cast<std::size_t>(step.key.flexion)];
  const Eigen::Vector3d t_mm = world_translation_mm(frame, step.pose);
  place_bodies(raw_.joint_pose(step.attitude, {t_mm.x(), t_mm.y(), t_mm.z(), step.pose.theta_rad}), raw_,
               layers_of_step());
  place_markers(step);
}

void RunScene::show(const store::JointPose& pose, const store::Motion& motion)
{
  place_bodies(pose, motion, options_.layers);
  view::show_bodies(scene_, shown_bodies_, view::FixedObject::push,
                     pose.status == store::PoseStatus::solved);
  points_->show(scene_, false);
  arrows_->show(scene_, false);
}

// The layers draw the contacts of a model's cells; those of a step are drawn here.
view::LayerSet RunScene::layers_of_step() const
{
  view::LayerSet layers = options_.layers;
  for (const view::Layer layer : {view::Layer::contacts, view::Layer::normals, view::Layer::helical_axis})
    layers.set(layer, false);
  return layers;
}

void RunScene::place_bodies(const store::JointPose& pose, const store::Motion& motion,
                            const view::LayerSet& layers)
{
  pose_ = pose;
  const view::JointFrames frames = view::frames_of(motion, pose);
  view::place(scene_, frames);
  layers_->update(scene_, motion, {pose, frames, layers});
}

void RunScene::reserve_markers(std::size_t n_contacts)
{
  points_->reserve(scene_, n_contacts);
  arrows_->reserve(scene_, n_contacts);
  ++n_layouts_;
}

void RunScene::place_markers(const RunStep& step)
{
  const std::size_t n = step.contacts.size();
  if (n > points_->capacity()) reserve_markers(2 * n);
  points_->show(scene_, options_.layers.has(view::Layer::contacts) && n > 0);
  arrows_->show(scene_, options_.layers.has(view::Layer::normals) && n > 0);
  if (n == 0) return;
  SolverFrame frame = frame_;
  frame.delta = deltas_[static_cast<std::size_t>(step.key.flexion)];
  std::vector<Eigen::Vector3d> tips_mm, arrows_mm;
  for (const ContactRecord& contact : step.contacts) {
    tips_mm.push_back(world_from_solver(frame, contact.point_solver_mm));
    arrows_mm.emplace_back(scale_ * view::plain_arrow_mm * world_from_solver(frame, contact.normal_solver));
  }
  points_->place(scene_, tips_mm, arrows_mm, scale_);
  arrows_->place(scene_, tips_mm, arrows_mm, scale_);
}

std::vector<Eigen::Vector3d> RunScene::framed_points() const
{
  view::Scene scene = scene_;
  std::vector<Eigen::Vector3d> all;
  const Eigen::Vector3d t_mm = pose_.X_world_moving * frame_.rotation_centre_mm;
  const double first_rad = raw_.first_flexion_rad(), last_rad = raw_.last_flexion_rad();
  for (const double flexion_rad : {first_rad, 0.5 * (first_rad + last_rad), last_rad}) {
    view::place(scene,
                 view::frames_of(raw_.joint_pose({flexion_rad, 0.0}, {t_mm.x(), t_mm.y(), t_mm.z(), 0.0})));
    const std::vector<Eigen::Vector3d> near = view::points_within(scene, view::joint_sphere(scene));
    all.insert(all.end(), near.begin(), near.end());
  }
  return all;
}

namespace {

// Fraction of the image width, limited to what text and map need at least and can use at most.
constexpr double panel_part = 0.25;
constexpr int narrowest_panel_px = 150, widest_panel_px = 420;
// Text size relative to the image height.
constexpr double text_part = 1.0 / 60.0, smallest_text_px = 10.0, largest_text_px = 22.0;

}  // namespace

RunScreen::RunScreen(const store::MotionModel& model, const RunScreenOptions& options) : options_(options)
{
  check(!options.views.empty(), "there is at least one view");
  scene_.emplace(model, options.scene);
  make_text();
  resize(options.width, options.height);
}

void RunScreen::restart(const store::MotionModel& model)
{
  finish(model);
  has_step_ = false;
  fit_cameras();
}

void RunScreen::finish(const store::MotionModel& result)
{
  scene_.emplace(result, options_.scene);
  n_loaded_layouts_ = 0;
}

void RunScreen::make_text()
{
  text_.emplace(std::clamp(text_part * options_.height, smallest_text_px, largest_text_px));
  is_font_loaded_ = false;
}

bool RunScreen::resize(int width, int height)
{
  const bool is_same = width == options_.width && height == options_.height && !shots_.empty();
  if (is_same) return false;
  const bool is_taller = height != options_.height;
  options_.width = width;
  options_.height = height;
  if (is_taller) make_text();
  const int panel_px = std::clamp(static_cast<int>(panel_part * width),
                                  std::min(narrowest_panel_px, width / 2), widest_panel_px);
  panel_area_ = {width - panel_px, 0, panel_px, height};
  fit_cameras();
  return true;
}

void RunScreen::fit_cameras()
{
  const view::Viewport area{0, 0, options_.width - panel_area_.width, options_.height};
  const std::vector<Eigen::Vector3d> points_mm = scene_->framed_points();
  shots_ = fitted_shots(options_.views, tiles(options_.views.size(), area), points_mm, options_.zoom);
  pivots_world_mm_.assign(options_.views.size(), view::joint_sphere(scene_->scene()).centre_world_mm);
  set_depths();
}

std::optional<std::size_t> RunScreen::view_at(const Eigen::Vector2d& pointer_px) const
{
  for (std::size_t k = 0; k < shots_.size(); ++k) {
    const view::Viewport& at = shots_[k].viewport;
    const double x = pointer_px.x() - at.x, y = pointer_px.y() - at.y;
    if (x >= 0.0 && x < at.width && y >= 0.0 && y < at.height) return k;
  }
  return std::nullopt;
}

void RunScreen::set_orbit_camera(std::size_t view, const view::OrbitCamera& gaze)
{
  pivots_world_mm_[view] = gaze.pivot_world_mm;
  shots_[view].camera = view::with_depth_range(gaze.camera, scene_->scene());
}

void RunScreen::set_depths()
{
  for (view::Shot& shot : shots_) shot.camera = view::with_depth_range(shot.camera, scene_->scene());
}

void RunScreen::show(const RunState& state, const std::vector<std::string>& lines)
{
  if (state.shown()) scene_->show(*state.shown());
  draw(state, lines, state.shown().has_value());
}

void RunScreen::show(const RunState& state, const std::vector<std::string>& lines,
                     const store::JointPose& pose, const store::Motion& motion)
{
  scene_->show(pose, motion);
  draw(state, lines, true);
}

void RunScreen::draw(const RunState& state, const std::vector<std::string>& lines, bool has_pose)
{
  if (has_pose && !has_step_) fit_cameras();
  has_step_ = has_step_ || has_pose;
  set_depths();
  view::clear_overlay(overlay_, options_.width, options_.height);
  RunPanel panel = state.panel();
  panel.lines.insert(panel.lines.end(), lines.begin(), lines.end());
  for (std::size_t k = 0; k < shots_.size(); ++k)
    add_label(overlay_, *text_, shots_[k].viewport, options_.views[k].name);
  add_panel(overlay_, *text_, panel_area_, panel);
  view::finish_overlay(overlay_);
}

void RunScreen::load(view::Renderer& renderer)
{
  if (n_loaded_layouts_ != scene_->n_layouts()) renderer.load(scene_->scene());
  n_loaded_layouts_ = scene_->n_layouts();
  if (!is_font_loaded_) renderer.load(text_->font());
  is_font_loaded_ = true;
}

}  // namespace vrda::show
