/// A flexion motion as an animated scene that any glTF 2.0 viewer plays.
#pragma once

#include <string>

#include "exports/flexion_motion.hpp"

namespace vrda {

/// The whole binary file (.glb): both bodies, a node and a mesh a component, a material a name, and one
/// animation "flexion" with a key a frame that turns the reference and turns and moves the moving body.
/// Metres, Y up is proximal, +Z is anterior (the axes of glTF), the rotation centre at the scene's origin.
std::string animated_glb(const MotionModel& model, const FlexionMotion& motion, double degrees_per_second);

}  // namespace vrda
