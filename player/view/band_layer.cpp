// Layer of the band of an uncertain job, as translucent copies of the moving object.
#include "view/layers.hpp"

#include <algorithm>

#include "view/scene.hpp"

namespace vrda::view {
namespace {

constexpr float copy_opacity = 0.5F;  // two overlapping outlines remain distinct
// The object covers the copies, which show beyond its outline: their intersections would show as patches.
constexpr double copy_depth_offset_mm = 10.0;

struct BandEnd {
  const char* set;
  VertexColour colour;
};
constexpr BandEnd band_ends[] = {{"quantile_5", {70, 130, 220, 255}}, {"quantile_95", {235, 135, 50, 255}}};

}  // namespace

BandLayer::BandLayer(const store::MotionModel& model, Scene& scene)
{
  const std::vector<std::string> names = store::quantile_set_names(model);
  for (const BandEnd& end : band_ends) {
    if (std::find(names.begin(), names.end(), end.set) == names.end()) continue;
    QuantileCopy copies{store::Motion(model, end.set), {}};
    const std::size_t n_bodies = scene.drawables.size();
    for (std::size_t k = 0; k < n_bodies; ++k) {
      const Drawable& body = scene.drawables[k];
      if (body.layer != Layer::bodies || body.parent != ParentFrame::moving || !body.has_contact) continue;
      Drawable copy = body;
      copy.name += ", " + std::string(end.set);
      copy.layer = Layer::band;
      copy.parent = ParentFrame::world;
      copy.is_shown = false;
      copy.material = marker_material(end.colour);
      copy.material.opacity = copy_opacity;
      copy.depth_offset_mm = copy_depth_offset_mm;
      copies.drawables.push_back(scene.drawables.size());
      scene.drawables.push_back(std::move(copy));
    }
    copies_.push_back(std::move(copies));
  }
}

void BandLayer::update(Scene& scene, const DisplayedPose& shown) const
{
  for (const QuantileCopy& copies : copies_) {
    const store::JointPose pose = copies.motion.at(shown.pose.attitude);
    if (pose.status != store::PoseStatus::solved) continue;
    const Pose X_world_moving = shown.frames.X_world_reference * pose.X_reference_moving;
    for (const std::size_t k : copies.drawables) {
      scene.drawables[k].is_shown = true;
      place(scene.drawables[k], X_world_moving);
    }
  }
}

}  // namespace vrda::view
