/// Smooths the raw surfaces of a motion model by least-squares polynomials of a total degree.
/// store/derived.hpp describes the result, store/evaluate_smoothed.hpp evaluates it.
#pragma once

#include <string>
#include <vector>

#include "store/evaluate_smoothed.hpp"
#include "store/motion_model.hpp"

namespace vrda::analysis {

/// Surfaces to smooth. Residuals have the units of these values: mm and degrees.
struct SmoothInput {
  std::string name;                 ///< output file or job, for messages
  std::vector<double> flexion_deg;  ///< [n_flexion], strictly increasing
  std::vector<double> varus_deg;    ///< [n_varus], strictly increasing
  store::GridD tx_mm, ty_mm, tz_mm, theta_deg;
  store::GridB status;            ///< cells that are not StepStatus::stable are omitted
  store::GridB theta_determined;  ///< theta is fitted to cells with 1, if these determine the degree
  store::GridD varus_solved_deg;  ///< fifth surface if varus was free; otherwise empty
};

/// Varus counts as free if its axis has one value and a solved cell has another.
SmoothInput smooth_input(const store::MotionModel& model, const std::string& name);

struct SmoothOptions {
  bool is_robust = false;  ///< Huber weights (smooth/huber.hpp), separate for each surface
};

/// A smoothed set with its errors at each grid cell, in the order of set.surfaces.
struct SmoothFit {
  store::SmoothedSet set;
  std::vector<store::GridD> residual;  ///< raw minus smoothed value; NaN if the cell is not fitted
  std::vector<store::GridD>
      leave_one_out;  ///< residual of a fit without the cell; NaN also if the fit needs the cell
  std::vector<store::GridD> weight;  ///< of the cell in the fit, 1 unless robust; NaN if it is not fitted
  std::vector<bool> is_converged;    ///< false if the Huber weights reached the iteration limit
};

/// Least squares on P_i(u) P_j(v), i + j <= degree: Legendre polynomials of flexion and varus, each axis
/// mapped to [-1, 1] by its first and last value. An axis with one value contributes a constant only.
/// rms, largest_residual and leave_one_out_rms weight every fitted cell equally, robust or not. Leave-one-out
/// errors are exact for least squares; for a robust fit the other weights are kept. leave_one_out_rms is NaN
/// if omitting a cell would leave the degree undetermined. Throws InputError if the cells do not determine
/// the degree, with their number and the largest possible degree. Cost: cells times terms squared.
SmoothFit smooth_fit(const SmoothInput& input, int degree, const SmoothOptions& options = {});

store::SmoothedSet smooth(const SmoothInput& input, int degree, const SmoothOptions& options = {});

/// The highest degree up to `limit` that the solved cells determine; -1 without solved cells.
int largest_degree(const SmoothInput& input, int limit = store::max_smoothed_degree);

}  // namespace vrda::analysis
