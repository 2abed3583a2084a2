#include "job/sampled_case.hpp"

#include <Eigen/Dense>
#include <boost/random/sobol.hpp>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <numeric>
#include <optional>
#include <random>

#include "core/text.hpp"
#include "geometry/nearest_surface.hpp"
#include "job/job_parts.hpp"
#include "model/frames.hpp"

namespace vrda::job {
namespace {

// An attachment this close to its object's mesh is on it: noise of a segmentation, and the thickness of a
// periosteum.
constexpr double attached_mm = 3.0;
constexpr double least_strain = -0.9, largest_strain = 1.0;
constexpr double infinite = std::numeric_limits<double>::infinity();

bool is_vector(const UncertainParameter& parameter)
{
  return parameter.quantity == InputQuantity::attachment ||
         parameter.quantity == InputQuantity::rotation_centre;
}

// The draws of one parameter: the first column of each fibre's own draw, and that of its bundle's if fibres
// are correlated.
struct ParameterDraws {
  std::vector<Eigen::Index> own;     // [fibres of the parameter], or one
  std::vector<Eigen::Index> common;  // [fibres of the parameter] with a correlation, else empty
  Eigen::Index n_columns = 1;        // of each draw: 3 of a displacement
};

// Columns of all draws and their names.
class DrawColumns {
 public:
  DrawColumns(const UncertainParameter& parameter, const std::vector<model::Fibre>& fibres,
              std::vector<std::string>& names)
      : parameter_(parameter), fibres_(fibres), names_(names)
  {
  }

  ParameterDraws draws()
  {
    ParameterDraws draws;
    draws.n_columns = is_vector(parameter_) ? 3 : 1;
    if (parameter_.fibres.empty()) {
      draws.own.push_back(column_of("", draws.n_columns));
      return draws;
    }
    const bool is_correlated = parameter_.correlation > 0.0;
    for (const std::size_t k : parameter_.fibres) {
      if (is_correlated) draws.common.push_back(column_of(fibres_[k].bundle + " (common)", draws.n_columns));
    }
    for (const std::size_t k : parameter_.fibres)
      draws.own.push_back(column_of(shared_name(k), draws.n_columns));
    return draws;
  }

 private:
  // Empty where all fibres share the draw, or where the parameter's name contains the bundle's.
  std::string shared_name(std::size_t k) const
  {
    const bool is_one = parameter_.shared_by == SharedBy::all ||
                        (parameter_.shared_by == SharedBy::bundle && is_one_bundle());
    return is_one ? "" : job::shared_name(fibres_[k], parameter_.shared_by);
  }

  bool is_one_bundle() const
  {
    return std::all_of(parameter_.fibres.begin(), parameter_.fibres.end(), [&](std::size_t k) {
      return fibres_[k].bundle == fibres_[parameter_.fibres.front()].bundle;
    });
  }

  // The first column of that name; adds the name if it is new.
  Eigen::Index column_of(const std::string& word, Eigen::Index n)
  {
    for (const auto& [known, column] : columns_) {
      if (known == word) return column;
    }
    const auto column = static_cast<Eigen::Index>(names_.size());
    columns_.emplace_back(word, column);
    const std::string name = parameter_.name + (word.empty() ? "" : " " + word);
    for (Eigen::Index k = 0; k < n; ++k)
      names_.push_back(n == 1 ? name : name + " " + axis_names[static_cast<std::size_t>(k)]);
    return column;
  }

