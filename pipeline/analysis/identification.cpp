#include "analysis/identification.hpp"

#include <algorithm>
#include <cmath>

#include "core/axis.hpp"
#include "core/parallel.hpp"
#include "core/text.hpp"
#include "core/units.hpp"
#include "job/job_parts.hpp"
#include "model/linear_algebra.hpp"
#include "solve/case_solver.hpp"
#include "solve/quadratic_program.hpp"

namespace vrda::analysis {
namespace {

constexpr double least_strain = -0.9, largest_strain = 1.0;  // as an uncertain strain

// Of an unknown at one of several angles: 1 there, 0 at the neighbours.
double hat(const Unknown& unknown, double flexion_rad)
{
  const std::vector<double>& nodes = unknown.all_flexions_rad;
  if (nodes.empty()) return 1.0;
  const double at = std::clamp(flexion_rad, nodes.front(), nodes.back());
  for (std::size_t k = 0; k + 1 < nodes.size(); ++k) {
    if (at < nodes[k] || at > nodes[k + 1]) continue;
    const double share = (at - nodes[k]) / (nodes[k + 1] - nodes[k]);
    if (unknown.flexion_rad == nodes[k]) return 1.0 - share;
    if (unknown.flexion_rad == nodes[k + 1]) return share;
  }
  return 0.0;
}

void add_load(const job::Job& job, const job::Case& job_case, std::size_t number, Unknown unknown,
              std::vector<Unknown>& all)
{
  const job::FitParameterJob& parameter = job.fit->parameters[number];
  unknown.load = core::value_named<job::InputLoad>(parameter.load).value();
  unknown.name += parameter.load;
  const std::string key = "fit.parameter." + std::to_string(number);
  if (unknown.follower &&
      job::load_n(job_case.followers.at(*unknown.follower), unknown.load) + parameter.from < 0.0)
    job.document.refuse(key + ".from", shortest_decimal(parameter.from),
                        "a change that leaves push.force_n above 0");
  if (parameter.flexion_deg.empty()) all.push_back(unknown);
  for (const double flexion_deg : parameter.flexion_deg)
    unknown.all_flexions_rad.push_back(rad_from_deg(flexion_deg));
  for (const double flexion_deg : parameter.flexion_deg) {
    Unknown at = unknown;
    at.name += " at " + shortest_decimal(flexion_deg);
    at.flexion_rad = rad_from_deg(flexion_deg);
    all.push_back(at);
  }
}

job::Push changed_push(job::Push push, const LoadChange& by)
{
  push.force_n += by.force_n;
  push.moment_nmm += by.moment_nmm;
  push.varus_moment_nmm += by.varus_moment_nmm;
  return push;
}

}  // namespace

const char* Unknown::unit() const
{
  if (quantity == job::InputQuantity::reference_strain) return "";
  if (quantity == job::InputQuantity::attachment) return "mm";
  return load == job::InputLoad::moment || load == job::InputLoad::varus_moment ? "N mm" : "N";
}

std::vector<Unknown> unknowns_of(const job::Job& job, const job::Case& job_case)
{
  std::vector<Unknown> all;
  for (std::size_t k = 0; k < job.fit->parameters.size(); ++k) {
    const job::FitParameterJob& parameter = job.fit->parameters[k];
    Unknown unknown;
    unknown.quantity = parameter.quantity;
    unknown.sd = parameter.sd;
    unknown.from = parameter.from;
    unknown.to = parameter.to;
    if (!parameter.follower.empty()) {
      const auto own = std::ranges::find(job_case.followers, parameter.follower, &job::Follower::name);
      unknown.follower = static_cast<std::size_t>(own - job_case.followers.begin());
      unknown.name = parameter.follower + ' ';
    }
    if (parameter.quantity == job::InputQuantity::load) {
      add_load(job, job_case, k, unknown, all);
      continue;
    }
    const bool is_strain = parameter.quantity == job::InputQuantity::reference_strain;
    if (!is_strain) {
      unknown.body = job::attached_body(job, parameter.body, "fit.parameter." + std::to_string(k) + ".body");
      unknown.axis = std::ranges::find(axis_names, parameter.axis) - axis_names.begin();
    }
    const model::Ligaments& ligaments = job::ligaments_of(job_case, unknown.follower);
    job::choose_fibres(job.document, "fit.parameter." + std::to_string(k), ligaments.fibres,
                       {parameter.fibre, parameter.bundle, parameter.body}, unknown);
    // One unknown for the fibres that share it, in the order of the fibres.
    std::vector<std::pair<std::string, Unknown>> groups;
    for (const std::size_t row : unknown.fibres) {
      const std::string& name = job::shared_name(ligaments.fibres[row], parameter.shared_by);
      auto at = std::ranges::find(groups, name, &std::pair<std::string, Unknown>::first);
      if (at == groups.end()) {
        at = groups.insert(groups.end(), {name, unknown});
        at->second.fibres.clear();
        at->second.name += is_strain ? "reference_strain " + name
                                     : "attachment " + parameter.body + ' ' + name + ' ' + parameter.axis;
      }
      at->second.fibres.push_back(row);
    }
    for (auto& [name, one] : groups) all.push_back(std::move(one));
  }
  return all;
}

double& component(LoadChange& change, job::InputLoad load)
{
  switch (load) {
    case job::InputLoad::anterior_force:
      return change.force_n.x();
    case job::InputLoad::force:
      return change.force_n.y();
    case job::InputLoad::right_force:
      return change.force_n.z();
    case job::InputLoad::moment:
      return change.moment_nmm;
    case job::InputLoad::varus_moment:
      return change.varus_moment_nmm;
    default:
      break;
  }
  throw InternalError("a follower's load is not the joint's");
}

LoadChange load_change_at(const std::vector<Unknown>& unknowns, const Eigen::VectorXd& change,
                          double flexion_rad)
{
  LoadChange loads;
  for (std::size_t k = 0; k < unknowns.size(); ++k) {
    if (unknowns[k].quantity == job::InputQuantity::load && !unknowns[k].follower)
      component(loads, unknowns[k].load) +=
          hat(unknowns[k], flexion_rad) * change(static_cast<Eigen::Index>(k));
  }
  return loads;
}

std::vector<double> reference_lengths_mm(const job::Case& job_case, const model::Ligaments& ligaments,
                                         std::optional<std::size_t> follower)
{
  std::vector<double> lengths_mm;
  if (!follower) {
    for (const model::FibreState& state : model::fibre_states(ligaments, {}, {}))
      lengths_mm.push_back(state.length_mm);
    return lengths_mm;
  }
  for (const double strain : job::scan_strains(job_case.followers, *follower, ligaments))
    lengths_mm.push_back((1.0 + strain) * ligaments.fibres[lengths_mm.size()].slack_length_mm);
  return lengths_mm;
}

model::Ligaments changed_ligaments(const job::Case& job_case, const std::vector<Unknown>& unknowns,
                                   const Eigen::VectorXd& change, std::optional<std::size_t> follower)
{
  const model::Ligaments& given = job::ligaments_of(job_case, follower);
  model::Ligaments ligaments = given;
  std::vector<double> strain_change(ligaments.fibres.size(), 0.0);
  std::vector<bool> is_changed(ligaments.fibres.size(), false);
  for (std::size_t k = 0; k < unknowns.size(); ++k) {
    if (unknowns[k].follower != follower) continue;
    const double by = change(static_cast<Eigen::Index>(k));
    for (const std::size_t row : unknowns[k].fibres) {
      is_changed[row] = is_changed[row] || by != 0.0;
      model::Fibre& fibre = ligaments.fibres[row];
      if (unknowns[k].quantity == job::InputQuantity::attachment) {
        (unknowns[k].body == fibre.to ? fibre.moving_mm : fibre.reference_mm)(unknowns[k].axis) += by;
      } else {
        strain_change[row] += by;
      }
    }
  }
  const std::vector<double> before_mm = reference_lengths_mm(job_case, given, follower);
  const std::vector<double> after_mm = reference_lengths_mm(job_case, ligaments, follower);
  for (std::size_t row = 0; row < before_mm.size(); ++row) {
    model::Fibre& fibre = ligaments.fibres[row];
    if (!is_changed[row] || fibre.tension_n > 0.0 || !(after_mm[row] > 0.0)) continue;
    const double strain = before_mm[row] / fibre.slack_length_mm - 1.0 + strain_change[row];
    fibre.slack_length_mm = after_mm[row] / (1.0 + std::clamp(strain, least_strain, largest_strain));
  }
  return ligaments;
}

job::Case changed_case(const job::Case& job_case, const std::vector<Unknown>& unknowns,
                       const Eigen::VectorXd& change)
{
  job::Case changed = job_case;
  changed.ligaments = changed_ligaments(job_case, unknowns, change);
  const auto change_rows = [&](std::vector<job::Push>& rows, const std::vector<double>& flexions_deg) {
    for (std::size_t k = 0; k < rows.size(); ++k) {
      rows[k] = changed_push(rows[k], load_change_at(unknowns, change, rad_from_deg(flexions_deg[k])));
    }
  };
  change_rows(changed.push, changed.grid.flexion_deg);
  change_rows(changed.path_push, changed.path_flexion_deg);
  for (std::size_t row = 0; row < changed.followers.size(); ++row)
    changed.followers[row].ligaments = changed_ligaments(job_case, unknowns, change, row);
  for (std::size_t k = 0; k < unknowns.size(); ++k) {
    if (!unknowns[k].follower || unknowns[k].quantity != job::InputQuantity::load) continue;
    job::Follower& follower = changed.followers[*unknowns[k].follower];
    job::set_load(follower, unknowns[k].load,
                  job::load_n(follower, unknowns[k].load) + change(static_cast<Eigen::Index>(k)));
  }
  return changed;
}

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

Misfit misfit_of(const ModelEvaluation& model, const DataPart& part, const Residuals& residuals,
                 std::optional<std::size_t> follower)
{
  Misfit rms;
  rms.fill(nan);
  for (std::size_t c = 0; c < n_scored; ++c) {
    double sum = 0.0;
    int n = 0;
    for (std::size_t k = 0; k < model.rows().size(); ++k) {
      const ModelEvaluation::Row& row = model.rows()[k];
      const double residual = residuals(static_cast<Eigen::Index>(k));
      if (!part.contains(row) || row.follower != follower || row.coordinate != c || !std::isfinite(residual))
        continue;
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
    return inverse_of_definite(precision);
  };
  // Of the data, less the numbers that they determine.
  const double n_fitted = static_cast<double>(n) - posterior(1.0).trace();
  const double n_free = std::max(1.0, fit.n_independent(end.residuals) - n_fitted);
  found.noise_scale = std::max(1.0, std::sqrt(fit.data_squares(end.residuals) / n_free));
  const Eigen::MatrixXd C = posterior(found.noise_scale);
  const Eigen::VectorXd variances = eigenvalues(C);
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
    const auto misfit = [&](std::optional<std::size_t> follower) {
      return BodyMisfit{misfit_of(model, parts[k], before, follower),
                        misfit_of(model, parts[k], end.residuals, follower),
                        misfit_of(model, parts[k], ends[k + 1].residuals, follower)};
    };
    TrialMisfit trial{name_of_part(data, parts, k), parts[k].last - parts[k].first, misfit({}), {}};
    for (std::size_t f = 0; f < data.motion->followers.size(); ++f) {
      if (model.is_measured(parts[k].trial, f))
        trial.followers.emplace_back(data.motion->followers[f].name, misfit(f));
    }
    found.trials.push_back(std::move(trial));
  }
  const std::vector<double> first = model.laxities_at(origin), last = model.laxities_at(end.x);
  for (std::size_t k = 0; k < data.laxities.size(); ++k)
    found.laxities.push_back({data.laxities[k], first[k], last[k]});
  return found;
}

namespace {

// Kinds of evaluations. The values are those of the journal.
enum EvaluationKind : std::int8_t { whole_spine, near_spine, whole_laxity, near_laxity };

// A pose that moves farther by a difference is another equilibrium.
constexpr double same_branch_mm = 5.0, same_branch_rad = rad_from_deg(15.0);
constexpr double rounding_rad = 1e-9;
constexpr std::size_t n_pose_values = 6;  // status, translation, theta, varus

std::vector<double> numbers_of(const Eigen::VectorXd& x)
{
  return {x.data(), x.data() + x.size()};
}

std::vector<double> joined(const Eigen::VectorXd& a, const Eigen::VectorXd& b)
{
  std::vector<double> all = numbers_of(a);
  all.insert(all.end(), b.data(), b.data() + b.size());
  return all;
}

void append_pose(std::vector<double>& values, const StepRecord& record)
{
  values.push_back(static_cast<double>(record.status));
  for (Eigen::Index k = 0; k < 3; ++k) values.push_back(record.pose.translation_mm(k));
  values.push_back(record.pose.theta_rad);
  values.push_back(record.varus_rad);
}

constexpr std::size_t n_follower_values = 1 + n_joint_coordinates;  // status, coordinates; behind all poses

void append_follower(std::vector<double>& values, const job::Case& job_case, std::size_t follower,
                     const StepRecord& record)
{
  const job::Follower& own = job_case.followers.at(follower);
  values.push_back(static_cast<double>(record.status));
  JointCoordinates q = JointCoordinates::Constant(nan);
  if (record.status == StepStatus::stable)
    q = follower_coordinates(solve::follower_pose_of(solve::follower_frame(job_case, own), record),
                             job_case.frame.side, own.centre_mm);
  values.insert(values.end(), q.begin(), q.end());
}

StepStatus status_of(const double* follower_values)
{
  return static_cast<StepStatus>(static_cast<std::int8_t>(follower_values[0]));
}

StepRecord record_at(const std::vector<double>& values, std::size_t row)
{
  const double* v = values.data() + n_pose_values * row;
  StepRecord record;
  record.status = static_cast<StepStatus>(static_cast<std::int8_t>(v[0]));
  record.pose = {{v[1], v[2], v[3]}, v[4]};
  record.varus_rad = v[5];
  return record;
}

// Of a follower's coordinates.
bool is_same_branch(const JointCoordinates& a, const JointCoordinates& b)
{
  return (a - b).head<3>().cwiseAbs().maxCoeff() <= same_branch_rad &&
         (a - b).tail<3>().norm() <= same_branch_mm;
}

bool is_same_branch(const StepRecord& a, const StepRecord& b)
{
  return (a.pose.translation_mm - b.pose.translation_mm).norm() <= same_branch_mm &&
         std::abs(a.pose.theta_rad - b.pose.theta_rad) <= same_branch_rad &&
         std::abs(a.varus_rad - b.varus_rad) <= same_branch_rad;
}

}  // namespace

ModelEvaluation::ModelEvaluation(const FitData& data, const IdentifyPlan& plan)
    : data_(data), plan_(plan), surfaces_(data.motion == nullptr ? 0 : data.motion->followers.size())
{
  const job::Case& of = data.motion != nullptr ? *data.motion : *data.laxity;
  joint_ = std::make_shared<const solve::Joint>(solve::joint_of(of, of.frame));
  for (const Evaluation& known : plan.known) known_.emplace(Key{known.kind, known.at}, known.values);
  add_rows();
  if (data.motion == nullptr) return;
  std::vector<double> flexions_rad;
  for (const double flexion_deg : data.motion->grid.flexion_deg)
    flexions_rad.push_back(rad_from_deg(flexion_deg));
  is_needed_.assign(flexions_rad.size(), false);
  for (const Row& row : rows_) {
    if (row.trial == data.trials.size()) continue;
    const double at_rad = data.trials[row.trial].rows[row.row].value[at_flexion];
    // At a flexion of the grid, rounding of the solved poses decides which neighbour is interpolated.
    for (const double near_rad : {at_rad - rounding_rad, at_rad + rounding_rad}) {
      const auto after =
          std::lower_bound(flexions_rad.begin(), flexions_rad.end(), near_rad) - flexions_rad.begin();
      const std::size_t high = std::min(static_cast<std::size_t>(after), flexions_rad.size() - 1);
      is_needed_[high] = is_needed_[high > 0 ? high - 1 : 0] = true;
    }
  }
}

bool ModelEvaluation::is_measured(std::size_t trial, std::size_t follower) const
{
  return trial < data_.followers.size() && !data_.followers[trial].at(follower).empty();
}

void ModelEvaluation::add_follower_rows(std::size_t trial, std::size_t row, double weight)
{
  for (std::size_t f = 0; f < data_.motion->followers.size(); ++f) {
    const auto noise = plan_.fit.follower_noise.find(data_.motion->followers[f].name);
    if (noise == plan_.fit.follower_noise.end() || !is_measured(trial, f)) continue;
    for (std::size_t c = 0; c < n_joint_coordinates; ++c) {
      if (!std::isfinite(noise->second[c])) continue;
      rows_.push_back({trial, row, c, weight, noise->second[c], f});
      has_followers_ = true;
    }
  }
}

void ModelEvaluation::add_rows()
{
  const double independent_rad = rad_from_deg(plan_.fit.independent_deg);
  for (std::size_t t = 0; t < data_.trials.size(); ++t) {
    const std::vector<analysis::Row>& rows = data_.trials[t].rows;
    for (std::size_t r = 0; r < rows.size(); ++r) {
      if (!rows[r].missing.empty()) continue;
      const auto n_near = std::count_if(rows.begin(), rows.end(), [&](const analysis::Row& other) {
        return other.missing.empty() &&
               std::abs(other.value[at_flexion] - rows[r].value[at_flexion]) <= 0.5 * independent_rad;
      });
      for (std::size_t c = 1; c < n_scored; ++c) {
        if (rows[r].is_determined[c] && std::isfinite(plan_.fit.noise[c]))
          rows_.push_back({t, r, c, 1.0 / static_cast<double>(n_near), plan_.fit.noise[c]});
      }
      add_follower_rows(t, r, 1.0 / static_cast<double>(n_near));
    }
  }
  for (std::size_t r = 0; r < data_.laxities.size(); ++r) {
    const PublishedValue& row = data_.laxities[r];
    double noise = row.sd;
    for (std::size_t k = 0; k < n_laxity_tests && std::isnan(noise); ++k) {
      const TestKind& kind = kind_of(static_cast<LaxityTest>(k));
      if (row.test == kind.name || row.test == kind.both)
        noise = in_file_unit(kind, plan_.fit.noise[static_cast<std::size_t>(kind.coordinate)]);
    }
    if (std::isfinite(noise)) rows_.push_back({data_.trials.size(), r, 0, 1.0, noise});
  }
}

Eigen::VectorXd ModelEvaluation::change(const Eigen::VectorXd& x) const
{
  Eigen::VectorXd changes = x;
  for (Eigen::Index k = 0; k < x.size(); ++k) changes(k) *= plan_.unknowns[static_cast<std::size_t>(k)].sd;
  return changes;
}

std::vector<double> ModelEvaluation::recalled(const Key& key,
                                              const std::function<std::vector<double>()>& compute)
{
  {
    const std::scoped_lock lock(mutex_);
    const auto found = known_.find(key);
    if (found != known_.end()) return found->second;
  }
  if (is_stopped()) return {};
  const std::vector<double> values = compute();
  if (is_stopped()) return {};
  const std::scoped_lock lock(mutex_);
  // Another fit may have solved the same meanwhile, with the same result.
  if (known_.emplace(key, values).second && plan_.keep) plan_.keep({key.first, key.second, values});
  if (plan_.on_progress) plan_.on_progress();
  return values;
}

std::vector<double> ModelEvaluation::spine_poses(const Eigen::VectorXd& x)
{
  return recalled({whole_spine, numbers_of(x)}, [&] {
    const job::Case changed = changed_case(*data_.motion, plan_.unknowns, change(x));
    solve::SweepPlan plan = solve::plan_of(changed);
    plan.has_band = false;
    if (!has_followers_) plan.follow = nullptr;
    plan.prior.clear();  // fitted are bones and fibres
    solve::CaseSolver solver(changed, 1, joint_);
    solve::SweepHooks hooks;
    hooks.is_stopped = plan_.is_stopped;
    const solve::SweepResult swept = solve::sweep(
        plan, [&](const solve::StepTask& task) { return solver(task); }, hooks, 1);
    std::vector<double> values;
    const std::size_t n = swept.free_spine.size();
    // A reaction moves the cells.
    const bool is_followed = has_followers_ && !is_stopped();
    check(!is_followed || swept.followers.size() == n, "a sweep that ended has its followers");
    for (std::size_t k = 0; k < n; ++k)
      append_pose(values, is_followed ? swept.cells[k] : swept.free_spine[k].chosen);
    for (std::size_t k = 0; k < n && is_followed; ++k) {
      for (std::size_t f = 0; f < changed.followers.size(); ++f)
        append_follower(values, changed, f, swept.followers[k][f]);
    }
    return values;
  });
}

const double* ModelEvaluation::follower_values(const std::vector<double>& poses, std::size_t flexion,
                                               std::size_t follower) const
{
  const std::size_t n_flexions = data_.motion->grid.flexion_deg.size();
  return poses.data() + n_pose_values * n_flexions +
         n_follower_values * (flexion * data_.motion->followers.size() + follower);
}

void ModelEvaluation::append_near_followers(std::vector<double>& values, const job::Case& changed,
                                            const StepRecord& cell, const std::vector<double>& from)
{
  const auto i = static_cast<std::size_t>(cell.key.flexion);
  model::BodyPoses placed{Pose::Identity()};
  if (cell.status == StepStatus::stable) placed.push_back(solve::joint_pose_of(changed, cell));
  for (std::size_t f = 0; f < changed.followers.size(); ++f) {
    const job::Follower& follower = changed.followers[f];
    const double* seed = follower_values(from, i, f);
    const JointCoordinates q_seed = Eigen::Map<const JointCoordinates>(seed + 1);
    StepRecord record;
    if (placed.size() == 2 + f && status_of(seed) == StepStatus::stable)
      record = solve::FollowerSolver(changed, f, surfaces_[f])
                   .solve(placed, {follower_pose(q_seed, changed.frame.side, follower.centre_mm)});
    append_follower(values, changed, f, record);
    double* found = values.data() + values.size() - n_follower_values;
    if (record.status != StepStatus::stable) continue;
    const JointCoordinates q = Eigen::Map<const JointCoordinates>(found + 1);
    if (!is_same_branch(q_seed, q)) {
      found[0] = static_cast<double>(StepStatus::iteration_limit);
    } else {
      placed.push_back(placed.at(model::row_of(follower.of)) *
                       follower_pose(q, changed.frame.side, follower.centre_mm));
    }
  }
}

std::vector<double> ModelEvaluation::near_poses(const Eigen::VectorXd& base, const Eigen::VectorXd& x)
{
  // Joint and followers that react are solved in turn, which the spine does.
  if (has_followers_ && std::ranges::any_of(data_.motion->followers, &job::Follower::has_reaction))
    return spine_poses(x);
  const std::vector<double> from = spine_poses(base);
  return recalled({near_spine, joined(base, x)}, [&] {
    const job::Case changed = changed_case(*data_.motion, plan_.unknowns, change(x));
    const model::Ligaments ligaments = model::solver_ligaments(changed.ligaments, changed.frame);
    solve::EquilibriumSolver solver(*joint_, ligaments, changed.equilibrium);
    std::vector<double> values, of_followers;
    for (std::size_t k = 0; k < changed.push.size() && !from.empty(); ++k) {
      const StepRecord seed = record_at(from, k);
      solve::EquilibriumSolver::Task task;
      task.attitude = {rad_from_deg(changed.grid.flexion_deg[k]), seed.varus_rad};
      task.seed = seed.pose;
      task.loads = solve::loads_of(changed, changed.push[k]);
      task.is_varus_free = true;
      task.is_measured = false;
      StepRecord record = seed;
      if (!is_needed_[k]) record.status = StepStatus::pending;
      if (record.status == StepStatus::stable) record = solver.solve(task);
      if (record.status == StepStatus::stable && !is_same_branch(seed, record))
        record.status = StepStatus::iteration_limit;
      append_pose(values, record);
      if (!has_followers_) continue;
      record.key.flexion = static_cast<std::int32_t>(k);
      append_near_followers(of_followers, changed, record, from);
    }
    values.insert(values.end(), of_followers.begin(), of_followers.end());
    return values;
  });
}

std::vector<double> ModelEvaluation::solved_laxities(const Eigen::VectorXd& x,
                                                     const std::vector<StepRecord>& unloaded)
{
  LaxityPlan plan;
  plan.loads = data_.loads;
  plan.unloaded = unloaded;
  plan.joint = joint_;
  plan.is_stopped = plan_.is_stopped;
  const job::Case changed = changed_case(*data_.laxity, plan_.unknowns, change(x));
  const LaxityResult result = laxity_of(changed, plan);
  std::vector<double> values;
  for (const Compared& row : compared(result, data_.laxities)) values.push_back(row.found);
  for (const StepRecord& record : result.unloaded) append_pose(values, record);
  return values;
}

// Of each row, then the unloaded poses: from those of the motion, or by a spine of their own.
std::vector<double> ModelEvaluation::laxity_values(const Eigen::VectorXd& x)
{
  return recalled({whole_laxity, numbers_of(x)}, [&] {
    if (data_.motion == nullptr) return solved_laxities(x, {});
    const std::vector<double> poses = spine_poses(x);
    if (poses.empty()) return std::vector<double>{};
    const std::vector<double>& solved_deg = data_.motion->grid.flexion_deg;
    std::vector<StepRecord> unloaded;
    for (const double flexion_deg : data_.loads.flexion_deg) {
      const auto at = std::ranges::find(solved_deg, flexion_deg);
      check(at != solved_deg.end(), "a fit solves the motion at the flexions of the loads");
      unloaded.push_back(record_at(poses, static_cast<std::size_t>(at - solved_deg.begin())));
    }
    return solved_laxities(x, unloaded);
  });
}

std::vector<double> ModelEvaluation::near_laxity_values(const Eigen::VectorXd& base, const Eigen::VectorXd& x)
{
  const std::vector<double> from = laxity_values(base);
  return recalled({near_laxity, joined(base, x)}, [&] {
    if (from.empty()) return std::vector<double>{};
    const std::vector<double> poses(from.begin() + static_cast<std::ptrdiff_t>(data_.laxities.size()),
                                    from.end());
    std::vector<StepRecord> unloaded;
    for (std::size_t k = 0; k < data_.loads.flexion_deg.size(); ++k) unloaded.push_back(record_at(poses, k));
    return solved_laxities(x, unloaded);
  });
}

double ModelEvaluation::follower_difference(const std::vector<double>& poses, const Row& row) const
{
  const std::vector<double>& flexions_deg = data_.motion->grid.flexion_deg;
  const auto [at, share] =
      position_on(flexions_deg, deg_from_rad(data_.trials[row.trial].rows[row.row].value[at_flexion]));
  double value = 0.0;
  for (std::size_t end = 0; end < (share > 0.0 ? 2 : 1); ++end) {
    const double* found = follower_values(poses, at + end, *row.follower);
    if (status_of(found) != StepStatus::stable) return nan;
    value += (end == 0 ? 1.0 - share : share) * found[1 + row.coordinate];
  }
  return value -
         data_.followers[row.trial][*row.follower][row.row](static_cast<Eigen::Index>(row.coordinate));
}

Residuals ModelEvaluation::residuals(const std::vector<double>& poses,
                                     const std::vector<double>& laxities) const
{
  Residuals all = Residuals::Constant(static_cast<Eigen::Index>(rows_.size()), nan);
  std::vector<std::vector<analysis::Row>> found;
  if (data_.motion != nullptr && !poses.empty()) {
    const job::Case& job_case = *data_.motion;
    std::vector<Pose> X;
    for (std::size_t k = 0; k < job_case.grid.flexion_deg.size(); ++k) {
      const StepRecord record = record_at(poses, k);
      X.push_back(X_reference_moving(
          job_case.frame, {rad_from_deg(job_case.grid.flexion_deg[k]), record.varus_rad}, record.pose));
    }
    Sequence model =
        sequence_of(job_case.title, "flexion_deg", job_case.grid.flexion_deg, X, data_.convention);
    for (std::size_t k = 0; k < model.rows.size(); ++k) {
      const StepStatus status = record_at(poses, k).status;
      if (status != StepStatus::stable) model.rows[k].missing = name_of(status);
    }
    for (const Sequence& trial : data_.trials) found.push_back(rows_over_flexion(model, trial, true));
  }
  for (std::size_t k = 0; k < rows_.size(); ++k) {
    const Row& row = rows_[k];
    double difference = nan;
    if (row.follower) {
      if (!poses.empty()) difference = follower_difference(poses, row);
    } else if (row.trial == data_.trials.size()) {
      if (!laxities.empty()) difference = laxities[row.row] - data_.laxities[row.row].value;
    } else if (!found.empty() && found[row.trial][row.row].missing.empty()) {
      difference = found[row.trial][row.row].value[row.coordinate] -
                   data_.trials[row.trial].rows[row.row].value[row.coordinate];
    }
    all(static_cast<Eigen::Index>(k)) = difference / row.noise;
  }
  return all;
}

Residuals ModelEvaluation::at(const Eigen::VectorXd& x)
{
  return residuals(data_.motion == nullptr ? std::vector<double>{} : spine_poses(x),
                   data_.laxity == nullptr ? std::vector<double>{} : laxity_values(x));
}

Residuals ModelEvaluation::near(const Eigen::VectorXd& base, const Eigen::VectorXd& x)
{
  return residuals(data_.motion == nullptr ? std::vector<double>{} : near_poses(base, x),
                   data_.laxity == nullptr ? std::vector<double>{} : near_laxity_values(base, x));
}

std::vector<double> ModelEvaluation::laxities_at(const Eigen::VectorXd& x)
{
  std::vector<double> values;
  if (data_.laxity != nullptr) values = laxity_values(x);
  values.resize(data_.laxities.size(), nan);
  return values;
}

Eigen::MatrixXd ModelEvaluation::derivatives(const Eigen::VectorXd& x, double length)
{
  const Residuals middle = near(x, x);
  Eigen::MatrixXd J = Eigen::MatrixXd::Zero(middle.size(), x.size());
  for (Eigen::Index c = 0; c < x.size(); ++c) {
    const Unknown& unknown = plan_.unknowns[static_cast<std::size_t>(c)];
    Eigen::VectorXd low = x, high = x;
    low(c) = std::max(unknown.from / unknown.sd, x(c) - length);
    high(c) = std::min(unknown.to / unknown.sd, x(c) + length);
    const Residuals below = near(x, low), above = near(x, high);
    for (Eigen::Index r = 0; r < middle.size(); ++r) {
      // One side where the other has no pose nearby.
      const bool has_low = std::isfinite(below(r)), has_high = std::isfinite(above(r));
      const double from = has_low ? below(r) : middle(r), to = has_high ? above(r) : middle(r);
      const double step = (has_high ? high(c) : x(c)) - (has_low ? low(c) : x(c));
      if (step > 0.0 && std::isfinite(from) && std::isfinite(to)) J(r, c) = (to - from) / step;
    }
  }
  return J;
}

}  // namespace vrda::analysis
