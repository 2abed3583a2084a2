#include "tables/convention_search.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <memory>
#include <optional>
#include <utility>

#include "core/parallel.hpp"
#include "core/text.hpp"
#include "core/units.hpp"
#include "geometry/gap_query.hpp"

namespace vrda::tables {
namespace {

constexpr std::size_t most_frames = 31;
/// More than cartilage and menisci of a scan without them, less than the size of any joint.
constexpr double largest_mean_gap_mm = 10.0;
/// Below it poses are the same: coordinates of some 100 mm have rounding of 1e-13 mm.
constexpr double same_pose = 1e-9;
/// Conventions within this factor of the best, or this much gap, cannot be distinguished (README).
constexpr double same_factor = 1.5, same_gap_mm = 0.02;
/// An object that moves less gives no information.
constexpr double least_motion_mm = 1e-9;

std::vector<std::size_t> chosen_frames(std::size_t n)
{
  std::vector<std::size_t> frames;
  const std::size_t n_chosen = std::min(n, most_frames);
  for (std::size_t k = 0; k < n_chosen; ++k)
    frames.push_back(n_chosen == 1 ? 0 : k * (n - 1) / (n_chosen - 1));
  return frames;
}

MotionTable part_of(const MotionTable& table, const std::vector<std::size_t>& frames)
{
  MotionTable part = table;
  const auto keep = [&](auto& rows) {
    if (rows.empty()) return;
    auto kept = rows;
    kept.clear();
    for (const std::size_t frame : frames) kept.push_back(rows[frame]);
    rows = std::move(kept);
  };
  keep(part.key);
  keep(part.line);
  keep(part.matrices);
  keep(part.of_reference);
  keep(part.coordinates);
  return part;
}

bool are_equal(const std::vector<Pose>& a, const std::vector<Pose>& b)
{
  for (std::size_t i = 0; i < a.size(); ++i)
    if (!((a[i].matrix() - b[i].matrix()).cwiseAbs().maxCoeff() <= same_pose)) return false;
  return true;
}

double motion_mm(const std::vector<Pose>& poses, const Box& box)
{
  double sum_mm2 = 0.0;
  for (int corner = 0; corner < 8; ++corner) {
    const Eigen::Vector3d p((corner & 1) != 0 ? box.max_mm.x() : box.min_mm.x(),
                            (corner & 2) != 0 ? box.max_mm.y() : box.min_mm.y(),
                            (corner & 4) != 0 ? box.max_mm.z() : box.min_mm.z());
    Eigen::Vector3d mean = Eigen::Vector3d::Zero();
    for (const Pose& X : poses) mean += X * p / static_cast<double>(poses.size());
    for (const Pose& X : poses) sum_mm2 += (X * p - mean).squaredNorm();
  }
  return std::sqrt(sum_mm2 / (8.0 * static_cast<double>(poses.size())));
}

/// Measures gaps in one thread.
class GapMeter {
 public:
  explicit GapMeter(const SearchScene& scene) : frame_(scene.frame)
  {
    const solve::Joint& joint = scene.joint;
    if (joint.compartment_of_triangle.empty()) {
      queries_.emplace_back(joint.reference_gap, joint.moving_gap);
    } else {
      for (const geometry::GapTree& gap : joint.compartment_gap)
        queries_.emplace_back(joint.reference_gap, gap);
    }
  }

  /// Empty if nothing faces in a frame.
  std::vector<GapSpread> spreads(const std::vector<Pose>& poses)
  {
    std::vector<std::vector<double>> gaps_mm(queries_.size());
    for (const Pose& X : poses) {
      const solve::SolverPosition at = solve::solver_position(frame_, X);
      for (std::size_t k = 0; k < queries_.size(); ++k) {
        const double gap_mm = queries_[k].gap_mm(at.attitude, at.pose);
        if (std::isnan(gap_mm)) return {};
        gaps_mm[k].push_back(gap_mm);
      }
    }
    std::vector<GapSpread> spreads;
    for (const std::vector<double>& of_compartment : gaps_mm) {
      GapSpread& spread = spreads.emplace_back();
      const auto n = static_cast<double>(of_compartment.size());
      for (const double gap_mm : of_compartment) spread.mean_mm += gap_mm / n;
      double sum_mm2 = 0.0;
      for (const double gap_mm : of_compartment)
        sum_mm2 += (gap_mm - spread.mean_mm) * (gap_mm - spread.mean_mm);
      spread.deviation_mm = std::sqrt(sum_mm2 / n);
    }
    return spreads;
  }

