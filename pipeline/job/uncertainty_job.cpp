// [uncertainty] of a job: its parameters and their distributions.
#include "job/job_parts.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <set>

#include "core/axis.hpp"
#include "core/text.hpp"

namespace vrda::job {
namespace {

constexpr std::size_t largest_value_table = 100000;

class UncertaintyReader {
 public:
  UncertaintyReader(const Job& job, const std::string& data_directory, const Case& loaded,
                    const LoadedLigaments& ligaments)
      : job_(job), data_directory_(data_directory), loaded_(loaded), ligaments_(ligaments)
  {
  }

  LoadedUncertainty read(const core::DocumentValue& table)
  {
    if (job_.method != SolverMethod::equilibrium) {
      throw InputError({job_.document.source_of_conflict({"uncertainty", "solver.method"}), "uncertainty",
                        "[uncertainty] with \"stability-search\"", "solver.method = \"equilibrium\""});
    }
    Uncertainty found;
    found.n_samples = static_cast<std::int32_t>(core::integer_at(table, "samples"));
    found.sequence =
        core::text_at(table, "sequence") == "sobol" ? SampleSequence::sobol : SampleSequence::latin_hypercube;
    found.seed = static_cast<std::uint32_t>(core::integer_at(table, "seed"));
    found.reference_strain = given_strains(ligaments_.jobs);
    for (const core::DocumentValue& value : core::value_at(table, "parameter")) {
      at_ = "uncertainty.parameter." + std::to_string(found.parameters.size());
      found.parameters.push_back(parameter_of(value));
      if (!names_.insert(found.parameters.back().name).second)
        refuse("name", "\"" + found.parameters.back().name + "\" a second time",
               "a unique name for each parameter: name = \"...\"");
    }
    loaded_uncertainty_.uncertainty = std::move(found);
    return std::move(loaded_uncertainty_);
  }

 private:
  [[noreturn]] void refuse(const std::string& key, const std::string& found, const std::string& wanted) const
  {
    job_.document.refuse(key.empty() ? at_ : at_ + "." + key, found, wanted);
  }

  UncertainParameter parameter_of(const core::DocumentValue& value)
  {
    UncertainParameter parameter;
    const std::string& quantity = core::text_at(value, "quantity");
    parameter.quantity = core::value_named<InputQuantity>(quantity).value();
    check_keys(value, parameter.quantity);
    const core::DocumentValue* factor = core::find_at(value, "factor");
    parameter.is_factor =
        factor != nullptr ? core::flag_at(*factor, "") : parameter.quantity == InputQuantity::stiffness;
    parameter.name = quantity;
    if (const std::string& follower = core::text_or_empty(value, "follower"); !follower.empty()) {
      parameter.follower = follower_named(job_.document, at_ + ".follower", follower);
      parameter.body = model::follower_index(*parameter.follower);
      parameter.name += " " + follower;
    }
    if (is_of_fibres(parameter.quantity)) set_fibres(value, parameter);
    if (parameter.quantity == InputQuantity::load) set_load(value, parameter);
    if (parameter.quantity == InputQuantity::offset) set_component(value, parameter);
    if (parameter.quantity == InputQuantity::thickness) set_thickness(value, parameter);
    if (is_of_prior(parameter.quantity)) set_term(value, parameter);
    if (parameter.quantity == InputQuantity::direction) set_direction(value, parameter);
    if (const std::string& name = core::text_or_empty(value, "name"); !name.empty()) parameter.name = name;
    parameter.distribution = distribution_of(value, parameter);
    check_range(parameter);
    return parameter;
  }

  static bool is_of_fibres(InputQuantity quantity)
  {
    return quantity == InputQuantity::stiffness || quantity == InputQuantity::reference_strain ||
           quantity == InputQuantity::attachment;
  }

  static bool is_of_prior(InputQuantity quantity)
  {
    return quantity == InputQuantity::prior_shape || quantity == InputQuantity::prior_level;
  }

  static bool is_vector(InputQuantity quantity)
  {
    return quantity == InputQuantity::attachment || quantity == InputQuantity::rotation_centre;
  }

  // What a parameter of a follower may change.
  static bool may_be_of_follower(InputQuantity quantity)
  {
    return is_of_fibres(quantity) || quantity == InputQuantity::load || quantity == InputQuantity::offset ||
           quantity == InputQuantity::thickness || quantity == InputQuantity::direction;
  }

