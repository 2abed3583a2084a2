#include "tables/convention_search.hpp"

#include <algorithm>
#include <cmath>
#include <memory>
#include <optional>
#include <utility>

#include "core/error.hpp"
#include "model/frames.hpp"
#include "core/parallel.hpp"
#include "geometry/gap_query.hpp"

namespace vrda::tables {
namespace {

using tables::Convention;

constexpr std::size_t most_frames = 31;
/// More than cartilage and menisci of a scan without them, less than the size of any joint.
constexpr double largest_mean_gap_mm = 10.0;
/// Below it poses are the same: coordinates of some 100 mm have rounding of 1e-13 mm.
constexpr double same_pose = 1e-9;
/// Conventions within this factor of the best, or this much gap, cannot be distinguished (README).
constexpr double same_factor = 1.5, same_gap_mm = 0.02;
/// An object that moves less gives no information.
constexpr double least_motion_mm = 1e-9;

/// The values that a term may have.
template <typename Value>
std::vector<Value> open_values(const std::optional<Value>& by_user, const std::optional<Value>& by_file,
                               bool is_automatic, std::vector<Value> all)
{
  if (by_user) return {*by_user};
  if (by_file && !is_automatic) return {*by_file};
  return all;
}

std::vector<std::size_t> chosen_frames(std::size_t n)
{
  std::vector<std::size_t> frames;
  const std::size_t n_chosen = std::min(n, most_frames);
  for (std::size_t k = 0; k < n_chosen; ++k)
    frames.push_back(n_chosen == 1 ? 0 : k * (n - 1) / (n_chosen - 1));
  return frames;
}

tables::MotionTable part_of(const tables::MotionTable& table, const std::vector<std::size_t>& frames)
{
  tables::MotionTable part = table;
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
      queries_.emplace_back(joint.reference_gap, joint.medial_gap);
      queries_.emplace_back(joint.reference_gap, joint.lateral_gap);
    }
  }

  /// Empty if nothing faces in a frame.
  std::vector<GapSpread> spreads(const std::vector<Pose>& poses)
  {
    std::vector<std::vector<double>> gaps_mm(queries_.size());
    for (const Pose& X : poses) {
      const SolverPosition coordinates = solver_position(frame_, X);
      for (std::size_t k = 0; k < queries_.size(); ++k) {
        queries_[k].set_attitude(coordinates.attitude);
        const double gap_mm = queries_[k].travel_mm(coordinates.pose);
        if (!std::isfinite(gap_mm)) return {};
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

const char* name_of(Term term)
{
  switch (term) {
    case Term::unit:
      return "unit";
    case Term::angles:
      return "angles";
    case Term::order:
      return "order";
    case Term::direction:
      return "direction";
    case Term::axes:
      return "axes";
    case Term::side:
      return "side";
    case Term::lengths:
      return "lengths";
  }
  throw InternalError("a term without a name");
}

std::string value_of(const Convention& c, Term term)
{
  switch (term) {
    case Term::unit:
      return tables::length_unit_name(c.length_mm);
    case Term::angles:
      return tables::name_of(c.angles);
    case Term::order:
      return tables::name_of(c.order);
    case Term::direction:
      return tables::name_of(c.direction);
    case Term::axes:
      return tables::name_of(c.axes);
    case Term::side:
      return tables::name_of_side(c.side);
    case Term::lengths:
      return tables::name_of(c.lengths);
  }
  throw InternalError("a term without a value");
}

std::vector<Convention> open_conventions(const tables::MotionTable& table, const SearchRequest& request,
                                         const tables::JointFrame& joint)
{
  const tables::StatedConvention &user = request.stated, &file = table.stated;
  const auto is_automatic = [&](Term term) { return request.automatic.count(term) > 0; };
  const Convention known = tables::completed(user, file, joint.side);
  const bool has_angles = !table.has_matrices();
  // A matrix has no signs to choose, and clinical numbers state the side by their definition.
  const bool determines_side = table.has_matrices() || table.are_angles_clinical;
  const auto other = joint.side == Side::left ? Side::right : Side::left;
  using tables::AngleUnit, tables::Direction, tables::TableAxes, tables::LengthPoint;
  const auto units =
      open_values(user.length_mm, file.length_mm, is_automatic(Term::unit), {1.0, 10.0, 1000.0});
  const auto angles = has_angles ? open_values(user.angles, file.angles, is_automatic(Term::angles),
                                               {AngleUnit::degrees, AngleUnit::radians})
                                 : std::vector{known.angles};
  const auto orders = has_angles
                          ? open_values(user.order, file.order, is_automatic(Term::order),
                                        {std::begin(tables::all_orders), std::end(tables::all_orders)})
                          : std::vector{known.order};
  const auto directions = open_values(user.direction, file.direction, is_automatic(Term::direction),
                                      {Direction::moving_in_reference, Direction::reference_in_moving});
  const auto axes =
      open_values(user.axes, file.axes, is_automatic(Term::axes), {TableAxes::canonical, TableAxes::files});
  const auto sides = open_values(user.side, determines_side ? std::optional(joint.side) : std::nullopt,
                                 is_automatic(Term::side), {joint.side, other});
  const auto points = has_angles ? open_values(user.lengths, file.lengths, is_automatic(Term::lengths),
                                               {LengthPoint::origin, LengthPoint::centre})
                                 : std::vector{known.lengths};
  std::vector<Convention> all;
  for (const double unit : units)
    for (const AngleUnit angle : angles)
      for (const tables::AngleOrder order : orders)
        for (const Direction direction : directions)
          for (const TableAxes axis : axes)
            for (const Side side : sides)
              for (const LengthPoint point : points)
                all.push_back({unit, angle, order, direction, axis, side, point});
  return all;
}

ConventionSearch find_convention(const tables::MotionTable& table, const SearchRequest& request,
                                 const tables::JointFrame& joint, const SearchScene& scene, int n_threads)
{
  const tables::MotionTable part = part_of(table, chosen_frames(table.key.size()));
  ConventionSearch search;
  std::vector<std::vector<Pose>> poses;
  const std::vector<Convention> open = open_conventions(table, request, joint);
  for (const Convention& convention : open) {
    std::vector<Pose> here = tables::poses_of(part, convention, joint);
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

}  // namespace vrda::tables
