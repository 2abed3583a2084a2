/// The parts of the joint's layers that others use; JointLayers (scene.hpp) draws all of them.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "store/motion_model.hpp"
#include "view/scene.hpp"

namespace vrda::view {

/// Length of the arrow of a contact without force, for a knee.
inline constexpr double plain_arrow_mm = 9.0;

/// The balls or the arrows of contacts, in a drawable whose number of triangles is constant: unused ones are
/// degenerate.
class ContactMarkers {
 public:
  /// `layer`: contacts (balls) or normals (arrows). `origin_mm`: of the positions.
  ContactMarkers(Scene& scene, Layer layer, BodyIndex parent, const std::string& name,
                 const Eigen::Vector3d& origin_mm = Eigen::Vector3d::Zero());
  /// Sets the largest number of contacts; the renderer must load the scene again.
  void reserve(Scene& scene, std::size_t n_contacts);
  std::size_t capacity() const { return capacity_; }
  void show(Scene& scene, bool is_shown) const;
  /// One contact or more. `arrow_mm`: from tail to tip; not read for balls.
  void place(Scene& scene, std::span<const Eigen::Vector3d> tip_mm, std::span<const Eigen::Vector3d> arrow_mm,
             double scale);

 private:
  bool is_arrows_;
  std::size_t drawable_, capacity_ = 0;
  std::vector<std::uint32_t> triangles_;  ///< of all markers
};

}  // namespace vrda::view
