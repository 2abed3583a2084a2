/// Generated motion models with data for every layer, and measurements of the drawn layers.
#pragma once

#include <initializer_list>
#include <string>

#include "view/scene.hpp"

namespace vrda::test {

inline constexpr double force_ratio = 3.0;  ///< ratio of the two contact forces of each cell

/// A ball of 20 mm on a finely divided sheet, with two contacts and forces per cell, a straight fibre that is
/// slack at 0 degrees and taut from 37 degrees, and one wrapped around a cylinder. The left model mirrors the
/// right one.
store::MotionModel layered_model(const std::string& side);

struct Degrees {
  double flexion = 0.0, varus = 0.0;
};
Degrees attitude_deg(const store::MotionModel& model, std::size_t cell);

/// A scene with its layers at raw poses of a model.
struct Stage {
  explicit Stage(store::MotionModel made);
  void show(const Degrees& attitude, const view::LayerSet& wanted);
  void show(const Degrees& attitude, std::initializer_list<view::Layer> wanted);
  void show(const store::JointPose& pose, const view::LayerSet& wanted);

  store::MotionModel model;
  view::Scene scene;
  view::JointLayers layers;
  store::Motion motion;
  BodyIndex held = BodyIndex::world;
};

view::LayerSet set_of(std::initializer_list<view::Layer> layers);
view::LayerSet every_layer();

/// The first drawable with that name.
const view::Drawable& drawable_of(const view::Scene& scene, const std::string& name);

/// Mean of vertices, world.
Eigen::Vector3d middle_world_mm(const view::Drawable& drawable, std::size_t first, std::size_t n);
/// Mean of the corners of all non-degenerate triangles, world.
Eigen::Vector3d middle_of_drawn_mm(const view::Drawable& drawable);

/// Vertex `v` of a gap sheet projected back onto the part below; canonical axes of the moving body.
Eigen::Vector3d unlifted_mm(const Stage& stage, const view::Drawable& sheet, std::size_t v);

/// Travel along world Y from a point of the moving body to the first downward face of `reference`, from 3 mm
/// of overlap on; infinite if none exists.
double gap_by_every_face_mm(const Mesh& reference, const store::JointPose& pose,
                            const Eigen::Vector3d& p_moving_mm);

/// The largest difference of any channel.
int difference(const view::VertexColour& a, const view::VertexColour& b);

}  // namespace vrda::test
