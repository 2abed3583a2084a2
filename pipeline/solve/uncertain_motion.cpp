// From the solved samples of an uncertain job to bands and shares of the spread.
#include "solve/case_solver.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/text.hpp"
#include "core/units.hpp"
#include "job/sampled_case.hpp"
#include "model/coordinates.hpp"
#include "solve/followers.hpp"
#include "solve/prior.hpp"

namespace vrda::solve {
namespace {

class UncertainAssembly {
 public:
  UncertainAssembly(const job::Case& job_case, const std::vector<StepRecord>& records)
      : case_(job_case),
        records_(records),
        samples_(job_case),
        n_samples_(static_cast<std::size_t>(samples_.n_samples())),
        n_flexion_(job_case.grid.flexion_deg.size()),
        n_fibres_(job_case.ligaments.fibres.size())
  {
    const job::Uncertainty& uncertainty = *job_case.uncertainty;
    motion_.sequence = uncertainty.sequence == job::SampleSequence::sobol ? "sobol" : "latin-hypercube";
    motion_.seed = static_cast<std::int32_t>(uncertainty.seed);
    motion_.draw = samples_.draw_names();
    motion_.probability.assign(store::band_probabilities.begin(), store::band_probabilities.end());
    motion_.quantity.assign(store::uncertain_quantities.begin(), store::uncertain_quantities.end());
    const Eigen::MatrixXd& values = samples_.values();
    for (Eigen::Index s = 0; s < values.rows(); ++s) {
      for (Eigen::Index d = 0; d < values.cols(); ++d) motion_.value.push_back(values(s, d));
    }
  }

  store::UncertainMotion assembled()
  {
    add_samples();
    add_bands(motion_);
    motion_.contact_force_band_n = band_of(motion_.contact_force_n, 3);
    add_tensions();
    add_quantile_motions();
    const std::size_t n_forces = case_.compartment_of_triangle.empty() ? 1 : 3;
    add_shares(motion_, columns_of_kinds(), 2 * 3 + n_forces);
    for (store::UncertainFollower& follower : motion_.followers) {
      add_bands(follower);
      add_shares(follower, {&follower.rotation_deg, &follower.translation_mm}, n_joint_coordinates);
    }
    std::sort(motion_.followers.begin(), motion_.followers.end(),
              [](const auto& a, const auto& b) { return a.name < b.name; });
    return std::move(motion_);
  }

 private:
  std::vector<std::vector<double>*> columns_of_kinds()
  {
    return {&motion_.rotation_deg, &motion_.translation_mm, &motion_.contact_force_n};
  }

  void add_samples()
  {
    motion_.contact_force_n.assign(n_samples_ * n_flexion_ * 3, nan);
    prepare(motion_);
    for (const job::Follower& follower : case_.followers) {
      motion_.followers.push_back({{follower.name}, {}});
      prepare(motion_.followers.back());
    }
    samples_motion_.resize(n_samples_ * n_flexion_);
    tension_n_.assign(n_samples_ * n_flexion_ * n_fibres_, nan);
    std::vector<const StepRecord*> ordered;
    for (const StepRecord& record : records_) {
      if (record.key.kind == StepKind::sample) ordered.push_back(&record);
      if (record.key.kind == StepKind::sample_follower) add_follower(record);
    }
    std::sort(ordered.begin(), ordered.end(), [](const StepRecord* a, const StepRecord* b) {
      return std::pair(a->key.varus, a->key.flexion) < std::pair(b->key.varus, b->key.flexion);
    });
    for (const StepRecord* record : ordered) add_sample(*record);
    check_solved(motion_);
    for (const store::UncertainFollower& follower : motion_.followers) check_solved(follower);
  }

  void prepare(store::UncertainPose& of) const
  {
    of.status.assign(n_samples_ * n_flexion_, status_pending);
    of.n_solved.assign(n_flexion_, 0);
    of.rotation_deg.assign(n_samples_ * n_flexion_ * 3, nan);
    of.translation_mm = of.rotation_deg;
  }