  const UncertainParameter& parameter_;
  const std::vector<model::Fibre>& fibres_;
  std::vector<std::string>& names_;
  std::vector<std::pair<std::string, Eigen::Index>> columns_;
};

// Of three scores: with a normal distribution along each axis, or uniform in a ball.
Eigen::Vector3d displacement_mm(const job::Distribution& distribution, const Eigen::Vector3d& scores)
{
  if (distribution.kind == job::DistributionKind::normal) return distribution.sd * scores;
  const double size = scores.norm();
  if (size == 0.0) return Eigen::Vector3d::Zero();
  return distribution.to * radius_in_ball(size) / size * scores;
}

geometry::NearestSurface surface_of(const Body& body)
{
  Mesh mesh = body.contact.mesh;
  mesh.normals.resize(0, 3);
  mesh.offset_mm.clear();
  Mesh visual = body.visual.mesh;
  visual.normals.resize(0, 3);
  visual.offset_mm.clear();
  append(mesh, visual);
  return geometry::NearestSurface(std::move(mesh));
}

// Along the surface if the point is on it: the tangential part of the displacement, then back onto the
// surface, at the same height above it. Otherwise the whole displacement.
Eigen::Vector3d moved_mm(const Eigen::Vector3d& p_mm, const Eigen::Vector3d& displacement_mm,
                         const geometry::NearestSurface& surface)
{
  const auto nearest = [&](const Eigen::Vector3d& at) { return surface.nearest(at); };
  const geometry::SurfacePoint from = surface.is_empty() ? geometry::SurfacePoint{} : nearest(p_mm);
  if (from.triangle < 0 || from.distance_mm > attached_mm) return p_mm + displacement_mm;
  const Eigen::Vector3d normal = surface.normal(from.triangle);
  const double height_mm = (p_mm - from.p_mm).dot(normal);
  const geometry::SurfacePoint to =
      nearest(from.p_mm + displacement_mm - displacement_mm.dot(normal) * normal);
  return to.p_mm + height_mm * surface.normal(to.triangle);
}

}  // namespace

struct SampledCase::State {
  const job::Case& job_case;
  std::vector<std::string> names;
  std::vector<ParameterDraws> draws;  // [parameters]
  Eigen::MatrixXd scores, values;
  std::vector<std::vector<double>> strain;  // [1 + followers, fibres] where the scan found the objects
  std::map<BodyIndex, geometry::NearestSurface> surfaces;  // on which attachments move

  explicit State(const job::Case& given) : job_case(given)
  {
    check(given.uncertainty.has_value() && given.steps_scale == 1.0, "SampledCase: an uncertain case");
    const job::Uncertainty& uncertainty = *given.uncertainty;
    for (const UncertainParameter& parameter : uncertainty.parameters) {
      draws.push_back(DrawColumns(parameter, ligaments_of(given, parameter.follower).fibres, names).draws());
      if (parameter.quantity != InputQuantity::attachment) continue;
      if (!surfaces.contains(parameter.body))
        surfaces.emplace(parameter.body, surface_of(body_of(given, parameter)));
    }
    if (uncertainty.sequence == job::SampleSequence::sobol && names.size() > most_sobol_dimensions) {
      throw InputError({"uncertainty.parameter", "", std::to_string(names.size()) + " independent draws",
                        "at most " + std::to_string(most_sobol_dimensions) +
                            " with sequence = \"sobol\"; or \"latin-hypercube\", or shared_by = \"bundle\""});
    }
    scores = unit_samples(uncertainty.sequence, uncertainty.n_samples,
                          static_cast<Eigen::Index>(names.size()), uncertainty.seed)
                 .unaryExpr(&score_of_probability);
    const std::vector<model::FibreState> states = model::fibre_states(given.ligaments, {}, {});
    strain.emplace_back();
    for (std::size_t k = 0; k < states.size(); ++k)
      strain[0].push_back(states[k].length_mm / given.ligaments.fibres[k].slack_length_mm - 1.0);
    for (std::size_t row = 0; row < given.followers.size(); ++row)
      strain.push_back(scan_strains(given.followers, row));
    set_values();
  }

  void set_values()
  {
    values = scores;
    for (std::size_t p = 0; p < draws.size(); ++p) {
      const UncertainParameter& parameter = job_case.uncertainty->parameters[p];
      if (!draws[p].common.empty()) continue;
      std::vector<Eigen::Index> columns = draws[p].own;
      std::sort(columns.begin(), columns.end());
      columns.erase(std::unique(columns.begin(), columns.end()), columns.end());
      for (const Eigen::Index column : columns) {
        for (Eigen::Index s = 0; s < scores.rows(); ++s) {
          if (is_vector(parameter)) {
            const Eigen::Vector3d three = scores.block<1, 3>(s, column).transpose();
            values.block<1, 3>(s, column) = displacement_mm(parameter.distribution, three).transpose();
          } else {
            values(s, column) = quantile_above(
                parameter.distribution, probability_of_score(scores(s, column)), least_draw(parameter));
          }
        }
      }
    }
  }

