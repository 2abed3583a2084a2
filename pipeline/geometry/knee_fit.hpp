/// Registers a subject's knee with a template: unit, side, and the frame of each bone.
#pragma once

#include <functional>
#include <optional>

#include "model/clinical.hpp"
#include "geometry/bone_fit.hpp"

namespace vrda::geometry {

struct KneeFitOptions {
  std::optional<Side> side;       ///< known side; absent: found
  std::optional<double> unit_mm;  ///< known unit; absent: found
  /// Points known of each bone; the subject's in its own unit.
  std::vector<KnownPoint> femur_points = {}, tibia_points = {};
  std::function<bool()> is_stopped = {};  ///< polled; true: returns a fit that means nothing
};

/// Between the bones of one knee with 5 mm of cartilage, with room for flexed scans.
constexpr double largest_gap_mm = 20.0;

/// The template, mirrored for a left knee, placed on the subject.
struct KneeFit {
  double unit_mm = 1.0;  ///< of the subject's meshes
  Side side = Side::right;
  double side_margin = 1.0;  ///< coarse residual of the other side over that of `side`
  double coarse_residual_mm = 0.0;
  double nearest_mm = 0.0;  ///< smallest distance between samples of the bones
  BoneFit femur, tibia;
  /// Canonical axes of each bone (X anterior, Y proximal, Z the subject's right) with its origin at the
  /// image of the template's rotation centre, in the subject's axes, mm.
  Pose X_scan_femur = Pose::Identity();
  Pose X_scan_tibia = Pose::Identity();
  ClinicalCoordinates scanned;  ///< tibia in the femur's frame, as in the scan
};

/// `subject` is in any unit and orientation.
KneeFit fit_knee(const KneeSurfaces& subject, const TemplateKnee& reference,
                 const KneeFitOptions& options = {});

}  // namespace vrda::geometry
