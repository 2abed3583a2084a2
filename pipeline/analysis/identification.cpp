#include "analysis/identification.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

#include "core/error.hpp"
#include "core/parallel.hpp"
#include "analysis/model_evaluation.hpp"
#include "solve/quadratic_program.hpp"

namespace vrda::analysis {
namespace {

constexpr int most_iterations_of_fit = 40;
// Steps of the differences, in prior deviations: equilibria jump at facets, and long steps average the jumps;
// the last, short steps are closer to the derivative.
constexpr double long_difference = 0.5, short_difference = 0.1;
constexpr int most_passes = 3;                              // over both
constexpr double first_radius = 1.0, largest_radius = 2.0;  // of a step, in prior deviations
// Decreases of half the sum of squares: a step of a seventh of the posterior's deviation gives 0.01.
constexpr double settled_decrease = 0.01;
// A fit that no step improves has converged within the jumps of the equilibria if the decrease predicted for
// a full step is smaller than this: 0.4 deviations.
constexpr double unsettled_decrease = 0.08;
// Limits of Identifiability.
constexpr double decided_share = 0.9, undecided_share = 0.1;

/// A part of the measurements that is left out together: rows of one trial.
struct DataPart {
  std::size_t trial = 0;
  std::size_t first = 0, last = 0;
  bool contains(const ModelEvaluation::Row& row) const
  {
    return row.trial == trial && row.row >= first && row.row < last;
  }
};

std::vector<DataPart> parts_of(const FitData& data)
{
  std::vector<DataPart> parts;
  for (std::size_t t = 0; t < data.trials.size(); ++t) parts.push_back({t, 0, data.trials[t].rows.size()});
  if (parts.size() != 1) return parts;
  const std::size_t half = parts[0].last / 2;
  return {{0, 0, half}, {0, half, parts[0].last}};
}

/// One fit.
struct FitEnd {
  FitStatus status = FitStatus::iteration_limit;
  int n_iterations = 0;
  Eigen::VectorXd x;    ///< in prior deviations
  Residuals residuals;  ///< of all rows, those left out too
  Eigen::MatrixXd J;
  double half_squares = 0.0;
};

class Fit {
 public:
  /// `weights`: of each row; 0 where it is left out.
  Fit(ModelEvaluation& model, const std::vector<Unknown>& unknowns, Eigen::VectorXd weights)
      : model_(model), weights_(std::move(weights))
  {
    const auto n = static_cast<Eigen::Index>(unknowns.size());
    low_.resize(n);
    high_.resize(n);
    for (Eigen::Index k = 0; k < n; ++k) {
      const Unknown& unknown = unknowns[static_cast<std::size_t>(k)];
      low_(k) = unknown.from / unknown.sd;
      high_(k) = unknown.to / unknown.sd;
    }
  }

  FitEnd run(const Eigen::VectorXd& start)
  {
    FitEnd end;
    end.x = start;
    end.residuals = model_.at(end.x);
    end.half_squares = half_squares(end.x, end.residuals);
    n_missing_ = n_missing(end.residuals);
    for (int pass = 0; pass < most_passes && !model_.is_stopped(); ++pass) {
      const bool is_lower = descend(end, long_difference);
      if (!descend(end, short_difference) && (pass > 0 || !is_lower)) break;
    }
    if (model_.is_stopped()) return end;
    const double promised = predicted_decrease(end, planned_step(end, largest_radius));
    if (promised <= unsettled_decrease) {
      end.status = FitStatus::converged;
    } else if (end.n_iterations < most_iterations_of_fit) {
      end.status = FitStatus::not_smooth;
    }
    return end;
  }

 private:
  Eigen::VectorXd planned_step(const FitEnd& at, double radius) const
  {
    return solve::minimum_in_box(information(at.J, at.residuals) + identity(), slope(at),
                                 (low_ - at.x).cwiseMax(-radius).cwiseMin(0.0),
                                 (high_ - at.x).cwiseMin(radius).cwiseMax(0.0));
  }
  double predicted_decrease(const FitEnd& at, const Eigen::VectorXd& step) const
  {
    const Eigen::MatrixXd H = information(at.J, at.residuals) + identity();
    return -(0.5 * step.dot(H * step) + slope(at).dot(step));
  }

  /// Steps with differences of one length until none predicts or gives a decrease. True if one did.
  bool descend(FitEnd& end, double difference)
  {
    double radius = std::min(first_radius, 4.0 * difference);
    end.J = model_.derivatives(end.x, difference);
    if (model_.is_stopped()) return false;
    bool is_lower = false;
    while (radius >= difference && end.n_iterations < most_iterations_of_fit && !model_.is_stopped()) {
      const Eigen::VectorXd step = planned_step(end, radius);
      const double predicted = predicted_decrease(end, step);
      if (!(predicted > settled_decrease)) break;
      ++end.n_iterations;
      const Eigen::VectorXd x = (end.x + step).cwiseMax(low_).cwiseMin(high_);
      const Residuals residuals = model_.at(x);
      const double now = half_squares(x, residuals);
      const double ratio = n_missing(residuals) > n_missing_ ? -1.0 : (end.half_squares - now) / predicted;
      const double length = step.cwiseAbs().maxCoeff();
      if (ratio > 0.0) {
        end.x = x;
        end.residuals = residuals;
        end.half_squares = now;
        end.J = model_.derivatives(x, difference);
        is_lower = true;
      }
      if (ratio > 0.75) radius = std::min(largest_radius, std::max(radius, 2.0 * length));
      if (ratio < 0.25) radius = 0.5 * length;
    }
    return is_lower;
  }

