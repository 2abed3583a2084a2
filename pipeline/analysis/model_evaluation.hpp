/// The differences between a model with some changes and the measurements.
#pragma once

#include <map>
#include <mutex>
#include <utility>

#include "analysis/identification.hpp"
#include "solve/equilibrium.hpp"

namespace vrda::analysis {

/// Differences divided by their noise, one per row and coordinate: motions first, then laxities. NaN where
/// the model has no pose.
using Residuals = Eigen::VectorXd;

/// Thread-safe. The data and the plan must outlive it.
class ModelEvaluation {
 public:
  ModelEvaluation(const FitData& data, const IdentifyPlan& plan);

  struct Row {
    std::size_t trial = 0;       ///< trials.size(): a laxity
    std::size_t row = 0;         ///< of the trial, or of the laxities
    std::size_t coordinate = 0;  ///< of a motion
    double weight = 1.0;
    double noise = 1.0;  ///< rad or mm; of a laxity mm or degrees
  };
  const std::vector<Row>& rows() const { return rows_; }

  /// At changes `x`, in units of the prior's deviation, by the whole spine.
  Residuals at(const Eigen::VectorXd& x);
  /// At `x`, from the equilibria found at `base`, which is near.
  Residuals near(const Eigen::VectorXd& base, const Eigen::VectorXd& x);
  /// Derivatives by changes, columns, at `x`: differences over `step` to either side.
  Eigen::MatrixXd derivatives(const Eigen::VectorXd& x, double step);
  /// Of the laxities, mm or degrees.
  std::vector<double> laxities_at(const Eigen::VectorXd& x);

  bool is_stopped() const { return plan_.is_stopped && plan_.is_stopped(); }
  Eigen::VectorXd change(const Eigen::VectorXd& x) const;

 private:
  using Key = std::pair<std::int8_t, std::vector<double>>;
  struct Stopped {};

  std::vector<double> recalled(const Key& key, const std::function<std::vector<double>()>& compute);
  std::vector<double> spine_poses(const Eigen::VectorXd& x);
  std::vector<double> near_poses(const Eigen::VectorXd& base, const Eigen::VectorXd& x);
  std::vector<double> laxity_values(const Eigen::VectorXd& x);
  std::vector<double> near_laxity_values(const Eigen::VectorXd& base, const Eigen::VectorXd& x);
  std::vector<double> solved_laxities(const Eigen::VectorXd& x, const std::vector<StepRecord>& unloaded);
  Residuals residuals(const std::vector<double>& poses, const std::vector<double>& laxities) const;
  void add_rows();

  const FitData& data_;
  const IdentifyPlan& plan_;
  std::vector<Row> rows_;
  solve::Joint joint_;           ///< of the motion's case
  std::vector<bool> is_needed_;  ///< [n_flexion] next to the flexion of a row
  std::map<Key, std::vector<double>> known_;
  std::mutex mutex_;
};

}  // namespace vrda::analysis
