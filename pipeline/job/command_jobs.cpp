// [fit] of a job: what `vrda fit --to` may change.
#include "job/job_parts.hpp"

#include <algorithm>
#include <functional>
#include <limits>

#include "core/axis.hpp"
#include "core/document.hpp"
#include "core/units.hpp"

namespace vrda::job {
namespace {

// The keys of each quantity besides sd, from and to: those it may have, and of these those it must have.
struct QuantityKeys {
  std::vector<std::string> may, must;
};

const QuantityKeys& keys_of(InputQuantity quantity)
{
  static const QuantityKeys all[] = {
      {{"fibre", "bundle"}, {}},
      {{"fibre", "bundle", "body", "axis"}, {"body", "axis"}},
      {{"load", "flexion_deg"}, {"load"}},
  };
  return all[static_cast<std::size_t>(quantity)];
}

// Refuses what only the joint or only a follower has.
void check_owner(const core::Document& document, const FitParameterJob& parameter, const std::string& key)
{
  const bool is_joint = parameter.follower.empty();
  const bool is_load_of_follower = parameter.load == "push" || parameter.load == "tension";
  if (!parameter.load.empty() && is_load_of_follower == is_joint)
    document.refuse(
        key + ".load", '"' + parameter.load + '"',
        is_joint ? "a load of [push], or the key follower" : "\"push\" or \"tension\", of a follower");
  if (is_joint && !parameter.body.empty() && parameter.body != "reference" && parameter.body != "moving")
    document.refuse(key + ".body", '"' + parameter.body + '"', "\"reference\" or \"moving\"");
  if (!is_joint && !parameter.flexion_deg.empty())
    document.refuse(key + ".flexion_deg", "this key", "no value: the load of a follower is constant");
}

FitParameterJob parameter_of(const core::Document& document, const core::DocumentValue& value,
                             const std::string& key)
{
  FitParameterJob parameter;
  parameter.follower = core::text_or_empty(value, "follower");
  if (!parameter.follower.empty()) follower_named(document, key + ".follower", parameter.follower);
  const std::string& quantity = core::text_at(value, "quantity");
  parameter.quantity = core::value_named<InputQuantity>(quantity).value();
  const QuantityKeys& keys = keys_of(parameter.quantity);
  for (const char* name : {"fibre", "bundle", "body", "axis", "load", "flexion_deg"}) {
    const bool has = value.contains(name);
    const auto is_in = [&](const std::vector<std::string>& list) {
      return std::find(list.begin(), list.end(), name) != list.end();
    };
    if (has && !is_in(keys.may))
      document.refuse(key + "." + name, "this key", "no value: the quantity is " + quantity);
    if (!has && is_in(keys.must))
      document.refuse(key + "." + name, "nothing", "this key, since the quantity is " + quantity);
  }
  parameter.fibre = core::text_or_empty(value, "fibre");
  parameter.bundle = core::text_or_empty(value, "bundle");
  if (!parameter.fibre.empty() && !parameter.bundle.empty())
    document.refuse(key, "both fibre and bundle", "one of them, or none for all fibres");
  parameter.shared_by = core::value_named<SharedBy>(core::text_at(value, "shared_by")).value();
  parameter.body = core::text_or_empty(value, "body");
  parameter.axis = core::text_or_empty(value, "axis");
  parameter.load = core::text_or_empty(value, "load");
  if (value.contains("flexion_deg")) parameter.flexion_deg = core::numbers_at(value, "flexion_deg");
  const std::vector<double>& flexions = parameter.flexion_deg;
  if (std::adjacent_find(flexions.begin(), flexions.end(), std::greater_equal<>()) != flexions.end())
    document.refuse(key + ".flexion_deg", core::shown(core::value_at(value, "flexion_deg")),
                    "ascending angles");
  check_owner(document, parameter, key);
  parameter.sd = core::number_at(value, "sd");
  parameter.from = core::number_at(value, "from");
  parameter.to = core::number_at(value, "to");
  if (parameter.from == parameter.to) document.refuse(key + ".to", "0, as from", "a range of changes");
  return parameter;
}

}  // namespace

namespace {

// Coordinates from `first` on by their names; true if one is finite.
bool read_noise(const core::DocumentValue& value, const std::array<const char*, n_joint_coordinates>& names,
                std::size_t first, std::array<double, n_joint_coordinates>& noise)
{
  bool is_fitted = false;
  for (std::size_t k = first; k < n_joint_coordinates; ++k) {
    const double given = core::number_at(value, std::string("noise.") + names[k] + unit_suffix(k));
    noise[k] = from_file(given, k);
    is_fitted = is_fitted || given < std::numeric_limits<double>::infinity();
  }
  return is_fitted;
}

}  // namespace

std::optional<FitJob> fit_of(const core::Document& document)
{
  const core::DocumentValue* table = core::find_at(document.root, "fit");
  if (table == nullptr) return std::nullopt;
  FitJob fit;
  fit.noise.fill(std::numeric_limits<double>::infinity());
  bool is_fitted = read_noise(*table, joint_coordinate_names, 1, fit.noise);
  for (const core::DocumentValue& value : core::list_or_empty(*table, "follower")) {
    const std::string& name = core::text_at(value, "name");
    const std::string key = "fit.follower." + std::to_string(fit.follower_noise.size());
    follower_named(document, key + ".name", name);
    const auto [noise, is_new] = fit.follower_noise.emplace(name, std::array<double, n_joint_coordinates>{});
    if (!is_new) document.refuse(key + ".name", '"' + name + "\" a second time", "each follower once");
    is_fitted = read_noise(value, follower_coordinate_names, 0, noise->second) || is_fitted;
  }
  if (!is_fitted) document.refuse("fit.noise", "no coordinate to fit", "at least one that is not inf");
  fit.independent_deg = core::number_at(*table, "independent_deg");
  for (const core::DocumentValue& value : core::value_at(*table, "parameter")) {
    const std::string key = "fit.parameter." + std::to_string(fit.parameters.size());
    fit.parameters.push_back(parameter_of(document, value, key));
  }
  return fit;
}

// [laxity] of a job: the loads of `vrda laxity`; and a job over other flexions with free varus.

std::optional<LaxityJob> laxity_of(const core::Document& document)
{
  const core::DocumentValue* table = core::find_at(document.root, "laxity");
  if (table == nullptr) return std::nullopt;
  const auto load = [&](const char* key) {
    const core::DocumentValue* value = core::find_at(*table, key);
    return value == nullptr ? 0.0 : core::number_at(*value, "");
  };
  LaxityJob laxity;
  laxity.flexion_deg = core::numbers_at(*table, "flexion_deg");
  if (std::adjacent_find(laxity.flexion_deg.begin(), laxity.flexion_deg.end(), std::greater_equal<>()) !=
      laxity.flexion_deg.end())
    document.refuse("laxity.flexion_deg", core::shown(core::value_at(*table, "flexion_deg")),
                    "ascending angles");
  laxity.anterior_force_n = load("anterior_force_n");
  laxity.internal_moment_nmm = load("internal_moment_nmm");
  laxity.varus_moment_nmm = load("varus_moment_nmm");
  if (laxity.anterior_force_n + laxity.internal_moment_nmm + laxity.varus_moment_nmm == 0.0)
    document.refuse("laxity", "no load", "one of anterior_force_n, internal_moment_nmm and varus_moment_nmm");
  laxity.load_steps = static_cast<int>(core::integer_at(*table, "load_steps"));
  if (const core::DocumentValue* cuts = core::find_at(*table, "cut")) {
    for (const core::DocumentValue& cut : *cuts)
      laxity.cuts.push_back({core::text_at(cut, "name"), core::texts_at(cut, "bundles")});
  }
  return laxity;
}

Job over_flexions(const Job& job, const std::vector<double>& flexion_deg)
{
  if (job.method != SolverMethod::equilibrium)
    job.document.refuse("solver.method", "\"stability-search\"", "\"equilibrium\": a search has no loads");
  if (job.coordinates) job.document.refuse("coordinates", "coordinates with roles of their own", "[grid]");
  if (job.push.is_fixed_in_reference) job.document.refuse("push.frame", "\"reference\"", "\"world\"");
  for (Eigen::Index row = 0; row < job.push.delta.value.rows(); ++row) {
    const Eigen::Vector3d delta = job.push.delta.value.row(row).transpose();
    if (delta != Eigen::Vector3d::UnitY())
      job.document.refuse("push.delta", core::shown(core::value_at(job.document.root, "push.delta")),
                          "[0, 1, 0]: loads act on the joint's own coordinates");
  }
  Job over = job;
  over.grid = {flexion_deg, {0.0}};
  over.is_varus_free = true;
  over.smooth_degrees.clear();
  // No warnings of a grid that is not used.
  over.document.root.erase("grid");
  return over;
}

namespace {

std::vector<double> row_of(const core::DocumentValue& value)
{
  return value.is_array() ? core::numbers_of(value) : std::vector<double>{core::number_at(value, "")};
}

// `key` is that of the value, for messages; `n` its number of components.
FlexionTable over_flexion_of(const core::Document& document, const core::DocumentValue& value,
                             const std::string& key, std::size_t n)
{
  FlexionTable out;
  if (value.contains("columns")) {
    out.columns = core::texts_at(value, "columns");
    out.key = key + ".columns";
    if (out.columns.size() != n)
      document.refuse(out.key, std::to_string(out.columns.size()) + " columns", std::to_string(n));
    if (!document.root.contains("frames"))
      document.refuse(out.key, "columns without [frames]", "[frames] with file = \"motion.csv\", or numbers");
    return out;
  }
  std::vector<std::vector<double>> rows;
  if (!value.is_object()) {
    out.flexion_rad = {0.0};
    rows = {row_of(value)};
  } else {
    out.is_over_driving = value.contains("driving");
    out.key = key;
    if (out.is_over_driving == (value.contains("flexion_deg")))
      document.refuse(key, out.is_over_driving ? "flexion_deg and driving" : "value alone",
                      "flexion_deg or driving");
    const char* const at = out.is_over_driving ? "driving" : "flexion_deg";
    for (const double given : core::numbers_at(value, at)) {
      const double x = out.is_over_driving ? given : rad_from_deg(given);
      if (!out.flexion_rad.empty() && x <= out.flexion_rad.back())
        document.refuse(key + "." + at, core::shown(core::value_at(value, at)), "increasing values");
      out.flexion_rad.push_back(x);
    }
    for (const core::DocumentValue& row : core::value_at(value, "value")) rows.push_back(row_of(row));
    if (rows.size() != out.flexion_rad.size()) {
      document.refuse(
          key + ".value", std::to_string(rows.size()) + " values",
          std::string("one for each value of ") + at + ", " + std::to_string(out.flexion_rad.size()));
    }
  }
  out.value.resize(static_cast<Eigen::Index>(rows.size()), static_cast<Eigen::Index>(rows.front().size()));
  for (Eigen::Index i = 0; i < out.value.rows(); ++i) {
    for (Eigen::Index j = 0; j < out.value.cols(); ++j) {
      out.value(i, j) = rows[static_cast<std::size_t>(i)][static_cast<std::size_t>(j)];
    }
  }
  return out;
}

}  // namespace

FlexionTable over_flexion_at(const core::Document& document, const std::string& key, std::size_t n)
{
  return over_flexion_of(document, core::value_at(document.root, key), key, n);
}

namespace {

FlexionTable delta_at(const core::Document& document)
{
  FlexionTable delta = over_flexion_at(document, "push.delta", 3);
  for (Eigen::Index i = 0; i < delta.value.rows(); ++i) {
    const Eigen::Vector3d given = delta.value.row(i);
    // Scaled first: squares of huge or tiny components would leave the range of doubles.
    const double largest = given.cwiseAbs().maxCoeff();
    if (!(largest > 0.0))
      document.refuse("push.delta", core::shown(core::value_at(document.root, "push.delta")),
                      "a direction: not all zero");
    delta.value.row(i) = (given / largest).normalized().transpose();
  }
  return delta;
}

// Adds a name; refuses one that an earlier entry of the list has.
void add_name(const core::Document& document, const std::string& key, const std::string& name,
              std::vector<std::string>& names)
{
  if (std::find(names.begin(), names.end(), name) != names.end())
    document.refuse(key + ".name", "\"" + name + "\" a second time", "a unique name");
  names.push_back(name);
}

// Everywhere, as far as the job file says.
bool is_zero(const FlexionTable& setting)
{
  return setting.columns.empty() && setting.value.isZero(0.0);
}

LoadJob load_of(const core::Document& document, const core::DocumentValue& value, const std::string& key)
{
  LoadJob load;
  load.at = {core::text_at(value, "name"),
             core::value_named<BodyIndex>(core::text_at(value, "frame")).value(),
             core::vector3_at(value, "point_mm")};
  load.force_n = over_flexion_of(document, core::value_at(value, "force_n"), key + ".force_n", 3);
  load.moment_nmm = over_flexion_of(document, core::value_at(value, "moment_nmm"), key + ".moment_nmm", 3);
  if (is_zero(load.force_n) && is_zero(load.moment_nmm)) {
    document.refuse(key + ".force_n", core::shown(core::value_at(value, "force_n")) + " without a moment",
                    "a force or a moment that is not zero");
  }
  return load;
}

std::vector<Eigen::Vector3d> points_of(const core::DocumentValue& value, const std::string& key)
{
  std::vector<Eigen::Vector3d> points;
  for (const std::vector<double>& row : core::rows_at(value, key))
    points.emplace_back(row[0], row[1], row[2]);
  return points;
}

LineJob line_of(const core::Document& document, const core::DocumentValue& value, const std::string& key)
{
  LineJob line;
  line.path = {core::text_at(value, "name"), points_of(value, "reference_mm"), points_of(value, "moving_mm")};
  line.tension_n = over_flexion_of(document, core::value_at(value, "tension_n"), key + ".tension_n", 1);
  if (is_zero(line.tension_n))
    document.refuse(key + ".tension_n", core::shown(core::value_at(value, "tension_n")),
                    "a tension above 0 N at some flexion");
  if (line.path.reference_mm.back() == line.path.moving_mm.front())
    document.refuse(key + ".moving_mm", "a first point that is the last of reference_mm",
                    "another point: the line has no direction between the objects");
  return line;
}

}  // namespace

Eigen::VectorXd value_at_flexion(const FlexionTable& setting, double flexion_rad)
{
  const auto [at, share] = position_on(setting.flexion_rad, flexion_rad);
  const auto row = static_cast<Eigen::Index>(at);
  if (share == 0.0) return setting.value.row(row).transpose();
  return ((1.0 - share) * setting.value.row(row) + share * setting.value.row(row + 1)).transpose();
}

PushJob push_of(const core::Document& document)
{
  const core::DocumentValue& root = document.root;
  PushJob push;
  push.delta = delta_at(document);
  push.is_fixed_in_reference = core::text_or_empty(core::value_at(root, "push"), "frame") == "reference";
  push.force_n = over_flexion_at(document, "push.force_n", 1);
  push.lateral_force_n = over_flexion_at(document, "push.lateral_force_n", 2);
  push.moment_nmm = over_flexion_at(document, "push.moment_nmm", 1);
  push.varus_moment_nmm = over_flexion_at(document, "push.varus_moment_nmm", 1);
  push.point_mm = core::vector3_at(root, "push.point_mm");
  std::vector<std::string> load_names, line_names;
  for (const core::DocumentValue& value : core::list_or_empty(root, "push.load")) {
    const std::string key = "push.load." + std::to_string(push.loads.size());
    push.loads.push_back(load_of(document, value, key));
    add_name(document, key, push.loads.back().at.name, load_names);
  }
  for (const core::DocumentValue& value : core::list_or_empty(root, "push.line")) {
    const std::string key = "push.line." + std::to_string(push.lines.size());
    push.lines.push_back(line_of(document, value, key));
    add_name(document, key, push.lines.back().path.name, line_names);
  }
  return push;
}

std::vector<PushTable> tables_of(PushJob& push)
{
  const double any = std::numeric_limits<double>::quiet_NaN();
  std::vector<PushTable> tables{{&push.force_n, 0.0, true},
                                {&push.lateral_force_n, any},
                                {&push.moment_nmm, any},
                                {&push.varus_moment_nmm, any}};
  for (LoadJob& load : push.loads) {
    tables.push_back({&load.force_n, any});
    tables.push_back({&load.moment_nmm, any});
  }
  for (LineJob& line : push.lines) tables.push_back({&line.tension_n, 0.0});
  return tables;
}

Push push_at(const PushJob& job, const Eigen::Vector3d& delta, double flexion_rad, std::size_t frame)
{
  const auto value_of = [&](const FlexionTable& setting) -> Eigen::VectorXd {
    if (setting.columns.empty()) return value_at_flexion(setting, flexion_rad);
    return setting.value.row(static_cast<Eigen::Index>(frame)).transpose();
  };
  Push push;
  push.delta = delta;
  const Eigen::Vector2d across_n = value_of(job.lateral_force_n);
  push.force_n = value_of(job.force_n)[0] * delta + shortest_rotation(Eigen::Vector3d::UnitY(), delta) *
                                                        Eigen::Vector3d(across_n[0], 0.0, across_n[1]);
  push.moment_nmm = value_of(job.moment_nmm)[0];
  push.varus_moment_nmm = value_of(job.varus_moment_nmm)[0];
  for (const LoadJob& load : job.loads) {
    push.load_force_n.emplace_back(value_of(load.force_n));
    push.load_moment_nmm.emplace_back(value_of(load.moment_nmm));
  }
  for (const LineJob& line : job.lines) push.line_tension_n.push_back(value_of(line.tension_n)[0]);
  return push;
}

// [[prior]] of a job.

namespace {

// Passive motion of cadaver knees (Walker, Rovick and Robertson 1988, J Biomech 21:965-974): polynomials of
// flexion in degrees, from its first power. Their translation is that of the femur on the tibia.
struct PublishedCurve {
  PriorCoordinate coordinate;
  std::array<double, 4> coefficient;
};
constexpr PublishedCurve walker_1988[] = {{PriorCoordinate::varus, {0.0791, -5.733e-4, -7.682e-6, 5.759e-8}},
                                          {PriorCoordinate::internal, {0.3695, -2.958e-3, 7.666e-6, 0.0}},
                                          {PriorCoordinate::centre_anterior, {-0.1283, 4.796e-4, 0.0, 0.0}}};
constexpr int last_published_deg = 120;

void set_published(const core::Document& document, const std::string& key, PriorTerm& term)
{
  const auto* const curve = std::find_if(std::begin(walker_1988), std::end(walker_1988),
                                         [&](const auto& one) { return one.coordinate == term.coordinate; });
  if (curve == std::end(walker_1988)) {
    document.refuse(key + ".shape", "\"walker-1988\" of " + std::string(name_of(term.coordinate)),
                    "a table { flexion_deg, value }: published are varus, internal and centre_anterior");
  }
  for (int deg = 0; deg <= last_published_deg; ++deg) {
    double value = 0.0;
    for (std::size_t k = curve->coefficient.size(); k-- > 0;) value = (value + curve->coefficient[k]) * deg;
    term.flexion_rad.push_back(rad_from_deg(deg));
    term.value.push_back(is_angle(term.coordinate) ? rad_from_deg(value) : value);
  }
}

void set_table(const core::Document& document, const core::DocumentValue& value, const std::string& key,
               PriorTerm& term)
{
  const FlexionTable table = over_flexion_of(document, value, key, 1);
  if (table.is_over_driving) document.refuse(key + ".driving", "values of a coordinate", "flexion_deg");
  term.flexion_rad = table.flexion_rad;
  for (Eigen::Index i = 0; i < table.value.rows(); ++i)
    term.value.push_back(is_angle(term.coordinate) ? rad_from_deg(table.value(i, 0)) : table.value(i, 0));
}

PriorTerm prior_term_of(const core::Document& document, const core::DocumentValue& value,
                        const std::string& key)
{
  PriorTerm term;
  term.coordinate = core::value_named<PriorCoordinate>(core::text_at(value, "coordinate")).value();
  const core::DocumentValue& shape = core::value_at(value, "shape");
  term.shape = shape.is_string() ? shape.get<std::string>() : "table";
  if (shape.is_string())
    set_published(document, key, term);
  else
    set_table(document, shape, key + ".shape", term);
  const core::DocumentValue& stiffness = core::value_at(value, "stiffness");
  term.has_factor = stiffness.is_object();
  term.stiffness = core::number_at(stiffness, term.has_factor ? "at_least" : "");
  if (stiffness.contains("times_own")) term.times_own = core::number_at(stiffness, "times_own");
  if (term.has_factor) term.at_most_times = core::number_at(stiffness, "at_most_times");
  const core::DocumentValue& level = core::value_at(value, "level");
  if (level.is_number())
    term.level = is_angle(term.coordinate) ? rad_from_deg(level.get<double>()) : level.get<double>();
  return term;
}

}  // namespace

std::vector<PriorTerm> prior_of(const core::Document& document, const PushJob& push, double band_moment_nmm)
{
  std::vector<PriorTerm> terms;
  int n_definitions = 0;
  for (const core::DocumentValue& value : core::list_or_empty(document.root, "prior")) {
    const std::string key = "prior." + std::to_string(terms.size());
    const PriorTerm term = prior_term_of(document, value, key);
    if (std::any_of(terms.begin(), terms.end(),
                    [&](const PriorTerm& t) { return t.coordinate == term.coordinate; }))
      document.refuse(key + ".coordinate", std::string(name_of(term.coordinate)) + " a second time",
                      "each coordinate once");
    if (term.times_own > 0.0 && term.coordinate != PriorCoordinate::internal)
      document.refuse(
          key + ".stiffness.times_own", "this key",
          "none: the joint's own stiffness is measured about Delta, of coordinate = \"internal\"");
    n_definitions += term.times_own > 0.0 ? 1 : 0;
    terms.push_back(term);
  }
  if (terms.empty()) return terms;
  if (core::text_at(document.root, "solver.method") != "equilibrium")
    document.refuse("prior", "[[prior]] with \"stability-search\"", "solver.method = \"equilibrium\"");
  for (const char* other : {"coordinates", "frames"}) {
    if (document.root.contains(other))
      document.refuse("prior", "[[prior]] with [" + std::string(other) + "]", "[grid]");
  }
  const bool is_turned = push.is_fixed_in_reference || push.delta.value.rows() != 1 ||
                         Eigen::Vector3d(push.delta.value.row(0)) != Eigen::Vector3d::UnitY();
  if (is_turned) document.refuse("prior", "[[prior]] with another push.delta", "push.delta = [0, 1, 0]");
  for (std::size_t k = 0; k < terms.size(); ++k) {
    if (terms[k].has_factor && n_definitions == 0)
      document.refuse("prior." + std::to_string(k) + ".stiffness", "at_least without times_own",
                      "times_own of coordinate = \"internal\", or a number");
  }
  if (n_definitions > 0 && band_moment_nmm == 0.0)
    document.refuse("solver.equilibrium.band_moment_nmm", "0 with times_own of [[prior]]",
                    "a moment above 0, which measures the joint's own stiffness");
  return terms;
}

}  // namespace vrda::job