  static void check_solved(const store::UncertainPose& of)
  {
    check(std::none_of(of.status.begin(), of.status.end(),
                       [](std::int8_t status) { return status == status_pending; }),
          "every sample is solved");
  }

  void add_follower(const StepRecord& r)
  {
    const auto flexion = static_cast<std::size_t>(r.key.flexion);
    const auto row = static_cast<std::size_t>(r.key.varus % most_in_step);
    const std::size_t at = static_cast<std::size_t>(r.key.varus / most_in_step) * n_flexion_ + flexion;
    store::UncertainFollower& of = motion_.followers.at(row);
    of.status.at(at) = static_cast<std::int8_t>(r.status);
    if (r.status != StepStatus::stable) return;
    ++of.n_solved[flexion];
    const job::Follower& follower = case_.followers[row];
    set(of, at,
        in_files(follower_coordinates(follower_pose_of(follower_frame(case_, follower), r), case_.frame.side,
                                      follower.centre_mm)));
  }

  void add_sample(const StepRecord& r)
  {
    const auto flexion = static_cast<std::size_t>(r.key.flexion);
    const std::size_t at = static_cast<std::size_t>(r.key.varus) * n_flexion_ + flexion;
    motion_.status.at(at) = static_cast<std::int8_t>(r.status);
    if (r.status != StepStatus::stable) return;
    ++motion_.n_solved[flexion];
    if (r.key.varus != sample_) {
      sample_ = r.key.varus;
      ligaments_ = samples_.ligaments_at(sample_);
      centre_mm_ = samples_.rotation_centre_mm_at(sample_);
    }
    SolverFrame frame = frame_of(case_, case_.push.at(flexion));
    frame.rotation_centre_mm = centre_mm_;
    const Attitude attitude{
        r.coordinates ? r.coordinates->flexion_rad : rad_from_deg(case_.grid.flexion_deg[flexion]),
        r.varus_rad};
    set(motion_, at,
        in_files(clinical_coordinates(X_reference_moving(frame, attitude, r.pose), frame.side,
                                      case_.frame.rotation_centre_mm)));
    add_forces(r, at);
    add_world(r, at, attitude, frame);
    if (n_fibres_ == 0) return;
    const auto states = model::fibre_states(model::solver_ligaments(ligaments_, frame), attitude, r.pose);
    for (std::size_t k = 0; k < n_fibres_; ++k) tension_n_[at * n_fibres_ + k] = states[k].force_n;
  }

  static void set(store::UncertainPose& of, std::size_t at, const OfCoordinates<double>& numbers)
  {
    for (std::size_t k = 0; k < numbers.size(); ++k)
      (is_rotation(k) ? of.rotation_deg : of.translation_mm)[3 * at + k % 3] = numbers[k];
  }

  void add_forces(const StepRecord& r, std::size_t at)
  {
    std::array<Eigen::Vector3d, 3> sum_n;  // all, medial, lateral
    sum_n.fill(Eigen::Vector3d::Zero());
    for (const ContactForce& f : r.balance.forces) {
      const Eigen::Vector3d force_n = f.along_delta_n * f.normal_solver / -f.normal_solver.y();
      sum_n[0] += force_n;
      if (f.compartment > 0) sum_n[static_cast<std::size_t>(f.compartment)] += force_n;
    }
    const bool has_compartments = !case_.compartment_of_triangle.empty();
    for (std::size_t k = 0; k < sum_n.size(); ++k)
      motion_.contact_force_n[3 * at + k] = k == 0 || has_compartments ? sum_n[k].norm() : nan;
  }