 private:
  SolverFrame frame_;
  std::vector<geometry::GapQuery> queries_;
};

bool is_ranked(const Candidate& candidate)
{
  return !candidate.gaps.empty() &&
         std::all_of(candidate.gaps.begin(), candidate.gaps.end(),
                     [](const GapSpread& gap) { return std::abs(gap.mean_mm) <= largest_mean_gap_mm; });
}

void measure(Candidate& candidate, const std::vector<Pose>& poses, const SearchScene& scene, GapMeter& meter)
{
  candidate.motion_mm = motion_mm(poses, scene.moving_box);
  candidate.gaps = meter.spreads(poses);
  if (!is_ranked(candidate)) return;
  double sum_mm2 = 0.0;
  for (const GapSpread& gap : candidate.gaps) sum_mm2 += gap.deviation_mm * gap.deviation_mm;
  candidate.deviation_mm = std::sqrt(sum_mm2 / static_cast<double>(candidate.gaps.size()));
  candidate.share = candidate.deviation_mm / std::max(candidate.motion_mm, least_motion_mm);
}

void set_undecided(ConventionSearch& search)
{
  const Candidate& best = search.candidates.front();
  const double limit = std::max(same_factor * best.share,
                                best.share + same_gap_mm / std::max(best.motion_mm, least_motion_mm));
  const auto end = std::find_if(search.candidates.begin(), search.candidates.end(),
                                [&](const Candidate& c) { return !(c.share <= limit); });
  search.n_best = static_cast<std::size_t>(end - search.candidates.begin());
  for (const Term term : all_terms) {
    const bool differs = std::any_of(search.candidates.begin(), end, [&](const Candidate& c) {
      return value_of(c.convention, term) != value_of(best.convention, term);
    });
    if (differs) search.undecided.push_back(term);
  }
}

}  // namespace

std::string value_of(const Convention& c, Term term)
{
  switch (term) {
    case Term::unit:
      return length_unit_name(c.length_mm);
    case Term::angles:
      return name_of(c.angles);
    case Term::order:
      return name_of(c.order);
    case Term::direction:
      return name_of(c.direction);
    case Term::axes:
      return name_of(c.axes);
    case Term::side:
      return side_name(c.side);
    case Term::lengths:
      return name_of(c.lengths);
  }
  throw InternalError("a term without a value");
}

std::vector<Convention> open_conventions(const MotionTable& table, const SearchRequest& request,
                                         const JointFrame& joint)
{
  const StatedConvention &user = request.stated, &file = table.stated;
  std::vector<Convention> all{completed(user, file, joint.side)};
  // Every value of a term that neither the user nor the file states; else its value in completed() is kept.
  const auto open = [&](Term term, auto Convention::*field, bool by_user, bool by_file, const auto& values) {
    if (by_user || (by_file && request.automatic.count(term) == 0)) return;
    std::vector<Convention> more;
    for (const Convention& c : all) {
      for (const auto& value : values) {
        more.push_back(c);
        more.back().*field = value;
      }
    }
    all = std::move(more);
  };
  // A matrix has no signs to choose, and clinical numbers state the side by their definition.
  const bool has_angles = !table.has_matrices();
  const bool determines_side = table.has_matrices() || table.are_angles_clinical;
  open(Term::unit, &Convention::length_mm, user.length_mm.has_value(), file.length_mm.has_value(),
       std::array{1.0, 10.0, 1000.0});
  if (has_angles) {
    open(Term::angles, &Convention::angles, user.angles.has_value(), file.angles.has_value(),
         std::array{AngleUnit::degrees, AngleUnit::radians});
    open(Term::order, &Convention::order, user.order.has_value(), file.order.has_value(), all_orders);
  }
  open(Term::direction, &Convention::direction, user.direction.has_value(), file.direction.has_value(),
       std::array{Direction::moving_in_reference, Direction::reference_in_moving});
  open(Term::axes, &Convention::axes, user.axes.has_value(), file.axes.has_value(),
       std::array{TableAxes::canonical, TableAxes::files});
  open(Term::side, &Convention::side, user.side.has_value(), determines_side,
       std::array{joint.side, joint.side == Side::left ? Side::right : Side::left});
  if (has_angles)
    open(Term::lengths, &Convention::lengths, user.lengths.has_value(), file.lengths.has_value(),
         std::array{LengthPoint::origin, LengthPoint::centre});
  return all;
}

ConventionSearch find_convention(const MotionTable& table, const SearchRequest& request,
                                 const JointFrame& joint, const SearchScene& scene, int n_threads)
{
  const MotionTable part = part_of(table, chosen_frames(table.key.size()));
  ConventionSearch search;
  std::vector<std::vector<Pose>> poses;
  const std::vector<Convention> open = open_conventions(table, request, joint);
  for (const Convention& convention : open) {
    std::vector<Pose> here = poses_of(part, convention, joint);
    if (std::any_of(poses.begin(), poses.end(), [&](const auto& known) { return are_equal(known, here); }))
      continue;
    search.candidates.push_back({convention, {}});
    poses.push_back(std::move(here));
  }
  for_each_index(poses.size(), n_threads, [&] {
    return [&, meter = GapMeter(scene)](std::size_t i) mutable {
      measure(search.candidates[i], poses[i], scene, meter);
    };
  });
  std::stable_sort(search.candidates.begin(), search.candidates.end(),
                   [](const Candidate& a, const Candidate& b) { return a.share < b.share; });
  if (search.candidates.size() == 1) {
    search.n_best = 1;
    return search;
  }
  if (!std::isfinite(search.candidates.front().share)) {
    throw InputError({table.file, "",
                      "no convention of " + std::to_string(open.size()) +
                          " with facing bodies less than 10 mm apart in all frames",
                      "poses of the bodies of the job: check its frames, and state --unit, --angles, "
                      "--order, --direction and --axes"});
  }
  set_undecided(search);
  return search;
}

namespace {

// As numbers, of radians that are taken for degrees or the reverse.
constexpr double turn_rad = 2.0 * pi;    // no joint turns further
constexpr double usual_flexion = 1.6;    // 92 degrees in rad
constexpr double largest_flexion = 2.8;  // 160 degrees in rad
constexpr double least_span = 0.1;       // 6 degrees in rad: a motion, not a posture
constexpr double least_angle = 0.005;    // 0.3 degrees in rad: more than rounding of a constrained joint
// Rotations other than flexion stay below 29 degrees in most motions of a knee; half a degree over ten
// degrees of flexion is less than in any measured one (the least known is 0.7, varus of a knee replacement).
constexpr double small_other = 0.5, large_flexion_deg = 10.0;

struct Extent {
  double least = std::numeric_limits<double>::infinity(), most = -least;
  double largest() const { return std::max(std::abs(least), std::abs(most)); }
  double span() const { return most - least; }
};

std::array<Extent, 3> extents_of(const MotionTable& table)
{
  std::array<Extent, 3> extents;
  for (const PoseCoordinates& row : table.coordinates) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      extents[axis].least = std::min(extents[axis].least, row.angle[axis]);
      extents[axis].most = std::max(extents[axis].most, row.angle[axis]);
    }
  }
  return extents;
}