  // A key that the quantity or the distribution does not use is a mistake.
  void check_keys(const core::DocumentValue& value, InputQuantity quantity) const
  {
    const std::string& distribution = core::text_at(value, "distribution");
    std::set<std::string> used{"name", "quantity", "distribution"};
    if (is_of_fibres(quantity)) used.insert({"fibre", "bundle", "shared_by", "correlation"});
    if (quantity == InputQuantity::attachment) used.insert("body");
    if (quantity == InputQuantity::direction) used.insert("bundle");
    if (quantity == InputQuantity::offset || quantity == InputQuantity::thickness)
      used.insert({value.contains("follower") ? "follower" : "body", "component"});
    if (may_be_of_follower(quantity)) used.insert("follower");
    if (is_of_prior(quantity)) used.insert("coordinate");
    if (quantity == InputQuantity::load) used.insert("load");
    if (!is_vector(quantity)) used.insert("factor");
    if (distribution == "normal" || distribution == "lognormal") used.insert("sd");
    if (!is_vector(quantity) && used.contains("sd")) used.insert("mean");
    if (distribution == "uniform") used.insert("to");
    if (distribution == "uniform" && !is_vector(quantity)) used.insert("from");
    if (distribution == "table") used.insert({"values", "file", "column"});
    for (const auto& [key, given] : value.items()) {
      if (used.contains(key)) continue;
      refuse(key, core::shown(given),
             "no such key for quantity = \"" + core::text_at(value, "quantity") + "\" and distribution = \"" +
                 distribution + "\"");
    }
  }

  BodyIndex body_at(const core::DocumentValue& value, bool is_of_follower = false) const
  {
    const std::string& name = core::text_or_empty(value, "body");
    const BodyIndex body = attached_body(job_, name, at_ + ".body");
    if (!is_of_follower && model::row_of(body) >= std::size(all_bodies))
      refuse("body", '"' + name + '"', "\"reference\" or \"moving\"");
    return body;
  }

  void set_fibres(const core::DocumentValue& value, UncertainParameter& parameter)
  {
    const std::vector<model::Fibre>& fibres = ligaments_of(loaded_, parameter.follower).fibres;
    std::string body;
    if (parameter.quantity == InputQuantity::attachment) {
      parameter.body = body_at(value, parameter.follower.has_value());
      body = body_name(parameter);
      parameter.name += " " + body;
    }
    const std::string& fibre = core::text_or_empty(value, "fibre");
    const std::string& bundle = core::text_or_empty(value, "bundle");
    if (!fibre.empty() && !bundle.empty()) refuse("", "both fibre and bundle", "one of them, or neither");
    const std::string& word = fibre.empty() ? bundle : fibre;
    if (!word.empty()) parameter.name += " " + word;
    choose_fibres(job_.document, at_, fibres, {fibre, bundle, body}, parameter);
    parameter.shared_by =
        core::value_named<SharedBy>(core::text_or_empty(value, "shared_by")).value_or(SharedBy::bundle);
    const core::DocumentValue* correlation = core::find_at(value, "correlation");
    if (correlation == nullptr) return;
    if (parameter.shared_by != SharedBy::fibre)
      refuse("correlation", core::shown(*correlation), "shared_by = \"fibre\", or no correlation");
    parameter.correlation = core::number_at(*correlation, "");
  }

