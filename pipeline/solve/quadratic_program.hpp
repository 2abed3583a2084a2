/// Small strictly convex quadratic programmes: the steps and the certificate of the equilibrium
/// (DESIGN.md 5.3).
#pragma once

#include <Eigen/Core>
#include <array>
#include <vector>

namespace vrda::solve {

using QpVector = Eigen::Matrix<double, 5, 1>;
using QpMatrix = Eigen::Matrix<double, 5, 5>;

/// normal . d >= offset. Rows of about unit length make `qp_tolerance` a distance.
struct HalfSpace {
  QpVector normal = QpVector::Zero();
  double offset = 0.0;
};

/// Largest violation of a half-space that counts as satisfied.
inline constexpr double qp_tolerance = 1e-11;

struct QpSolution {
  struct ActiveConstraint {
    std::size_t row = 0;      ///< of the half-spaces
    double multiplier = 0.0;  ///< above 0: H d + g = sum of multiplier * normal
  };
  QpVector d = QpVector::Zero();
  std::array<ActiveConstraint, 5> active{};  ///< the active set: the first n_active entries, unordered
  std::size_t n_active = 0;
  bool is_solved = false;  ///< false: infeasible, to rounding
};

/// The d that minimises d.H d / 2 + g.d subject to every half-space. H must be positive definite.
/// To hold a coordinate at 0, set its row and column of H to zero with 1 on the diagonal, and its entries of
/// g and the normals to zero. Allocates nothing; ties select the first row. Source: Goldfarb and Idnani
/// (1983), Math. Programming 27:1-33, the dual algorithm; it starts from the unconstrained minimum, so
/// redundant and degenerate half-spaces are allowed.
QpSolution solve_quadratic_program(const QpMatrix& H, const QpVector& g,
                                   const std::vector<HalfSpace>& half_spaces);

}  // namespace vrda::solve
