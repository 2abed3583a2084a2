/// Coverage of confidence intervals.
#pragma once

#include <map>
#include <string>

#include "bench/calibration_file.hpp"

namespace vrda::test {

/// Counts how often intervals contain the true value.
class Coverage {
 public:
  /// `error`: estimated minus true value of each number, or of the first ones.
  void add(const bench::Estimate& estimate, const Eigen::VectorXd& error);
  void add(const std::string& name, double error, double half_width);
  /// Expects each number within its 95 % interval in 90 to 98 % of cases, which holds for correct intervals
  /// in 97 % of runs of 200 cases. Numbers of the left and the right eye are pooled.
  void expect_honest() const;

 private:
  struct Count {
    int n = 0, n_within = 0;
  };
  std::map<std::string, Count> counts_;
};

/// Pose error as in Estimate: translation in mm and rotation vector about the fixed axes in deg.
Eigen::VectorXd place_error(const Pose& X_found, const Pose& X_true);

}  // namespace vrda::test
