#include "analysis/highest_seat.hpp"

#include <algorithm>
#include <cmath>

#include "solve/quadratic_program.hpp"

namespace vrda::analysis {
namespace {

// Features this far above the first contact limit a step. A ball in a cup has thousands within its clearance.
constexpr double band_mm = 0.02;
constexpr double height_tolerance_mm = 1e-5;
constexpr double first_radius_mm = 1.0, largest_radius_mm = 8.0;
constexpr double least_radius_mm = 1e-5;  // the seat is then at a ridge of the height
constexpr double accepted_share = 0.1;    // of the predicted rise
constexpr int max_steps = 200;
// Makes the linear programme strictly convex: a step is shorter where the rise is below 1e-4 of it.
constexpr double convexity_per_mm = 1e-4;

/// Height of the moving object in contact with one feature: height + slope . (x, z).
struct Plane {
  double height_mm = 0.0, slope_x = 0.0, slope_z = 0.0;

  double at(double x, double z) const { return height_mm + slope_x * x + slope_z * z; }
};

Plane plane_of(const geometry::GapFeature& feature, const MovingPose& pose)
{
  const double slope_x = -feature.normal.x() / feature.normal.y();
  const double slope_z = -feature.normal.z() / feature.normal.y();
  const Eigen::Vector3d& t = pose.translation_mm;
  return {t.y() + feature.travel_mm - slope_x * t.x() - slope_z * t.z(), slope_x, slope_z};
}

class SeatSearch {
 public:
  SeatSearch(geometry::GapQuery& query, const SeatTask& task) : query_(query), task_(task) {}

  Seat run()
  {
    MovingPose start = task_.centre;
    start.translation_mm += Eigen::Vector3d(task_.start_mm.x(), 0.0, task_.start_mm.y());
    if (!measure(start)) return {};
    seat_ = trial_;
    planes_ = trial_planes_;
    double radius_mm = first_radius_mm;
    for (int step = 0; step < max_steps && !seat_.is_converged; ++step) {
      const Eigen::Vector3d d = highest_point(radius_mm);
      if (d.z() <= height_tolerance_mm || radius_mm <= least_radius_mm) {
        seat_.is_converged = true;
        break;
      }
      MovingPose next = seat_.pose;
      next.translation_mm += Eigen::Vector3d(d.x(), d.z(), d.y());
      const double height_mm = seat_.pose.translation_mm.y();
      if (!measure(next)) {
        radius_mm *= 0.5;
      } else if (trial_.pose.translation_mm.y() - height_mm > accepted_share * d.z()) {
        seat_ = trial_;
        planes_ = trial_planes_;
        radius_mm = std::min(2.0 * radius_mm, largest_radius_mm);
      } else {
        planes_.insert(planes_.end(), trial_planes_.begin(), trial_planes_.end());
        radius_mm = 0.5 * std::min(radius_mm, std::max(std::abs(d.x()), std::abs(d.y())));
      }
    }
    seat_.is_found = true;
    return seat_;
  }

 private:
  // Moves the pose along Delta into contact. False: nothing ahead.
  bool measure(const MovingPose& pose)
  {
    const geometry::GapResult& found = query_.features(pose, band_mm);
    if (found.pair.reference < 0) return false;
    trial_ = {pose, found.features, true, false};
    trial_.pose.translation_mm.y() += found.travel_mm;
    for (geometry::GapFeature& feature : trial_.contacts) {
      feature.travel_mm -= found.travel_mm;
      feature.point_mm.y() += found.travel_mm;
    }
    trial_planes_.clear();
    for (const geometry::GapFeature& feature : trial_.contacts)
      trial_planes_.push_back(plane_of(feature, trial_.pose));
    return true;
  }

  // Displacement along X and Z, and the rise, to the highest point below all planes within the radius and the
  // limit.
  Eigen::Vector3d highest_point(double radius_mm)
  {
    const Eigen::Vector3d& t = seat_.pose.translation_mm;
    half_spaces_.clear();
    for (const Plane& plane : planes_) {
      solve::QpVector row = solve::QpVector::Zero();
      row.head<3>() = Eigen::Vector3d(plane.slope_x, plane.slope_z, -1.0);
      const double clearance_mm = plane.at(t.x(), t.z()) - t.y(), length = row.norm();
      half_spaces_.push_back({row / length, -clearance_mm / length});
    }
    const Eigen::Vector2d away(t.x() - task_.centre.translation_mm.x(),
                               t.z() - task_.centre.translation_mm.z());
    for (int k = 0; k < 2; ++k) {
      for (const double sign : {1.0, -1.0}) {
        solve::QpVector row = solve::QpVector::Zero();
        row[k] = sign;
        const double room_mm = std::max(0.0, task_.limit_mm + sign * away[k]);
        half_spaces_.push_back({row, -std::min(radius_mm, room_mm)});
      }
    }
    // The programme has room for five coordinates; the last two stay 0.
    solve::QpMatrix H = solve::QpMatrix::Identity();
    H.diagonal().head<3>().setConstant(convexity_per_mm);
    const solve::QpSolution solution =
        solve::solve_quadratic_program<5>(H, -solve::QpVector::Unit(2), half_spaces_);
    return solution.is_solved ? Eigen::Vector3d(solution.d.head<3>()) : Eigen::Vector3d::Zero();
  }

  geometry::GapQuery& query_;
  const SeatTask& task_;
  Seat seat_, trial_;
  std::vector<Plane> planes_, trial_planes_;
  std::vector<solve::HalfSpace> half_spaces_;
};

}  // namespace

Seat highest_seat(geometry::GapQuery& query, const SeatTask& task)
{
  return SeatSearch(query, task).run();
}

}  // namespace vrda::analysis
