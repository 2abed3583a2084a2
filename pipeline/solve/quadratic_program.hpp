/// Small strictly convex quadratic programmes: the steps and the certificate of the equilibrium
/// (solve/README.md).
#pragma once

#include <Eigen/Core>
#include <array>
#include <vector>

namespace vrda::solve {

template <int N>
using QpVectorOf = Eigen::Matrix<double, N, 1>;
template <int N>
using QpMatrixOf = Eigen::Matrix<double, N, N>;

/// normal . d >= offset. Rows of about unit length make `qp_tolerance` a distance.
template <int N>
struct HalfSpaceOf {
  QpVectorOf<N> normal = QpVectorOf<N>::Zero();
  double offset = 0.0;
};

/// Largest violation of a half-space that counts as satisfied.
inline constexpr double qp_tolerance = 1e-11;

template <int N>
struct QpSolutionOf {
  struct ActiveConstraint {
    std::size_t row = 0;      ///< of the half-spaces
    double multiplier = 0.0;  ///< above 0: H d + g = sum of multiplier * normal
  };
  QpVectorOf<N> d = QpVectorOf<N>::Zero();
  std::array<ActiveConstraint, N> active{};  ///< the active set: the first n_active entries, unordered
  std::size_t n_active = 0;
  bool is_solved = false;  ///< false: infeasible, to rounding
};

/// The d that minimises d.H d / 2 + g.d subject to every half-space. H must be positive definite.
/// To hold a coordinate at 0, set its row and column of H to zero with 1 on the diagonal, and its entries of
/// g and the normals to zero. Allocates nothing; ties select the first row. Source: Goldfarb and Idnani
/// (1983), Math. Programming 27:1-33, the dual algorithm; it starts from the unconstrained minimum, so
/// redundant and degenerate half-spaces are allowed.
template <int N>
QpSolutionOf<N> solve_quadratic_program(const QpMatrixOf<N>& H, const QpVectorOf<N>& g,
                                        const std::vector<HalfSpaceOf<N>>& half_spaces);
extern template QpSolutionOf<5> solve_quadratic_program(const QpMatrixOf<5>&, const QpVectorOf<5>&,
                                                        const std::vector<HalfSpaceOf<5>>&);
extern template QpSolutionOf<6> solve_quadratic_program(const QpMatrixOf<6>&, const QpVectorOf<6>&,
                                                        const std::vector<HalfSpaceOf<6>>&);

using QpVector = QpVectorOf<5>;
using QpMatrix = QpMatrixOf<5>;
using HalfSpace = HalfSpaceOf<5>;
using QpSolution = QpSolutionOf<5>;

/// Minimises, by NLopt (SLSQP), x' H x / 2 + g' x over low <= x <= high from x = 0, which must be in the box.
/// `H` is symmetric and positive definite. All arguments have the same length, at least 1; use scaled
/// unknowns.
Eigen::VectorXd minimum_in_box(const Eigen::MatrixXd& H, const Eigen::VectorXd& g, const Eigen::VectorXd& low,
                               const Eigen::VectorXd& high);

}  // namespace vrda::solve