  // In the frame of the job, whose rotation centre may differ from that of the sample's `frame`.
  void add_world(const StepRecord& r, std::size_t at, const Attitude& attitude, const SolverFrame& frame)
  {
    MovingPose pose = r.pose;
    SolverFrame of_job = frame;
    of_job.rotation_centre_mm = case_.frame.rotation_centre_mm;
    if (of_job.rotation_centre_mm != frame.rotation_centre_mm) {
      // The translation of the relative pose is linear in that of the moving object.
      const auto relative_mm = [&](const SolverFrame& in, const MovingPose& of) -> Eigen::Vector3d {
        return X_reference_moving(in, attitude, of).translation();
      };
      Eigen::Matrix3d slope;
      for (int k = 0; k < 3; ++k) {
        MovingPose shifted = pose;
        shifted.translation_mm += Eigen::Vector3d::Unit(k);
        slope.col(k) = relative_mm(of_job, shifted) - relative_mm(of_job, pose);
      }
      pose.translation_mm += slope.inverse() * (relative_mm(frame, r.pose) - relative_mm(of_job, pose));
    }
    samples_motion_.set(at, world_translation_mm(of_job, pose), deg_from_rad(pose.theta_rad),
                        deg_from_rad(r.varus_rad));
  }

  // Samples that are solved at most flexions, by increasing internal rotation.
  std::vector<std::size_t> ordered_samples() const
  {
    constexpr std::size_t internal = 2, median = 2;
    std::vector<std::size_t> n_solved(n_samples_, 0);
    std::vector<double> rotation_deg(n_samples_, 0.0);
    for (std::size_t s = 0; s < n_samples_; ++s) {
      for (std::size_t i = 0; i < n_flexion_; ++i) {
        const std::size_t at = s * n_flexion_ + i;
        if (motion_.status[at] != status_stable) continue;
        ++n_solved[s];
        rotation_deg[s] += motion_.rotation_deg[3 * at + internal] -
                           motion_.rotation_band_deg[3 * (median * n_flexion_ + i) + internal];
      }
    }
    const std::size_t most = *std::max_element(n_solved.begin(), n_solved.end());
    std::vector<std::size_t> order;
    for (std::size_t s = 0; s < n_samples_; ++s)
      if (n_solved[s] == most) order.push_back(s);
    std::stable_sort(order.begin(), order.end(),
                     [&](std::size_t a, std::size_t b) { return rotation_deg[a] < rotation_deg[b]; });
    return order;
  }

  void add_quantile_motions()
  {
    const std::vector<std::size_t> order = ordered_samples();
    for (const double probability : store::band_probabilities) {
      const double at = std::round(probability * static_cast<double>(order.size() - 1));
      const std::size_t first = order[static_cast<std::size_t>(at)] * n_flexion_;
      motion_.quantile_sample.push_back(static_cast<std::int32_t>(order[static_cast<std::size_t>(at)]));
      const auto from_row = [&](auto& to, const auto& from) {
        to.insert(to.end(), from.begin() + static_cast<std::ptrdiff_t>(first),
                  from.begin() + static_cast<std::ptrdiff_t>(first + n_flexion_));
      };
      from_row(motion_.quantile_status, motion_.status);
      const auto to = store::PoseRows::columns_of(motion_);
      const auto from = store::PoseRows::columns_of(samples_motion_);
      for (std::size_t k = 0; k < to.size(); ++k) from_row(*to[k], *from[k]);
    }
  }

  // [n_probabilities, n_flexion, n] quantiles over the samples of [n_samples, n_flexion, n].
  std::vector<double> band_of(const std::vector<double>& rows, std::size_t n) const
  {
    std::vector<double> band(store::band_probabilities.size() * n_flexion_ * n);
    std::vector<double> values(n_samples_);
    for (std::size_t at = 0; at < n_flexion_ * n; ++at) {
      for (std::size_t s = 0; s < n_samples_; ++s) values[s] = rows[s * n_flexion_ * n + at];
      for (std::size_t q = 0; q < store::band_probabilities.size(); ++q)
        band[q * n_flexion_ * n + at] = job::quantile(values, store::band_probabilities[q]);
    }
    return band;
  }

