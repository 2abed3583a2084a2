#include "geometry/gap_query.hpp"

#include <algorithm>
#include <array>
#include <atomic>
#include <bit>
#include <optional>
#include <utility>

#include "core/text.hpp"
#include "geometry/gap_tree.hpp"
#include "geometry/rounded_kernel.hpp"

namespace vrda::geometry {
namespace {

std::atomic<InstructionSet>& chosen()
{
  static std::atomic<InstructionSet> set{instruction_sets().back()};
  return set;
}

}  // namespace

std::vector<InstructionSet> instruction_sets()
{
  std::vector<InstructionSet> sets{InstructionSet::baseline};
  if (__builtin_cpu_supports("avx2")) sets.push_back(InstructionSet::avx2);
  if (__builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512vl") &&
      __builtin_cpu_supports("avx512dq")) {
    sets.push_back(InstructionSet::avx512);
  }
  return sets;
}

void set_instruction_set(InstructionSet set)
{
  const std::vector<InstructionSet> sets = instruction_sets();
  check(std::find(sets.begin(), sets.end(), set) != sets.end(), "the processor supports the instruction set");
  chosen() = set;
}

InstructionSet instruction_set()
{
  return chosen();
}

namespace {

// Number of hints: after a small change of pose the result is often one of the last few pairs.
constexpr std::size_t n_hints = 8;

// Above the rounding of a RoundedPair's limit, so that ties are visited.
constexpr double bound_slack_mm = 1e-6;

// The least PlacedPairs::candidates with a pair of edges.
constexpr unsigned first_edge_candidate = 1U << 6U;

Corners corners_of(const double (&rows)[9][block_lanes], unsigned lane)
{
  const auto corner = [&](int k) {
    return Eigen::Vector3d(rows[3 * k][lane], rows[3 * k + 1][lane], rows[3 * k + 2][lane]);
  };
  return {corner(0), corner(1), corner(2)};
}

// Pairs evaluated before the traversal, without duplicates, newest first.
class Hints {
 public:
  auto begin() const { return pairs_.begin(); }
  auto end() const { return pairs_.end(); }
  void remember(const TrianglePair& pair)
  {
    if (pair.reference < 0) return;
    auto at = std::find(pairs_.begin(), pairs_.end(), pair);
    if (at == pairs_.end()) at = pairs_.size() < n_hints ? pairs_.insert(at, pair) : at - 1;
    std::rotate(pairs_.begin(), at, at + 1);
    pairs_.front() = pair;
  }

 private:
  std::vector<TrianglePair> pairs_;
};

}  // namespace

struct GapQuery::State {
  std::shared_ptr<const GapTree::Data> reference, moving;
  Eigen::Matrix3d R = Eigen::Matrix3d::Identity();
  std::optional<DualTreeTraversal> signed_traversal, forward_traversal;  // built on first use
  Hints signed_hints, forward_hints;
  GapResult answer;
  std::vector<NearCandidate> near;  // possible features
  std::vector<FeatureKey> keys;     // scratch memory
  PairBatch batch;                  // pairs that wait for the exact kernel
  PlacedPairs placed;               // of `batch`, without offsets
  std::array<TrianglePair, block_lanes> waiting;
  std::size_t n_waiting = 0;
  std::vector<TrianglePair> close;
  int n_queries = 0;

