/// The minimum of a quadratic function in a box, by NLopt (SLSQP).
#pragma once

#include <Eigen/Core>

namespace vrda::solve {

/// Minimises x' H x / 2 + g' x over low <= x <= high from x = 0, which must be in the box. `H` is symmetric
/// and positive definite. All arguments have the same length, at least 1; use scaled unknowns.
Eigen::VectorXd minimum_in_box(const Eigen::MatrixXd& H, const Eigen::VectorXd& g, const Eigen::VectorXd& low,
                               const Eigen::VectorXd& high);

}  // namespace vrda::solve