  void add_bands(store::UncertainPose& of) const
  {
    of.rotation_band_deg = band_of(of.rotation_deg, 3);
    of.translation_band_mm = band_of(of.translation_mm, 3);
  }

  void add_tensions()
  {
    if (n_fibres_ > 0) motion_.tension_band_n = band_of(tension_n_, n_fibres_);
  }

  // [n_samples, 3 * columns] results at a flexion.
  Eigen::MatrixXd results_at(const std::vector<std::vector<double>*>& columns, std::size_t flexion) const
  {
    Eigen::MatrixXd results(static_cast<Eigen::Index>(n_samples_),
                            static_cast<Eigen::Index>(3 * columns.size()));
    for (std::size_t s = 0; s < n_samples_; ++s) {
      for (std::size_t k = 0; k < 3 * columns.size(); ++k)
        results(static_cast<Eigen::Index>(s), static_cast<Eigen::Index>(k)) =
            (*columns[k / 3])[3 * (s * n_flexion_ + flexion) + k % 3];
    }
    return results;
  }

  // Of the quantities in `columns`, of which the first `n_used` have numbers.
  void add_shares(store::UncertainPose& of, const std::vector<std::vector<double>*>& columns,
                  std::size_t n_used) const
  {
    const std::vector<int> group = job::jackknife_groups(n_samples_, case_.uncertainty->seed);
    const std::size_t n_draws = motion_.draw.size(), n_quantities = 3 * columns.size();
    for (std::vector<double>* table :
         {&of.rank_correlation, &of.first_order, &of.first_order_low, &of.first_order_high})
      table->resize(n_flexion_ * n_quantities * n_draws);
    for (std::size_t i = 0; i < n_flexion_; ++i) {
      const Eigen::MatrixXd results = results_at(columns, i);
      for (std::size_t d = 0; d < n_draws; ++d) {
        const Eigen::VectorXd scores = samples_.scores().col(static_cast<Eigen::Index>(d));
        std::vector<job::FirstOrderIndex> indices =
            job::first_order_indices(scores, results.leftCols(static_cast<Eigen::Index>(n_used)), group);
        indices.resize(n_quantities, {nan, nan, nan});
        for (std::size_t k = 0; k < n_quantities; ++k) {
          const std::size_t at = (i * n_quantities + k) * n_draws + d;
          const auto column = results.col(static_cast<Eigen::Index>(k));
          of.rank_correlation[at] =
              std::isnan(indices[k].index)
                  ? nan
                  : job::rank_correlation({scores.data(), n_samples_}, {column.data(), n_samples_});
          of.first_order[at] = indices[k].index;
          of.first_order_low[at] = indices[k].low;
          of.first_order_high[at] = indices[k].high;
        }
      }
    }
  }

