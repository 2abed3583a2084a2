#include "scene/joint_layers.hpp"

#include "scene/axes_layer.hpp"
#include "scene/contact_layer.hpp"
#include "scene/gap_layer.hpp"
#include "scene/ligament_layer.hpp"

namespace vrda {

struct JointLayers::Parts {
  Parts(const MotionModel& model, Scene& scene)
      : contacts(model, scene),
        axes(model, scene),
        helical_axis(model, scene),
        gaps(model, scene),
        ligaments(model, scene)
  {
  }

  ContactLayer contacts;
  AxesLayer axes;
  HelicalAxisLayer helical_axis;
  GapLayer gaps;
  LigamentLayer ligaments;
};

JointLayers::JointLayers(const MotionModel& model, Scene& scene)
    : parts_(std::make_unique<Parts>(model, scene))
{
  available_.set(Layer::contacts, !parts_->contacts.is_empty());
  available_.set(Layer::normals, !parts_->contacts.is_empty());
  available_.set(Layer::axes, true);
  available_.set(Layer::helical_axis, model.flexion_deg.size() > 1);
  available_.set(Layer::gap_map, !parts_->gaps.is_empty());
  available_.set(Layer::ligaments, !parts_->ligaments.is_empty());
}

JointLayers::~JointLayers() = default;
JointLayers::JointLayers(JointLayers&&) noexcept = default;
JointLayers& JointLayers::operator=(JointLayers&&) noexcept = default;

void JointLayers::update(Scene& scene, const Motion& motion, const Shown& shown)
{
  for (Drawable& drawable : scene.drawables) {
    if (drawable.layer != Layer::bodies) drawable.is_shown = false;
  }
  if (shown.pose.status != PoseStatus::solved) return;
  const LayerSet& wanted = shown.layers;
  parts_->contacts.update(scene, shown.pose, wanted);
  if (wanted.has(Layer::axes)) parts_->axes.update(scene, motion, shown);
  if (wanted.has(Layer::helical_axis)) parts_->helical_axis.update(scene, motion, shown);
  if (wanted.has(Layer::gap_map)) parts_->gaps.update(scene, motion, shown.pose);
  if (wanted.has(Layer::ligaments)) parts_->ligaments.update(scene, shown.pose);
}

const Legend& JointLayers::gap_legend() const
{
  return parts_->gaps.legend();
}

const Legend& JointLayers::strain_legend() const
{
  return parts_->ligaments.legend();
}

void see_through(Scene& scene, Owner owner, float part)
{
  for (Drawable& drawable : scene.drawables) {
    if (drawable.owner == owner && drawable.layer == Layer::bodies) drawable.material.opacity *= part;
  }
}

void hide(Scene& scene, Owner owner)
{
  for (Drawable& drawable : scene.drawables) {
    if (drawable.owner == owner && drawable.layer == Layer::bodies) drawable.is_shown = false;
  }
}

}  // namespace vrda
