/// Smooths the raw surfaces of a motion model: polynomials of a total degree, by least squares
/// (DESIGN.md 5.5). The result and how to evaluate it: store/motion_model.hpp, store/evaluate_smoothed.hpp.
#pragma once

#include <string>
#include <vector>

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
};

SmoothInput smooth_input(const MotionModel& model, const std::string& name);

/// Least squares on P_i(u) P_j(v), i + j <= degree: Legendre polynomials of flexion and varus, each axis
/// mapped to [-1, 1] by its first and last value. Of an axis with one value only the constant is used.
/// leave_one_out_rms is NaN where leaving some cell out would leave the degree undetermined.
/// Throws InputError when the cells cannot carry the degree, saying how many there are and which degree they
/// would carry. Cost: cells times terms squared; 0.1 s for 91 x 21 cells and degree 12.
SmoothedSet smooth(const SmoothInput& input, int degree);

/// The highest degree, up to 20, that the solved cells can carry; -1 where even a constant has no cell.
int largest_degree(const SmoothInput& input);

}  // namespace vrda
