#include "store/motion.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <utility>

#include "core/axis.hpp"
#include "core/text.hpp"
#include "model/mesh.hpp"

namespace vrda::store {
AxisRanges axis_ranges(const std::vector<double>& flexion_deg, const std::vector<double>& varus_deg)
{
  check(!flexion_deg.empty() && !varus_deg.empty(), "an axis must have at least one value");
  return {{flexion_deg.front(), flexion_deg.back()}, {varus_deg.front(), varus_deg.back()}};
}

LegendreTable legendre(double u, int degree)
{
  check(degree >= 0 && degree <= max_smoothed_degree, "the degree must not exceed the table");
  LegendreTable table;
  table.value[0] = 1.0;
  if (degree > 0) table.value[1] = u;
  // Bonnet: (n + 1) P_{n+1} = (2n + 1) u P_n - n P_{n-1}.
  for (int n = 1; n < degree; ++n)
    table.value[n + 1] = ((2 * n + 1) * u * table.value[n] - n * table.value[n - 1]) / (n + 1);
  return table;
}

double unit_coordinate(double x_deg, const AxisRange& range)
{
  if (range.first_deg == range.last_deg) return 0.0;
  // Exactly -1 and 1 at the ends.
  return ((x_deg - range.first_deg) - (range.last_deg - x_deg)) / (range.last_deg - range.first_deg);
}

double evaluate(const SmoothedSet& set, const SmoothedSurface& surface, const AxisRanges& ranges,
                double flexion_deg, double varus_deg)
{
  const LegendreTable P = legendre(unit_coordinate(flexion_deg, ranges.flexion), set.degree);
  const LegendreTable Q = legendre(unit_coordinate(varus_deg, ranges.varus), set.degree);
  double value = 0.0;
  for (Eigen::Index k = 0; k < set.exponents.rows(); ++k) {
    const double coefficient = surface.coefficients[static_cast<std::size_t>(k)];
    value += coefficient * P.value[set.exponents(k, 0)] * Q.value[set.exponents(k, 1)];
  }
  return value;
}

// The motion over flexion of one sample of an uncertain job.

namespace {

// Of store::band_probabilities.
constexpr std::array<const char*, 5> quantile_names{"quantile_0", "quantile_5", "quantile_50", "quantile_95",
                                                    "quantile_100"};

// The row of [5, n_flexion] as a column over flexion.
template <typename Number>
std::vector<Number> quantile_row(const std::vector<Number>& table, std::size_t row)
{
  const auto n = static_cast<std::ptrdiff_t>(table.size() / quantile_names.size());
  const auto first = table.begin() + static_cast<std::ptrdiff_t>(row) * n;
  return {first, first + n};
}

// 0 where there is a pose, else -1, as use_flexion_table() reads it.
std::vector<std::int8_t> posed_rows(std::vector<std::int8_t> status)
{
  for (std::int8_t& row : status) row = row == status_stable ? std::int8_t{0} : std::int8_t{-1};
  return status;
}

bool has_quantile(const store::UncertainMotion& motion, std::size_t row)
{
  const std::vector<std::int8_t> status = quantile_row(motion.quantile_status, row);
  return std::find(status.begin(), status.end(), status_stable) != status.end();
}

}  // namespace

std::vector<std::string> quantile_set_names(const store::MotionModel& model)
{
  std::vector<std::string> listed;
  for (std::size_t row = 0; model.uncertainty && !model.frames && row < quantile_names.size(); ++row) {
    if (has_quantile(*model.uncertainty, row)) listed.emplace_back(quantile_names[row]);
  }
  return listed;
}

std::vector<std::string> all_set_names(const store::MotionModel& model)
{
  std::vector<std::string> sets = set_names(model);
  for (std::string& name : quantile_set_names(model)) sets.push_back(std::move(name));
  if (model.prior) sets.emplace_back(store::bones_alone_name);
  return sets;
}

std::optional<store::TwoSided> quantile_motion(const store::MotionModel& model, const std::string& set)
{
  const auto name = std::find(quantile_names.begin(), quantile_names.end(), set);
  if (name == quantile_names.end()) return std::nullopt;
  check(model.uncertainty.has_value(), "the set is one of all_set_names");
  const store::UncertainMotion& table = *model.uncertainty;
  const auto row = static_cast<std::size_t>(name - quantile_names.begin());
  store::TwoSided motion;
  motion.contact = posed_rows(quantile_row(table.quantile_status, row));
  const auto to = PoseRows::columns_of(motion);
  const auto from = PoseRows::columns_of(table);
  for (std::size_t k = 0; k < to.size(); ++k) *to[k] = quantile_row(*from[k], row);
  return motion;
}

namespace {

/// Values along one grid line.
struct Line {
  const std::vector<double>& at;
  std::vector<double> value;
  std::vector<bool> is_solved;
};

/// One-sided slope at node k from the nodes on side `step` (+1 or -1).
double one_sided_slope(const Line& line, std::ptrdiff_t k, std::ptrdiff_t step)
{
  const auto value = [&](std::ptrdiff_t i) { return line.value[static_cast<std::size_t>(i)]; };
  const auto at = [&](std::ptrdiff_t i) { return line.at[static_cast<std::size_t>(i)]; };
  const auto n = static_cast<std::ptrdiff_t>(line.at.size());
  const double chord = (value(k + step) - value(k)) / (at(k + step) - at(k));
  const std::ptrdiff_t far = k + 2 * step;
  if (far < 0 || far >= n || !line.is_solved[static_cast<std::size_t>(far)]) return chord;
  const double next_chord = (value(far) - value(k + step)) / (at(far) - at(k + step));
  return chord - (at(k + step) - at(k)) * (next_chord - chord) / (at(far) - at(k));
}

double slope(const Line& line, std::ptrdiff_t k)
{
  const auto n = static_cast<std::ptrdiff_t>(line.at.size());
  const auto i = static_cast<std::size_t>(k);
  if (!line.is_solved[i]) return 0.0;
  const bool has_before = k > 0 && line.is_solved[i - 1];
  const bool has_after = k + 1 < n && line.is_solved[i + 1];
  if (has_before && has_after) {
    const double h_before = line.at[i] - line.at[i - 1], h_after = line.at[i + 1] - line.at[i];
    const double before = (line.value[i] - line.value[i - 1]) / h_before;
    const double after = (line.value[i + 1] - line.value[i]) / h_after;
    return (before * h_after + after * h_before) / (h_before + h_after);
  }
  if (has_after) return one_sided_slope(line, k, 1);
  if (has_before) return one_sided_slope(line, k, -1);
  return 0.0;
}

template <std::size_t N>
using Field = std::array<double, N> HermiteNode<N>::*;

/// Sets `slope_field` to the slopes of `value_field` along a grid line with coordinates `at`: nodes `first`,
/// `first + stride`, ...
template <std::size_t N>
void fill_slopes(HermiteGrid<N>& grid, const std::vector<double>& at, std::size_t first, std::size_t stride,
                 std::pair<Field<N>, Field<N>> value_and_slope)
{
  const auto [value_field, slope_field] = value_and_slope;
  for (std::size_t number = 0; number < N; ++number) {
    Line line{at, {}, {}};
    for (std::size_t k = 0; k < at.size(); ++k) {
      const HermiteNode<N>& node = grid.nodes[first + k * stride];
      line.value.push_back((node.*value_field)[number]);
      line.is_solved.push_back(node.is_solved);
    }
    for (std::size_t k = 0; k < at.size(); ++k) {
      (grid.nodes[first + k * stride].*slope_field)[number] = slope(line, static_cast<std::ptrdiff_t>(k));
    }
  }
}

/// Fraction of a step: far below any measured angle, far above rounding.
constexpr double on_node = 1e-9;

/// Hermite weights of the values and slopes at the two ends of a patch, along one angle.
struct Weights {
  std::array<double, 2> value{};
  std::array<double, 2> slope{};
};

/// One angle's part of a patch.
struct Span {
  std::size_t first = 0;
  double step_rad = 0.0;    ///< 0 where the axis has one value
  double s = 0.0, r = 1.0;  ///< fraction of the step from the first end, and from the second
  Weights weights{{1.0, 0.0}, {0.0, 0.0}};
};

Span span_of(const std::vector<double>& at, double x)
{
  Span span;
  if (at.size() == 1) return span;
  const auto above = std::upper_bound(at.begin() + 1, at.end() - 1, x);
  span.first = static_cast<std::size_t>(above - at.begin()) - 1;
  const double h = at[span.first + 1] - at[span.first];
  // Divided, not multiplied by 1/h: s is exactly 1 at the last node.
  double s = (x - at[span.first]) / h;
  // Snaps to a nearby node: 0.1 added three times must not use the cell beyond 0.3.
  if (std::abs(s) < on_node) s = 0.0;
  if (std::abs(1.0 - s) < on_node) s = 1.0;
  const double r = 1.0 - s;
  span.step_rad = h;
  span.s = s;
  span.r = r;
  span.weights = {{r * r * (1.0 + 2.0 * s), s * s * (1.0 + 2.0 * r)}, {h * s * r * r, -h * r * s * s}};
  return span;
}

/// Adds the contribution of a node to every surface.
template <std::size_t N>
void add(std::array<double, N>& sums, const HermiteNode<N>& node, const std::array<double, 4>& weights)
{
  for (std::size_t number = 0; number < N; ++number) {
    sums[number] += weights[0] * node.value[number] + weights[1] * node.by_flexion[number] +
                    weights[2] * node.by_varus[number] + weights[3] * node.by_both[number];
  }
}

/// Weights of a node's value and slopes, at end `a` of the patch along flexion and `b` along varus.
std::array<double, 4> product(const Weights& flexion, std::size_t a, const Weights& varus, std::size_t b)
{
  return {flexion.value[a] * varus.value[b], flexion.slope[a] * varus.value[b],
          flexion.value[a] * varus.slope[b], flexion.slope[a] * varus.slope[b]};
}

/// Calls use(node, a, b) for the corners of a patch with nonzero weight until one call returns false; returns
/// whether all returned true.
template <std::size_t N, typename Use>
bool for_corners(const HermiteGrid<N>& grid, const Span& flexion, const Span& varus, const Use& use)
{
  for (std::size_t a = 0; a < 2; ++a) {
    if (flexion.weights.value[a] == 0.0) continue;  // on a node the far end of the patch has no weight
    for (std::size_t b = 0; b < 2; ++b) {
      if (varus.weights.value[b] == 0.0) continue;
      if (!use(grid.nodes[(flexion.first + a) * grid.varus_rad.size() + varus.first + b], a, b)) return false;
    }
  }
  return true;
}

}  // namespace

template <std::size_t N>
void set_slopes(HermiteGrid<N>& grid)
{
  using Node = HermiteNode<N>;
  const std::size_t n_flexion = grid.flexion_rad.size(), n_varus = grid.varus_rad.size();
  for (std::size_t j = 0; j < n_varus; ++j) {
    fill_slopes<N>(grid, grid.flexion_rad, j, n_varus, {&Node::value, &Node::by_flexion});
  }
  for (std::size_t i = 0; i < n_flexion; ++i) {
    fill_slopes<N>(grid, grid.varus_rad, i * n_varus, 1, {&Node::value, &Node::by_varus});
    fill_slopes<N>(grid, grid.varus_rad, i * n_varus, 1, {&Node::by_flexion, &Node::by_both});
  }
}

template <std::size_t N>
HermiteSample<N> sample(const HermiteGrid<N>& grid, const Attitude& attitude)
{
  const Span flexion = span_of(grid.flexion_rad, attitude.flexion_rad);
  const Span varus = span_of(grid.varus_rad, attitude.varus_rad);
  HermiteSample<N> result;
  result.is_solved =
      for_corners(grid, flexion, varus, [&](const HermiteNode<N>& node, std::size_t a, std::size_t b) {
        if (node.is_solved) add(result.values, node, product(flexion.weights, a, varus.weights, b));
        return node.is_solved;
      });
  return result;
}

template void set_slopes(HermiteGrid<1>&);
template void set_slopes(HermiteGrid<4>&);
template void set_slopes(HermiteGrid<5>&);
template void set_slopes(HermiteGrid<6>&);
template HermiteSample<1> sample(const HermiteGrid<1>&, const Attitude&);
template HermiteSample<4> sample(const HermiteGrid<4>&, const Attitude&);
template HermiteSample<5> sample(const HermiteGrid<5>&, const Attitude&);
template HermiteSample<6> sample(const HermiteGrid<6>&, const Attitude&);

namespace {

bool ascends(const std::vector<double>& axis)
{
  return std::adjacent_find(axis.begin(), axis.end(), std::greater_equal<>()) == axis.end();
}

void check_model(const store::MotionModel& model)
{
  const auto rows = static_cast<Eigen::Index>(model.flexion_deg.size());
  const auto columns = static_cast<Eigen::Index>(model.varus_deg.size());
  check(rows > 0 && columns > 0, "a motion model has at least one flexion and one varus");
  check(ascends(model.flexion_deg) && ascends(model.varus_deg), "the axes of a motion model ascend");
  for (const store::GridD* grid : {&model.tx_mm, &model.ty_mm, &model.tz_mm, &model.theta_deg}) {
    check(grid->rows() == rows && grid->cols() == columns,
          "the surfaces of a motion model have the size of its axes");
  }
  check(model.status.rows() == rows && model.status.cols() == columns, "status has the size of the axes");
}

}  // namespace

RawSurfaces raw_surfaces(const store::MotionModel& model)
{
  check_model(model);
  RawSurfaces surfaces{radians(model.flexion_deg), radians(model.varus_deg), {}};
  const std::size_t n_flexion = surfaces.flexion_rad.size(), n_varus = surfaces.varus_rad.size();
  surfaces.nodes.resize(n_flexion * n_varus);
  for (std::size_t i = 0; i < n_flexion; ++i) {
    for (std::size_t j = 0; j < n_varus; ++j) {
      const auto row = static_cast<Eigen::Index>(i), column = static_cast<Eigen::Index>(j);
      if (model.status(row, column) != status_stable) continue;
      RawNode& node = surfaces.nodes[i * n_varus + j];
      node.is_solved = true;
      node.value = {model.tx_mm(row, column), model.ty_mm(row, column), model.tz_mm(row, column),
                    rad_from_deg(model.theta_deg(row, column))};
    }
  }
  set_slopes(surfaces);
  return surfaces;
}

namespace {

constexpr std::array<const char*, 5> names{"tx", "ty", "tz", "theta", "varus"};
constexpr std::size_t varus = 4;

/// Null if the set has no such surface; only varus may be missing.
const store::SmoothedSurface* surface_named(const store::SmoothedSet& set, std::size_t number)
{
  const auto found = std::find_if(set.surfaces.begin(), set.surfaces.end(),
                                  [&](const store::SmoothedSurface& s) { return s.name == names[number]; });
  if (found == set.surfaces.end()) {
    check(number == varus, "a smoothed set has the surfaces tx, ty, tz and theta");
    return nullptr;
  }
  check(found->coefficients.size() == static_cast<std::size_t>(set.exponents.rows()),
        "a smoothed surface has one coefficient per term");
  return &*found;
}

}  // namespace

namespace {

// Null surfaces have coefficients of 0.
template <std::size_t N>
SmoothedTerms<N> terms_of(const store::MotionModel& model, const store::SmoothedSet& set,
                          const std::array<const store::SmoothedSurface*, N>& surfaces,
                          const std::array<bool, N>& is_angle)
{
  SmoothedTerms<N> result;
  result.ranges = store::axis_ranges(model.flexion_deg, model.varus_deg);
  for (Eigen::Index k = 0; k < set.exponents.rows(); ++k) {
    SmoothedTerm<N> term{set.exponents(k, 0), set.exponents(k, 1), {}};
    result.degree = std::max({result.degree, term.flexion_degree, term.varus_degree});
    check(
        std::min(term.flexion_degree, term.varus_degree) >= 0 && result.degree <= store::max_smoothed_degree,
        "the exponents of a smoothed set fit the table of polynomials");
    for (std::size_t number = 0; number < N; ++number) {
      if (surfaces[number] == nullptr) continue;
      const double c = surfaces[number]->coefficients[static_cast<std::size_t>(k)];
      term.coefficient[number] = is_angle[number] ? rad_from_deg(c) : c;
    }
    result.terms.push_back(term);
  }
  return result;
}

}  // namespace

SmoothedSurfaces smoothed_surfaces(const store::MotionModel& model, const store::SmoothedSet& set)
{
  std::array<const store::SmoothedSurface*, names.size()> surfaces{};
  for (std::size_t number = 0; number < names.size(); ++number) surfaces[number] = surface_named(set, number);
  return {terms_of<5>(model, set, surfaces, {false, false, false, true, true}), surfaces[varus] != nullptr};
}

template <std::size_t N>
std::array<double, N> evaluate(const SmoothedTerms<N>& surfaces, const Attitude& attitude)
{
  const double u = store::unit_coordinate(deg_from_rad(attitude.flexion_rad), surfaces.ranges.flexion);
  const double v = store::unit_coordinate(deg_from_rad(attitude.varus_rad), surfaces.ranges.varus);
  const store::LegendreTable P = store::legendre(u, surfaces.degree), Q = store::legendre(v, surfaces.degree);
  std::array<double, N> numbers{};
  for (const SmoothedTerm<N>& term : surfaces.terms) {
    const double basis = P.value[term.flexion_degree] * Q.value[term.varus_degree];
    for (std::size_t number = 0; number < numbers.size(); ++number)
      numbers[number] += term.coefficient[number] * basis;
  }
  return numbers;
}
template std::array<double, 5> evaluate(const SmoothedTerms<5>&, const Attitude&);
template std::array<double, 6> evaluate(const SmoothedTerms<6>&, const Attitude&);

namespace {

std::string name_of(const store::SmoothedSet& set)
{
  return "degree_" + std::to_string(set.degree);
}

/// Suffix of the name of a recontacted set.
constexpr const char* recontacted = "_recontacted";

bool is_pose(std::int8_t source)
{
  return source != static_cast<std::int8_t>(store::ZeroVarusSource::none);
}

bool has_pose(const std::optional<store::ZeroVarus>& table)
{
  return table && std::any_of(table->source.begin(), table->source.end(), is_pose);
}

std::vector<Attitude> solved_spine(const store::MotionModel& model, const RawSurfaces& raw)
{
  std::vector<Attitude> spine;
  if (model.is_spine.size() == 0) return spine;
  const std::size_t n_varus = raw.varus_rad.size();
  check(model.is_spine.rows() == model.status.rows() && model.is_spine.cols() == model.status.cols(),
        "is_spine has the size of the axes");
  for (std::size_t i = 0; i < raw.flexion_rad.size(); ++i) {
    for (std::size_t j = 0; j < n_varus; ++j) {
      const bool is_spine = model.is_spine(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(j)) == 1;
      if (!is_spine || !raw.nodes[i * n_varus + j].is_solved) continue;
      spine.push_back({raw.flexion_rad[i], raw.varus_rad[j]});
      break;
    }
  }
  return spine;
}

Eigen::Matrix3d rotation_world_solver(const SolverFrame& frame)
{
  Eigen::Matrix3d R;
  for (int axis = 0; axis < 3; ++axis) R.col(axis) = world_from_solver(frame, Eigen::Vector3d::Unit(axis));
  return R;
}

/// Delta of each flexion; empty if all are equal.
std::vector<Eigen::Vector3d> deltas_by_flexion(const store::MotionModel& model)
{
  const Points& delta = model.push.delta;
  check(delta.rows() == static_cast<Eigen::Index>(model.flexion_deg.size()),
        "a push has one row per flexion");
  std::vector<Eigen::Vector3d> deltas;
  if (delta == delta.row(0).replicate(delta.rows(), 1)) return deltas;
  for (Eigen::Index i = 0; i < delta.rows(); ++i) deltas.emplace_back(delta.row(i).transpose());
  return deltas;
}

/// The varus solved at each flexion; empty if it is that of the axis.
std::vector<Attitude> free_varus(const store::MotionModel& model, const RawSurfaces& raw)
{
  std::vector<Attitude> found;
  if (raw.varus_rad.size() > 1) return found;
  bool is_free = false;
  for (std::size_t i = 0; i < raw.flexion_rad.size(); ++i) {
    if (!raw.nodes[i].is_solved) continue;
    const double varus_deg = model.varus_solved_deg(static_cast<Eigen::Index>(i), 0);
    is_free = is_free || varus_deg != model.varus_deg.front();
    found.push_back({raw.flexion_rad[i], rad_from_deg(varus_deg)});
  }
  if (!is_free) found.clear();
  return found;
}

/// Linear in flexion between the attitudes, constant beyond the first and last. Needs at least one.
double varus_between(const std::vector<Attitude>& attitudes, double flexion_rad)
{
  const auto after =
      std::lower_bound(attitudes.begin(), attitudes.end(), flexion_rad,
                       [](const Attitude& cell, double flexion) { return cell.flexion_rad < flexion; });
  if (after == attitudes.begin()) return after->varus_rad;
  if (after == attitudes.end()) return attitudes.back().varus_rad;
  const Attitude& before = *(after - 1);
  const double s = (flexion_rad - before.flexion_rad) / (after->flexion_rad - before.flexion_rad);
  return before.varus_rad + s * (after->varus_rad - before.varus_rad);
}

/// Rotates about the rotation centre, then translates: maps stored vertices to W.
Pose about_centre(const Eigen::Matrix3d& R_world, const Eigen::Vector3d& shift_mm,
                  const Eigen::Vector3d& centre_mm)
{
  Pose X = Pose::Identity();
  X.linear() = R_world;
  X.translation() = shift_mm - R_world * centre_mm;
  return X;
}

}  // namespace

std::vector<std::string> set_names(const store::MotionModel& model)
{
  std::vector<const store::SmoothedSet*> sets;
  sets.reserve(model.smoothed.size());
  for (const store::SmoothedSet& set : model.smoothed) sets.push_back(&set);
  std::sort(sets.begin(), sets.end(),
            [](const store::SmoothedSet* a, const store::SmoothedSet* b) { return a->degree > b->degree; });
  std::vector<std::string> listed;
  if (model.two_sided) listed.emplace_back("two_sided");
  for (const store::SmoothedSet* set : sets) {
    if (set->recontact_mm) listed.push_back(name_of(*set) + recontacted);
    listed.push_back(name_of(*set));
  }
  listed.emplace_back("raw");
  if (has_pose(model.zero_varus)) listed.emplace_back("zero_varus");
  return listed;
}

store::DefaultMotion default_motion(const store::MotionModel& model)
{
  const std::vector<std::string> sets = set_names(model);
  const bool is_there =
      model.default_motion && std::find(sets.begin(), sets.end(), model.default_motion->set) != sets.end();
  store::DefaultMotion shown = is_there ? *model.default_motion : store::DefaultMotion{sets.front(), ""};
  if (model.prior) shown.statement = model.prior->statement;
  return shown;
}

std::string chosen_set(const store::MotionModel& model, const std::string& file, const std::string& set)
{
  if (set.empty()) return default_motion(model).set;
  const std::vector<std::string> known = all_set_names(model);
  if (std::ranges::find(known, set) != known.end()) return set;
  throw InputError({file, "--set", set, joined(known)});
}

Motion::Motion(const store::MotionModel& model)
    : frame_{side_named(model.side), model.rotation_centre_mm, model.delta},
      R_world_solver_(rotation_world_solver(frame_)),
      deltas_(deltas_by_flexion(model)),
      raw_(model.frames ? RawSurfaces{} : raw_surfaces(model))
{
  check(model.side == "right" || model.side == "left", "the side of a motion model is right or left");
  use_followers(model);
  if (model.frames) {
    use_frames(model);
    return;
  }
  spine_ = solved_spine(model, raw_);
  free_varus_ = free_varus(model, raw_);
}

Motion::Motion(const store::MotionModel& model, const store::SmoothedSet& set) : Motion(model)
{
  use_smoothed(model, set, set.recontact_mm.has_value());
  set_varus_range();
}

Motion::Motion(const store::MotionModel& model, const std::string& set) : Motion(model)
{
  const auto found =
      std::find_if(model.smoothed.begin(), model.smoothed.end(), [&](const store::SmoothedSet& candidate) {
        return name_of(candidate) == set || name_of(candidate) + recontacted == set;
      });
  if (set == "two_sided") {
    check(model.two_sided.has_value(), "the set is one of set_names");
    use_flexion_table(radians(model.two_sided->flexion_deg), model.two_sided->contact, *model.two_sided);
    // Its surfaces are those of a degree, which the model may have with the followers.
    for (const SmoothedSet& of_degree : model.smoothed) {
      if (of_degree.degree == model.two_sided->degree) use_smoothed_followers(model, of_degree, true);
    }
  } else if (set == "zero_varus") {
    check(has_pose(model.zero_varus), "the set is one of set_names");
    use_flexion_table(raw_.flexion_rad, model.zero_varus->source, *model.zero_varus);
  } else if (set == store::bones_alone_name) {
    check(model.prior.has_value(), "the set is one of all_set_names");
    use_flexion_table(raw_.flexion_rad, posed_rows(model.prior->bones_alone.status),
                      model.prior->bones_alone);
  } else if (const auto sample = quantile_motion(model, set)) {
    use_flexion_table(raw_.flexion_rad, sample->contact, *sample);
    use_sampled_followers(
        *model.uncertainty,
        static_cast<std::size_t>(std::ranges::find(quantile_names, set) - quantile_names.begin()));
  } else if (set != "raw") {
    check(found != model.smoothed.end(), "the set is one of set_names");
    use_smoothed(model, *found, set != name_of(*found));
  }
  set_varus_range();
}

void Motion::set_varus_range()
{
  if (track_) return;
  first_varus_rad_ = raw_.varus_rad.front();
  last_varus_rad_ = raw_.varus_rad.back();
  if (!free_varus_.empty()) first_varus_rad_ = last_varus_rad_ = free_varus_.front().varus_rad;
  for (const Attitude& found : free_varus_) {
    first_varus_rad_ = std::min(first_varus_rad_, found.varus_rad);
    last_varus_rad_ = std::max(last_varus_rad_, found.varus_rad);
  }
}

void Motion::use_smoothed(const store::MotionModel& model, const store::SmoothedSet& set, bool is_recontacted)
{
  use_smoothed_followers(model, set, is_recontacted);
  check(!is_recontacted || set.recontact_mm.has_value(), "the recontacted set has travels");
  if (is_recontacted) travel_ = travels(*set.recontact_mm);
  smoothed_ = smoothed_surfaces(model, set);
  if (!smoothed_->has_varus) return;
  free_varus_.clear();
  for (const double flexion_rad : raw_.flexion_rad) {
    free_varus_.push_back({flexion_rad, evaluate(*smoothed_, {flexion_rad, 0.0})[4]});
  }
}

HermiteGrid<1> Motion::travels(const store::GridD& travel_mm) const
{
  HermiteGrid<1> travel{raw_.flexion_rad, raw_.varus_rad, {}};
  check(static_cast<std::size_t>(travel_mm.rows()) == raw_.flexion_rad.size() &&
            static_cast<std::size_t>(travel_mm.cols()) == raw_.varus_rad.size(),
        "a recontacted set has a travel at every attitude of the axes");
  for (Eigen::Index cell = 0; cell < travel_mm.size(); ++cell) {
    HermiteNode<1>& node = travel.nodes.emplace_back();
    node.is_solved = !std::isnan(travel_mm.data()[cell]);
    if (node.is_solved) node.value = {travel_mm.data()[cell]};
  }
  set_slopes(travel);
  return travel;
}

void Motion::use_flexion_table(const std::vector<double>& flexion_rad, const std::vector<std::int8_t>& state,
                               const PoseRows& table)
{
  const std::size_t n = flexion_rad.size();
  for (const std::vector<double>* column : PoseRows::columns_of(table))
    check(column->size() == n && state.size() == n, "a motion over flexion has one row per flexion");
  by_flexion_ = HermiteGrid<5>{flexion_rad, {0.0}, {}};
  free_varus_.clear();
  for (std::size_t i = 0; i < n; ++i) {
    HermiteNode<5>& node = by_flexion_->nodes.emplace_back();
    node.is_solved = is_pose(state[i]);
    if (!node.is_solved) continue;
    node.value = {table.tx_mm[i], table.ty_mm[i], table.tz_mm[i], rad_from_deg(table.theta_deg[i]),
                  rad_from_deg(table.varus_deg[i])};
    free_varus_.push_back({flexion_rad[i], node.value[4]});
  }
  set_slopes(*by_flexion_);
}

/// Of the numbers of each attitude those nearest to the ones before.
void Motion::use_frames(const store::MotionModel& model)
{
  key_name_ = model.frames->key_name;
  keys_ = model.frames->key;
  track_ = HermiteGrid<6>{keys_, {0.0}, {}};
  std::optional<ClinicalCoordinates> before;
  constexpr double rounding_rad = 1e-9;
  track_->nodes.resize(keys_.size());
  for (std::size_t i = 0; i < keys_.size(); ++i) {
    const auto row = static_cast<Eigen::Index>(i);
    if (model.status(row, 0) != status_stable) continue;
    HermiteNode<6>& node = track_->nodes[i];
    node.is_solved = true;
    ClinicalCoordinates c;
    c.flexion_rad = rad_from_deg(model.flexion_deg[i]);
    c.varus_rad = rad_from_deg(model.varus_solved_deg(row, 0));
    c.internal_rotation_rad = rad_from_deg(model.theta_deg(row, 0));
    Eigen::Vector3d shift_mm(model.tx_mm(row, 0), model.ty_mm(row, 0), model.tz_mm(row, 0));
    if (before) {
      c = nearest_numbers(c, *before);
      // Past gimbal lock another theta turns W about Delta.
      const double turn_rad = c.internal_rotation_rad - rad_from_deg(model.theta_deg(row, 0));
      const Eigen::Matrix3d R = R_world_solver(delta_on(keys_, keys_[i]));
      if (std::abs(nearest_turn(turn_rad, 0.0)) > rounding_rad)
        shift_mm = R * rotation_y(turn_rad) * R.transpose() * shift_mm;
    }
    node.value = {shift_mm.x(), shift_mm.y(), shift_mm.z(), c.internal_rotation_rad,
                  c.varus_rad,  c.flexion_rad};
    first_varus_rad_ = before ? std::min(first_varus_rad_, c.varus_rad) : c.varus_rad;
    last_varus_rad_ = before ? std::max(last_varus_rad_, c.varus_rad) : c.varus_rad;
    before = c;
  }
  set_slopes(*track_);
}

void Motion::use_followers(const store::MotionModel& model)
{
  for (const FollowerRows* rows : in_order(model.followers)) {
    FollowerTrack& track = followers_.emplace_back();
    track.name = rows->name;
    track.delta = rows->delta;
    track.body = static_cast<BodyIndex>(rows->body_index);
    track.of = static_cast<BodyIndex>(rows->of);
    track.centre_mm = rows->centre_mm;
    track.coordinates = {model.frames ? model.frames->key : raw_.flexion_rad,
                         model.frames ? std::vector<double>{0.0} : raw_.varus_rad,
                         std::vector<HermiteNode<6>>(static_cast<std::size_t>(rows->status.size()))};
    for (std::size_t cell = 0; cell < track.coordinates.nodes.size(); ++cell) {
      if (rows->status.data()[cell] != status_stable) continue;
      HermiteNode<6>& node = track.coordinates.nodes[cell];
      node.is_solved = true;
      for (std::size_t k = 0; k < n_joint_coordinates; ++k) {
        const double value = rows->coordinates[k].data()[cell];
        node.value[k] = from_file(value, k);
      }
    }
    set_slopes(track.coordinates);
  }
}

void Motion::use_smoothed_followers(const store::MotionModel& model, const store::SmoothedSet& set,
                                    bool is_recontacted)
{
  std::array<bool, n_joint_coordinates> is_angle{};
  for (std::size_t k = 0; k < n_joint_coordinates; ++k) is_angle[k] = is_rotation(k);
  for (FollowerTrack& track : followers_) {
    const auto found = std::find_if(set.followers.begin(), set.followers.end(),
                                    [&](const SmoothedFollower& other) { return other.name == track.name; });
    if (found == set.followers.end()) continue;
    std::array<const SmoothedSurface*, n_joint_coordinates> surfaces{};
    for (std::size_t k = 0; k < n_joint_coordinates; ++k) surfaces[k] = &found->surfaces.at(k);
    track.smoothed = terms_of<n_joint_coordinates>(model, set, surfaces, is_angle);
    if (is_recontacted && found->recontact_mm) track.travel = travels(*found->recontact_mm);
  }
}

void Motion::use_sampled_followers(const store::UncertainMotion& samples, std::size_t quantile)
{
  const std::size_t n = raw_.flexion_rad.size();
  for (FollowerTrack& track : followers_) {
    const auto found = std::ranges::find(samples.followers, track.name, &UncertainFollower::name);
    if (found == samples.followers.end()) continue;
    const std::size_t first = static_cast<std::size_t>(samples.quantile_sample.at(quantile)) * n;
    track.coordinates = {raw_.flexion_rad, {0.0}, std::vector<HermiteNode<6>>(n)};
    for (std::size_t i = 0; i < n; ++i) {
      HermiteNode<6>& node = track.coordinates.nodes[i];
      node.is_solved = found->status.at(first + i) == status_stable;
      for (std::size_t k = 0; k < 3 && node.is_solved; ++k) {
        node.value[k] = rad_from_deg(found->rotation_deg.at(3 * (first + i) + k));
        node.value[3 + k] = found->translation_mm.at(3 * (first + i) + k);
      }
    }
    set_slopes(track.coordinates);
  }
}

bool Motion::place(const FollowerTrack& track, const Attitude& at, Pose& X_of) const
{
  if (track.smoothed) {
    const std::array<double, n_joint_coordinates> values = evaluate(*track.smoothed, at);
    X_of = follower_pose(JointCoordinates::Map(values.data()), frame_.side, track.centre_mm);
    if (!track.travel) return true;
    const HermiteSample<1> travel = sample(*track.travel, at);
    X_of.translation() += travel.values[0] * (X_of.linear() * track.delta);
    return travel.is_solved;
  }
  const HermiteSample<6> here = sample(track.coordinates, at);
  X_of = follower_pose(JointCoordinates::Map(here.values.data()), frame_.side, track.centre_mm);
  return here.is_solved;
}

void Motion::place_followers(const Attitude& at, JointPose& pose) const
{
  if (pose.status != PoseStatus::solved) return;
  for (const FollowerTrack& track : followers_) {
    const bool has_of = model::row_of(track.of) < 2 || pose.has_follower.at(model::follower_row(track.of));
    Pose X_of;
    if (!has_of || !place(track, at, X_of)) continue;
    const std::size_t row = model::follower_row(track.body);
    pose.X_reference_follower.at(row) = pose.X_reference(track.of) * X_of;
    pose.has_follower.at(row) = true;
  }
}

JointPose Motion::at_frame(double key) const
{
  check(track_.has_value(), "only a sequence of frames is evaluated by its key");
  const double used = std::clamp(key, keys_.front(), keys_.back());
  const HermiteSample<6> here = sample(*track_, {used, 0.0});
  JointPose pose;
  if (here.is_solved) {
    const auto& [tx, ty, tz, theta_rad, varus_rad, flexion_rad] = here.values;
    const auto within_turn = [](double angle_rad) {
      return angle_rad - 2.0 * pi * std::round(angle_rad / (2.0 * pi));
    };
    pose = pose_along(delta_on(keys_, used), {within_turn(flexion_rad), varus_rad},
                      {tx, ty, tz, within_turn(theta_rad)});
  }
  pose.key = used;
  pose.is_flexion_clamped = used != key;
  place_followers({used, 0.0}, pose);
  return pose;
}

double Motion::key_at(double position) const
{
  check(track_.has_value(), "only a sequence of frames has keys");
  const double last = static_cast<double>(keys_.size() - 1);
  const double at = std::clamp(position, 0.0, last), below = std::floor(at);
  const auto i = static_cast<std::size_t>(below);
  // Exact at the frames.
  return at == below ? keys_[i] : keys_[i] + (at - below) * (keys_[i + 1] - keys_[i]);
}

double Motion::position_of(double key) const
{
  check(track_.has_value(), "only a sequence of frames has keys");
  const auto [row, share] = position_on(keys_, key);
  return static_cast<double>(row) + share;
}

Eigen::Vector3d Motion::delta_of(const JointPose& pose) const
{
  return track_ ? delta_on(keys_, pose.key) : delta(pose.attitude.flexion_rad);
}

Motion::Evaluation Motion::smoothed_at(const Attitude& attitude) const
{
  const PoseAndVarus here = evaluate(*smoothed_, attitude);
  Evaluation found{attitude, {here[0], here[1], here[2], here[3]}, true};
  if (smoothed_->has_varus) found.attitude.varus_rad = here[4];
  if (!travel_) return found;
  const HermiteSample<1> travel = sample(*travel_, attitude);
  found.is_solved = travel.is_solved;
  const Eigen::Vector3d shift_mm = travel.values[0] * delta(attitude.flexion_rad);
  for (int axis = 0; axis < 3; ++axis) found.numbers[static_cast<std::size_t>(axis)] += shift_mm[axis];
  return found;
}

Motion::Evaluation Motion::flexion_table_at(const Attitude& attitude) const
{
  const HermiteSample<5> here = sample(*by_flexion_, attitude);
  if (!here.is_solved) return {attitude, {}, false};
  return {{attitude.flexion_rad, here.values[4]},
          {here.values[0], here.values[1], here.values[2], here.values[3]},
          true};
}

Attitude Motion::with_set_varus(const Attitude& wanted) const
{
  if (free_varus_.empty()) return wanted;
  return {wanted.flexion_rad, varus_between(free_varus_, wanted.flexion_rad)};
}

/// `wanted` must be within the axes; the returned attitude has the set's own varus if there is one.
Motion::Evaluation Motion::evaluation_at(const Attitude& wanted) const
{
  const Attitude attitude = with_set_varus(wanted);
  if (by_flexion_) return flexion_table_at(attitude);
  if (smoothed_) return smoothed_at(attitude);
  const RawSample here = sample(raw_, attitude);
  return {attitude, here.values, here.is_solved};
}

std::optional<ClinicalCoordinates> Motion::own_coordinates(const JointPose& pose) const
{
  const bool is_proximal = deltas_.empty() && frame_.delta == Eigen::Vector3d::UnitY();
  if (is_proximal || pose.status != PoseStatus::solved) return std::nullopt;
  return clinical_coordinates(pose.X_reference_moving, frame_.side, frame_.rotation_centre_mm);
}

Eigen::Vector3d Motion::delta(double flexion_rad) const
{
  check(!track_ || deltas_.empty(), "Delta of a sequence of frames is that of a pose");
  return delta_on(raw_.flexion_rad, flexion_rad);
}

Eigen::Vector3d Motion::delta_on(const std::vector<double>& at, double x) const
{
  if (deltas_.empty()) return frame_.delta;
  const auto [row, share] = position_on(at, x);
  if (share == 0.0) return deltas_[row];
  return (deltas_[row] + share * (deltas_[row + 1] - deltas_[row])).normalized();
}

Eigen::Matrix3d Motion::R_world_solver(const Eigen::Vector3d& delta) const
{
  if (deltas_.empty()) return R_world_solver_;
  SolverFrame frame = frame_;
  frame.delta = delta;
  return rotation_world_solver(frame);
}

Attitude Motion::clamped(const Attitude& wanted) const
{
  return {std::clamp(wanted.flexion_rad, first_flexion_rad(), last_flexion_rad()),
          std::clamp(wanted.varus_rad, first_varus_rad(), last_varus_rad())};
}

JointPose Motion::at(const Attitude& wanted) const
{
  check(!track_, "a sequence of frames is evaluated by its key");
  return posed(evaluation_at(clamped(wanted)), wanted);
}

JointPose Motion::posed(const Evaluation& found, const Attitude& wanted) const
{
  JointPose pose;
  if (found.is_solved) pose = joint_pose(found.attitude, found.numbers);
  pose.attitude = found.attitude;
  pose.is_flexion_clamped = pose.attitude.flexion_rad != wanted.flexion_rad;
  pose.is_varus_clamped = pose.attitude.varus_rad != wanted.varus_rad;
  place_followers({std::clamp(pose.attitude.flexion_rad, raw_.flexion_rad.front(), raw_.flexion_rad.back()),
                   std::clamp(pose.attitude.varus_rad, raw_.varus_rad.front(), raw_.varus_rad.back())},
                  pose);
  return pose;
}

JointPose Motion::joint_pose(const Attitude& attitude, const PoseCoordinates& numbers) const
{
  return pose_along(delta(attitude.flexion_rad), attitude, numbers);
}

JointPose Motion::pose_along(const Eigen::Vector3d& delta, const Attitude& attitude,
                             const PoseCoordinates& numbers) const
{
  JointPose pose;
  pose.attitude = attitude;
  pose.status = PoseStatus::solved;
  pose.theta_rad = numbers[3];

  // Attitude and theta rotate in the solver's frame; conjugation maps them to W of the joint's own side.
  const Eigen::Matrix3d R = R_world_solver(delta);
  const Eigen::Matrix3d R_solver_world = R.transpose();
  const Eigen::Matrix3d R_attitude = R * reference_rotation(pose.attitude) * R_solver_world;
  const Eigen::Matrix3d R_theta = R * rotation_y(pose.theta_rad) * R_solver_world;
  const Eigen::Vector3d shift_mm(numbers[0], numbers[1], numbers[2]);
  pose.X_world_reference = about_centre(R_attitude, Eigen::Vector3d::Zero(), frame_.rotation_centre_mm);
  pose.X_world_moving = about_centre(R_theta, shift_mm, frame_.rotation_centre_mm);
  pose.X_reference_moving = pose.X_world_reference.inverse() * pose.X_world_moving;
  return pose;
}

double Motion::balanced_varus_rad(double flexion_rad) const
{
  check(!track_, "varus of a sequence of frames is that of a pose");
  if (!free_varus_.empty()) {
    return evaluation_at({std::clamp(flexion_rad, first_flexion_rad(), last_flexion_rad()), 0.0})
        .attitude.varus_rad;
  }
  if (spine_.empty()) return std::clamp(0.0, first_varus_rad(), last_varus_rad());
  return varus_between(spine_, flexion_rad);
}

}  // namespace vrda::store
