/// Smooths the raw surfaces of a motion model: polynomials of a total degree, by least squares
/// (DESIGN.md 5.5). The result and how to evaluate it: store/derived.hpp, store/evaluate_smoothed.hpp.
#pragma once

#include <string>
#include <vector>

#include "store/evaluate_smoothed.hpp"
#include "store/motion_model.hpp"

namespace vrda {

/// Units of the result's residuals are those of the values given: mm and degrees.
struct SmoothInput {
  std::string name;                 ///< for messages: the output file or the job
  std::vector<double> flexion_deg;  ///< [n_flexion], strictly increasing
  std::vector<double> varus_deg;    ///< [n_varus], strictly increasing
  GridD tx_mm, ty_mm, tz_mm, theta_deg;
  GridB status;            ///< cells that are not StepStatus::stable are left out
  GridB theta_determined;  ///< theta is fitted where this is 1, if those cells can carry the degree
  GridD varus_solved_deg;  ///< a fifth surface where varus was free; empty where it was given
};

/// Varus counts as free where it has one value and some solved cell another.
SmoothInput smooth_input(const MotionModel& model, const std::string& name);

struct SmoothOptions {
  bool is_robust = false;  ///< Huber's weights (smooth/huber.hpp), each surface its own
};

/// A smoothed set with what it leaves at each cell of the grid, in the order of set.surfaces.
struct SmoothFit {
  SmoothedSet set;
  std::vector<GridD> residual;     ///< raw value less smoothed; NaN where the cell is not fitted
  std::vector<GridD> left_out;     ///< the same as if the cell were not in the fit; NaN also where it must be
  std::vector<bool> is_converged;  ///< false where the steps to Huber's weights met their limit
};

/// Least squares on P_i(u) P_j(v), i + j <= degree: Legendre polynomials of flexion and varus, each axis
/// mapped to [-1, 1] by its first and last value. Of an axis with one value only the constant is used.
/// rms, largest_residual and leave_one_out_rms count every fitted cell alike, robust or not. Leaving out is
/// exact for least squares; a robust fit is left out with the weights of the others as they are.
/// leave_one_out_rms is NaN where leaving some cell out would leave the degree undetermined.
/// Throws InputError when the cells cannot carry the degree, saying how many there are and which degree they
/// would carry. Cost: cells times terms squared.
SmoothFit smooth_fit(const SmoothInput& input, int degree, const SmoothOptions& options = {});

SmoothedSet smooth(const SmoothInput& input, int degree, const SmoothOptions& options = {});

/// The highest degree, up to `limit`, that the solved cells can carry; -1 where even a constant has no cell.
int largest_degree(const SmoothInput& input, int limit = largest_smoothed_degree);

}  // namespace vrda