  // Where the draws of a parameter are truncated; of several fibres or flexions, for the largest value.
  double least_draw(const UncertainParameter& parameter) const
  {
    if (parameter.is_factor) return least_factor(parameter);
    double largest = -infinite;
    if (parameter.quantity == InputQuantity::stiffness) {
      for (const std::size_t k : parameter.fibres)
        largest = std::max(largest, ligaments_of(job_case, parameter.follower).fibres[k].stiffness_n);
    } else if (parameter.quantity == InputQuantity::offset) {
      const Part& part = body_of(job_case, parameter).contact;
      for (std::size_t t = 0; t < part.component.size(); ++t) {
        if (part.component[t] == parameter.component)
          largest = std::max(largest, offset_mm(part.mesh, static_cast<Eigen::Index>(t)));
      }
    } else if (parameter.quantity == InputQuantity::load && parameter.follower) {
      largest = load_n(job_case.followers.at(*parameter.follower), parameter.load);
    } else if (parameter.quantity == InputQuantity::load) {
      for (const job::Push& push : job_case.push) {
        if (parameter.load == InputLoad::force) largest = std::max(largest, push.force_n.dot(push.delta));
        if (parameter.load == InputLoad::line)
          largest = std::max(largest, push.line_tension_n[parameter.load_row]);
      }
    }
    return std::isfinite(largest) ? -largest : -infinite;
  }

  static double least_factor(const UncertainParameter& parameter)
  {
    const bool is_signed = parameter.quantity == InputQuantity::reference_strain ||
                           (parameter.quantity == InputQuantity::load && !parameter.follower &&
                            parameter.load != InputLoad::force && parameter.load != InputLoad::line);
    return is_signed ? -infinite : 0.0;
  }

  // Score of the f-th fibre's draw in column `k` of it.
  double score_of(std::size_t p, std::size_t f, int sample, Eigen::Index k = 0) const
  {
    const ParameterDraws& of = draws[p];
    const double own = scores(sample, of.own[f] + k);
    if (of.common.empty()) return own;
    const double correlation = job_case.uncertainty->parameters[p].correlation;
    return std::sqrt(correlation) * scores(sample, of.common[f] + k) + std::sqrt(1.0 - correlation) * own;
  }

  // `nominal` with the change or factor drawn; the result is above `least`.
  double changed(std::size_t p, std::size_t f, int sample, double nominal, double least = -infinite) const
  {
    const UncertainParameter& parameter = job_case.uncertainty->parameters[p];
    const double probability = probability_of_score(score_of(p, f, sample));
    if (parameter.is_factor)
      return nominal * quantile_above(parameter.distribution, probability, least_factor(parameter));
    return nominal + quantile_above(parameter.distribution, probability, least - nominal);
  }

  void move_attachments(std::size_t p, int sample, model::Ligaments& ligaments) const
  {
    const UncertainParameter& parameter = job_case.uncertainty->parameters[p];
    const geometry::NearestSurface& surface = surfaces.at(parameter.body);
    for (std::size_t f = 0; f < parameter.fibres.size(); ++f) {
      const Eigen::Vector3d three(score_of(p, f, sample, 0), score_of(p, f, sample, 1),
                                  score_of(p, f, sample, 2));
      model::Fibre& fibre = ligaments.fibres[parameter.fibres[f]];
      Eigen::Vector3d& p_mm = fibre.to == parameter.body ? fibre.moving_mm : fibre.reference_mm;
      p_mm = moved_mm(p_mm, displacement_mm(parameter.distribution, three), surface);
    }
  }

