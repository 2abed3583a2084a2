#include "follow/run_screen.hpp"

#include <algorithm>

#include "core/error.hpp"

namespace vrda {
namespace {

// Of the picture's width, within what words and map need and what they can use.
constexpr double panel_part = 0.25;
constexpr int narrowest_panel_px = 150, widest_panel_px = 420;
// Text as large as on a page, whatever the size of the picture.
constexpr double text_part = 1.0 / 60.0, smallest_text_px = 10.0, largest_text_px = 22.0;

}  // namespace

RunScreen::RunScreen(const MotionModel& model, const RunScreenOptions& options) : options_(options)
{
  check(!options.views.empty(), "there is at least one view");
  scene_.emplace(model, options.scene);
  make_text();
  resize(options.width, options.height);
}

void RunScreen::begin(const MotionModel& model)
{
  scene_.emplace(model, options_.scene);
  n_loaded_layouts_ = 0;
  has_step_ = false;
  fit_cameras();
}

void RunScreen::finish(const MotionModel& result)
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
  const Viewport area{0, 0, options_.width - panel_area_.width, options_.height};
  const std::vector<Eigen::Vector3d> points_mm = scene_->framed_points();
  shots_ = fitted_shots(options_.views, tiles(options_.views.size(), area), points_mm, options_.zoom);
  pivots_world_mm_.assign(options_.views.size(), joint_sphere(scene_->scene()).centre_world_mm);
  set_depths();
}

void RunScreen::reset_views()
{
  fit_cameras();
}

std::optional<std::size_t> RunScreen::view_at(const Eigen::Vector2d& pointer_px) const
{
  for (std::size_t k = 0; k < shots_.size(); ++k) {
    const Viewport& at = shots_[k].viewport;
    const double x = pointer_px.x() - at.x, y = pointer_px.y() - at.y;
    if (x >= 0.0 && x < at.width && y >= 0.0 && y < at.height) return k;
  }
  return std::nullopt;
}

Gaze RunScreen::gaze(std::size_t view) const
{
  return {shots_[view].camera, pivots_world_mm_[view]};
}

void RunScreen::look(std::size_t view, const Gaze& gaze)
{
  pivots_world_mm_[view] = gaze.pivot_world_mm;
  shots_[view].camera = with_depth_range(gaze.camera, scene_->scene());
}

void RunScreen::set_depths()
{
  for (Shot& shot : shots_) shot.camera = with_depth_range(shot.camera, scene_->scene());
}

void RunScreen::show(const RunState& state, const std::vector<std::string>& lines)
{
  if (state.shown()) {
    scene_->show(*state.shown());
    if (!has_step_) fit_cameras();
    has_step_ = true;
  }
  set_depths();
  draw_overlay(state, lines);
}

void RunScreen::show(const RunState& state, const std::vector<std::string>& lines, const JointPose& pose,
                     const Motion& motion)
{
  scene_->show(pose, motion);
  if (!has_step_) fit_cameras();
  has_step_ = true;
  set_depths();
  draw_overlay(state, lines);
}

void RunScreen::draw_overlay(const RunState& state, const std::vector<std::string>& lines)
{
  empty_overlay(overlay_, options_.width, options_.height);
  RunPanel panel = state.panel();
  panel.lines.insert(panel.lines.end(), lines.begin(), lines.end());
  for (std::size_t k = 0; k < shots_.size(); ++k)
    add_label(overlay_, *text_, shots_[k].viewport, options_.views[k].name);
  add_panel(overlay_, *text_, panel_area_, panel);
  close_overlay(overlay_);
}

void RunScreen::load(Renderer& renderer)
{
  if (n_loaded_layouts_ != scene_->n_layouts()) scene_->load(renderer);
  n_loaded_layouts_ = scene_->n_layouts();
  if (!is_font_loaded_) renderer.load(text_->font());
  is_font_loaded_ = true;
}

}  // namespace vrda
