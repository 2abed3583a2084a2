/// A layer's drawable in a scene.
#pragma once

#include <string>
#include <vector>

#include "scene/scene.hpp"
#include "store/motion_model.hpp"

namespace vrda {

/// How large signs are drawn: 1 for a knee, whose plateaus are 80 mm wide.
double sign_scale(const MotionModel& model);

/// The cells whose values set a scale: the stable ones of the spine, where a joint is shown by default;
/// without any, every stable one.
std::vector<std::size_t> telling_cells(const MotionModel& model);

/// Appended hidden; its place in the scene is returned. It does not take part in contact.
std::size_t add_layer(Scene& scene, Layer layer, Owner owner, const std::string& name);

/// The material of signs: plain, opaque, a soft highlight.
Material sign_material(const VertexColour& colour);

/// The box of the vertices that the triangles use. Wanted after a mesh was changed.
void update_box(Drawable& drawable);

}  // namespace vrda