  // Of the joint, or of a follower by its row.
  model::Ligaments ligaments_at(int sample, std::optional<std::size_t> follower = {}) const
  {
    const job::Uncertainty& uncertainty = *job_case.uncertainty;
    model::Ligaments ligaments = ligaments_of(job_case, follower);
    const std::vector<double>& old_strain = strain.at(follower ? 1 + *follower : 0);
    std::vector<double> new_strain = old_strain;
    std::vector<bool> has_strain(new_strain.size(), false);  // the slack length follows from the strain
    const std::vector<double>& given =
        follower ? job_case.followers[*follower].reference_strain : uncertainty.reference_strain;
    for (std::size_t k = 0; k < has_strain.size(); ++k) has_strain[k] = !std::isnan(given[k]);
    bool is_moved = false, is_strained = false;
    for (std::size_t p = 0; p < uncertainty.parameters.size(); ++p) {
      const UncertainParameter& parameter = uncertainty.parameters[p];
      if (parameter.follower != follower) continue;
      if (parameter.quantity == InputQuantity::attachment) {
        move_attachments(p, sample, ligaments);
        is_moved = true;
      }
      for (std::size_t f = 0; f < parameter.fibres.size(); ++f) {
        const std::size_t k = parameter.fibres[f];
        double& stiffness_n = ligaments.fibres[k].stiffness_n;
        if (parameter.quantity == InputQuantity::stiffness)
          stiffness_n = changed(p, f, sample, stiffness_n, 0.0);
        if (parameter.quantity != InputQuantity::reference_strain) continue;
        new_strain[k] =
            std::clamp(changed(p, f, sample, new_strain[k], least_strain), least_strain, largest_strain);
        has_strain[k] = is_strained = true;
      }
    }
    if (!is_moved && !is_strained) return ligaments;
    if (follower) {
      const std::vector<double> moved =
          is_moved ? scan_strains(job_case.followers, *follower, ligaments) : old_strain;
      for (std::size_t k = 0; k < moved.size(); ++k) {
        if (has_strain[k]) ligaments.fibres[k].slack_length_mm *= (1.0 + moved[k]) / (1.0 + new_strain[k]);
      }
      return ligaments;
    }
    const std::vector<model::FibreState> states = model::fibre_states(ligaments, {}, {});
    for (std::size_t k = 0; k < states.size(); ++k) {
      const bool is_changed = new_strain[k] != old_strain[k] || is_moved;
      if (has_strain[k] && is_changed && states[k].length_mm > 0.0)
        ligaments.fibres[k].slack_length_mm = states[k].length_mm / (1.0 + new_strain[k]);
    }
    return ligaments;
  }

  void change_load(std::size_t p, int sample, job::Push& push) const
  {
    const UncertainParameter& parameter = job_case.uncertainty->parameters[p];
    const Eigen::Matrix3d R = shortest_rotation(Eigen::Vector3d::UnitY(), push.delta);
    const auto change_along = [&](const Eigen::Vector3d& axis, double least) {
      const double before_n = push.force_n.dot(axis);
      push.force_n += (changed(p, 0, sample, before_n, least) - before_n) * axis;
    };
    switch (parameter.load) {
      case InputLoad::push:
      case InputLoad::tension:
        throw InternalError("a follower's load is not the joint's");
      case InputLoad::force:
        return change_along(push.delta, 0.0);
      case InputLoad::anterior_force:
        return change_along(R.col(0), -infinite);
      case InputLoad::right_force:
        return change_along(R.col(2), -infinite);
      case InputLoad::moment:
        push.moment_nmm = changed(p, 0, sample, push.moment_nmm);
        return;
      case InputLoad::varus_moment:
        push.varus_moment_nmm = changed(p, 0, sample, push.varus_moment_nmm);
        return;
      case InputLoad::applied:
        push.load_force_n[parameter.load_row] *= changed(p, 0, sample, 1.0);
        push.load_moment_nmm[parameter.load_row] *= changed(p, 0, sample, 1.0);
        return;
      case InputLoad::line:
        double& tension_n = push.line_tension_n[parameter.load_row];
        tension_n = std::max(0.0, changed(p, 0, sample, tension_n, 0.0));
        return;
    }
  }

  void change_follower_load(std::size_t p, int sample, Follower& follower) const
  {
    const InputLoad load = job_case.uncertainty->parameters[p].load;
    set_load(follower, load, std::max(0.0, changed(p, 0, sample, load_n(follower, load), 0.0)));
  }

