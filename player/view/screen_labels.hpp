/// The labels of a joint on screen.
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "view/renderer.hpp"
#include "view/layers.hpp"

namespace vrda::view {

struct ScreenLabel {
  std::string text;
  Eigen::Vector2d centre_px = Eigen::Vector2d::Zero();  ///< from the top left corner of the window
  bool is_shown = false;                                ///< within the shot
};

/// One label for each of `labels`, hidden.
std::vector<ScreenLabel> screen_labels(const std::vector<store::JointLabel>& labels);

/// Places the labels, which have the order of `labels`. Allocates nothing.
void place(std::vector<ScreenLabel>& shown, const std::vector<store::JointLabel>& labels,
           const view::JointFrames& frames, const view::Shot& shot);

}  // namespace vrda::view
