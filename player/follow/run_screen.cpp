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

void RunScreen::make_text()
{
  text_.emplace(std::clamp(text_part * options_.height, smallest_text_px, largest_text_px));
  is_font_loaded_ = false;
}

void RunScreen::resize(int width, int height)
{
  const bool is_taller = height != options_.height;
  options_.width = width;
  options_.height = height;
  if (is_taller) make_text();
  const int panel_px = std::clamp(static_cast<int>(panel_part * width),
                                  std::min(narrowest_panel_px, width / 2), widest_panel_px);
  panel_area_ = {width - panel_px, 0, panel_px, height};
  fit_cameras();
}

void RunScreen::fit_cameras()
{
  const Viewport area{0, 0, options_.width - panel_area_.width, options_.height};
  shots_ = fitted_shots(options_.views, tiles(options_.views.size(), area), scene_->framed_points(),
                        options_.zoom);
  set_depths();
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

void RunScreen::show(const RunState& state, const std::vector<std::string>& lines, const JointPose& pose)
{
  scene_->show(pose);
  if (!has_step_) fit_cameras();
  has_step_ = true;
  set_depths();
  draw_overlay(state, lines);
}

void RunScreen::draw_overlay(const RunState& state, const std::vector<std::string>& lines)
{
  overlay_ = empty_overlay(options_.width, options_.height);
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
