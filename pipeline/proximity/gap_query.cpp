#include "proximity/gap_query.hpp"

#include <algorithm>
#include <numeric>
#include <utility>

#include "proximity/gap_features.hpp"
#include "proximity/gap_surface.hpp"

namespace vrda {
namespace {

// A travel may come out below a bound by the kernel's rounding; the pair must be looked at all the same, or
// the answer would depend on the order of the walk. Far above that rounding (1e-13 mm on coordinates of 100
// mm).
constexpr double bound_slack_mm = 1e-9;

std::vector<std::int32_t> all_rows(const Mesh& mesh)
{
  std::vector<std::int32_t> rows(static_cast<std::size_t>(mesh.triangles.rows()));
  std::iota(rows.begin(), rows.end(), 0);
  return rows;
}

GapFace face_of(const Mesh& mesh, std::int32_t t)
{
  return gap_face(corners(mesh, t));
}

// Edges that can touch first, for faces that look one way.
template <typename Counts>
std::vector<unsigned> edges_where(const GapSurface& surface, const Counts& counts)
{
  std::vector<bool> is_counted(static_cast<std::size_t>(surface.mesh.triangles.rows()));
  for (const std::int32_t t : surface.triangles) is_counted[static_cast<std::size_t>(t)] = counts(t);
  std::vector<unsigned> edges(is_counted.size(), 7);
  for (const std::int32_t t : surface.triangles) {
    edges[static_cast<std::size_t>(t)] = touching_edges(surface, t, is_counted);
  }
  return edges;
}

}  // namespace

struct GapTree::Data {
  GapSurface surface;
  BoxTree all;
  BoxTree up;                      // faces that look up
  std::vector<unsigned> up_edges;  // of faces that look up
};

GapTree::GapTree(const Mesh& mesh) : GapTree(mesh, all_rows(mesh)) {}

GapTree::GapTree(const Mesh& mesh, const std::vector<std::int32_t>& triangles)
{
  auto data = std::make_shared<Data>();
  data->surface = gap_surface(mesh, triangles);
  const GapSurface& surface = data->surface;
  const auto looks_up = [&surface](std::int32_t t) { return face_of(surface.mesh, t).looks_up(); };
  std::vector<std::int32_t> up;
  std::copy_if(surface.triangles.begin(), surface.triangles.end(), std::back_inserter(up), looks_up);
  data->all = BoxTree(mesh, surface.triangles);
  data->up = BoxTree(mesh, up);
  data->up_edges = edges_where(surface, looks_up);
  data_ = std::move(data);
}

bool GapTree::is_empty() const
{
  return data_ == nullptr || data_->surface.triangles.empty();
}

struct GapQuery::State {
  std::shared_ptr<const GapTree::Data> reference, moving;
  TreeMesh turned;
  std::vector<unsigned> down_edges;
  TrianglePair hint;
  GapAnswer answer;
  int n_queries = 0;

  bool is_empty() const { return turned.tree.is_empty() || moving == nullptr || moving->up.is_empty(); }

  GapFace reference_face(std::int32_t t) const
  {
    GapFace face = face_of(turned.mesh, t);
    face.edges = down_edges[static_cast<std::size_t>(t)];
    return face;
  }

  GapFace moving_face(std::int32_t t, const Placement& place) const
  {
    GapFace face = gap_face(place(corners(moving->surface.mesh, t)));
    face.edges = moving->up_edges[static_cast<std::size_t>(t)];
    return face;
  }

