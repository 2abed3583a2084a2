/// Compliant contact of the equilibrium: an elastic foundation whose pressure is proportional to the overlap,
/// with energy and derivatives in closed form, and the steps solved with it (solve/README.md).
#pragma once

#include <array>
#include <memory>
#include <mutex>
#include <utility>
#include <vector>

#include "geometry/distance_field.hpp"
#include "geometry/gap_query.hpp"
#include "geometry/nearest_surface.hpp"
#include "solve/equilibrium.hpp"

namespace vrda::solve {

/// Both surfaces of one joint, prepared: the smoothed distance to the reference, and points of the moving
/// object that face along Delta, half a millimetre apart, on its smoothed surface. In S at zero attitude.
/// A closed thin layer of the reference without what is behind it counts as a sheet, so that an overlap
/// deeper than half its thickness still grows: the side away from the moving object is left out.
struct CompliantSurfaces {
  /// `component` of each triangle of the reference, or empty. Cost: a second for a knee.
  CompliantSurfaces(const Joint& joint, const std::vector<std::int32_t>& component);

  struct Point {
    Eigen::Vector3d p_mm = Eigen::Vector3d::Zero();  ///< moving frame
    double area_mm2 = 0.0;
    double offset_mm = 0.0;      ///< of the triangle
    std::int32_t triangle = -1;  ///< of the moving mesh, under the point
  };
  /// Points near each other, so that all can be skipped at once.
  struct Tile {
    std::size_t begin = 0, end = 0;
    Eigen::Vector3d centre_mm = Eigen::Vector3d::Zero();
    double radius_mm = 0.0;
    double largest_offset_mm = 0.0;
  };
  std::vector<Tile> tiles;
  std::vector<Point> points;  ///< tile by tile
  geometry::NearestSurface reference_surface;
  geometry::DistanceField reference;
};

/// Surfaces that are prepared when they are first needed, of the joint that first needs them. Shared by all
/// threads.
class LazyCompliantSurfaces {
 public:
  explicit LazyCompliantSurfaces(std::vector<std::int32_t> component) : component_(std::move(component)) {}
  const CompliantSurfaces& of(const Joint& joint) const;

 private:
  std::vector<std::int32_t> component_;
  mutable std::once_flag flag_;
  mutable std::unique_ptr<const CompliantSurfaces> surfaces_;
};

/// Sum of the pressure of one compartment on the moving object.
struct PressureSum {
  Eigen::Vector3d force_n = Eigen::Vector3d::Zero();             ///< S
  Eigen::Vector3d moment_nmm = Eigen::Vector3d::Zero();          ///< about the origin of S
  Eigen::Vector3d weighted_point_nmm = Eigen::Vector3d::Zero();  ///< points times pressure and area
  double pressed_n = 0.0;                                        ///< pressure times area
  double area_mm2 = 0.0;                                         ///< in contact
};

/// A configuration at one flexion.
struct FoundationState {
  const CompliantSurfaces& surfaces;
  const Configuration& configuration;
  const RotationScale& scale;
  double flexion_rad = 0.0;
  double thicker_mm = 0.0;  ///< added to every overlap
};

struct Foundation {
  Potential potential;      ///< over the configuration, as potential_at()
  double deepest_mm = 0.0;  ///< largest overlap
};

/// Half the stiffness (N/mm3) times the squared overlap, over the area. The overlap of a point is its depth
/// in the distance field plus its offset. Cost: 0.3 microseconds a point in contact.
Foundation foundation_at(const FoundationState& state, double stiffness_n_per_mm3);

/// The pressure there, by Compartment; all in the first without compartments.
std::array<PressureSum, 3> pressures_at(const FoundationState& state, double stiffness_n_per_mm3,
                                        const Joint& joint);

/// Solver of one thread. References as in EquilibriumSolver.
class CompliantSolver {
 public:
  CompliantSolver(const Joint& joint, const model::Ligaments& ligaments, const EquilibriumOptions& options);
  ~CompliantSolver();

  /// As EquilibriumSolver::solve(), with these differences. The seed is moved into contact along Delta, and
  /// the sum of foundation, fibres, loads and push is minimised. Then the pose is moved out of the overlap
  /// until both compartments touch exactly: y and, where it is free and both bear load, varus change; x, z
  /// and theta do not. Balance, energy and forces are those of the pose with overlap, with one force for each
  /// compartment; contacts and gaps are those of the pose returned.
  /// `unbounded`: the objects part, or overlap by more than the thickness.
  StepRecord solve(const EquilibriumSolver::Task& task, const SearchObserver& observer);

 private:
  class Run;
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace vrda::solve