  double reach_mm(const MovingPose& pose) const
  {
    return std::max(reference->radius_mm, moving->radius_mm + pose.translation_mm.norm()) + rounding_mm();
  }
  double rounding_mm() const { return reference->offset_mm + moving->offset_mm; }
  double offset_of_mm(const TrianglePair& pair) const
  {
    return reference->faces[static_cast<std::size_t>(pair.reference)].offset_mm +
           moving->faces[static_cast<std::size_t>(pair.moving)].offset_mm;
  }
  // Of a part with an allowed overlap only the near side counts: where it is thinner than twice that, the
  // limit of its far side is in front (inward_limit).
  bool is_near_side(const TrianglePair& pair, const GapFace& r, const GapFace& m) const
  {
    return (r.faces_down() || overlap_mm(reference->surface.mesh, pair.reference) == 0.0) &&
           (m.faces_up() || overlap_mm(moving->surface.mesh, pair.moving) == 0.0);
  }
  GapFace reference_face(std::int32_t row) const;
  unsigned reference_edges(std::int32_t row) const;
  GapFace moving_face(std::int32_t row, const Placement& place) const;
  bool looks_down(std::int32_t row) const;
  template <typename Offer>
  void visit_pair(const TrianglePair& pair, const Placement& place, double limit_mm, const Offer& offer);
  // The same for a pair of `batch`.
  template <typename Offer>
  void visit_waiting(unsigned lane, const Placement& place, double limit_mm, const Offer& offer);
  void take(const TrianglePair& pair, double travel_mm);
  void try_pair(const TrianglePair& pair, const Placement& place);
  void try_touch(const TrianglePair& pair, const Placement& place, Gap& best) const;
  void reset_answer();
  template <typename Pairs>
  double least_travel_mm(const Pairs& pairs, const MovingPose& pose);
  void start(const MovingPose& pose, const Placement& place);
  void find_least(const MovingPose& pose, const Placement& place);
  void find_features(const MovingPose& pose, const Placement& place, double band_mm);
  DualTreeTraversal& traversal(GapKind kind);
  PairPlacement pair_placement(const MovingPose& pose) const;
  void wait(const TrianglePair& pair);
  // Traverses the trees; pairs that `screen` does not reject in the batch are visited, in any order.
  template <typename Limit, typename Screen, typename Visit>
  void run(DualTreeTraversal& pairs, const Limit& limit, const Screen& screen, const Visit& visit);
  template <typename Limit, typename Visit>
  void run_signed(const MovingPose& pose, const Limit& limit, const Visit& visit);
};

bool GapQuery::State::looks_down(std::int32_t row) const
{
  return R.row(1).dot(reference->surface.face_normals.row(row)) <= -gap_rules::vertical_normal;
}

GapFace GapQuery::State::reference_face(std::int32_t row) const
{
  const ExactFace& own = reference->faces[static_cast<std::size_t>(row)];
  const auto turned = [this](const Eigen::Vector3d& p) {
    return Eigen::Vector3d(R(0, 0) * p.x() + R(0, 1) * p.y() + R(0, 2) * p.z(),
                           R(1, 0) * p.x() + R(1, 1) * p.y() + R(1, 2) * p.z(),
                           R(2, 0) * p.x() + R(2, 1) * p.y() + R(2, 2) * p.z());
  };
  return gap_face({turned(own.corner[0]), turned(own.corner[1]), turned(own.corner[2])}, own.doubled_area);
}

unsigned GapQuery::State::reference_edges(std::int32_t row) const
{
  const std::array<std::int32_t, 3>& across = reference->surface.neighbours[static_cast<std::size_t>(row)];
  unsigned edges = 0;
  for (unsigned k = 0; k < 3; ++k) {
    if (across[k] < 0 || !looks_down(across[k])) edges |= 1U << k;
  }
  return edges;
}

GapFace GapQuery::State::moving_face(std::int32_t row, const Placement& place) const
{
  const ExactFace& own = moving->faces[static_cast<std::size_t>(row)];
  return gap_face(place(own.corner), own.doubled_area);
}

void GapQuery::State::take(const TrianglePair& pair, double travel_mm)
{
  if (travel_mm < answer.travel_mm || (travel_mm == answer.travel_mm && pair < answer.pair)) {
    answer.travel_mm = travel_mm;
    answer.pair = pair;
  }
}

template <typename Offer>
void GapQuery::State::visit_pair(const TrianglePair& pair, const Placement& place, double limit_mm,
                                 const Offer& offer)
{
  GapFace r = reference_face(pair.reference);
  if (!r.faces_down()) return;
  r.edges = reference_edges(pair.reference);
  GapFace m = moving_face(pair.moving, place);
  m.edges = moving->up_edges[static_cast<std::size_t>(pair.moving)];
  const auto take_and_offer = [&](const ContactCandidate& at) {
    take(pair, at.travel_mm);
    offer(pair, at);
  };
  const double offset_mm = offset_of_mm(pair);
  if (offset_mm > 0.0) {
    RoundedPair(r, m, offset_mm, limit_mm).visit(take_and_offer);
  } else {
    visit_contact_candidates(r, m, take_and_offer);
  }
}

template <typename Offer>
void GapQuery::State::visit_waiting(unsigned lane, const Placement& place, double limit_mm,
                                    const Offer& offer)
{
  const TrianglePair& pair = waiting[lane];
  if (rounding_mm() > 0.0) {
    visit_pair(pair, place, limit_mm, offer);
    return;
  }
  const auto wanted = static_cast<unsigned>(placed.candidates[lane]);
  GapFace r = gap_face(corners_of(placed.reference, lane),
                       reference->faces[static_cast<std::size_t>(pair.reference)].doubled_area);
  if (!r.faces_down()) return;
  GapFace m = gap_face(corners_of(placed.moving, lane),
                       moving->faces[static_cast<std::size_t>(pair.moving)].doubled_area);
  if (wanted >= first_edge_candidate) {
    r.edges = reference_edges(pair.reference);
    m.edges = moving->up_edges[static_cast<std::size_t>(pair.moving)];
  }
  visit_contact_candidates(
      r, m,
      [&](const ContactCandidate& at) {
        take(pair, at.travel_mm);
        offer(pair, at);
      },
      wanted);
}

void GapQuery::State::try_pair(const TrianglePair& pair, const Placement& place)
{
  visit_pair(pair, place, answer.travel_mm + bound_slack_mm,
             [](const TrianglePair&, const ContactCandidate&) {});
}

void GapQuery::State::reset_answer()
{
  answer.travel_mm = gap_rules::infinity;
  answer.pair = {};
  answer.features.clear();
}

template <typename Pairs>
double GapQuery::State::least_travel_mm(const Pairs& pairs, const MovingPose& pose)
{
  const Placement place(pose);
  reset_answer();
  for (const TrianglePair& pair : pairs) try_pair(pair, place);
  return answer.travel_mm;
}

void GapQuery::State::start(const MovingPose& pose, const Placement& place)
{
  ++n_queries;
  reset_answer();
  traversal(GapKind::signed_facing).place(pose, reach_mm(pose), {0.0, rounding_mm()});
  for (const TrianglePair& hint : signed_hints) try_pair(hint, place);
}

PairPlacement GapQuery::State::pair_placement(const MovingPose& pose) const
{
  const SinCos turn = sin_cos(pose.theta_rad);
  PairPlacement at{
      {}, turn.cos, turn.sin, pose.translation_mm.x(), pose.translation_mm.y(), pose.translation_mm.z()};
  for (int i = 0; i < 3; ++i) {
    for (int k = 0; k < 3; ++k) at.R[i][k] = R(i, k);
  }
  return at;
}

void GapQuery::State::wait(const TrianglePair& pair)
{
  const ExactFace& r = reference->faces[static_cast<std::size_t>(pair.reference)];
  const ExactFace& m = moving->faces[static_cast<std::size_t>(pair.moving)];
  for (int k = 0; k < 9; ++k) {
    batch.reference[k][n_waiting] = r.corner[static_cast<std::size_t>(k / 3)][k % 3];
    batch.moving[k][n_waiting] = m.corner[static_cast<std::size_t>(k / 3)][k % 3];
  }
  batch.least_projected[0][n_waiting] = r.least_projected;
  batch.least_projected[1][n_waiting] = m.least_projected;
  batch.offset_mm[n_waiting] = r.offset_mm + m.offset_mm;
  waiting[n_waiting++] = pair;
}

template <typename Limit, typename Screen, typename Visit>
void GapQuery::State::run(DualTreeTraversal& pairs, const Limit& limit, const Screen& screen,
                          const Visit& visit)
{
  const auto decide = [&] {
    unsigned kept = screen() & ((1U << n_waiting) - 1U);
    n_waiting = 0;
    for (; kept != 0; kept &= kept - 1) visit(static_cast<unsigned>(std::countr_zero(kept)));
  };
  n_waiting = 0;
  pairs.run(limit, [&](const TrianglePair& pair) {
    wait(pair);
    if (n_waiting == waiting.size()) decide();
  });
  if (n_waiting > 0) decide();
}

template <typename Limit, typename Visit>
void GapQuery::State::run_signed(const MovingPose& pose, const Limit& limit, const Visit& visit)
{
  DualTreeTraversal& pairs = traversal(GapKind::signed_facing);
  const PairPlacement at = pair_placement(pose);
  const BlockFunctions& functions = pairs.functions();
  if (rounding_mm() > 0.0) {
    run(
        pairs, limit,
        [&] {
          return functions.screen_apart(batch, at, {0.0, limit(), true});
        },
        visit);
  } else {
    run(
        pairs, limit, [&] { return functions.screen_pairs(batch, at, limit(), placed); }, visit);
  }
}

void GapQuery::State::find_least(const MovingPose& pose, const Placement& place)
{
  run_signed(
      pose, [this] { return answer.travel_mm; },
      [this, &place](unsigned lane) {
        visit_waiting(lane, place, answer.travel_mm + bound_slack_mm,
                      [](const TrianglePair&, const ContactCandidate&) {});
      });
}

// Collects candidates while the minimum travel decreases; those outside the final band are removed at the
// end.
void GapQuery::State::find_features(const MovingPose& pose, const Placement& place, double band_mm)
{
  near.clear();
  run_signed(
      pose, [this, band_mm] { return answer.travel_mm + band_mm; },
      [&](unsigned lane) {
        visit_waiting(lane, place, answer.travel_mm + band_mm + bound_slack_mm,
                      [&](const TrianglePair& pair, const ContactCandidate& at) {
                        if (at.travel_mm <= answer.travel_mm + band_mm) near.push_back({pair, at});
                      });
      });
  std::erase_if(
      near, [this, band_mm](const NearCandidate& n) { return n.at.travel_mm > answer.travel_mm + band_mm; });
  keep_one_candidate_per_feature(reference->surface.mesh, moving->surface.mesh, near, keys);
  for (const NearCandidate& n : near) {
    answer.features.push_back(gap_feature(reference_face(n.pair.reference), moving_face(n.pair.moving, place),
                                          n.at, n.pair, offset_of_mm(n.pair)));
  }
  merge_features(answer.features);
}

void GapQuery::State::try_touch(const TrianglePair& pair, const Placement& place, Gap& best) const
{
  const GapFace r = reference_face(pair.reference), m = moving_face(pair.moving, place);
  if (!is_near_side(pair, r, m)) return;
  const auto take = [&](double travel_mm) {
    if (travel_mm < 0.0 || travel_mm > best.travel_mm) return;
    if (travel_mm < best.travel_mm || pair < best.pair) best = {travel_mm, pair};
  };
  const double offset_mm = offset_of_mm(pair);
  if (offset_mm > 0.0) {
    take(rounded_passage(r.corner, m.corner, offset_mm, best.travel_mm + bound_slack_mm).ahead_mm());
  } else {
    visit_contact_candidates(r, m, [&take](const ContactCandidate& at) { take(at.travel_mm); });
  }
}

DualTreeTraversal& GapQuery::State::traversal(GapKind kind)
{
  std::optional<DualTreeTraversal>& known =
      kind == GapKind::signed_facing ? signed_traversal : forward_traversal;
  if (!known) {
    known.emplace(reference->as_reference(), moving->as_moving(kind), kind);
    known->turn(R);
  }
  return *known;
}

GapQuery::GapQuery(const GapTree& reference, const GapTree& moving)
{
  static const auto empty = std::make_shared<const GapTree::Data>();
  state_ = std::make_unique<State>();
  state_->reference = reference.data_ != nullptr ? reference.data_ : empty;
  state_->moving = moving.data_ != nullptr ? moving.data_ : empty;
  set_attitude({});
}

GapQuery::~GapQuery() = default;
GapQuery::GapQuery(GapQuery&&) noexcept = default;

void GapQuery::set_attitude(const Attitude& attitude)
{
  state_->R = reference_rotation(attitude);
  for (std::optional<DualTreeTraversal>* known : {&state_->signed_traversal, &state_->forward_traversal}) {
    if (*known) (*known)->turn(state_->R);
  }
}

double GapQuery::travel_mm(const MovingPose& pose)
{
  const Placement place(pose);
  state_->start(pose, place);
  state_->find_least(pose, place);
  state_->signed_hints.remember(state_->answer.pair);
  return state_->answer.travel_mm;
}

double GapQuery::gap_mm(const Attitude& attitude, const MovingPose& pose)
{
  set_attitude(attitude);
  const double found_mm = travel_mm(pose);
  return std::isfinite(found_mm) ? found_mm : nan;
}

double GapQuery::travel_upper_bound_mm(const MovingPose& pose)
{
  return state_->least_travel_mm(state_->signed_hints, pose);
}

double GapQuery::travel_upper_bound_mm(const MovingPose& pose, const std::vector<TrianglePair>& pairs)
{
  return state_->least_travel_mm(pairs, pose);
}

const GapResult& GapQuery::features(const MovingPose& pose, double band_mm)
{
  const Placement place(pose);
  state_->start(pose, place);
  state_->find_features(pose, place, band_mm);
  state_->signed_hints.remember(state_->answer.pair);
  return state_->answer;
}

Gap GapQuery::next_contact(const MovingPose& pose)
{
  State& state = *state_;
  ++state.n_queries;
  const Placement place(pose);
  DualTreeTraversal& traversal = state.traversal(GapKind::non_negative);
  traversal.place(pose, state.reach_mm(pose), {0.0, state.rounding_mm()});
  Gap best;
  for (const TrianglePair& hint : state.forward_hints) state.try_touch(hint, place, best);
  const PairPlacement at = state.pair_placement(pose);
  const auto limit = [&best] { return best.travel_mm; };
  state.run(
      traversal, limit,
      [&] {
        return traversal.functions().screen_apart(state.batch, at, {0.0, limit(), true});
      },
      [&](unsigned lane) { state.try_touch(state.waiting[lane], place, best); });
  state.forward_hints.remember(best.pair);
  return best;
}

double GapQuery::travel_of_mm(const MovingPose& pose, const TrianglePair& pair) const
{
  Gap best;
  state_->try_touch(pair, Placement(pose), best);
  return best.travel_mm;
}

bool GapQuery::any_close_pair(const MovingPose& pose, double band_mm,
                              const std::function<bool(const TrianglePair&)>& visit)
{
  // Between two points within the band, h apart across Delta, the heights over a plane of slope s differ by
  // at most sqrt(band^2 - h^2) + s h, so by sqrt(1 + s^2) bands: two for 60 degrees, the steepest plane of a
  // bound. One is in the margin of place().
  const double limit_mm = band_mm;
  DualTreeTraversal& traversal = state_->traversal(GapKind::non_negative);
  traversal.place(pose, state_->reach_mm(pose), {band_mm, state_->rounding_mm()});
  ++state_->n_queries;
  bool is_found = false;
  const PairPlacement at = state_->pair_placement(pose);
  state_->run(
      traversal, [&] { return is_found ? -gap_rules::infinity : limit_mm; },
      [&] {
        return traversal.functions().screen_apart(state_->batch, at, {band_mm, 0.0, false});
      },
      [&](unsigned lane) { is_found = is_found || visit(state_->waiting[lane]); });
  return is_found;
}

const std::vector<TrianglePair>& GapQuery::close_pairs(const MovingPose& pose, double band_mm)
{
  state_->close.clear();
  any_close_pair(pose, band_mm, [this](const TrianglePair& pair) {
    state_->close.push_back(pair);
    return false;
  });
  return state_->close;
}

int GapQuery::n_queries() const
{
  return state_->n_queries;
}

}  // namespace vrda::geometry