  // Calls `visit(pair)` for every pair of facing triangles whose boxes may come within limit() of meeting.
  template <typename Limit, typename Visit>
  void walk(const Placement& place, const Limit& limit, const Visit& visit) const;
  void find_least(const MovingPose& pose);
};

template <typename Limit, typename Visit>
void GapQuery::State::walk(const Placement& place, const Limit& limit, const Visit& visit) const
{
  std::vector<std::pair<std::int32_t, std::int32_t>> tasks{{0, 0}};
  const BoxTree &r_tree = turned.tree, &m_tree = moving->up;
  while (!tasks.empty()) {
    const auto [ri, mi] = tasks.back();
    tasks.pop_back();
    const BoxTree::Node& r = r_tree.nodes()[static_cast<std::size_t>(ri)];
    const BoxTree::Node m = place(m_tree.nodes()[static_cast<std::size_t>(mi)]);
    if (r.min_mm[0] > m.max_mm[0] || m.min_mm[0] > r.max_mm[0] || r.min_mm[2] > m.max_mm[2] ||
        m.min_mm[2] > r.max_mm[2] || r.min_mm[1] - m.max_mm[1] - bound_slack_mm > limit()) {
      continue;
    }
    if (r.is_leaf() && m.is_leaf()) {
      visit_leaves(r_tree, r, m_tree, m, [&visit](const TrianglePair& pair) {
        visit(pair);
        return false;
      });
    } else if (m.is_leaf() || (!r.is_leaf() && r.max_mm[0] - r.min_mm[0] >= m.max_mm[0] - m.min_mm[0])) {
      tasks.insert(tasks.end(), {{r.first, mi}, {ri + 1, mi}});
    } else {
      tasks.insert(tasks.end(), {{ri, m.first}, {ri, mi + 1}});
    }
  }
}

void GapQuery::State::find_least(const MovingPose& pose)
{
  ++n_queries;
  answer.travel_mm = gap_rules::infinity;
  answer.pair = {};
  answer.features.clear();
  if (is_empty()) return;
  const Placement place(pose);
  const auto offer = [this, &place](const TrianglePair& pair) {
    const GapFace r = reference_face(pair.reference);
    if (!r.looks_down()) return;
    visit_meeting_places(r, moving_face(pair.moving, place), [this, &pair](const MeetingPlace& at) {
      if (at.travel_mm > answer.travel_mm) return;
      if (at.travel_mm < answer.travel_mm || pair < answer.pair) answer.pair = pair;
      answer.travel_mm = at.travel_mm;
    });
  };
  if (hint.reference >= 0) offer(hint);
  walk(
      place, [this] { return answer.travel_mm; }, offer);
  if (answer.pair.reference >= 0) hint = answer.pair;
}

GapQuery::GapQuery(const GapTree& reference, const GapTree& moving) : state_(std::make_unique<State>())
{
  state_->reference = reference.data_;
  state_->moving = moving.data_;
  set_attitude({});
}

GapQuery::~GapQuery() = default;
GapQuery::GapQuery(GapQuery&&) noexcept = default;

void GapQuery::set_attitude(const Attitude& attitude)
{
  if (state_->reference == nullptr) return;
  const GapSurface& surface = state_->reference->surface;
  state_->turned = vrda::turned({surface.mesh, state_->reference->all}, attitude);
  const Mesh& mesh = state_->turned.mesh;
  state_->down_edges =
      edges_where(surface, [&mesh](std::int32_t t) { return face_of(mesh, t).looks_down(); });
}

double GapQuery::travel_mm(const MovingPose& pose)
{
  state_->find_least(pose);
  return state_->answer.travel_mm;
}

const GapAnswer& GapQuery::features(const MovingPose& pose, double band_mm)
{
  state_->find_least(pose);
  GapAnswer& answer = state_->answer;
  if (answer.pair.reference < 0) return answer;
  const Placement place(pose);
  const double limit_mm = answer.travel_mm + band_mm;
  state_->walk(
      place, [limit_mm] { return limit_mm; },
      [&](const TrianglePair& pair) {
        const GapFace r = state_->reference_face(pair.reference);
        if (!r.looks_down()) return;
        const GapFace m = state_->moving_face(pair.moving, place);
        visit_meeting_places(r, m, [&](const MeetingPlace& at) {
          if (at.travel_mm <= limit_mm) answer.features.push_back(gap_feature(r, m, at, pair));
        });
      });
  merge_features(answer.features);
  return answer;
}

int GapQuery::n_queries() const
{
  return state_->n_queries;
}

}  // namespace vrda