  void set_load(const core::DocumentValue& value, UncertainParameter& parameter)
  {
    const std::string& name = core::text_or_empty(value, "load");
    const std::optional<InputLoad> known = core::value_named<InputLoad>(name);
    const bool is_of_follower = known == InputLoad::push || known == InputLoad::tension;
    if (parameter.follower) {
      if (!is_of_follower)
        refuse("load", name.empty() ? "nothing" : "\"" + name + "\"",
               "\"push\" or \"tension\", of a follower");
      parameter.load = *known;
      parameter.name += " " + name;
      return;
    }
    bool is_found = known && !is_of_follower;
    if (is_found) parameter.load = *known;
    std::vector<std::string> names{"force", "anterior_force", "right_force", "moment", "varus_moment"};
    const auto find_in = [&](const auto& list, InputLoad kind) {
      for (std::size_t k = 0; k < list.size(); ++k) {
        names.push_back(list[k].name);
        if (is_found || list[k].name != name) continue;
        parameter.load = kind;
        parameter.load_row = k;
        is_found = true;
      }
    };
    find_in(loaded_.loads, InputLoad::applied);
    find_in(loaded_.lines, InputLoad::line);
    if (!is_found)
      refuse("load", name.empty() ? "nothing" : "\"" + name + "\"",
             "force, anterior_force, right_force, moment, varus_moment, or the name of a load or line; "
             "the nearest is \"" +
                 nearest_word(name, names) + "\"");
    if (parameter.load == InputLoad::applied && !parameter.is_factor)
      refuse("factor", "no factor", "factor = true: a [[push.load]] has a force and a moment");
    parameter.name += " " + name;
  }

  void set_component(const core::DocumentValue& value, UncertainParameter& parameter)
  {
    const std::string& name = core::text_or_empty(value, "component");
    if (!parameter.follower) parameter.body = body_at(value);
    if (parameter.is_factor) refuse("factor", "true", "false: an offset changes by mm");
    const BodyJob& body =
        parameter.follower ? job_.followers[*parameter.follower].body : part_of(job_, parameter.body);
    std::vector<std::string> names;
    for (const ComponentJob& component : body.components) {
      if (component.has_contact) names.push_back(component.name);
      if (component.name == name && component.has_contact)
        parameter.component = static_cast<std::int32_t>(&component - body.components.data());
    }
    if (std::find(names.begin(), names.end(), name) == names.end())
      refuse("component", name.empty() ? "nothing" : "\"" + name + "\"",
             "a component of " + body_name(parameter) + " in contact; the nearest is \"" +
                 nearest_word(name, names) + "\"");
    parameter.name += " " + name;
  }

  // Of one component in contact, or of all of the body.
  void set_thickness(const core::DocumentValue& value, UncertainParameter& parameter)
  {
    if (value.contains("component")) return set_component(value, parameter);
    if (!parameter.follower) parameter.body = body_at(value);
    parameter.component = -1;
    if (parameter.is_factor) refuse("factor", "true", "false: a thickness changes by mm");
    if (!parameter.follower) parameter.name += " " + body_name(parameter);
  }

  std::string body_name(const UncertainParameter& parameter) const
  {
    std::vector<std::string> followers;
    for (const Follower& follower : loaded_.followers) followers.push_back(follower.name);
    return model::object_name(parameter.body, followers);
  }

  void set_direction(const core::DocumentValue& value, UncertainParameter& parameter)
  {
    if (!parameter.follower) refuse("follower", "nothing", "the name of a [[follower]] of the job");
    const std::vector<TendonDirection>& directions = loaded_.followers[*parameter.follower].directions;
    const std::string& bundle = core::text_or_empty(value, "bundle");
    const auto found = std::ranges::find(directions, bundle, &TendonDirection::bundle);
    if (found == directions.end())
      refuse("bundle", bundle.empty() ? "nothing" : '"' + bundle + '"',
             "the bundle of a [[follower.direction]] of " + body_name(parameter));
    if (parameter.is_factor) refuse("factor", "true", "false: a direction changes by degrees");
    parameter.term = static_cast<std::size_t>(found - directions.begin());
    parameter.name += " " + bundle;
  }

  void set_term(const core::DocumentValue& value, UncertainParameter& parameter)
  {
    const std::string& name = core::text_or_empty(value, "coordinate");
    std::string known;
    for (std::size_t k = 0; k < job_.prior.size(); ++k) {
      const std::string term = name_of(job_.prior[k].coordinate);
      known += (known.empty() ? "" : ", ") + term;
      if (term == name) parameter.term = k + 1;
    }
    if (parameter.term == 0)
      refuse("coordinate", name.empty() ? "nothing" : "\"" + name + "\"",
             known.empty() ? "a job with [[prior]]" : "the coordinate of a [[prior]]: " + known);
    --parameter.term;
    if (parameter.is_factor) refuse("factor", "true", "false: the curve changes by degrees or mm");
    parameter.name += " " + name;
  }