  const job::Case& case_;
  const std::vector<StepRecord>& records_;
  const job::SampledCase samples_;
  const std::size_t n_samples_, n_flexion_, n_fibres_;
  store::UncertainMotion motion_;
  store::PoseRows samples_motion_;  // [n_samples, n_flexion]
  std::vector<double> tension_n_;   // [n_samples, n_flexion, n_fibres]
  int sample_ = -1;                 // of the next two
  model::Ligaments ligaments_;
  Eigen::Vector3d centre_mm_ = Eigen::Vector3d::Zero();
};

}  // namespace

store::UncertainMotion uncertain_motion_of(const job::Case& job_case, const std::vector<StepRecord>& records)
{
  return UncertainAssembly(job_case, records).assembled();
}

namespace {

constexpr const char* units[] = {"degree", "mm", "N"};

bool has_number(const BandQuantity& quantity)
{
  for (std::size_t at = quantity.row % 3; at < quantity.samples->size(); at += 3) {
    if (std::isfinite((*quantity.samples)[at])) return true;
  }
  return false;
}

}  // namespace

std::vector<BandQuantity> quantities_of(const store::UncertainMotion& motion)
{
  std::vector<BandQuantity> quantities;
  const auto add = [&](const std::string& name, const store::UncertainPose& of, std::size_t q,
                       std::size_t n) {
    const auto& samples = q < 3 ? of.rotation_deg : q < 6 ? of.translation_mm : motion.contact_force_n;
    const auto& bands = q < 3   ? of.rotation_band_deg
                        : q < 6 ? of.translation_band_mm
                                : motion.contact_force_band_n;
    const BandQuantity quantity{name, units[q / 3], &of, &samples, &bands, q, n};
    if (has_number(quantity)) quantities.push_back(quantity);
  };
  for (std::size_t q = 0; q < store::uncertain_quantities.size(); ++q)
    add(store::uncertain_quantities[q], motion, q, store::uncertain_quantities.size());
  for (const store::UncertainFollower& follower : motion.followers) {
    for (std::size_t q = 0; q < n_joint_coordinates; ++q)
      add(follower.name + "_" + follower_coordinate_names[q], follower, q, n_joint_coordinates);
  }
  return quantities;
}

double BandQuantity::band_at(std::size_t probability, std::size_t flexion) const
{
  return bands->at(3 * (probability * of->n_solved.size() + flexion) + row % 3);
}

std::size_t BandQuantity::share_row(std::size_t flexion, std::size_t draw) const
{
  const std::size_t n_draws = of->first_order.size() / (of->n_solved.size() * n_rows);
  return (flexion * n_rows + row) * n_draws + draw;
}

std::vector<double> variances_of(const BandQuantity& quantity)
{
  const std::vector<double>& samples = *quantity.samples;
  const std::size_t n_flexion = quantity.of->n_solved.size();
  std::vector<double> variances;
  for (std::size_t i = 0; i < n_flexion; ++i) {
    double n = 0.0, sum = 0.0, squares = 0.0;
    const double near = quantity.band_at(2, i);  // the median, against cancellation
    for (std::size_t s = 0; s < quantity.of->n_samples(); ++s) {
      const double value = samples[3 * (s * n_flexion + i) + quantity.row % 3] - near;
      if (!std::isfinite(value)) continue;
      n += 1.0;
      sum += value;
      squares += value * value;
    }
    variances.push_back(n > 1.0 ? (squares - sum * sum / n) / (n - 1.0) : 0.0);
  }
  return variances;
}

std::vector<SpreadShare> spread_shares(const BandQuantity& quantity)
{
  const std::vector<double> variances = variances_of(quantity);
  const store::UncertainPose& of = *quantity.of;
  std::vector<SpreadShare> shares;
  const std::size_t n_draws = of.first_order.size() / (variances.size() * quantity.n_rows);
  for (std::size_t d = 0; d < n_draws; ++d) {
    SpreadShare share{d};
    double weights = 0.0;
    for (std::size_t i = 0; i < variances.size(); ++i) {
      const std::size_t at = quantity.share_row(i, d);
      if (!std::isfinite(of.first_order[at])) continue;
      weights += variances[i];
      share.index += variances[i] * of.first_order[at];
      share.low += variances[i] * of.first_order_low[at];
      share.high += variances[i] * of.first_order_high[at];
      share.rank_correlation += variances[i] * of.rank_correlation[at];
    }
    if (!(weights > 0.0)) continue;
    for (double* value : {&share.index, &share.low, &share.high, &share.rank_correlation}) *value /= weights;
    shares.push_back(share);
  }
  std::stable_sort(shares.begin(), shares.end(),
                   [](const SpreadShare& a, const SpreadShare& b) { return a.index > b.index; });
  return shares;
}

namespace {

struct SampleStopped {};

class SampleMotion {
 public:
  SampleMotion(const SweepPlan& plan, const SweepResult& job, const SolveStep& solve,
               const SampleOptions& options)
      : plan_(plan),
        job_(job),
        solve_(solve),
        options_(options),
        prior_(job.prior),
        ends_(plan.flexion_rad.size())
  {
    check(job.free_spine.size() == plan.flexion_rad.size(), "sample_motion: a spine with free varus");
    const std::vector<double>& path = path_of(plan);
    for (const double flexion_rad : plan.flexion_rad) {
      const auto at = std::lower_bound(path.begin(), path.end(), flexion_rad);
      path_row_.push_back(static_cast<std::int32_t>(at - path.begin()));
    }
  }

