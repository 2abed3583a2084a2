/// Where the moving object would go if a handful of obstacles were all there is: the step that an iteration
/// of the equilibrium tries. Asks no gap query.
#pragma once

#include <array>
#include <vector>

#include "solve/obstacle.hpp"
#include "solve/potential.hpp"
#include "solve/quadratic_program.hpp"

namespace vrda {

struct PlanOptions {
  std::array<bool, 5> is_free{true, true, true, true, true};
  double radius_mm = 1.0;      ///< no coordinate but the height goes further from `from`, angles times lever
  double standoff_mm = 1e-5;   ///< travel left to every obstacle
  double tolerance_mm = 1e-4;  ///< steps a tenth of this end the plan
  double reach_mm = 1e3;       ///< how far ligaments may pull it away from contact
  double force_tolerance_n = 0;  ///< along Delta, of a pose that rests without contact
};

struct StepPlan {
  Rest end;
  double length_mm = 0.0;  ///< largest coordinate of the step but its height, angles times the lever
  double gain_nmm = 0.0;   ///< how much potential and spring fall; never negative
  std::array<std::size_t, 5> bearing{};  ///< rows of the obstacles that bear load in the end
  std::size_t n_bearing = 0;
};

/// Sequential quadratic programming with exact obstacles: each linearised anew at each iterate, second
/// derivatives of the potential and, along what the bearing obstacles leave free, of those obstacles made
/// positive, heights restored exactly; the potential of ligaments to second order. Keeps scratch, which
/// changes nothing.
class StepPlanner {
 public:
  StepPlanner(const Forces& forces, const SeedSpring& spring) : forces_(forces), spring_(spring) {}

  /// `from` must leave every obstacle its standoff, to rounding.
  StepPlan plan(const Rest& from, const std::vector<Obstacle>& obstacles, const PlanOptions& options);

  /// Potential and spring.
  double merit_nmm(const Rest& rest) const;

 private:
  Rest rest_after(const Rest& at, const QpVector& d, const std::vector<Obstacle>& obstacles,
                  const PlanOptions& options);
  Rest corrected(const Rest& at, const Vector5d& gone, QpVector d, const std::vector<Obstacle>& obstacles,
                 const PlanOptions& options);
  void take_support(const QpSolution& qp, StepPlan& plan, std::size_t n_obstacles);
  void look(const std::vector<Obstacle>& obstacles, const Place& place);
  QpMatrix curvature(const Rest& at, const std::vector<Obstacle>& obstacles,
                     const PlanOptions& options) const;
  QpMatrix scaled(const Matrix5d& hessian, const PlanOptions& options) const;
  QpSolution solve_linearised(const Rest& at, const Vector5d& gone, const std::vector<Obstacle>& obstacles,
                              const PlanOptions& options, double radius_mm);

  Forces forces_;
  SeedSpring spring_;
  std::vector<Clearance> clearances_;   // of the iterate
  std::vector<Clearance> next_;         // of a trial
  std::vector<Clearance> linear_;       // what the programme keeps
  double sunk_mm_ = 0.0;                // of a trial: from its linear height to its rest
  std::vector<HalfSpace> half_spaces_;  // obstacles first
  std::vector<double> row_length_;      // of the obstacles' half-spaces before scaling
  std::vector<double> multipliers_;     // of the obstacles, N along Delta
};

}  // namespace vrda
