/// Scaling of a joint to a subject, passed between load, store and app. schemas/scaling.md defines what is
/// scaled and how a factor is fitted.
#pragma once

#include <Eigen/Core>
#include <limits>
#include <string>
#include <vector>

namespace vrda::inline model {

struct Scaling {
  Eigen::Vector3d factor{1.0, 1.0, 1.0};  ///< anterior, proximal, right; about the rotation centre
  bool keeps_steps = false;               ///< steps solved at factor 1, lengths of the results scaled

  // Landmark pairs to which a uniform factor was fitted; empty where the job gives the factor.
  std::vector<std::string> landmark;  ///< [n_pairs]
  std::vector<double> model_mm;       ///< [n_pairs] distance at factor 1
  std::vector<double> subject_mm;     ///< [n_pairs] distance in the subject
  std::vector<double> residual_mm;    ///< [n_pairs] subject_mm - factor * model_mm
  double residual_rms_mm = std::numeric_limits<double>::quiet_NaN();  ///< NaN without pairs
  double standard_error = std::numeric_limits<double>::quiet_NaN();   ///< of the factor; NaN below two pairs
};

/// Whether the three factors are equal.
bool is_uniform(const Eigen::Vector3d& factor);

}  // namespace vrda::inline model
