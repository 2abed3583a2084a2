// The motion of a model along its flexion, for functional registration.
#include "calibration/calibration_bench.hpp"

#include <algorithm>
#include <cmath>

#include "core/error.hpp"
#include "core/units.hpp"
#include "store/poses.hpp"
#include "view/arguments.hpp"
#include "show/settings_text.hpp"
#include "store/motion_model_file.hpp"
#include "store/solved_cells.hpp"
#include "bench/screw.hpp"

namespace vrda::calibration {
namespace {

calibration::JointCurve::Knot knot_at(const store::Motion& motion, double flexion_rad,
                                      const std::string& file)
{
  const store::JointPose pose = motion.at({flexion_rad, motion.balanced_varus_rad(flexion_rad)});
  if (pose.status != store::PoseStatus::solved) {
    throw InputError(
        {file, "flexion",
         "no solved pose at " + show::rounded_text(deg_from_rad(flexion_rad), 1) + " degrees",
         "a motion solved at all flexions; choose another --set, as degree_6"});
  }
  calibration::JointCurve::Knot knot;
  knot << pose.X_reference_moving.translation(), bench::turn_of(pose.X_reference_moving.linear());
  return knot;
}

}  // namespace

calibration::JointCurve joint_curve(const std::string& file, const std::string& set)
{
  const store::MotionModel model = store::read_motion_model(file);
  store::require_grid(model, file, "a functional registration");
  const store::Motion motion(model, store::chosen_set(model, file, set));
  const double range_rad = motion.last_flexion_rad() - motion.first_flexion_rad();
  if (!(range_rad > 0.0))
    throw InputError(
        {file, "flexion", "one flexion", "a range of flexions, to compare with the leg's motion"});
  constexpr double step_rad = rad_from_deg(2.0);
  const int n_steps = std::max(1, static_cast<int>(std::lround(range_rad / step_rad)));
  calibration::JointCurve curve;
  curve.centre_mm = store::solver_frame(model, 0).rotation_centre_mm;
  curve.first_rad = motion.first_flexion_rad();
  curve.step_rad = range_rad / n_steps;
  for (int k = 0; k <= n_steps; ++k)
    curve.knots.push_back(knot_at(motion, curve.first_rad + k * curve.step_rad, file));
  return curve;
}

}  // namespace vrda::calibration