  void change_offset(std::size_t p, int sample, job::Case& sampled) const
  {
    const UncertainParameter& parameter = job_case.uncertainty->parameters[p];
    Part& part = body_of(sampled, parameter).contact;
    part.mesh.offset_mm.resize(static_cast<std::size_t>(part.mesh.triangles.rows()), 0.0);
    for (std::size_t t = 0; t < part.component.size(); ++t) {
      double& offset_mm = part.mesh.offset_mm[t];
      if (part.component[t] == parameter.component) offset_mm = changed(p, 0, sample, offset_mm, 0.0);
    }
  }

  double thickness_mm(std::size_t p, int sample) const { return changed(p, 0, sample, 0.0); }

  void change_thickness(std::size_t p, int sample, job::Case& sampled) const
  {
    const UncertainParameter& parameter = job_case.uncertainty->parameters[p];
    Part& part = body_of(sampled, parameter).contact;
    const double by_mm = thickness_mm(p, sample);
    std::vector<bool> is_moved(static_cast<std::size_t>(part.mesh.vertices_mm.rows()), false);
    for (Eigen::Index t = 0; t < part.mesh.triangles.rows(); ++t) {
      const bool is_of_it =
          parameter.component < 0 || part.component[static_cast<std::size_t>(t)] == parameter.component;
      for (Eigen::Index k = 0; is_of_it && k < 3; ++k)
        is_moved[static_cast<std::size_t>(part.mesh.triangles(t, k))] = true;
    }
    const Points normals = vertex_normals(part.mesh);
    for (Eigen::Index v = 0; v < normals.rows(); ++v) {
      if (is_moved[static_cast<std::size_t>(v)]) part.mesh.vertices_mm.row(v) += by_mm * normals.row(v);
    }
  }

  void turn_direction(std::size_t p, int sample, job::Case& sampled) const
  {
    const UncertainParameter& parameter = job_case.uncertainty->parameters[p];
    sampled.followers.at(*parameter.follower).directions.at(parameter.term).rest_rad +=
        rad_from_deg(changed(p, 0, sample, 0.0));
  }