std::string digits(double value)
{
  return rounded_text(value, 4);
}

/// An angle that is hardly meant so.
struct Doubt {
  std::size_t axis = 0;
  bool is_certain = false;  ///< the unit is almost certainly the other one
};

/// The axis of flexion: Z by name, else the one that turns most.
std::size_t flexion_axis(const MotionTable& table, const std::array<Extent, 3>& extents)
{
  if (table.are_angles_clinical) return 2;
  const auto most = std::max_element(extents.begin(), extents.end(),
                                     [](const Extent& a, const Extent& b) { return a.span() < b.span(); });
  return static_cast<std::size_t>(most - extents.begin());
}

std::vector<Doubt> doubts_of_degrees(const std::array<Extent, 3>& extents, std::size_t flexion,
                                     std::optional<bool> has_large_flexion)
{
  const Extent& main = extents[flexion];
  double others = 0.0;
  for (std::size_t axis = 0; axis < 3; ++axis)
    if (axis != flexion) others = std::max(others, extents[axis].largest());
  const bool is_small_throughout = std::max(others, main.largest()) <= usual_flexion;
  if (main.span() >= least_span && main.largest() <= largest_flexion) {
    const bool is_certain =
        main.largest() <= usual_flexion && (has_large_flexion.value_or(true) || is_small_throughout);
    // A joint that flexes little may turn more about the other axes.
    if (is_certain || has_large_flexion.value_or(false) || others <= usual_flexion)
      return {{flexion, is_certain}};
  } else if (main.span() < least_span && is_small_throughout &&
             std::max(others, main.largest()) >= least_angle) {
    return {{main.largest() >= others ? flexion : flexion == 0 ? std::size_t{1} : std::size_t{0}, false}};
  }
  std::vector<Doubt> doubts;
  if (main.span() < large_flexion_deg) return doubts;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const Extent& other = extents[axis];
    if (axis != flexion && other.span() >= least_angle && other.largest() <= small_other)
      doubts.push_back({axis, false});
  }
  return doubts;
}

