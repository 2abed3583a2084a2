/// Small strictly convex quadratic programmes: the steps and the certificate of the equilibrium
/// (DESIGN.md 5.3).
#pragma once

#include <Eigen/Core>
#include <array>
#include <vector>

namespace vrda {

using QpVector = Eigen::Matrix<double, 5, 1>;
using QpMatrix = Eigen::Matrix<double, 5, 5>;

/// normal . d >= offset. Rows of about unit length make `qp_tolerance` a distance.
struct HalfSpace {
  QpVector normal = QpVector::Zero();
  double offset = 0.0;
};

/// Half-spaces count as kept down to this.
inline constexpr double qp_tolerance = 1e-11;

struct QpSolution {
  struct Support {
    std::size_t row = 0;      ///< of the half-spaces
    double multiplier = 0.0;  ///< above 0: H d + g = sum of multiplier * normal
  };
  QpVector d = QpVector::Zero();
  std::array<Support, 5> support{};  ///< what holds d; the first n_support, in no particular order
  std::size_t n_support = 0;
  bool is_solved = false;  ///< false: the half-spaces leave nothing over, to rounding
};

/// The d that minimises d.H d / 2 + g.d subject to every half-space. H must be positive definite.
/// A coordinate is held at 0 by a zero row and column of H with 1 on the diagonal, and zeros in g and the
/// normals. Allocates nothing; ties go to the first row.
/// Source: Goldfarb and Idnani (1983), Math. Programming 27:1-33, the dual algorithm; starts from the minimum
/// without half-spaces, so redundant and degenerate ones do no harm.
QpSolution solve_quadratic_program(const QpMatrix& H, const QpVector& g,
                                   const std::vector<HalfSpace>& half_spaces);

}  // namespace vrda
