/// Vector instruction set of the gap queries. All sets give the same bits; only the run time differs.
#pragma once

#include <functional>
#include <limits>
#include <memory>
#include <vector>

#include "geometry/placement.hpp"
#include "model/coordinates.hpp"

namespace vrda::geometry {

enum class InstructionSet {
  baseline,  ///< SSE2: x86-64-v1 and -v2 processors
  avx2,
  avx512,  ///< F, VL and DQ
};

/// The sets that this processor supports, slowest first; never empty.
std::vector<InstructionSet> instruction_sets();

/// Sets the instruction set of GapQuery objects created from now on; the default is the last of
/// instruction_sets(). For tests and benchmarks. Expects one of instruction_sets().
void set_instruction_set(InstructionSet set);
InstructionSet instruction_set();

// Directional gap with all near-active features, for the equilibrium solver.

/// A travel and the pair of triangles in contact at its end.
struct Gap {
  double travel_mm = std::numeric_limits<double>::infinity();  ///< infinite: no contact
  TrianglePair pair;                                           ///< -1, -1 without contact
};

/// Which travels count.
enum class GapKind {
  non_negative,   ///< the smallest non-negative one: the next contact along Delta from the current pose
  signed_facing,  ///< the smallest signed one over facing pairs: the first contact of an object approaching
                  ///< from far below; negative when the current pose is beyond it
};

/// A contact or near contact: a vertex under a face, a vertex over a face, or two edges that cross in
/// projection. Rules:
///  - only reference faces directed down and moving faces directed up are included. A face with |n_y| below
///    1e-6 (unit normal) is neither; it contributes the edges that it shares with included faces.
///  - edges are paired only where both can touch first: each is convex, a boundary, or between an included
///    and an excluded face. On a flat or reflex edge between two included faces the travel is never a strict
///    minimum: it is equally small along a line to another feature.
///  - a vertex over an edge or a vertex gives a feature for each different normal there: each is a valid
///    one-sided linearisation. The same point found through several triangles is one feature.
///  - pairs of edges with a sine below 1e-12 are ignored; their vertices cover them.
///  - projections that share only a point or a line count as overlapping.
///  - with offsets (Mesh::offset_mm) faces and pairs of edges touch shifted by the sum of both offsets along
///    their normal, and vertices are spheres and edges cylinders where nothing else of their pair is nearer.
struct GapFeature {
  double travel_mm = 0.0;    ///< along Delta until this feature touches; negative: overlap
  Eigen::Vector3d point_mm;  ///< on the moving mesh, without offset, at its current pose, S
  Eigen::Vector3d normal;    ///< unit, reaction on the moving object: y < 0
  TrianglePair triangles;
  ContactKind kind = ContactKind::moving_vertex;
  double offset_mm = 0.0;  ///< sum of both offsets: distance of the meshes' points along the normal
  Eigen::Vector3d edge = Eigen::Vector3d::Zero();  ///< unit, axis of the cylinder, S; otherwise zero
};

struct GapResult {
  double travel_mm = std::numeric_limits<double>::infinity();  ///< infinite: no facing pair
  TrianglePair pair;                                           ///< -1, -1 without a facing pair
  std::vector<GapFeature> features;  ///< those within the band of `travel_mm`, nearest first
};

/// A mesh in the solver frame at zero attitude, prepared for queries. Shared by all threads.
class GapTree {
 public:
  GapTree() = default;
  explicit GapTree(const Mesh& mesh);
  /// Only the listed triangles; results refer to rows of `mesh`.
  GapTree(const Mesh& mesh, const std::vector<std::int32_t>& triangles);
  bool is_empty() const;

  /// Build what queries of a role need now, instead of in the first query, for which other threads wait.
  void prepare_as_reference() const;
  void prepare_as_moving(GapKind kind) const;

 private:
  friend class GapQuery;
  struct Data;
  std::shared_ptr<const Data> data_;
};

/// Gap queries between two meshes for one thread. Keeps scratch memory and the last few results as hints,
/// which affect the run time but not the result.
class GapQuery {
 public:
  GapQuery(const GapTree& reference, const GapTree& moving);
  ~GapQuery();
  GapQuery(GapQuery&&) noexcept;

  /// Rotates the reference.
  void set_attitude(const Attitude& attitude);

  /// Signed travel to the first contact of an object approaching from far below, over facing pairs: negative
  /// when the pose is beyond it.
  double travel_mm(const MovingPose& pose);
  /// The same at an attitude; NaN where nothing faces.
  double gap_mm(const Attitude& attitude, const MovingPose& pose);

  /// Upper bound of travel_mm(pose) from the hints, often equal to it; infinite where no hint applies. Runs
  /// no query. Depends on earlier queries, so it must not decide anything that travel_mm() would decide
  /// differently.
  double travel_upper_bound_mm(const MovingPose& pose);

  /// The same from `pairs` instead of the hints; infinite where none can touch.
  double travel_upper_bound_mm(const MovingPose& pose, const std::vector<TrianglePair>& pairs);

  /// The same as travel_mm() with the features whose travel is within `band_mm` of it. Valid until the next
  /// call.
  const GapResult& features(const MovingPose& pose, double band_mm);

  /// The next contact along +Y from the current pose: the smallest non-negative travel over all pairs of
  /// triangles.
  Gap next_contact(const MovingPose& pose);

  /// Smallest non-negative travel of one pair at the pose, without a query; infinite if it is not ahead.
  double travel_of_mm(const MovingPose& pose, const TrianglePair& pair) const;

  /// A superset of the pairs of triangles within `band_mm` of each other at the pose, in any direction;
  /// both rounded by their offsets; unordered. Valid until the next call.
  const std::vector<TrianglePair>& close_pairs(const MovingPose& pose, double band_mm);
  /// Calls `visit` for such pairs until it returns true; returns whether it did.
  bool any_close_pair(const MovingPose& pose, double band_mm,
                      const std::function<bool(const TrianglePair&)>& visit);

  int n_queries() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace vrda::geometry
