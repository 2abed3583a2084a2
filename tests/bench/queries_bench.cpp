// Single queries at the same near misses, VRDA's and FCL's.
#include <benchmark/benchmark.h>
#include <fcl/narrowphase/collision.h>

#include "contact/contacts.hpp"
#include "fcl_search.hpp"
#include "geometry/gap_query.hpp"
#include "scene.hpp"
#include "support/directional_gap.hpp"

namespace vrda::benchmarks {
namespace {

// All near misses of a scene; the reference is rotated once per step, as in a search.
struct Queries {
  std::vector<geometry::TreeMesh> references;
  std::vector<std::pair<std::size_t, MovingPose>> poses;  // index of its reference
};

Queries queries_of(const Scene& s)
{
  Queries all;
  for (const Step& step : s.steps) {
    all.references.push_back(geometry::rotated_reference(s.joint.reference.tree_mesh, step.attitude));
    for (const MovingPose& pose : near_misses(step)) all.poses.emplace_back(all.references.size() - 1, pose);
  }
  return all;
}

void rate(benchmark::State& state, std::size_t n)
{
  state.counters["queries/s"] =
      benchmark::Counter(static_cast<double>(n), benchmark::Counter::kIsIterationInvariantRate);
}

void gap(benchmark::State& state, const std::string& knee)
{
  const Scene& s = scene(knee);
  const Queries all = queries_of(s);
  for (auto _ : state) {
    for (const auto& [reference, pose] : all.poses) {
      benchmark::DoNotOptimize(test::directional_gap(all.references[reference], s.joint.moving.tree_mesh.mesh,
                                                     s.joint.moving.tree_mesh.tree, pose));
    }
  }
  rate(state, all.poses.size());
}

// The same near misses with the block trees; the reference is rotated once per step.
template <typename Ask>
void gap_query(benchmark::State& state, const std::string& knee, const Ask& ask)
{
  const Scene& s = scene(knee);
  geometry::GapQuery query(s.joint.reference_gap, s.joint.moving_gap);
  std::size_t n = 0;
  for (auto _ : state) {
    n = 0;
    for (const Step& step : s.steps) {
      query.set_attitude(step.attitude);
      for (const MovingPose& pose : near_misses(step)) {
        benchmark::DoNotOptimize(ask(query, pose));
        ++n;
      }
    }
  }
  rate(state, n);
}

void gap_touch(benchmark::State& state, const std::string& knee)
{
  gap_query(state, knee, [](geometry::GapQuery& query, const MovingPose& pose) {
    return query.next_contact(pose).travel_mm;
  });
}

void gap_travel(benchmark::State& state, const std::string& knee)
{
  gap_query(state, knee,
            [](geometry::GapQuery& query, const MovingPose& pose) { return query.travel_mm(pose); });
}

void gap_features(benchmark::State& state, const std::string& knee)
{
  gap_query(state, knee, [](geometry::GapQuery& query, const MovingPose& pose) {
    return query.features(pose, 0.1).features.size();
  });
}

void collision(benchmark::State& state, const std::string& knee)
{
  const Scene& s = scene(knee);
  const Queries all = queries_of(s);
  contact::NarrowPhase narrow_phase;
  int n_hits = 0;
  for (auto _ : state) {
    n_hits = 0;
    for (const auto& [reference, pose] : all.poses) {
      n_hits +=
          contact::find_collision(all.references[reference], s.joint.moving.tree_mesh, pose, narrow_phase)
                  .has_value()
              ? 1
              : 0;
    }
    benchmark::DoNotOptimize(n_hits);
  }
  rate(state, all.poses.size());
  state.counters["colliding share"] = n_hits / static_cast<double>(all.poses.size());
}

void fcl_collision(benchmark::State& state, const std::string& knee)
{
  const Scene& s = scene(knee);
  const Queries all = queries_of(s);
  const auto reference = fcl_model(s.joint.reference.tree_mesh.mesh),
             moving = fcl_model(s.joint.moving.tree_mesh.mesh);
  fcl::CollisionObjectd fixed(reference), other(moving);
  int n_hits = 0;
  for (auto _ : state) {
    n_hits = 0;
    for (const auto& [step, pose] : all.poses) {
      fixed.setRotation(reference_rotation(s.steps[step].attitude));
      other.setTransform(fcl::Transform3d(pose_of(pose).matrix()));
      fcl::CollisionRequestd request;
      fcl::CollisionResultd result;
      n_hits += fcl::collide(&fixed, &other, request, result) > 0 ? 1 : 0;
    }
    benchmark::DoNotOptimize(n_hits);
  }
  rate(state, all.poses.size());
  state.counters["colliding share"] = n_hits / static_cast<double>(all.poses.size());
}

void contacts(benchmark::State& state, const std::string& knee)
{
  const Scene& s = scene(knee);
  const Queries all = queries_of(s);
  contact::NarrowPhase narrow_phase;
  std::size_t n_contacts = 0;
  for (auto _ : state) {
    n_contacts = 0;
    for (const auto& [reference, pose] : all.poses) {
      n_contacts +=
          contact::find_contacts({all.references[reference], s.joint.reference.features, s.joint.moving},
                                 pose, narrow_phase, {})
              .size();
    }
    benchmark::DoNotOptimize(n_contacts);
  }
  rate(state, all.poses.size());
  state.counters["contacts per query"] =
      static_cast<double>(n_contacts) / static_cast<double>(all.poses.size());
}

[[maybe_unused]] const bool registered = [] {
  for_each_knee("proximity/directional_gap", gap);
  for_each_knee("proximity/gap_touch", gap_touch);
  for_each_knee("proximity/gap_travel", gap_travel);
  for_each_knee("proximity/gap_features", gap_features);
  for_each_knee("contact/find_collision", collision);
  for_each_knee("contact/find_collision_by_FCL", fcl_collision);
  for_each_knee("contact/find_contacts", contacts);
  return true;
}();

}  // namespace
}  // namespace vrda::benchmarks