  void change_prior(std::size_t p, int sample, job::Case& sampled) const
  {
    const UncertainParameter& parameter = job_case.uncertainty->parameters[p];
    PriorTerm& term = sampled.prior.at(parameter.term);
    const double drawn = changed(p, 0, sample, 0.0);
    (parameter.quantity == InputQuantity::prior_shape ? term.shape_change : term.level_change) +=
        is_angle(term.coordinate) ? rad_from_deg(drawn) : drawn;
  }
};

SampledCase::SampledCase(const job::Case& job_case) : state_(std::make_unique<State>(job_case)) {}
SampledCase::~SampledCase() = default;
SampledCase::SampledCase(SampledCase&&) noexcept = default;

int SampledCase::n_samples() const
{
  return static_cast<int>(state_->scores.rows());
}

const std::vector<std::string>& SampledCase::draw_names() const
{
  return state_->names;
}

const Eigen::MatrixXd& SampledCase::scores() const
{
  return state_->scores;
}

const Eigen::MatrixXd& SampledCase::values() const
{
  return state_->values;
}

bool SampledCase::has_same_geometry() const
{
  return n_geometry_changes() == 0;
}

std::optional<double> SampledCase::thickness_change_mm(int sample) const
{
  const auto& parameters = state_->job_case.uncertainty->parameters;
  double change_mm = 0.0;
  std::ptrdiff_t n = 0;
  for (std::size_t p = 0; p < parameters.size(); ++p) {
    if (parameters[p].quantity != InputQuantity::thickness || parameters[p].component >= 0 ||
        parameters[p].follower)
      continue;
    change_mm += state_->thickness_mm(p, sample);
    ++n;
  }
  return n == n_geometry_changes() ? std::optional(change_mm) : std::nullopt;
}

std::ptrdiff_t SampledCase::n_geometry_changes() const
{
  return std::ranges::count_if(
      state_->job_case.uncertainty->parameters, [](const UncertainParameter& parameter) {
        return !parameter.follower && (parameter.quantity == InputQuantity::rotation_centre ||
                                       parameter.quantity == InputQuantity::offset ||
                                       parameter.quantity == InputQuantity::thickness);
      });
}

model::Ligaments SampledCase::ligaments_at(int sample) const
{
  return state_->ligaments_at(sample);
}

Eigen::Vector3d SampledCase::rotation_centre_mm_at(int sample) const
{
  const std::vector<UncertainParameter>& parameters = state_->job_case.uncertainty->parameters;
  Eigen::Vector3d centre_mm = state_->job_case.frame.rotation_centre_mm;
  for (std::size_t p = 0; p < parameters.size(); ++p) {
    if (parameters[p].quantity != InputQuantity::rotation_centre) continue;
    const Eigen::Vector3d three = state_->scores.block<1, 3>(sample, state_->draws[p].own[0]).transpose();
    centre_mm += displacement_mm(parameters[p].distribution, three);
  }
  return centre_mm;
}

job::Case SampledCase::at(int sample) const
{
  const State& state = *state_;
  job::Case sampled = state.job_case;
  sampled.uncertainty.reset();
  sampled.ligaments = state.ligaments_at(sample);
  for (std::size_t row = 0; row < sampled.followers.size(); ++row)
    sampled.followers[row].ligaments = state.ligaments_at(sample, row);
  sampled.frame.rotation_centre_mm = rotation_centre_mm_at(sample);
  const std::vector<UncertainParameter>& parameters = state.job_case.uncertainty->parameters;
  for (std::size_t p = 0; p < parameters.size(); ++p) {
    const InputQuantity quantity = parameters[p].quantity;
    if (quantity == InputQuantity::offset) state.change_offset(p, sample, sampled);
    if (quantity == InputQuantity::thickness) state.change_thickness(p, sample, sampled);
    if (quantity == InputQuantity::direction) state.turn_direction(p, sample, sampled);
    if (quantity == InputQuantity::prior_shape || quantity == InputQuantity::prior_level)
      state.change_prior(p, sample, sampled);
    if (quantity != InputQuantity::load) continue;
    if (parameters[p].follower) {
      state.change_follower_load(p, sample, sampled.followers[*parameters[p].follower]);
      continue;
    }
    for (std::vector<job::Push>* rows : {&sampled.push, &sampled.path_push}) {
      for (job::Push& push : *rows) state.change_load(p, sample, push);
    }
  }
  return sampled;
}

// Samples of the unit cube: the same numbers for the same arguments on every machine.

namespace {

constexpr double two_to_32 = 4294967296.0;

// Distributions of the standard library differ between implementations; the generator's numbers do not.
std::uint32_t random_bits(std::mt19937_64& random)
{
  return static_cast<std::uint32_t>(random() >> 32U);
}

double inside_unit(std::uint32_t bits)
{
  return (static_cast<double>(bits) + 0.5) / two_to_32;
}

Eigen::MatrixXd sobol_samples(Eigen::Index n_samples, Eigen::Index n_dimensions, std::mt19937_64& random)
{
  std::vector<std::uint32_t> shift(static_cast<std::size_t>(n_dimensions));
  for (std::uint32_t& bits : shift) bits = random_bits(random);
  boost::random::sobol_engine<std::uint32_t, 32> sequence(shift.size());
  Eigen::MatrixXd samples(n_samples, n_dimensions);
  for (Eigen::Index s = 0; s < n_samples; ++s) {
    // Boost omits the first point, the origin, without which 2^k points are not a net.
    for (Eigen::Index d = 0; d < n_dimensions; ++d)
      samples(s, d) = inside_unit((s == 0 ? 0U : sequence()) ^ shift[static_cast<std::size_t>(d)]);
  }
  return samples;
}

Eigen::MatrixXd latin_samples(Eigen::Index n_samples, Eigen::Index n_dimensions, std::mt19937_64& random)
{
  Eigen::MatrixXd samples(n_samples, n_dimensions);
  std::vector<Eigen::Index> order(static_cast<std::size_t>(n_samples));
  for (Eigen::Index d = 0; d < n_dimensions; ++d) {
    std::iota(order.begin(), order.end(), Eigen::Index{0});
    for (std::size_t k = order.size() - 1; k > 0; --k) std::swap(order[k], order[random() % (k + 1)]);
    for (Eigen::Index s = 0; s < n_samples; ++s)
      samples(s, d) =
          (static_cast<double>(order[static_cast<std::size_t>(s)]) + inside_unit(random_bits(random))) /
          static_cast<double>(n_samples);
  }
  return samples;
}

}  // namespace

Eigen::MatrixXd unit_samples(job::SampleSequence sequence, Eigen::Index n_samples, Eigen::Index n_dimensions,
                             std::uint32_t seed)
{
  check(n_samples > 0 && n_dimensions > 0, "unit_samples: an empty sample");
  std::mt19937_64 random(seed);
  return sequence == job::SampleSequence::sobol ? sobol_samples(n_samples, n_dimensions, random)
                                                : latin_samples(n_samples, n_dimensions, random);
}

namespace {

constexpr int n_terms = 4;                      // of a cubic
constexpr Eigen::Index fewest_samples = 40;     // ten for each term
constexpr double least_spread = 1e-9;           // mm, degrees or N: far below any tolerance of the solver
constexpr double score_of_90_percent = 1.6449;  // of the normal distribution, two-sided

// Mean rank of equal values.
std::vector<double> ranks_of(const std::vector<double>& values)
{
  std::vector<std::size_t> order(values.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) { return values[a] < values[b]; });
  std::vector<double> ranks(values.size());
  for (std::size_t first = 0, last = 0; first < order.size(); first = last) {
    while (last < order.size() && values[order[last]] == values[order[first]]) ++last;
    for (std::size_t k = first; k < last; ++k) ranks[order[k]] = 0.5 * static_cast<double>(first + last - 1);
  }
  return ranks;
}

double correlation(const std::vector<double>& x, const std::vector<double>& y)
{
  const Eigen::Map<const Eigen::ArrayXd> a(x.data(), static_cast<Eigen::Index>(x.size()));
  const Eigen::Map<const Eigen::ArrayXd> b(y.data(), static_cast<Eigen::Index>(y.size()));
  const Eigen::ArrayXd da = a - a.mean(), db = b - b.mean();
  const double spread = std::sqrt(da.square().sum() * db.square().sum());
  return spread > 0.0 ? (da * db).sum() / spread : nan;
}

using Terms = Eigen::Matrix<double, n_terms, 1>;

// Hermite polynomials of degree 0 to 3.
Terms hermite(double z)
{
  return {1.0, z, z * z - 1.0, z * (z * z - 3.0)};
}

// Sums over samples from which a least-squares fit follows; those of groups add up.
struct Sums {
  Eigen::Matrix4d terms = Eigen::Matrix4d::Zero();
  Eigen::MatrixXd products;  // [n_terms, m]
  Eigen::ArrayXd squares;    // [m]
  double n = 0.0;

