/// A joint scaled to a subject: what the rooms load, store and app pass on. schemas/scaling.md says what is
/// scaled and how a factor is fitted.
#pragma once

#include <Eigen/Core>
#include <limits>
#include <string>
#include <vector>

namespace vrda {

struct Scaling {
  Eigen::Vector3d factor{1.0, 1.0, 1.0};  ///< anterior, proximal, right; about the rotation centre
  bool keeps_steps = false;  ///< the steps were solved at factor 1, and lengths of their results scaled

  // Pairs of landmarks that an even factor was fitted to; empty where the job gives the factor.
  std::vector<std::string> landmark;  ///< [n_pairs]
  std::vector<double> model_mm;       ///< [n_pairs] distance at factor 1
  std::vector<double> subject_mm;     ///< [n_pairs] distance in the subject
  std::vector<double> residual_mm;    ///< [n_pairs] subject's less factor times model's
  double residual_rms_mm = std::numeric_limits<double>::quiet_NaN();  ///< NaN without pairs
  double standard_error = std::numeric_limits<double>::quiet_NaN();   ///< of the factor; NaN below two pairs
};

/// Whether the three factors are one.
bool is_even(const Eigen::Vector3d& factor);

}  // namespace vrda
