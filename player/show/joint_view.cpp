#include "show/joint_view.hpp"

#include "core/text.hpp"
#include "model/frames.hpp"

namespace vrda::show {

JointView::JointView(const store::MotionModel& model, const view::AppearanceOptions& look,
                     view::Backdrop backdrop)
    : side_(side_named(model.side)),
      rotation_centre_mm_(model.rotation_centre_mm),
      scene_(view::scene_of(model, model.rotation_centre_mm)),
      layers_(model, scene_),
      labels_(store::joint_labels(model))
{
  check(!scene_.drawables.empty(), "a validated motion model has triangles");
  scene_.background = view::background_of(backdrop);
  view::apply_appearance(scene_, look);
  shown_bodies_ = view::shown_drawables(scene_);
}

void JointView::show(const store::Motion& motion, const store::JointPose& pose, const view::LayerSet& layers)
{
  frames_ = view::frames_of(motion, pose, fixed_object, rotation_centre_mm_);
  view::place(scene_, frames_);
  view::show_bodies(scene_, shown_bodies_, fixed_object, pose.status == store::PoseStatus::solved, frames_);
  layers_.update(scene_, motion, {pose, frames_, layers});
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
  while (screen_labels_.size() < shots.size() * labels_.size())
    screen_labels_.push_back({labels_[screen_labels_.size() % labels_.size()].text});
  const std::span<view::ScreenLabel> all(screen_labels_.data(), shots.size() * labels_.size());
  for (std::size_t k = 0; k < shots.size(); ++k)
    view::place(all.subspan(k * labels_.size(), labels_.size()), labels_, frames_, shots[k]);
  return all;
}

std::vector<Eigen::Vector3d> JointView::framed_points(const store::JointPose& pose, view::Framing framing)
{
  view::place(scene_, view::frames_of(pose, fixed_object, rotation_centre_mm_));
  return view::framed_points(scene_, framing);
}

}  // namespace vrda::show
