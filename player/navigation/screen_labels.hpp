/// The labels of a joint on screen.
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "render/renderer.hpp"
#include "scene/layers.hpp"

namespace vrda::navigation {

struct ScreenLabel {
  std::string text;
  Eigen::Vector2d centre_px = Eigen::Vector2d::Zero();  ///< from the top left corner of the window
  bool is_shown = false;                                ///< within the shot
};

/// One label for each of `labels`, hidden.
std::vector<ScreenLabel> screen_labels(const std::vector<motion::JointLabel>& labels);

/// Places the labels, which have the order of `labels`. Allocates nothing.
void place(std::vector<ScreenLabel>& shown, const std::vector<motion::JointLabel>& labels,
           const scene::JointFrames& frames, const render::Shot& shot);

}  // namespace vrda::navigation
