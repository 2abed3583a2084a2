/// Smooths the raw surfaces of a motion model by least-squares polynomials of a total degree.
/// store/motion_model.hpp describes the result, store/motion.hpp evaluates it.
#pragma once

#include <Eigen/Core>

#include <array>
#include <string>
#include <vector>

#include "model/coordinates.hpp"
#include "store/motion.hpp"
#include "store/motion_model.hpp"

namespace vrda::analysis {

/// The six coordinates of a body that follows the joint, mm and degrees.
struct FollowerInput {
  std::string name;
  store::GridB status;
  std::array<store::GridD, n_joint_coordinates> coordinates;
};

/// Surfaces to smooth. Residuals have the units of these values: mm and degrees.
struct SmoothInput {
  std::string name;                 ///< output file or job, for messages
  std::vector<double> flexion_deg;  ///< [n_flexion], strictly increasing
  std::vector<double> varus_deg;    ///< [n_varus], strictly increasing
  store::GridD tx_mm, ty_mm, tz_mm, theta_deg;
  store::GridB status;            ///< cells that are not StepStatus::stable are omitted
  store::GridB theta_determined;  ///< theta is fitted to cells with 1, if these determine the degree
  store::GridD varus_solved_deg;  ///< fifth surface if varus was free; otherwise empty
  std::vector<FollowerInput> followers = {};  ///< by name
};

/// Varus counts as free if its axis has one value and a solved cell has another.
SmoothInput smooth_input(const store::MotionModel& model, const std::string& name);

struct SmoothOptions {
  bool is_robust = false;  ///< Huber weights (analysis/smooth.hpp), separate for each surface
};

/// A smoothed set with its errors at each grid cell, in the order of set.surfaces.
struct SmoothFit {
  store::SmoothedSet set;
  std::vector<store::GridD> residual;  ///< raw minus smoothed value; NaN if the cell is not fitted
  std::vector<store::GridD>
      leave_one_out;  ///< residual of a fit without the cell; NaN also if the fit needs the cell
  std::vector<store::GridD> weight;  ///< of the cell in the fit, 1 unless robust; NaN if it is not fitted
  /// False if the Huber weights reached the iteration limit; then those of followers.
  std::vector<bool> is_converged;
};

/// Least squares on P_i(u) P_j(v), i + j <= degree: Legendre polynomials of flexion and varus, each axis
/// mapped to [-1, 1] by its first and last value. An axis with one value contributes a constant only.
/// rms, largest_residual and leave_one_out_rms weight every fitted cell equally, robust or not. Leave-one-out
/// errors are exact for least squares; for a robust fit the other weights are kept. leave_one_out_rms is NaN
/// if omitting a cell would leave the degree undetermined. Throws InputError if the cells do not determine
/// the degree, with their number and the largest possible degree; a follower whose cells do not is left out.
/// Cost: cells times terms squared.
SmoothFit smooth_fit(const SmoothInput& input, int degree, const SmoothOptions& options = {});

store::SmoothedSet smooth(const SmoothInput& input, int degree, const SmoothOptions& options = {});

/// The highest degree up to `limit` that the solved cells determine; -1 without solved cells.
int largest_degree(const SmoothInput& input, int limit = store::max_smoothed_degree);

// Linear least squares by Eigen's Householder QR with column pivoting.
// Bitwise equal on every processor: uses only Eigen functions whose sums do not depend on the cache sizes
// (no product of two matrices, no blocked reflections). The tests set other sizes.

/// A = Q R with permuted columns, Q thin.
struct PivotedQr {
  Eigen::MatrixXd Q;      ///< [n_rows, n_columns], orthonormal columns
  Eigen::MatrixXd R;      ///< [n_columns, n_columns], upper triangular
  Eigen::VectorXi order;  ///< column k of Q R is column order(k) of A
  Eigen::Index rank = 0;  ///< |R(k, k)| above n_rows * epsilon * the largest of them
};

/// A must have at least one column and at least as many rows as columns.
PivotedQr pivoted_qr(const Eigen::MatrixXd& A);

/// Coefficients whose fitted values are Q * `along`, in the column order of A. The rank must be full.
Eigen::VectorXd coefficients_of(const PivotedQr& qr, const Eigen::VectorXd& along);

/// Least-squares solution, in the column order of A. The rank must be full.
Eigen::VectorXd solve(const PivotedQr& qr, const Eigen::VectorXd& data);

/// Diagonal of the hat matrix Q Q^T: derivative of each row's fitted value by its datum, 0 to 1.
Eigen::VectorXd leverages(const PivotedQr& qr);

/// Largest over smallest singular value of A. The rank must be full.
double condition_number(const PivotedQr& qr);

// The design matrix of a degree: its cells and terms, decomposed once for all surfaces that share it.

struct Cell {
  Eigen::Index flexion = 0;  ///< row of the grid
  Eigen::Index varus = 0;    ///< column
};

/// Legendre polynomials at every value of both axes.
struct AxisTables {
  std::vector<store::LegendreTable> flexion, varus;
};
AxisTables axis_tables(const std::vector<double>& flexion_deg, const std::vector<double>& varus_deg,
                       int degree);

/// [n_terms, 2] (i, j), i + j <= degree, by ascending i + j; i (j) is always 0 if its axis has one value.
using Exponents = decltype(store::SmoothedSet::exponents);
Exponents terms_of_degree(int degree, bool has_flexion, bool has_varus);

/// Decomposes the matrix P_i(u) P_j(v) of cells (rows) and terms (columns). Rank 0 if there are fewer cells
/// than terms.
PivotedQr decompose_design(const std::vector<Cell>& cells, const Exponents& exponents,
                           const AxisTables& tables);

/// True if the cells determine all terms.
bool is_full_rank(const PivotedQr& qr);

/// Polynomial at every grid attitude, bitwise equal to evaluate() of store/motion.hpp.
store::GridD grid_values(const std::vector<double>& coefficients, const Exponents& exponents,
                         const AxisTables& tables);

// Robust regression: outliers have a limited influence.

/// Residuals beyond this multiple of the scale get less weight: 95 % efficiency on normal noise (Huber 1981).
inline constexpr double huber_constant = 1.345;

/// Standard deviation of normal noise over the median of its absolute value: 1 / quantile(3/4).
inline constexpr double normal_scale = 1.4826022185056018;

/// normal_scale * median of |value|; 0 without values.
double robust_scale(Eigen::VectorXd values);

/// A weighted least-squares solution with Huber weights of its residuals.
struct HuberFit {
  Eigen::VectorXd coefficients;  ///< columns in the order of the decomposed matrix
  Eigen::VectorXd weights;       ///< [n_rows] min(1, huber_constant * scale / |residual|)
  Eigen::VectorXd leverage;      ///< [n_rows] diagonal of the hat matrix of the weighted problem
  double scale = 0.0;            ///< robust_scale of the residuals that set the weights
  int n_iterations = 0;
  bool is_converged = false;  ///< if false, the iterate after max_iterations
};

struct HuberOptions {
  int max_iterations = 300;
};

/// Huber's M-estimate: solves sum of weight * residual * row = 0. The first 30 iterations use the unweighted
/// matrix (Huber, Dutter 1974): same fixed point, no decomposition. The others are iteratively reweighted
/// least squares. The scale is estimated in the first 50 iterations and then fixed, so the loss is convex and
/// every iteration descends. Stops when an iteration changes the fit by less than 1e-6 of the scale (root
/// mean square), or when most of the data is fitted to rounding. The result is the weighted least-squares
/// solution with the final weights, so residual / (1 - leverage) is exactly the error of a refit without the
/// row and with these weights. The rank must be full.
HuberFit huber_fit(const PivotedQr& qr, const Eigen::VectorXd& data, const HuberOptions& options = {});

// Prediction errors of a smoothed set for blocks of attitudes that are left out together.

/// Attitudes of a contiguous block of the grid.
struct BlockSize {
  Eigen::Index flexion = 1, varus = 1;  ///< at least 1
};

/// [n_flexion, n_varus] number of each cell's block, from 0. The last blocks of an axis may be smaller.
store::GridI block_numbers(Eigen::Index n_flexion, Eigen::Index n_varus, const BlockSize& size);

/// Raw minus predicted value of a fit without the cell's block, in the order of fit.set.surfaces; NaN where
/// the cell is not fitted, or if the other cells do not determine the fit. Exact for least squares, e = (I -
/// H)^-1 r with the block's part H of the hat matrix; for a robust fit the weights are kept. `fit` is of
/// `input`.
std::vector<store::GridD> leave_blocks_out(const SmoothInput& input, const SmoothFit& fit,
                                           const BlockSize& size);

}  // namespace vrda::analysis