  explicit Sums(Eigen::Index m)
      : products(Eigen::MatrixXd::Zero(n_terms, m)), squares(Eigen::ArrayXd::Zero(m))
  {
  }

  void add(double score, const Eigen::RowVectorXd& results)
  {
    const Terms h = hermite(score);
    terms += h * h.transpose();
    products += h * results;
    squares += results.transpose().array().square();
    n += 1.0;
  }

  Sums& operator+=(const Sums& other)
  {
    terms += other.terms;
    products += other.products;
    squares += other.squares;
    n += other.n;
    return *this;
  }

  Sums without(const Sums& part) const
  {
    Sums rest = *this;
    rest.terms -= part.terms;
    rest.products -= part.products;
    rest.squares -= part.squares;
    rest.n -= part.n;
    return rest;
  }

  // [m] adjusted coefficients of determination.
  Eigen::ArrayXd indices() const
  {
    const Eigen::MatrixXd fit = terms.ldlt().solve(products);
    const Eigen::ArrayXd mean_square = products.row(0).transpose().array().square() / n;
    const Eigen::ArrayXd total = squares - mean_square;
    const Eigen::ArrayXd explained =
        products.cwiseProduct(fit).colwise().sum().transpose().array() - mean_square;
    Eigen::ArrayXd index = 1.0 - (1.0 - explained / total) * (n - 1.0) / (n - n_terms);
    for (Eigen::Index k = 0; k < index.size(); ++k) {
      if (!(std::sqrt(std::max(total[k], 0.0) / n) > least_spread)) index[k] = nan;
    }
    return index;
  }
};

}  // namespace

