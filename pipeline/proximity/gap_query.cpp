#include "proximity/gap_query.hpp"

#include <algorithm>
#include <bit>
#include <numeric>
#include <utility>

#include "core/error.hpp"
#include "proximity/gap_block_tree.hpp"
#include "proximity/gap_features.hpp"
#include "proximity/gap_walk.hpp"
#include "proximity/instruction_set.hpp"

namespace vrda {
namespace {

std::vector<std::int32_t> all_rows(const Mesh& mesh)
{
  std::vector<std::int32_t> rows(static_cast<std::size_t>(mesh.triangles.rows()));
  std::iota(rows.begin(), rows.end(), 0);
  return rows;
}

// A triangle as the exact kernel reads it.
struct ExactFace {
  Corners corner;
  double doubled_area = 0.0;
};

std::vector<ExactFace> exact_faces(const Mesh& mesh)
{
  std::vector<ExactFace> faces(static_cast<std::size_t>(mesh.triangles.rows()));
  for (std::size_t t = 0; t < faces.size(); ++t) {
    const Corners c = corners(mesh, static_cast<Eigen::Index>(t));
    faces[t] = {c, doubled_area(c)};
  }
  return faces;
}

}  // namespace

struct GapTree::Data {
  GapSurface surface;
  std::vector<ExactFace> faces;
  ReferenceTree as_reference;
  MovingTree as_moving;
  std::vector<unsigned> up_edges;  // [n_triangles] edges that can touch first, of faces that look up
  double radius_mm = 0.0;          // the farthest vertex from the origin
};

GapTree::GapTree(const Mesh& mesh) : GapTree(mesh, all_rows(mesh)) {}

GapTree::GapTree(const Mesh& mesh, const std::vector<std::int32_t>& triangles)
{
  auto data = std::make_shared<Data>();
  data->surface = gap_surface(mesh, triangles);
  data->faces = exact_faces(mesh);
  std::vector<bool> looks_up(data->faces.size());
  std::vector<std::int32_t> up;
  for (const std::int32_t t : data->surface.triangles) {
    const ExactFace& face = data->faces[static_cast<std::size_t>(t)];
    if (!gap_face(face.corner, face.doubled_area).looks_up()) continue;
    looks_up[static_cast<std::size_t>(t)] = true;
    up.push_back(t);
  }
  data->up_edges.assign(data->faces.size(), 0);
  for (const std::int32_t t : up) {
    data->up_edges[static_cast<std::size_t>(t)] = touching_edges(data->surface, t, looks_up);
  }
  data->as_reference = reference_tree(data->surface);
  data->as_moving = moving_tree(data->surface, up);
  if (mesh.vertices_mm.rows() > 0) data->radius_mm = mesh.vertices_mm.rowwise().norm().maxCoeff();
  data_ = std::move(data);
}

bool GapTree::is_empty() const
{
  return data_ == nullptr || data_->surface.triangles.empty();
}

struct GapQuery::State {
  std::shared_ptr<const GapTree::Data> reference, moving;
  Eigen::Matrix3d R = Eigen::Matrix3d::Identity();
  GapWalk walk;
  TrianglePair hint;
  GapAnswer answer;
  int n_queries = 0;

  State(std::shared_ptr<const GapTree::Data> r, std::shared_ptr<const GapTree::Data> m)
      : reference(std::move(r)), moving(std::move(m)), walk(reference->as_reference, moving->as_moving)
  {
  }

