/// Directional gap with every feature near it, as the equilibrium needs it (DESIGN.md 5.2).
#pragma once

#include <limits>
#include <memory>
#include <vector>

#include "core/coordinates.hpp"
#include "proximity/directional_gap.hpp"

namespace vrda {

/// Where the moving object meets the reference, or would soon: a vertex under a face, a vertex over a face,
/// or two edges that cross in projection. Rules:
///  - reference faces that look down meet moving faces that look up. A face with |n_y| below 1e-6 (unit
///  normal)
///    looks neither way: it takes part by the edges it shares with faces that do.
///  - edges cross only where both can touch first: each sticks out, bounds the sheet, or lies between a face
///    that counts and one that does not. On a flat or reflex edge between two faces that count the travel is
///    never least, unless it is as small all along a line to another feature.
///  - a vertex over an edge or a vertex gives a feature for each different normal there: each is a valid
///    one-sided linearisation. The same place seen through several triangles is one feature.
///  - edges closer to parallel than a sine of 1e-12 are left to their vertices.
///  - projections that only share a point or a line meet.
struct GapFeature {
  double travel_mm = 0.0;    ///< along Delta until this feature touches; negative: beyond it
  Eigen::Vector3d point_mm;  ///< on the moving object where it stands, S
  Eigen::Vector3d normal;    ///< unit, reaction on the moving object: y < 0
  TrianglePair triangles;
};

/// d travel / d coordinates: how much further along Delta the feature lets the moving object go. With n the
/// normal and J the velocities of the material point that touches, -(J^T n) / n.y. The derivative over y is
/// -1.
Vector5d travel_gradient(const GapFeature& feature, const MovingPose& pose);

struct GapAnswer {
  double travel_mm = std::numeric_limits<double>::infinity();  ///< infinite: nothing faces
  TrianglePair pair;                                           ///< -1, -1 when nothing faces
  std::vector<GapFeature> features;  ///< those within the band of `travel_mm`, nearest first
};

/// A mesh in the solver frame at zero attitude, prepared for queries. Shared by all threads.
class GapTree {
 public:
  GapTree() = default;
  explicit GapTree(const Mesh& mesh);
  /// Only the triangles listed; rows of `mesh` in every answer.
  GapTree(const Mesh& mesh, const std::vector<std::int32_t>& triangles);
  bool is_empty() const;

 private:
  friend class GapQuery;
  struct Data;
  std::shared_ptr<const Data> data_;
};

/// One thread's queries between two meshes; keeps scratch and the last few answers as hints, which change the
/// time, never the answer.
class GapQuery {
 public:
  GapQuery(const GapTree& reference, const GapTree& moving);
  ~GapQuery();
  GapQuery(GapQuery&&) noexcept;

  /// Turns the reference.
  void set_attitude(const Attitude& attitude);

  /// Signed travel of the first touch of an object that comes from far below, over facing pairs: negative
  /// when it stands deeper than that.
  double travel_mm(const MovingPose& pose);

  /// Not below travel_mm(pose), from the hints alone: often that itself, infinite where they say nothing.
  /// Asks no query. Depends on what was asked before, so decide nothing by it that travel_mm() would decide
  /// otherwise.
  double travel_at_most_mm(const MovingPose& pose);

  /// The same with the features whose travel is within `band_mm` of it. Valid until the next call.
  const GapAnswer& features(const MovingPose& pose, double band_mm);

  /// The next touch on the way up from where the object stands: the smallest travel that is not negative, of
  /// any pair of triangles whatever it faces. The bits of directional_gap() with GapKind::from_here.
  Gap touch(const MovingPose& pose);

  /// Every pair of triangles that come within `band_mm` of each other where the object stands, in whatever
  /// direction, and some that do not; in no order that counts. Valid until the next call.
  const std::vector<TrianglePair>& close_pairs(const MovingPose& pose, double band_mm);

  int n_queries() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace vrda
