/// A plate under a plate, held by horizontal fibres.
#pragma once

#include <string>

#include "job/case.hpp"
#include "support/meshes.hpp"

namespace vrda::test {

inline constexpr double slack_mm = 50.0;  ///< length of the fibres at the pose of the meshes

/// One flexion of 0, varus free, without fibres.
inline job::Case two_plates()
{
  job::Case plates;
  plates.title = "two plates";
  plates.method = "equilibrium";
  plates.reference.contact = {plate(200.0, false), {0, 0}};
  plates.moving.contact = {plate(20.0, true), {0, 0}};
  plates.initial.translation_mm = {0.0, -5.0, 0.0};
  plates.grid = {{0.0}, {0.0}};
  plates.path_flexion_deg = {0.0};
  plates.is_varus_free = true;
  plates.push.resize(1);
  plates.path_push.resize(1);
  plates.spine.n_restarts = 0;
  return plates;
}

/// Adds a fibre along X at `z_mm`, slack at the pose of the meshes, in front of the moving plate or behind
/// it.
inline void add_fibre(job::Case& plates, const std::string& bundle, bool is_front, double z_mm,
                      double stiffness_n)
{
  const std::string name = bundle + std::to_string(plates.ligaments.fibres.size());
  plates.ligaments.fibres.push_back(
      {name, bundle, {is_front ? slack_mm : -slack_mm, 0.0, z_mm}, {0.0, 0.0, z_mm}, stiffness_n, slack_mm});
}

}  // namespace vrda::test