  double number(const core::DocumentValue& value, const char* key) const
  {
    const core::DocumentValue* found = core::find_at(value, key);
    if (found == nullptr)
      refuse(key, "nothing", "a number, for distribution = \"" + core::text_at(value, "distribution") + "\"");
    return core::number_at(*found, "");
  }

  Distribution distribution_of(const core::DocumentValue& value, const UncertainParameter& parameter)
  {
    const std::string& name = core::text_at(value, "distribution");
    const bool is_in_ball = is_vector(parameter.quantity);
    Distribution distribution;
    if (is_in_ball && name != "normal" && name != "uniform")
      refuse("distribution", "\"" + name + "\"",
             "\"normal\" (sd along each axis) or \"uniform\" (to: radius)");
    if (name == "normal" || name == "lognormal") {
      distribution.kind = name == "normal" ? DistributionKind::normal : DistributionKind::lognormal;
      const core::DocumentValue* mean = core::find_at(value, "mean");
      distribution.mean = mean != nullptr ? core::number_at(*mean, "") : parameter.is_factor ? 1.0 : 0.0;
      distribution.sd = number(value, "sd");
      if (distribution.kind == DistributionKind::lognormal && !(distribution.mean > 0.0))
        refuse("mean", shortest_decimal(distribution.mean), "a median above 0, or factor = true");
      return distribution;
    }
    if (name == "uniform") {
      distribution.kind = DistributionKind::uniform;
      distribution.to = number(value, "to");
      distribution.from = is_in_ball ? 0.0 : number(value, "from");
      if (!(distribution.from < distribution.to))
        refuse("to", shortest_decimal(distribution.to), "more than " + shortest_decimal(distribution.from));
      return distribution;
    }
    distribution.kind = DistributionKind::table;
    distribution.values = values_of(value);
    std::sort(distribution.values.begin(), distribution.values.end());
    return distribution;
  }

  std::vector<double> values_of(const core::DocumentValue& value)
  {
    const std::string& file = core::text_or_empty(value, "file");
    if (const core::DocumentValue* values = core::find_at(value, "values")) {
      if (!file.empty()) refuse("values", "both values and file", "one of them");
      return core::numbers_of(*values);
    }
    if (file.empty()) refuse("values", "nothing", "a list of numbers, or file and column");
    const std::string& column = core::text_or_empty(value, "column");
    const InputFile input = input_file(job_, data_directory_, {at_ + ".file", file, "a CSV file"});
    loaded_uncertainty_.inputs.push_back({file, sha256_of(input.bytes)});
    return column_of(input, column);
  }

  static std::vector<double> column_of(const InputFile& input, const std::string& name)
  {
    const CsvTable table(input.path, input.bytes, {"value", "values", "values of a distribution"});
    table.require_rows(largest_value_table);
    std::vector<double> values = table.numbers(table.column_named(name, "column = "));
    if (values.size() < 2)
      table.refuse(table.header(), name, "one value", "at least two values of the distribution");
    return values;
  }

  // A normal distribution is cut off where values end; the others must not reach beyond.
  void check_range(const UncertainParameter& parameter) const
  {
    const Distribution& distribution = parameter.distribution;
    if (parameter.quantity == InputQuantity::reference_strain && !parameter.is_factor &&
        distribution.kind == DistributionKind::normal && distribution.sd > 1.0)
      refuse("sd", shortest_decimal(distribution.sd), "a standard deviation of strain, at most 1");
    if (distribution.kind == DistributionKind::normal || distribution.kind == DistributionKind::lognormal ||
        is_vector(parameter.quantity))
      return;
    const double smallest =
        distribution.kind == DistributionKind::uniform ? distribution.from : distribution.values.front();
    const auto require = [&](bool is_valid, const char* wanted) {
      if (!is_valid)
        refuse(distribution.kind == DistributionKind::uniform ? "from" : "values", shortest_decimal(smallest),
               wanted);
    };
    const bool is_factor = parameter.is_factor;
    if (parameter.quantity == InputQuantity::stiffness) {
      for (const std::size_t k : parameter.fibres)
        require(
            (is_factor ? 0.0 : ligaments_of(loaded_, parameter.follower).fibres[k].stiffness_n) + smallest >
                0.0,
            "values that keep every stiffness above 0");
    } else if (parameter.quantity == InputQuantity::offset) {
      const Part& part = body_of(loaded_, parameter).contact;
      for (std::size_t t = 0; t < part.component.size(); ++t) {
        if (part.component[t] == parameter.component)
          return require(offset_mm(part.mesh, static_cast<Eigen::Index>(t)) + smallest >= 0.0,
                         "values that keep the offset at or above 0");
      }
    } else if (parameter.quantity == InputQuantity::load && is_factor) {
      require(
          parameter.load == InputLoad::moment || parameter.load == InputLoad::varus_moment || smallest >= 0.0,
          "factors at or above 0");
    } else if (parameter.quantity == InputQuantity::load && parameter.follower) {
      require(load_n(loaded_.followers[*parameter.follower], parameter.load) + smallest >= 0.0,
              "changes that keep the force at or above 0");
    } else if (parameter.quantity == InputQuantity::load &&
               (parameter.load == InputLoad::force || parameter.load == InputLoad::line)) {
      for (const Push& push : loaded_.push)
        require((parameter.load == InputLoad::force ? push.force_n.dot(push.delta)
                                                    : push.line_tension_n[parameter.load_row]) +
                        smallest >=
                    0.0,
                "changes that keep the force at or above 0 at every flexion");
    }
  }