 public:
  /// Of the data, in prior deviations.
  Eigen::MatrixXd information(const Eigen::MatrixXd& J, const Residuals& residuals) const
  {
    const Eigen::VectorXd w = weights_of(residuals);
    return J.transpose() * w.asDiagonal() * J;
  }

  double data_squares(const Residuals& residuals) const
  {
    return weights_of(residuals).dot(finite(residuals).cwiseAbs2());
  }
  double n_independent(const Residuals& residuals) const { return weights_of(residuals).sum(); }
  double half_squares(const Eigen::VectorXd& x, const Residuals& residuals) const
  {
    return 0.5 * (data_squares(residuals) + x.squaredNorm());
  }

 private:
  Eigen::MatrixXd identity() const { return Eigen::MatrixXd::Identity(low_.size(), low_.size()); }
  static Eigen::VectorXd finite(const Residuals& residuals)
  {
    return residuals.unaryExpr([](double r) { return std::isfinite(r) ? r : 0.0; });
  }
  Eigen::VectorXd weights_of(const Residuals& residuals) const
  {
    Eigen::VectorXd w = weights_;
    for (Eigen::Index k = 0; k < w.size(); ++k) {
      if (!std::isfinite(residuals(k))) w(k) = 0.0;
    }
    return w;
  }
  Eigen::Index n_missing(const Residuals& residuals) const
  {
    Eigen::Index n = 0;
    for (Eigen::Index k = 0; k < residuals.size(); ++k)
      n += weights_(k) > 0.0 && !std::isfinite(residuals(k)) ? 1 : 0;
    return n;
  }
  Eigen::VectorXd slope(const FitEnd& at) const
  {
    return at.J.transpose() * weights_of(at.residuals).cwiseProduct(finite(at.residuals)) + at.x;
  }