  std::vector<StepRecord> run()
  {
    const auto n = static_cast<std::int32_t>(ends_.size());
    estimate_levels();
    for (std::int32_t i = 0; i < n; ++i) {
      start_from_job(i);
      if (i > 0) start_from_neighbour(i, i - 1);
    }
    for (std::int32_t i = n - 1; i-- > 0;) start_from_neighbour(i, i + 1);
    if (plan_.change_penalty_nmm) path_ = select_continuous(ends_, path_row_, plan_.change_penalty_nmm);
    std::vector<StepRecord> records;
    for (std::int32_t i = 0; i < n; ++i) records.push_back(measured(i));
    if (options_.follow) follow(records);
    return records;
  }

 private:
  std::vector<StepRecord>& ends(std::int32_t i) { return ends_[static_cast<std::size_t>(i)]; }
  std::int32_t path_row(std::int32_t i) const { return path_row_[static_cast<std::size_t>(i)]; }

  StepTask task_at(std::int32_t i, const Seed& seed) const
  {
    StepTask task;
    task.key = {StepKind::sample, i, options_.sample};
    task.path_row = path_row(i);
    task.attitude = {plan_.flexion_rad[static_cast<std::size_t>(i)],
                     seed.attitude ? seed.attitude->varus_rad : 0.0};
    task.seed = seed.pose;
    task.seed_attitude = seed.attitude;
    task.seed_path_row = seed.path_row;
    task.is_varus_free = true;
    task.springs = springs_at(options_.prior, prior_, plan_.flexion_rad[static_cast<std::size_t>(i)]);
    return task;
  }

  // As those of a spine with free varus, whose cells are the records.
  void follow(std::vector<StepRecord>& records) const
  {
    SweepPlan plan = plan_;
    plan.varus_rad = {0.0};
    plan.is_varus_free = true;
    plan.measures_chosen = false;
    plan.rows.reset();
    plan.springs.clear();
    for (const double flexion_rad : path_of(plan_))
      plan.springs.push_back(springs_at(options_.prior, prior_, flexion_rad));
    SweepResult result;
    result.cells = records;
    result.spine_column.assign(records.size(), 0);
    for (const StepRecord& record : records) result.free_spine.emplace_back().chosen = record;
    SweepHooks hooks;
    hooks.is_stopped = options_.is_stopped;
    if (!options_.follow(plan, solve_, hooks, 1, result)) throw SampleStopped{};
    for (std::size_t i = 0; i < result.cells.size(); ++i) {
      records[i] = result.cells[i];
      records[i].key = {StepKind::sample, static_cast<std::int32_t>(i), options_.sample};
    }
    for (std::size_t i = 0; i < result.followers.size(); ++i) {
      for (std::size_t k = 0; k < result.followers[i].size(); ++k) {
        records.push_back(result.followers[i][k]);
        records.back().key =
            sample_follower_key(static_cast<std::int32_t>(i), options_.sample, static_cast<std::int32_t>(k));
      }
    }
  }

  // Free levels follow from the joint, which differs in a sample; its drawn change of the level is beside
  // them.
  void estimate_levels()
  {
    std::vector<PriorTerm> terms = options_.prior;
    for (PriorTerm& term : terms) term.level_change = 0.0;
    PriorLevels levels(terms, prior_);
    for (const FreeSpineStep& step : job_.free_spine) starts_.push_back(step.chosen);
    for (int pass = 0; pass < n_sample_level_passes && levels.has_free(); ++pass) {
      std::vector<PriorPose> poses;
      for (std::size_t i = 0; i < starts_.size(); ++i) {
        if (starts_[i].status == StepStatus::stable) improve_start(i, terms);
        poses.push_back(prior_pose(starts_[i]));
      }
      levels.improve(poses);
    }
  }