std::vector<Doubt> doubts_of_radians(const std::array<Extent, 3>& extents, std::size_t flexion)
{
  std::vector<Doubt> doubts;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const bool is_certain = extents[axis].largest() > turn_rad;
    if (is_certain || (axis == flexion && extents[axis].largest() > largest_flexion))
      doubts.push_back({axis, is_certain});
  }
  return doubts;
}

/// "at most 1.571 degrees (90 if they are radians)".
std::string found_text(const Extent& extent, AngleUnit unit, UnitSource source)
{
  const bool is_degrees = unit == AngleUnit::degrees;
  const double other = is_degrees ? deg_from_rad(extent.largest()) : rad_from_deg(extent.largest());
  return "at most " + digits(extent.largest()) + (is_degrees ? " degrees" : " rad") +
         (source == UnitSource::assumed ? ", which the file does not state" : "") +
         (is_degrees ? " (" + digits(other) + " degrees if they are radians: times 57.2958)"
                     : " (" + digits(deg_from_rad(extent.largest())) + " degrees; " + digits(other) +
                           " rad if they are degrees: divided by 57.2958)");
}

}  // namespace

std::vector<std::string> unit_warnings(const MotionTable& table, AngleUnit unit, UnitSource source,
                                       const JointFrame& joint)
{
  std::vector<std::string> warnings;
  if (table.coordinates.empty()) return warnings;
  const bool is_degrees = unit == AngleUnit::degrees;
  const char* other = is_degrees ? "rad" : "deg";
  if (source == UnitSource::option && table.stated.angles && *table.stated.angles != unit)
    warnings.push_back(table.file + ": --angles " + name_of(unit) + " replaces the file's unit of angles, " +
                       other);
  if (source == UnitSource::assumed)
    warnings.push_back(
        table.file +
        ": no inDegrees in the header and no unit in the column names: the angles are taken for "
        "degrees; --angles states their unit");
  const std::array<Extent, 3> extents = extents_of(table);
  const std::size_t flexion = flexion_axis(table, extents);
  const bool may_refuse = source == UnitSource::file || source == UnitSource::assumed;
  for (const Doubt& doubt : is_degrees ? doubts_of_degrees(extents, flexion, joint.has_large_flexion)
                                       : doubts_of_radians(extents, flexion)) {
    const std::string column = "column " + table.angle_columns[doubt.axis];
    const std::string found = found_text(extents[doubt.axis], unit, source);
    if (doubt.is_certain && may_refuse) {
      throw InputError({table.file, column, found,
                        std::string("rotations of a joint in one unit; --angles ") + other +
                            " if it is that of all columns, --angles " + name_of(unit) +
                            " if they are right"});
    }
    warnings.push_back(table.file + ": " + column + ": " + found + "; check the unit of the column");
  }
  return warnings;
}

}  // namespace vrda::tables
