/// The names of a joint on screen, each at a visible point of what it names.
#pragma once

#include <Eigen/Core>

#include <cstddef>
#include <cstdint>
#include <deque>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "geometry/placement.hpp"
#include "store/motion_model.hpp"
#include "view/renderer.hpp"
#include "view/scene.hpp"

namespace vrda::view {

struct ScreenLabel {
  std::string text;
  Eigen::Vector2d anchor_px = Eigen::Vector2d::Zero();  ///< from the top left corner of the window
  Eigen::Vector3d anchor_world_mm = Eigen::Vector3d::Zero();
  Viewport picture;       ///< of its shot
  bool is_shown = false;  ///< a point of it is visible
};

/// Finds visible points: in the picture, in front of all opaque bodies, not cut away.
class LabelAnchors {
 public:
  /// `scene` has the layers of `model`; its order must not change afterwards.
  LabelAnchors(const store::MotionModel& model, const Scene& scene);

  const std::vector<std::string>& texts() const { return texts_; }
  /// Places the labels at the present placement of the scene; `shown` has the order of texts(). Allocates
  /// nothing except at the first call.
  void place(std::span<ScreenLabel> shown, const Scene& scene, const Shot& shot);

 private:
  struct Surface {
    Mesh mesh;
    geometry::BoxTree tree;
    std::size_t drawable = 0;
    bool is_closed = false;
  };
  using Points = std::vector<std::pair<std::size_t, std::uint32_t>>;  ///< drawable, vertex

  /// A point of a drawable that a label may name.
  bool is_visible(const Scene& scene, std::size_t label, const Drawable& own, const Eigen::Vector3d& p_mm,
                  const Eigen::Vector3d& eye_mm) const;
  void find_surfaces(const Scene& scene);

  std::vector<std::string> texts_;
  std::vector<Points> points_;    ///< [n_labels] where a label may be
  std::deque<Surface> surfaces_;  ///< of the bodies; made at the first use
};

}  // namespace vrda::view
