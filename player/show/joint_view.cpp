#include "show/joint_view.hpp"

#include <algorithm>

#include "core/text.hpp"
#include "model/frames.hpp"

namespace vrda::show {

JointView::JointView(const store::MotionModel& model, const view::AppearanceOptions& look,
                     view::Backdrop backdrop)
    : side_(side_named(model.side)),
      rotation_centre_mm_(model.rotation_centre_mm),
      scene_(view::scene_of(model, model.rotation_centre_mm)),
      layers_(model, scene_),
      caps_(scene_),
      structures_(view::structures_of(model)),
      bundles_(model),
      labels_(model, scene_)
{
  check(!scene_.drawables.empty(), "a validated motion model has triangles");
  scene_.background = view::background_of(backdrop);
  looks_.of.resize(structures_.size());
  for (const view::Drawable& drawable : scene_.drawables)
    rows_.push_back({structure_row(drawable.structure), drawable.material.opacity});
  view::apply_appearance(scene_, look);
  shown_bodies_ = view::shown_drawables(scene_);
  for (std::size_t k = 0; k < rows_.size(); ++k) {
    const view::Drawable& drawable = scene_.drawables[k];
    if (rows_[k].structure && drawable.layer != view::Layer::caps)  // which follow their solids
      looks_.of[*rows_[k].structure] = {!drawable.is_hidden, drawable.material.opacity / rows_[k].opacity};
  }
}

std::optional<std::size_t> JointView::structure_row(const std::string& id) const
{
  const auto found = std::ranges::find(structures_, id, &view::Structure::id);
  if (found == structures_.end()) return std::nullopt;
  return static_cast<std::size_t>(found - structures_.begin());
}

void JointView::use(const ViewState& state)
{
  view::change(looks_, structures_, view::LookChange::show_all);
  for (const auto& [id, look] : state.structures) looks_.of[structure_row(id).value()] = look;
  looks_.highlighted = structure_row(state.highlighted);
}

void JointView::apply_looks()
{
  constexpr float bundle_glow = 0.3F;  // its colour has a meaning
  for (std::size_t k = 0; k < rows_.size(); ++k) {
    if (!rows_[k].structure) continue;
    view::Drawable& drawable = scene_.drawables[k];
    const view::StructureLook& look = looks_.of[*rows_[k].structure];
    shown_bodies_[k] = look.is_visible;
    drawable.is_hidden = drawable.layer != view::Layer::gap_map &&
                         drawable.layer != view::Layer::contact_paths && !look.is_visible;
    drawable.material.opacity = rows_[k].opacity * look.opacity;
    const bool is_own = looks_.highlighted == rows_[k].structure;
    drawable.highlight = !is_own ? 0.0F : drawable.layer == view::Layer::ligaments ? bundle_glow : 1.0F;
  }
}

void JointView::show(const store::Motion& motion, const store::JointPose& pose, const view::LayerSet& layers)
{
  apply_looks();
  const view::JointFrames frames = view::frames_of(motion, pose, fixed_object, rotation_centre_mm_);
  view::place(scene_, frames);
  view::show_bodies(scene_, shown_bodies_, fixed_object, pose.status == store::PoseStatus::solved, frames);
  layers_.update(scene_, motion, {pose, frames, layers});
  caps_.update(scene_);
}

view::Readout JointView::readout(const PlayedSet& set, const store::JointPose& pose,
                                 const view::PoseDoubt& doubt)
{
  view::Readout readout;
  readout.pose = pose;
  readout.clinical = set.motion.own_coordinates(pose);
  if (pose.status == store::PoseStatus::solved)
    readout.joint = clinical_coordinates(pose.X_reference_moving, side_, rotation_centre_mm_);
  readout.gap = set.gaps.at(pose);
  const bool is_moving_fixed = fixed_object == BodyIndex::moving;
  const std::string& drawn = is_moving_fixed ? scene_.moving_name : scene_.reference_name;
  doubt_ = view::doubt_text(pose, doubt, drawn.c_str());
  if (doubt_[0] != 0) readout.doubt = doubt_.data();
  return readout;
}

std::span<const view::ScreenLabel> JointView::labels(std::span<const view::Shot> shots)
{
  const std::vector<std::string>& texts = labels_.texts();
  while (screen_labels_.size() < shots.size() * texts.size()) {
    screen_labels_.emplace_back();
    screen_labels_.back().text = texts[(screen_labels_.size() - 1) % texts.size()];
  }
  const std::span<view::ScreenLabel> all(screen_labels_.data(), shots.size() * texts.size());
  for (std::size_t k = 0; k < shots.size(); ++k)
    labels_.place(all.subspan(k * texts.size(), texts.size()), scene_, shots[k]);
  return all;
}

std::vector<Eigen::Vector3d> JointView::framed_points(const store::JointPose& pose, view::Framing framing)
{
  view::place(scene_, view::frames_of(pose, fixed_object, rotation_centre_mm_));
  return view::framed_points(scene_, framing);
}

}  // namespace vrda::show
