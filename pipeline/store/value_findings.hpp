/// Findings about the values of a file's datasets: one per dataset and rule, with the first wrong entry and
/// the number of wrong entries.
#pragma once

#include <Eigen/Core>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <string>
#include <utility>
#include <vector>

#include "store/dataset.hpp"

namespace vrda::store {

/// Unit vectors may be stored in single precision.
inline constexpr double normal_tolerance = 1e-5;

/// Deviation of R R^T from the identity, an entry. Products of three rotations in double reach a few 1e-16;
/// rotations rounded to text or float exceed 1e-9, and would displace points so far that contacts overlap. At
/// 500 mm from the origin 1e-9 is half a nanometre.
inline constexpr double exact_tolerance = 1e-9;

/// In mm, degrees, N or N mm: larger than in any joint, and small enough that values computed from a model
/// cannot overflow.
inline constexpr double max_magnitude = 1e9;
inline constexpr double min_axis_step_deg = 1e-6;

/// Whether `value` is finite and of magnitude up to max_magnitude.
inline bool is_number(double value)
{
  return std::abs(value) <= max_magnitude;
}

/// Whether 16 numbers, row by row, are a rotation and a translation.
inline bool is_rigid_pose(const double* entries)
{
  using Matrix4 = Eigen::Matrix<double, 4, 4, Eigen::RowMajor>;
  const Matrix4 X = Eigen::Map<const Matrix4>(entries);
  if (!(X.array().abs() <= max_magnitude).all()) return false;
  const Eigen::Matrix3d R = X.topLeftCorner<3, 3>();
  const Eigen::Matrix3d error = R * R.transpose() - Eigen::Matrix3d::Identity();
  return error.cwiseAbs().maxCoeff() <= exact_tolerance && R.determinant() > 0.0 &&
         X.row(3) == Eigen::RowVector4d(0, 0, 0, 1);
}

/// The text of a number in findings.
inline std::string text_of(double value)
{
  char text[40];
  std::snprintf(text, sizeof text, "%.10g", value);
  return text;
}

/// Collects findings in the order in which they are added.
class ValueFindings {
 public:
  bool empty() const { return findings_.empty(); }
  std::size_t size() const { return findings_.size(); }
  std::vector<Finding> take() { return std::move(findings_); }

  void add(const std::string& where, const std::string& found, const std::string& wanted)
  {
    findings_.push_back({where, found, wanted});
  }

  /// Adds one finding for all wrong entries of a dataset; `show` returns the text of the first.
  template <typename IsWrong, typename Show>
  void report_each(const std::string& where, std::size_t size, const std::string& wanted, IsWrong is_wrong,
                   Show show)
  {
    std::size_t n_wrong = 0, first = 0;
    for (std::size_t i = size; i-- > 0;) {
      if (!is_wrong(i)) continue;
      first = i;
      ++n_wrong;
    }
    if (n_wrong == 0) return;
    const std::string more = n_wrong == 1 ? "" : " (the first of " + std::to_string(n_wrong) + ")";
    add(where, std::string(show(first)) + " at entry " + std::to_string(first) + more, wanted);
  }

  /// The same for numbers, the first of which is shown.
  template <typename Real, typename IsWrong>
  void report_numbers(const std::string& where, const Real* values, std::size_t size,
                      const std::string& wanted, IsWrong is_wrong)
  {
    report_each(where, size, wanted, is_wrong, [&](std::size_t i) { return text_of(values[i]); });
  }

  /// Integers outside [low, high].
  template <typename Integer>
  void report_out_of_range(const std::string& where, const Integer* values, std::size_t size,
                           std::int64_t low, std::int64_t high)
  {
    report_each(
        where, size, "a value from " + std::to_string(low) + " to " + std::to_string(high),
        [&](std::size_t i) { return values[i] < low || values[i] > high; },
        [&](std::size_t i) { return std::to_string(values[i]); });
  }

  /// Numbers for which is_number() is false.
  template <typename Real>
  void report_not_finite(const std::string& where, const Real* values, std::size_t size)
  {
    report_numbers(where, values, size, "finite numbers of magnitude up to 1e9",
                   [&](std::size_t i) { return !is_number(static_cast<double>(values[i])); });
  }

 private:
  std::vector<Finding> findings_;
};

}  // namespace vrda::store