  ModelEvaluation& model_;
  Eigen::VectorXd weights_, low_, high_;
  Eigen::Index n_missing_ = 0;
};

Eigen::VectorXd weights_without(const ModelEvaluation& model, const DataPart* left_out)
{
  Eigen::VectorXd weights(static_cast<Eigen::Index>(model.rows().size()));
  for (std::size_t k = 0; k < model.rows().size(); ++k) {
    const ModelEvaluation::Row& row = model.rows()[k];
    weights(static_cast<Eigen::Index>(k)) = left_out != nullptr && left_out->contains(row) ? 0.0 : row.weight;
  }
  return weights;
}

Misfit misfit_of(const ModelEvaluation& model, const DataPart& part, const Residuals& residuals)
{
  Misfit rms;
  rms.fill(nan);
  for (std::size_t c = 1; c < analysis::n_scored; ++c) {
    double sum = 0.0;
    int n = 0;
    for (std::size_t k = 0; k < model.rows().size(); ++k) {
      const ModelEvaluation::Row& row = model.rows()[k];
      const double residual = residuals(static_cast<Eigen::Index>(k));
      if (!part.contains(row) || row.coordinate != c || !std::isfinite(residual)) continue;
      sum += residual * residual * row.noise * row.noise;
      ++n;
    }
    if (n > 0) rms[c] = std::sqrt(sum / n);
  }
  return rms;
}

std::string name_of_part(const FitData& data, const std::vector<DataPart>& parts, std::size_t number)
{
  const std::string& file = data.trials[parts[number].trial].file;
  if (data.trials.size() > 1) return file;
  return file + (number == 0 ? ", first half" : ", second half");
}

// The other fits may have passed a jump that stopped the first one: it continues from the best of their ends.
void continue_from_best(ModelEvaluation& model, Fit& fit, std::vector<FitEnd>& ends)
{
  const FitEnd* best = nullptr;
  double least = ends.front().half_squares - settled_decrease;
  for (std::size_t k = 1; k < ends.size() && !model.is_stopped(); ++k) {
    const double here = fit.half_squares(ends[k].x, ends[k].residuals);
    if (here >= least) continue;
    best = &ends[k];
    least = here;
  }
  if (best == nullptr) return;
  FitEnd again = fit.run(best->x);
  again.n_iterations += ends.front().n_iterations;
  if (again.half_squares < ends.front().half_squares) ends.front() = again;
}

void set_posterior(Identification& found, const FitEnd& end, const Fit& fit,
                   const std::vector<Unknown>& unknowns)
{
  const Eigen::Index n = end.x.size();
  const auto posterior = [&](double scale) -> Eigen::MatrixXd {
    const Eigen::MatrixXd precision =
        fit.information(end.J, end.residuals) / (scale * scale) + Eigen::MatrixXd::Identity(n, n);
    return precision.ldlt().solve(Eigen::MatrixXd::Identity(n, n));
  };
  // Of the data, less the numbers that they determine.
  const double n_fitted = static_cast<double>(n) - posterior(1.0).trace();
  const double n_free = std::max(1.0, fit.n_independent(end.residuals) - n_fitted);
  found.noise_scale = std::max(1.0, std::sqrt(fit.data_squares(end.residuals) / n_free));
  const Eigen::MatrixXd C = posterior(found.noise_scale);
  const Eigen::VectorXd variances = Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(C).eigenvalues();
  found.n_directions = static_cast<std::size_t>((variances.array() <= 1.0 - decided_share).count());
  found.covariance = C;
  for (Eigen::Index k = 0; k < n; ++k) {
    const Unknown& unknown = unknowns[static_cast<std::size_t>(k)];
    found.covariance.row(k) *= unknown.sd;
    found.covariance.col(k) *= unknown.sd;
    FittedUnknown one;
    one.change = unknown.sd * end.x(k);
    one.sd = unknown.sd * std::sqrt(C(k, k));
    one.explained = 1.0 - C(k, k);
    const bool is_at_bound = one.change <= unknown.from || one.change >= unknown.to;
    one.identifiability = is_at_bound ? Identifiability::at_bound
                          : one.explained >= decided_share && end.status == FitStatus::converged
                              ? Identifiability::decided
                          : one.explained < undecided_share ? Identifiability::undecided
                                                            : Identifiability::partly;
    for (Eigen::Index other = 0; other < n; ++other) {
      const double correlation = C(k, other) / std::sqrt(C(k, k) * C(other, other));
      if (other == k || std::abs(correlation) <= std::abs(one.correlation)) continue;
      one.correlation = correlation;
      one.partner = static_cast<std::size_t>(other);
    }
    found.unknowns.push_back(one);
  }
}

}  // namespace

const char* name_of(Identifiability identifiability)
{
  switch (identifiability) {
    case Identifiability::decided:
      return "decided";
    case Identifiability::partly:
      return "partly";
    case Identifiability::undecided:
      return "undecided";
    case Identifiability::at_bound:
      break;
  }
  return "at_bound";
}

Eigen::VectorXd Identification::change() const
{
  Eigen::VectorXd changes(static_cast<Eigen::Index>(unknowns.size()));
  for (Eigen::Index k = 0; k < changes.size(); ++k) changes(k) = unknowns[static_cast<std::size_t>(k)].change;
  return changes;
}

Identification identify(const FitData& data, const IdentifyPlan& plan)
{
  check(!plan.unknowns.empty() && (data.motion != nullptr || data.laxity != nullptr), "identify: a question");
  ModelEvaluation model(data, plan);
  const std::vector<DataPart> parts = parts_of(data);
  // The first fit has all data, the others lack one part each.
  std::vector<FitEnd> ends(1 + parts.size());
  std::vector<Fit> fits;
  for (std::size_t k = 0; k < ends.size(); ++k)
    fits.emplace_back(model, plan.unknowns, weights_without(model, k == 0 ? nullptr : &parts[k - 1]));
  for_each_index(ends.size(), plan.n_threads, [&] {
    return [&](std::size_t k) {
      ends[k] = fits[k].run(Eigen::VectorXd::Zero(static_cast<Eigen::Index>(plan.unknowns.size())));
    };
  });
  Identification found;
  found.is_stopped = model.is_stopped();
  if (found.is_stopped) return found;
  continue_from_best(model, fits.front(), ends);
  found.is_stopped = model.is_stopped();
  if (found.is_stopped) return found;
  const FitEnd& end = ends.front();
  const Eigen::VectorXd origin = Eigen::VectorXd::Zero(end.x.size());
  const Residuals before = model.at(origin);
  found.status = end.status;
  found.n_iterations = end.n_iterations;
  found.misfit_before = fits.front().data_squares(before);
  found.misfit_after = fits.front().data_squares(end.residuals);
  set_posterior(found, end, fits.front(), plan.unknowns);
  for (std::size_t k = 0; k < parts.size(); ++k) {
    found.trials.push_back({name_of_part(data, parts, k), parts[k].last - parts[k].first,
                            misfit_of(model, parts[k], before), misfit_of(model, parts[k], end.residuals),
                            misfit_of(model, parts[k], ends[k + 1].residuals)});
  }
  const std::vector<double> first = model.laxities_at(origin), last = model.laxities_at(end.x);
  for (std::size_t k = 0; k < data.laxities.size(); ++k)
    found.laxities.push_back({data.laxities[k], first[k], last[k]});
  return found;
}

}  // namespace vrda::analysis
