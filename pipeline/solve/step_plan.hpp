/// The trial step of one iteration of the equilibrium: minimises the potential subject to the known contact
/// constraints only. Makes no gap query.
#pragma once

#include <array>
#include <optional>
#include <vector>

#include "solve/contact_constraint.hpp"
#include "solve/potential.hpp"
#include "solve/quadratic_program.hpp"

namespace vrda::solve {

struct PlanOptions {
  std::array<bool, 5> is_free{true, true, true, true, true};
  double radius_mm = 1.0;        ///< trust region of all coordinates but the height, angles times the lever
  double standoff_mm = 1e-5;     ///< travel left to every constraint
  double tolerance_mm = 1e-4;    ///< the plan ends at steps below a tenth of this
  double reach_mm = 1e3;         ///< largest distance from contact under the ligaments' pull
  double force_tolerance_n = 0;  ///< along Delta, in equilibrium without contact
};

/// Of a step in mm.
double largest_but_height(const Vector5d& step);

struct StepPlan {
  EquilibriumCandidate end;
  double length_mm = 0.0;  ///< largest coordinate of the step but the height, angles times the lever
  double gain_nmm = 0.0;   ///< decrease of potential and proximal term; never negative
  std::array<std::size_t, 5> active{};  ///< rows of the active constraints at the end
  std::size_t n_active = 0;
};

/// Sequential quadratic programming. Each iterate linearises the constraints, and its Hessian is that of the
/// potential plus, in the null space of the active constraints, theirs, both made positive definite. Heights
/// are restored exactly; ligament energy is expanded to second order. Scratch memory does not affect results.
class StepPlanner {
 public:
  StepPlanner(const NonContactForces& forces, const ProximalTerm& spring) : forces_(forces), spring_(spring)
  {
  }

  /// `from` must satisfy every constraint with its standoff, to rounding.
  StepPlan plan(const EquilibriumCandidate& from, const std::vector<ContactConstraint>& constraints,
                const PlanOptions& options);

  /// Potential plus proximal term.
  double merit_nmm(const EquilibriumCandidate& candidate) const;

 private:
  EquilibriumCandidate candidate_after(const EquilibriumCandidate& at, const QpVector& d,
                                       const std::vector<ContactConstraint>& constraints,
                                       const PlanOptions& options);
  EquilibriumCandidate corrected(const EquilibriumCandidate& at, const Vector5d& travelled, QpVector d,
                                 const std::vector<ContactConstraint>& constraints,
                                 const PlanOptions& options);
  void update_active_set(const QpSolution& qp, StepPlan& plan, std::size_t n_constraints);
  void sample_constraints(const std::vector<ContactConstraint>& constraints,
                          const Configuration& configuration);
  QpMatrix curvature(const EquilibriumCandidate& at, const std::vector<ContactConstraint>& constraints,
                     const PlanOptions& options);
  QpMatrix scaled(const Matrix5d& hessian, const PlanOptions& options) const;
  QpSolution solve_linearised(const EquilibriumCandidate& at, const Vector5d& travelled,
                              const std::vector<ContactConstraint>& constraints, const PlanOptions& options,
                              double radius_mm);

  // Within a plan the potential's Hessian is mostly the same.
  struct BaseHessian {
    Matrix5d of;
    QpMatrix positive;
  };

  NonContactForces forces_;
  ProximalTerm spring_;
  std::optional<BaseHessian> base_;
  std::vector<Clearance> clearances_;   // of the iterate
  std::vector<Clearance> trial_;        // of a trial
  std::vector<Clearance> linear_;       // linearised constraints of the programme
  double drop_mm_ = 0.0;                // of a trial: from its linear height to its equilibrium along Delta
  std::vector<HalfSpace> half_spaces_;  // constraints first
  std::vector<double> row_length_;      // of the constraints' half-spaces before normalisation
  std::vector<double> multipliers_;     // of the constraints, N along Delta
};

}  // namespace vrda::solve
