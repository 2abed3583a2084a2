/// Generated joints and motions of the tests of repair.
#pragma once

#include <random>

#include "analysis/repair.hpp"

namespace vrda::test {

/// Sum of 12 uniform numbers: mean 0, standard deviation 1, the same on every platform.
double normal_number(std::mt19937_64& generator);

/// n poses at keys 0, 1, ..., all translated by `p_mm`.
analysis::MeasuredMotion resting_motion(std::size_t n, const Eigen::Vector3d& p_mm);

analysis::MeasurementNoise isotropic_noise(double mm, double deg);

/// Two balls side by side along Z under two shallow dishes, like condyles: a moving object whose contact
/// limits height and varus. Rotation centre at the origin, Delta +Y.
analysis::AuditScene condyle_scene();

/// Smooth poses of condyle_scene() in contact: flexion, rotation and translation vary as sines whose phase
/// and size follow `generator`; the height by travel into contact.
std::vector<Pose> contact_motion(const analysis::AuditScene& scene, std::size_t n,
                                 std::mt19937_64& generator);

/// `X_true` displaced by independent errors of that noise (Delta +Y, right side).
std::vector<Pose> with_noise(const std::vector<Pose>& X_true, const analysis::MeasurementNoise& noise,
                             std::mt19937_64& generator);

/// Root mean square over the frames of the Mahalanobis distance of X from X_true.
double distance_from(const std::vector<Pose>& X_true, const std::vector<Pose>& X,
                     const analysis::MeasurementNoise& noise);

std::vector<Pose> poses_of(const analysis::RepairedMotion& motion);

}  // namespace vrda::test
