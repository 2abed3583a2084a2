/// Single-precision bounds of a directional gap query: blocks of eight bounds, transformed and tested eight
/// at a time. Plain data without libraries, because this code is compiled once for every instruction set.
///
/// A bound is a box across Delta and two heights: a flat one and a plane a + b x + c z. Values are rounded to
/// nearest; comparisons add a margin (gap_slack_mm).
#pragma once

#include <cstdint>

namespace vrda::geometry {

inline constexpr int block_lanes = 8;

struct alignas(32) BlockRow {
  float lane[block_lanes];
};

/// Reference, own frame: boxes in space, a half-space normal . p >= offset that contains every vertex, and
/// the spread of the faces' outward normals around -normal (sine; 1 beyond a right angle). An unused lane has
/// a half width of -1e30.
struct ReferenceInner {
  BlockRow centre[3], half[3], normal[3], offset, spread;
};

/// Reference, own frame: eight triangles; x, y, z of each corner, the plane of each with its normal inward.
/// `absent` is 1e30 for an unused lane, else 0. `rounding` is the triangle's offset, by which its box and its
/// heights grow: all contacts of the rounded triangle are within its bounds.
struct ReferenceLeaf {
  BlockRow x[3], y[3], z[3], normal[3], offset, absent, rounding;
};

/// Moving, own frame: boxes across Delta, highest and lowest point, a plane above every vertex.
struct MovingInner {
  BlockRow centre_x, half_x, centre_z, half_z, top, bottom, a, b, c;
};

/// `rounding` as of ReferenceLeaf; `shift`: the offset times the normal, across Delta.
struct MovingLeaf {
  BlockRow x[3], z[3], top, bottom, a, b, c, absent, rounding, shift_x, shift_z;
};

/// Either object's bounds in S. Near side (`flat` and plane): lower bound of the reference's height, upper
/// bound of the moving object's. `far`: the opposite bound.
struct PlacedBlock {
  BlockRow x_low, x_high, z_low, z_high, flat, a, b, c, far;
};

/// One lane of a PlacedBlock.
struct PlacedBound {
  float x_low, x_high, z_low, z_high, flat, a, b, c;
};

/// A leaf's corners across Delta, in S.
struct PlacedCorners {
  BlockRow x[3], z[3];
};

struct BlockRotation {
  float R[3][3];
  float cull;   ///< faces with a normal further up than this are omitted
  float shift;  ///< 1: corners are shifted by the offset along the normal; 0 for faces in any orientation
};

struct BlockPlacement {
  float cos, sin, x, y, z;
  float slack;  ///< margin added to boxes, mm
  float shift;  ///< as of BlockRotation
};

/// The 8 x 8 pairs that may be within a limit, and a lower bound of each travel.
struct BlockPairs {
  std::uint8_t hits[block_lanes];  ///< per moving lane: bit i for reference lane i
  BlockRow bound[block_lanes];     ///< per moving lane
};

struct BlockLimits {
  float least, most;
};

/// Two leaves to be screened triangle by triangle.
struct LeafPair {
  const PlacedBlock &reference, &moving;
  const PlacedCorners &reference_corners, &moving_corners;
  float limit;
  float slack;     ///< error bound of a coordinate, mm
  float rounding;  ///< largest sum of the offsets of a pair, mm
  float shift;     ///< as of BlockRotation
};

/// Eight pairs of triangles in double: coordinates of corner k in rows 3 k to 3 k + 2, each before its object
/// is placed.
struct alignas(64) PairBatch {
  double reference[9][block_lanes], moving[9][block_lanes];
  double least_projected[2][block_lanes];  ///< of reference and moving: below, the triangle is not screened
  double offset_mm[block_lanes];           ///< sum of both
};

struct PairPlacement {
  double R[3][3];            ///< of the reference
  double cos, sin, x, y, z;  ///< of the moving object
};

/// Pairs of a batch after their objects are placed: bits of the exact kernel.
struct alignas(64) PlacedPairs {
  double reference[9][block_lanes], moving[9][block_lanes];
  /// Candidates of the exact kernel that may be within the limit. Bit k: corner k of the moving triangle over
  /// the reference; bit 3 + i: corner i of the reference; bit 6 + 3 i + k: edges from corners i and k.
  long long candidates[block_lanes];
};

inline constexpr unsigned n_candidates = 15, all_candidates = (1U << n_candidates) - 1U;

/// A pair is close within its offset and a band in any direction; with a travel, if it comes so close within
/// that travel.
struct ApartLimits {
  double band_mm, travel_mm;
  bool has_travel;
};

/// The same functions compiled for one instruction set; all give the same bits.
struct BlockFunctions {
  void (*rotate_inner)(const ReferenceInner&, const BlockRotation&, PlacedBlock&);
  void (*rotate_leaf)(const ReferenceLeaf&, const BlockRotation&, PlacedBlock&, PlacedCorners&);
  void (*place_inner)(const MovingInner&, const BlockPlacement&, PlacedBlock&);
  void (*place_leaf)(const MovingLeaf&, const BlockPlacement&, PlacedBlock&, PlacedCorners&);
  /// Whether any lane may be within the limit of one bound of the other object: an early rejection at an
  /// eighth of the cost of `test`.
  bool (*reference_near)(const PlacedBlock& reference, const PlacedBound& moving, float limit);
  bool (*moving_near)(const PlacedBlock& moving, const PlacedBound& reference, float limit);
  bool (*test)(const PlacedBlock& reference, const PlacedBlock& moving, float limit, BlockPairs&);
  /// The same without pairs in which the whole moving bound is above the reference by more than -least.
  bool (*test_ahead)(const PlacedBlock& reference, const PlacedBlock& moving, BlockLimits, BlockPairs&);
  /// Keeps the hits whose triangles (not only their boxes) may overlap in projection within the limit.
  void (*screen)(const LeafPair&, BlockPairs&);
  /// Places the pairs. Bit k: pair k may touch within the limit, mm.
  unsigned (*screen_pairs)(const PairBatch&, const PairPlacement&, double limit_mm, PlacedPairs&);
  /// Bit k: pair k, in any orientation, may be within the limits.
  unsigned (*screen_apart)(const PairBatch&, const PairPlacement&, const ApartLimits&);
};

extern const BlockFunctions block_functions_baseline, block_functions_avx2, block_functions_avx512;

/// Planes steeper than 60 degrees use the flat bound: their slopes would amplify rounding.
inline constexpr float steep_normal = 0.5F;
/// A normal with a larger y in float cannot have y <= -1e-6 in double.
inline constexpr float facing_slack = 1e-5F;

}  // namespace vrda::geometry