  GapFace reference_face(std::int32_t row) const;
  GapFace moving_face(std::int32_t row, const Placement& place) const;
  bool looks_down(std::int32_t row) const;
  void offer(const TrianglePair& pair, const Placement& place);
  void find_least(const Placement& place);
  void find_features(const Placement& place, double band_mm);
  void start(const MovingPose& pose);
};

bool GapQuery::State::looks_down(std::int32_t row) const
{
  return R.row(1).dot(reference->surface.face_normals.row(row)) <= -gap_rules::vertical_normal;
}

GapFace GapQuery::State::reference_face(std::int32_t row) const
{
  const ExactFace& own = reference->faces[static_cast<std::size_t>(row)];
  GapFace face = gap_face({R * own.corner[0], R * own.corner[1], R * own.corner[2]}, own.doubled_area);
  const std::array<std::int32_t, 3>& across = reference->surface.neighbours[static_cast<std::size_t>(row)];
  face.edges = 0;
  for (unsigned k = 0; k < 3; ++k) {
    if (across[k] < 0 || !looks_down(across[k])) face.edges |= 1U << k;
  }
  return face;
}

GapFace GapQuery::State::moving_face(std::int32_t row, const Placement& place) const
{
  const ExactFace& own = moving->faces[static_cast<std::size_t>(row)];
  GapFace face = gap_face(place(own.corner), own.doubled_area);
  face.edges = moving->up_edges[static_cast<std::size_t>(row)];
  return face;
}

void GapQuery::State::offer(const TrianglePair& pair, const Placement& place)
{
  const GapFace r = reference_face(pair.reference);
  if (!r.looks_down()) return;
  visit_meeting_places(r, moving_face(pair.moving, place), [this, &pair](const MeetingPlace& at) {
    if (at.travel_mm > answer.travel_mm) return;
    if (at.travel_mm < answer.travel_mm || pair < answer.pair) answer.pair = pair;
    answer.travel_mm = at.travel_mm;
  });
}

void GapQuery::State::start(const MovingPose& pose)
{
  ++n_queries;
  answer.travel_mm = gap_rules::infinity;
  answer.pair = {};
  answer.features.clear();
  const double reach_mm = reference->radius_mm + moving->radius_mm + pose.translation_mm.norm();
  walk.place(pose, reach_mm);
  if (hint.reference >= 0) offer(hint, Placement(pose));
}

void GapQuery::State::find_least(const Placement& place)
{
  walk.run([this] { return answer.travel_mm; },
           [this, &place](const TrianglePair& pair) { offer(pair, place); });
  if (answer.pair.reference >= 0) hint = answer.pair;
}

void GapQuery::State::find_features(const Placement& place, double band_mm)
{
  const double limit_mm = answer.travel_mm + band_mm;
  walk.run([limit_mm] { return limit_mm; },
           [&](const TrianglePair& pair) {
             const GapFace r = reference_face(pair.reference);
             if (!r.looks_down()) return;
             const GapFace m = moving_face(pair.moving, place);
             visit_meeting_places(r, m, [&](const MeetingPlace& at) {
               if (at.travel_mm <= limit_mm) answer.features.push_back(gap_feature(r, m, at, pair));
             });
           });
  merge_features(answer.features);
}

GapQuery::GapQuery(const GapTree& reference, const GapTree& moving)
{
  static const auto empty = std::make_shared<const GapTree::Data>();
  state_ = std::make_unique<State>(reference.data_ != nullptr ? reference.data_ : empty,
                                   moving.data_ != nullptr ? moving.data_ : empty);
  set_attitude({});
}

GapQuery::~GapQuery() = default;
GapQuery::GapQuery(GapQuery&&) noexcept = default;

void GapQuery::set_attitude(const Attitude& attitude)
{
  state_->R = reference_rotation(attitude);
  state_->walk.turn(state_->R);
}

double GapQuery::travel_mm(const MovingPose& pose)
{
  state_->start(pose);
  state_->find_least(Placement(pose));
  return state_->answer.travel_mm;
}

const GapAnswer& GapQuery::features(const MovingPose& pose, double band_mm)
{
  state_->start(pose);
  const Placement place(pose);
  state_->find_least(place);
  if (state_->answer.pair.reference >= 0) state_->find_features(place, band_mm);
  return state_->answer;
}

int GapQuery::n_queries() const
{
  return state_->n_queries;
}

}  // namespace vrda