  void improve_start(std::size_t i, const std::vector<PriorTerm>& terms)
  {
    const auto row = static_cast<std::int32_t>(i);
    StepTask task = task_at(row, seed_of(row, starts_[i]));
    task.springs = springs_at(terms, prior_, plan_.flexion_rad[i]);
    task.is_measured = false;
    const StepRecord end = solved(task);
    if (end.status == StepStatus::stable) starts_[i] = end;
  }

  StepRecord solved(const StepTask& task) const
  {
    if (options_.is_stopped && options_.is_stopped()) throw SampleStopped{};
    StepRecord record = solve_(task);
    record.key = task.key;
    return record;
  }

  void start(std::int32_t i, const Seed& seed)
  {
    StepTask task = task_at(i, seed);
    task.known = &ends(i);
    task.is_measured = false;
    ends(i).push_back(solved(task));
  }

  Seed seed_of(std::int32_t i, const StepRecord& record) const
  {
    const double flexion_rad =
        record.coordinates ? record.coordinates->flexion_rad : plan_.flexion_rad[static_cast<std::size_t>(i)];
    return {record.pose, Attitude{flexion_rad, record.varus_rad}, path_row(i)};
  }

  void start_from_job(std::int32_t i)
  {
    const FreeSpineStep& found = job_.free_spine[static_cast<std::size_t>(i)];
    const StepRecord& nearest = starts_[static_cast<std::size_t>(i)];
    const bool is_stable = nearest.status == StepStatus::stable;
    if (is_stable) start(i, seed_of(i, nearest));
    for (const SpineEquilibrium& other : found.equilibria) {
      if (other.is_chosen) continue;
      StepRecord at = found.chosen;
      at.pose = other.pose;
      at.varus_rad = other.varus_rad;
      start(i, seed_of(i, at));
    }
    if (!is_stable && i == 0) start(i, {plan_.initial, {}, 0});
  }

  void start_from_neighbour(std::int32_t to, std::int32_t from)
  {
    if (ends(from).empty()) return;
    const StepRecord lowest = select_lowest(ends(from)).chosen;
    if (lowest.status == StepStatus::stable) start(to, seed_of(from, lowest));
  }

  StepRecord measured(std::int32_t i)
  {
    StepRecord record;
    record.status = StepStatus::no_contact;  // no start at all: the job and both neighbours have no pose
    if (!ends(i).empty()) {
      const StepRecord chosen =
          path_.empty() ? select_lowest(ends(i)).chosen : path_[static_cast<std::size_t>(i)].chosen;
      record = chosen.status == StepStatus::stable ? solved(task_at(i, seed_of(i, chosen))) : chosen;
    }
    record.key = {StepKind::sample, i, options_.sample};
    return record;
  }

  const SweepPlan& plan_;
  const SweepResult& job_;
  const SolveStep& solve_;
  const SampleOptions& options_;
  PriorState prior_;                           // of the sample
  std::vector<std::int32_t> path_row_;         // [n_flexion]
  std::vector<StepRecord> starts_;             // [n_flexion] the job's, or those of the sample's levels
  std::vector<std::vector<StepRecord>> ends_;  // [n_flexion] results of all starts
  std::vector<FreeSpineStep> path_;            // [n_flexion] with a continuous path
};

}  // namespace

std::vector<StepRecord> sample_motion(const SweepPlan& plan, const SweepResult& job, const SolveStep& solve,
                                      const SampleOptions& options)
{
  try {
    return SampleMotion(plan, job, solve, options).run();
  } catch (const SampleStopped&) {
    return {};
  }
}

}  // namespace vrda::solve
