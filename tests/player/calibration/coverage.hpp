/// How often the stated intervals hold the truth.
#pragma once

#include <map>
#include <string>

#include "calibration/estimate.hpp"

namespace vrda::test {

/// Of many estimates against what is true.
class Coverage {
 public:
  /// `error`: found less true of each number in its units, or of the first ones.
  void add(const Estimate& estimate, const Eigen::VectorXd& error);
  void add(const std::string& name, double error, double half_width);
  /// Expects each number within its 95 % interval in 90 to 98 % of cases: of 200 honest ones in 97 of 100
  /// runs. Numbers of the left and of the right eye count as one.
  void expect_honest() const;

 private:
  struct Count {
    int n = 0, n_within = 0;
  };
  std::map<std::string, Count> counts_;
};

/// Found less true of a place, as Estimate has it: shift in mm and turn about the fixed axes in deg.
Eigen::VectorXd place_error(const Pose& X_found, const Pose& X_true);

}  // namespace vrda::test