  const Job& job_;
  const std::string& data_directory_;
  const Case& loaded_;
  const LoadedLigaments& ligaments_;
  std::string at_;
  std::set<std::string> names_;
  LoadedUncertainty loaded_uncertainty_;
};

}  // namespace

const std::string& shared_name(const model::Fibre& fibre, SharedBy shared_by)
{
  static const std::string all = name_of(SharedBy::all);
  return shared_by == SharedBy::fibre ? fibre.name : shared_by == SharedBy::bundle ? fibre.bundle : all;
}

void choose_fibres(const core::Document& document, const std::string& key,
                   const std::vector<model::Fibre>& fibres, const FibreWords& words, Parameter& parameter)
{
  const bool is_attachment = parameter.quantity == InputQuantity::attachment;
  const bool is_bundle = words.fibre.empty();
  const std::string& word = is_bundle ? words.bundle : words.fibre;
  std::vector<std::string> known;
  bool is_known = false;
  for (std::size_t k = 0; k < fibres.size(); ++k) {
    known.push_back(is_bundle ? fibres[k].bundle : fibres[k].name);
    if (!word.empty() && known.back() != word) continue;
    is_known = true;
    // A line has neither stiffness nor strain; a follower's fibre ends on two of several bodies.
    if (is_attachment ? fibres[k].from == parameter.body || fibres[k].to == parameter.body
                      : !(fibres[k].tension_n > 0.0))
      parameter.fibres.push_back(k);
  }
  if (!parameter.fibres.empty()) return;
  if (fibres.empty())
    document.refuse(key + ".quantity", "a quantity of fibres", "[ligaments], or another quantity");
  if (is_known && is_attachment)
    document.refuse(key + ".body", '"' + words.body + '"', "an object on which these fibres end");
  if (is_known)
    document.refuse(key + ".quantity",
                    std::string(name_of(parameter.quantity)) + " of lines of constant tension",
                    "fibres with a stiffness");
  document.refuse(key + (is_bundle ? ".bundle" : ".fibre"), '"' + word + '"',
                  std::string(is_bundle ? "a bundle" : "a fibre") + " of the job; the nearest is \"" +
                      nearest_word(word, known) + '"');
}

LoadedUncertainty load_uncertainty(const Job& job, const std::string& data_directory, const Case& loaded,
                                   const LoadedLigaments& ligaments)
{
  const core::DocumentValue* table = core::find_at(job.document.root, "uncertainty");
  if (table == nullptr) return {};
  return UncertaintyReader(job, data_directory, loaded, ligaments).read(*table);
}

namespace {

// Functions of the C library differ in their last bits between processors; these use arithmetic only.
constexpr double ln_2_high = 0x1.62e42fee00000p-1, ln_2_low = 0x1.a39ef35793c76p-33;
constexpr double root_of_2_pi = 2.50662827463100050242;
constexpr double farthest_score = 9.0;  // beyond: a probability of 1e-19

double exponential(double x)
{
  const double n = std::round(x / (ln_2_high + ln_2_low));
  const double rest = (x - n * ln_2_high) - n * ln_2_low;
  double sum = 1.0;
  for (int k = 20; k > 0; --k) sum = 1.0 + sum * rest / k;
  return std::ldexp(sum, static_cast<int>(n));
}

double logarithm(double x)
{
  int power = 0;
  double part = std::frexp(x, &power);  // from 0.5 to 1
  if (part < 0.70710678118654752) {
    part *= 2.0;
    --power;
  }
  const double s = (part - 1.0) / (part + 1.0);
  double sum = 0.0;
  for (int k = 41; k > 0; k -= 2) sum = 1.0 / k + sum * s * s;
  return 2.0 * s * sum + (power * ln_2_low + power * ln_2_high);
}

// Sum of z^(2n + 1) / (1 3 ... (2n + 1)) from n = `first` on.
double odd_series(double z, int first)
{
  double term = z, sum = first == 0 ? z : 0.0;
  for (int n = 1; n < 400 && term > 1e-18 * sum; ++n) {
    term *= z * z / (2 * n + 1);
    sum += term;
  }
  return sum;
}

double density(double score)
{
  return exponential(-0.5 * score * score) / root_of_2_pi;
}

double table_quantile(const std::vector<double>& values, double probability)
{
  const double at = probability * static_cast<double>(values.size() - 1);
  const auto below = std::min(static_cast<std::size_t>(at), values.size() - 2);
  const double share = at - static_cast<double>(below);
  return (1.0 - share) * values[below] + share * values[below + 1];
}

// The probability of values at or below `value`.
double table_probability(const std::vector<double>& values, double value)
{
  const auto [row, share] = position_on(values, value);
  return (static_cast<double>(row) + share) / static_cast<double>(values.size() - 1);
}

double probability_below(const job::Distribution& distribution, double value)
{
  switch (distribution.kind) {
    case job::DistributionKind::normal:
      return probability_of_score((value - distribution.mean) / distribution.sd);
    case job::DistributionKind::lognormal:
      return value > 0.0 ? probability_of_score(logarithm(value / distribution.mean) / distribution.sd) : 0.0;
    case job::DistributionKind::uniform:
      return std::clamp((value - distribution.from) / (distribution.to - distribution.from), 0.0, 1.0);
    case job::DistributionKind::table:
      return table_probability(distribution.values, value);
  }
  return 0.0;
}

}  // namespace

double probability_of_score(double score)
{
  const double size = std::abs(score);
  if (size > farthest_score) return score > 0.0 ? 1.0 : 0.0;
  const double half = density(size) * odd_series(size, 0);
  return score > 0.0 ? 0.5 + half : 0.5 - half;
}

double score_of_probability(double probability)
{
  if (probability > 0.5) return -score_of_probability(1.0 - probability);
  double low = -farthest_score, high = 0.0;
  for (int k = 0; k < 60; ++k) {
    const double middle = 0.5 * (low + high);
    (probability_of_score(middle) < probability ? low : high) = middle;
  }
  return 0.5 * (low + high);
}

double radius_in_ball(double size)
{
  if (size > farthest_score) return 1.0;
  const double probability = 2.0 * density(size) * odd_series(size, 1);  // chi, three degrees of freedom
  double radius = 1.0;
  for (int k = 0; k < 200; ++k) radius -= (radius - probability / (radius * radius)) / 3.0;
  return radius;
}

double quantile_of(const job::Distribution& distribution, double probability)
{
  switch (distribution.kind) {
    case job::DistributionKind::normal:
      return distribution.mean + distribution.sd * score_of_probability(probability);
    case job::DistributionKind::lognormal:
      return distribution.mean * exponential(distribution.sd * score_of_probability(probability));
    case job::DistributionKind::uniform:
      return distribution.from + probability * (distribution.to - distribution.from);
    case job::DistributionKind::table:
      return table_quantile(distribution.values, probability);
  }
  return 0.0;
}

double quantile_above(const job::Distribution& distribution, double probability, double least)
{
  const double cut = probability_below(distribution, least);
  if (cut == 0.0) return quantile_of(distribution, probability);
  check(cut < 1.0, "a distribution reaches above its limit");
  return quantile_of(distribution, cut + probability * (1.0 - cut));
}

}  // namespace vrda::job