double quantile(std::vector<double> values, double probability)
{
  std::erase_if(values, [](double value) { return !std::isfinite(value); });
  if (values.empty()) return nan;
  std::sort(values.begin(), values.end());
  const double at = probability * static_cast<double>(values.size() - 1);
  const auto below = static_cast<std::size_t>(at);
  if (below + 1 == values.size()) return values.back();
  const double share = at - static_cast<double>(below);
  return (1.0 - share) * values[below] + share * values[below + 1];
}

double rank_correlation(std::span<const double> x, std::span<const double> y)
{
  check(x.size() == y.size(), "rank_correlation: pairs");
  std::vector<double> a, b;
  for (std::size_t k = 0; k < x.size(); ++k) {
    if (!std::isfinite(x[k]) || !std::isfinite(y[k])) continue;
    a.push_back(x[k]);
    b.push_back(y[k]);
  }
  return a.size() < 3 ? nan : correlation(ranks_of(a), ranks_of(b));
}

std::vector<int> jackknife_groups(std::size_t n, std::uint32_t seed)
{
  std::vector<int> group(n);
  for (std::size_t k = 0; k < n; ++k) group[k] = static_cast<int>(k % n_jackknife_groups);
  std::mt19937_64 random(seed);
  for (std::size_t k = n; k-- > 1;) std::swap(group[k], group[random() % (k + 1)]);
  return group;
}

std::vector<FirstOrderIndex> first_order_indices(const Eigen::VectorXd& scores,
                                                 const Eigen::MatrixXd& results,
                                                 const std::vector<int>& group)
{
  const Eigen::Index m = results.cols();
  std::vector<Eigen::Index> rows;
  for (Eigen::Index s = 0; s < results.rows(); ++s) {
    if (results.row(s).allFinite()) rows.push_back(s);
  }
  std::vector<FirstOrderIndex> indices(static_cast<std::size_t>(m), {nan, nan, nan});
  if (static_cast<Eigen::Index>(rows.size()) < fewest_samples) return indices;
  Eigen::RowVectorXd mean = Eigen::RowVectorXd::Zero(m);
  for (const Eigen::Index s : rows) mean += results.row(s) / static_cast<double>(rows.size());
  std::vector<Sums> parts(n_jackknife_groups, Sums(m));
  Sums all(m);
  for (const Eigen::Index s : rows)
    parts[static_cast<std::size_t>(group[static_cast<std::size_t>(s)])].add(scores[s], results.row(s) - mean);
  for (const Sums& part : parts) all += part;
  const Eigen::ArrayXd index = all.indices();
  Eigen::ArrayXXd left_out(m, n_jackknife_groups);
  for (int g = 0; g < n_jackknife_groups; ++g)
    left_out.col(g) = all.without(parts[static_cast<std::size_t>(g)]).indices();
  const Eigen::ArrayXd centre = left_out.rowwise().mean();
  const Eigen::ArrayXd error = ((left_out.colwise() - centre).square().rowwise().sum() *
                                (n_jackknife_groups - 1.0) / n_jackknife_groups)
                                   .sqrt();
  for (Eigen::Index k = 0; k < m; ++k) {
    if (std::isnan(index[k])) continue;
    const double half_width = score_of_90_percent * error[k];
    indices[static_cast<std::size_t>(k)] = {std::clamp(index[k], 0.0, 1.0),
                                            std::clamp(index[k] - half_width, 0.0, 1.0),
                                            std::clamp(index[k] + half_width, 0.0, 1.0)};
  }
  return indices;
}

}  // namespace vrda::job
