/// Rejects pairs of triangles in double, before the exact kernel: four at a time, since the intermediate
/// values of eight spill from the registers and take three times as long. Included only by the files compiled
/// for one instruction set each; the anonymous namespace gives each file its own copy.
#pragma once

#ifdef __AVX2__
#include <immintrin.h>
#endif

#include "geometry/gap_blocks.hpp"

namespace vrda::geometry {

namespace {

// The compiler splits them into the registers of the instruction set.
using Double4 = double __attribute__((vector_size(32), may_alias));
using Mask4 = long long __attribute__((vector_size(32)));

struct Triangles4 {
  Double4 x[3], y[3], z[3];
};

struct PlacedPairs4 {
  Triangles4 reference, moving;
};

inline const Double4& row_at(const double* from, int at)
{
  return *reinterpret_cast<const Double4*>(from + at);
}

/// Coordinates are those of the exact kernel to the last bit.
PlacedPairs4 placed_pairs(const PairBatch& batch, int at, const PairPlacement& place)
{
  PlacedPairs4 pairs;
  Triangles4 &r = pairs.reference, &m = pairs.moving;
  for (int k = 0; k < 3; ++k) {
    const Double4 &x = row_at(batch.reference[3 * k], at), &y = row_at(batch.reference[3 * k + 1], at),
                  &z = row_at(batch.reference[3 * k + 2], at);
    r.x[k] = place.R[0][0] * x + place.R[0][1] * y + place.R[0][2] * z;
    r.y[k] = place.R[1][0] * x + place.R[1][1] * y + place.R[1][2] * z;
    r.z[k] = place.R[2][0] * x + place.R[2][1] * y + place.R[2][2] * z;
    const Double4 &u = row_at(batch.moving[3 * k], at), &v = row_at(batch.moving[3 * k + 1], at),
                  &w = row_at(batch.moving[3 * k + 2], at);
    m.x[k] = place.cos * u + place.sin * w + place.x;
    m.y[k] = v + place.y;
    m.z[k] = place.cos * w - place.sin * u + place.z;
  }
  return pairs;
}

unsigned bits_of(const Mask4& mask)
{
  unsigned bits = 0;
  for (int k = 0; k < 4; ++k) bits |= mask[k] != 0 ? 1U << k : 0U;
  return bits;
}

void store_rows(const Triangles4& t, int at, double (&rows)[9][block_lanes])
{
  for (int k = 0; k < 3; ++k) {
    *reinterpret_cast<Double4*>(rows[3 * k] + at) = t.x[k];
    *reinterpret_cast<Double4*>(rows[3 * k + 1] + at) = t.y[k];
    *reinterpret_cast<Double4*>(rows[3 * k + 2] + at) = t.z[k];
  }
}

/// Bit k: pair `at` + k may touch within `limit_mm`. Slacks of 1e-9 of a triangle and 1e-6 mm of travel
/// exceed the rounding of all but narrow, steep or near-parallel features, which are never rejected.
unsigned screen_half(const PairBatch& batch, int at, const PairPlacement& place, double limit_mm,
                     PlacedPairs& out)
{
  const auto row = [at](const double* from) -> const Double4& { return row_at(from, at); };
  const Double4 zero{}, slack = zero - 1e-9;
  constexpr Mask4 one{1, 1, 1, 1};
  const PlacedPairs4 placed = placed_pairs(batch, at, place);
  store_rows(placed.reference, at, out.reference);
  store_rows(placed.moving, at, out.moving);
  const auto& [rx, ry, rz] = placed.reference;
  const auto& [mx, my, mz] = placed.moving;
  // Edges in projection, and on which side of each the other triangle's corners are.
  Double4 rex[3], rez[3], mex[3], mez[3], r_end[3], m_size[3], side_of_r[3][3], side_of_m[3][3];
  for (int k = 0; k < 3; ++k) {
    const int next = (k + 1) % 3;
    rex[k] = rx[next] - rx[k];
    rez[k] = rz[next] - rz[k];
    mex[k] = mx[next] - mx[k];
    mez[k] = mz[next] - mz[k];
    r_end[k] = 1e-9 * ((rex[k] < zero ? -rex[k] : rex[k]) + (rez[k] < zero ? -rez[k] : rez[k]));
    m_size[k] = (mex[k] < zero ? -mex[k] : mex[k]) + (mez[k] < zero ? -mez[k] : mez[k]);
  }
  for (int k = 0; k < 3; ++k) {
    for (int j = 0; j < 3; ++j) {
      const Double4 dx = mx[j] - rx[k], dz = mz[j] - rz[k];
      side_of_r[k][j] = rez[k] * dx - rex[k] * dz;
      side_of_m[j][k] = mex[j] * dz - mez[j] * dx;
    }
  }
  const Double4 r_area = rez[0] * (rx[2] - rx[0]) - rex[0] * (rz[2] - rz[0]);
  const Double4 m_area = mez[0] * (mx[2] - mx[0]) - mex[0] * (mz[2] - mz[0]);
  const Double4 &r_least = row(batch.least_projected[0]), &m_least = row(batch.least_projected[1]);
  Mask4 candidates =
      (((r_area < r_least) & (-r_area < r_least)) | ((m_area < m_least) & (-m_area < m_least))) &
      ((one << n_candidates) - one);
  const Double4 limit = zero + (limit_mm + 1e-6), r_inverse = 1.0 / r_area, m_inverse = 1.0 / m_area;
  for (int j = 0; j < 3; ++j) {
    const Double4 u = side_of_r[1][j] * r_inverse, v = side_of_r[2][j] * r_inverse,
                  w = side_of_r[0][j] * r_inverse;
    candidates |= (u >= slack) & (v >= slack) & (w >= slack) &
                  (u * ry[0] + v * ry[1] + w * ry[2] - my[j] <= limit) & (one << j);
    const Double4 p = side_of_m[1][j] * m_inverse, q = side_of_m[2][j] * m_inverse,
                  s = side_of_m[0][j] * m_inverse;
    candidates |= (p >= slack) & (q >= slack) & (s >= slack) &
                  (ry[j] - (p * my[0] + q * my[1] + s * my[2]) <= limit) & (one << (3 + j));
  }
  for (int k = 0; k < 3; ++k) {
    const int r_next = (k + 1) % 3;
    for (int j = 0; j < 3; ++j) {
      const int m_next = (j + 1) % 3;
      // At the ends the kernel allows more than 0 to 1.
      const Double4 end = r_end[k] * m_size[j];
      const Double4 &m_from = side_of_r[k][j], &m_to = side_of_r[k][m_next], &r_from = side_of_m[j][k],
                    &r_to = side_of_m[j][r_next];
      const Mask4 crosses = ((m_from <= end) | (m_to <= end)) & ((m_from >= -end) | (m_to >= -end)) &
                            ((r_from <= end) | (r_to <= end)) & ((r_from >= -end) | (r_to >= -end));
      const Double4 cross = side_of_r[k][j] - side_of_r[k][m_next];
      const Double4 along_m = side_of_r[k][j] / cross;
      const Double4 along_r = side_of_m[j][k] / (side_of_m[j][k] - side_of_m[j][r_next]);
      const Double4 travel =
          (ry[k] + along_r * (ry[r_next] - ry[k])) - (my[j] + along_m * (my[m_next] - my[j]));
      const Double4 parallel = 1e-6 * (rex[k] * rex[k] + rez[k] * rez[k] + mex[j] * mex[j] + mez[j] * mez[j]);
      candidates |= crosses & ((travel <= limit) | ((cross < parallel) & (-cross < parallel))) &
                    (one << (6 + 3 * k + j));
    }
  }
  *reinterpret_cast<Mask4*>(out.candidates + at) = candidates;
  return bits_of(candidates);
}

/// Square of the distance along an axis between two triangles, 0 where they overlap: at the pose, or, with a
/// travel, at that travel, and less than at every smaller one, which an axis that is directed down ensures.
struct Separation4 {
  const PlacedPairs4& pairs;
  Double4 travel_mm;
  bool has_travel;

  void square_along(const Double4& x, const Double4& y, const Double4& z, Double4& square_mm2) const
  {
    const Double4 zero{};
    Range4 r, m;
    set_range(r, pairs.reference, x, y, z);
    set_range(m, pairs.moving, x, y, z);
    const Double4 above = m.least - r.most, below = r.least - m.most;
    Double4 apart;
    if (has_travel) {
      apart = y <= zero ? above + travel_mm * y : below - travel_mm * y;
    } else {
      apart = above > below ? above : below;
    }
    square_mm2 = apart > zero ? apart * apart / (x * x + y * y + z * z) : zero;
  }

 private:
  struct Range4 {
    Double4 least, most;
  };
  static void set_range(Range4& range, const Triangles4& t, const Double4& x, const Double4& y,
                        const Double4& z)
  {
    range.least = range.most = x * t.x[0] + y * t.y[0] + z * t.z[0];
    for (int k = 1; k < 3; ++k) {
      const Double4 at = x * t.x[k] + y * t.y[k] + z * t.z[k];
      range.least = at < range.least ? at : range.least;
      range.most = at > range.most ? at : range.most;
    }
  }
};

/// Adds the pairs that are farther apart than the reach by the normal of a face together with a normal of one
/// of its edges within the face: these are perpendicular, so the squares add.
void add_apart(const Separation4& separation, const Triangles4& face, const Double4& reach_mm2, Mask4& apart)
{
  Double4 x[3], y[3], z[3], along_normal, along_side;
  for (int k = 0; k < 3; ++k) {
    const int next = (k + 1) % 3;
    x[k] = face.x[next] - face.x[k];
    y[k] = face.y[next] - face.y[k];
    z[k] = face.z[next] - face.z[k];
  }
  const Double4 nx = y[0] * z[1] - z[0] * y[1], ny = z[0] * x[1] - x[0] * z[1],
                nz = x[0] * y[1] - y[0] * x[1];
  separation.square_along(nx, ny, nz, along_normal);
  for (int k = 0; k < 3; ++k) {
    separation.square_along(y[k] * nz - z[k] * ny, z[k] * nx - x[k] * nz, x[k] * ny - y[k] * nx, along_side);
    apart |= along_normal + along_side > reach_mm2;
  }
}

/// Bit k: pair `at` + k may be within the limits.
unsigned screen_apart_half(const PairBatch& batch, int at, const PairPlacement& place,
                           const ApartLimits& limits)
{
  constexpr double slack_mm = 1e-6;  // more than rounding
  const PlacedPairs4 pairs = placed_pairs(batch, at, place);
  const Double4 zero{};
  const Separation4 separation{pairs, zero + (limits.travel_mm + slack_mm), limits.has_travel};
  const Double4 reach_mm = row_at(batch.offset_mm, at) + (limits.band_mm + slack_mm);
  Mask4 apart = zero > zero;
  add_apart(separation, pairs.reference, reach_mm * reach_mm, apart);
  if (bits_of(apart) != 15U) add_apart(separation, pairs.moving, reach_mm * reach_mm, apart);
  return bits_of(~apart);
}

/// Both halves of the batch.
unsigned screen_pairs(const PairBatch& batch, const PairPlacement& place, double limit_mm, PlacedPairs& out)
{
  return screen_half(batch, 0, place, limit_mm, out) | screen_half(batch, 4, place, limit_mm, out) << 4U;
}

unsigned screen_apart(const PairBatch& batch, const PairPlacement& place, const ApartLimits& limits)
{
  return screen_apart_half(batch, 0, place, limits) | screen_apart_half(batch, 4, place, limits) << 4U;
}

}  // namespace

// Rotation and placement of blocks for a vector type F of F::width floats: bodies of the BlockFunctions.
// Included only by the files compiled for one instruction set each. F is in their anonymous namespaces, so
// code compiled for a newer processor cannot be linked into code for an older one.

template <typename F>
struct PlaceLanes {
  static F row(const BlockRow& r, int at) { return F::load(r.lane + at); }

  // Writes the half-space n . p >= offset as a plane a + b x + c z below it; steep planes as the flat bound.
  static void write_plane(const F n[3], F offset, PlacedBlock& out, int at)
  {
    const F is_flat_enough = n[1] >= F::all(steep_normal);
    const F scale = F::all(1.0F) / F::choose(is_flat_enough, n[1], F::all(1.0F));
    const F zero = F::all(0.0F);
    F::choose(is_flat_enough, offset * scale, row(out.flat, at)).store(out.a.lane + at);
    F::choose(is_flat_enough, (zero - n[0]) * scale, zero).store(out.b.lane + at);
    F::choose(is_flat_enough, (zero - n[2]) * scale, zero).store(out.c.lane + at);
  }

  static F turned(const float R[3], const F v[3])
  {
    return F::all(R[0]) * v[0] + F::all(R[1]) * v[1] + F::all(R[2]) * v[2];
  }

  static void rotate_inner(const ReferenceInner& in, const BlockRotation& turn, PlacedBlock& out)
  {
    for (int at = 0; at < block_lanes; at += F::width) {
      const F c[3] = {row(in.centre[0], at), row(in.centre[1], at), row(in.centre[2], at)};
      const F h[3] = {row(in.half[0], at), row(in.half[1], at), row(in.half[2], at)};
      const F own[3] = {row(in.normal[0], at), row(in.normal[1], at), row(in.normal[2], at)};
      F middle[3], half[3], n[3];
      for (int k = 0; k < 3; ++k) {
        const float* R = turn.R[k];
        const float size[3] = {F::absolute(R[0]), F::absolute(R[1]), F::absolute(R[2])};
        middle[k] = turned(R, c);
        half[k] = turned(size, h);
        n[k] = turned(R, own);
      }
      // Outward normals are within the spread around -n: none is directed down if n points further down.
      const F can_face = n[1] + row(in.spread, at) >= F::all(-turn.cull);
      write_box({middle[0] - half[0], middle[0] + half[0], middle[2] - half[2], middle[2] + half[2]},
                can_face, out, at);
      (middle[1] - half[1]).store(out.flat.lane + at);
      (middle[1] + half[1]).store(out.far.lane + at);
      write_plane(n, row(in.offset, at), out, at);
    }
  }

  struct Sides {
    F x_low, x_high, z_low, z_high;
  };

  // Lanes that are not kept get an empty box.
  static void write_box(const Sides& box, F keep, PlacedBlock& out, int at)
  {
    F::choose(keep, box.x_low, F::all(1e30F)).store(out.x_low.lane + at);
    F::choose(keep, box.x_high, F::all(-1e30F)).store(out.x_high.lane + at);
    box.z_low.store(out.z_low.lane + at);
    box.z_high.store(out.z_high.lane + at);
  }

  static void rotate_leaf(const ReferenceLeaf& in, const BlockRotation& turn, PlacedBlock& out,
                          PlacedCorners& corners)
  {
    for (int at = 0; at < block_lanes; at += F::width) {
      const F own[3] = {row(in.normal[0], at), row(in.normal[1], at), row(in.normal[2], at)};
      const F n[3] = {turned(turn.R[0], own), turned(turn.R[1], own), turned(turn.R[2], own)};
      const F shift = F::all(turn.shift) * row(in.rounding, at);
      F low[3], high[3];
      for (int corner = 0; corner < 3; ++corner) {
        const F v[3] = {row(in.x[corner], at), row(in.y[corner], at), row(in.z[corner], at)};
        for (int k = 0; k < 3; ++k) {
          const F p = turned(turn.R[k], v);
          if (k == 0) (p - shift * n[0]).store(corners.x[corner].lane + at);
          if (k == 2) (p - shift * n[2]).store(corners.z[corner].lane + at);
          low[k] = corner == 0 ? p : F::least(low[k], p);
          high[k] = corner == 0 ? p : F::most(high[k], p);
        }
      }
      const F absent = row(in.absent, at), rounding = row(in.rounding, at);
      write_box(
          {low[0] - rounding + absent, high[0] + rounding - absent, low[2] - rounding, high[2] + rounding},
          n[1] >= F::all(-turn.cull), out, at);
      (low[1] - rounding).store(out.flat.lane + at);
      (high[1] + rounding).store(out.far.lane + at);
      write_plane(n, row(in.offset, at), out, at);
    }
  }

  // A rotation about Y preserves the slope's magnitude; `a` is adjusted for the translation.
  template <typename Moving>
  static void place_plane(const Moving& in, const BlockPlacement& to, PlacedBlock& out, int at)
  {
    const F a = row(in.a, at), b = row(in.b, at), c = row(in.c, at);
    const F b_turned = F::all(to.cos) * b + F::all(to.sin) * c;
    const F c_turned = F::all(to.cos) * c - F::all(to.sin) * b;
    b_turned.store(out.b.lane + at);
    c_turned.store(out.c.lane + at);
    (a + F::all(to.y) - b_turned * F::all(to.x) - c_turned * F::all(to.z)).store(out.a.lane + at);
  }

  static void place_inner(const MovingInner& in, const BlockPlacement& to, PlacedBlock& out)
  {
    const F cos = F::all(to.cos), sin = F::all(to.sin), slack = F::all(to.slack);
    const F cos_size = F::all(F::absolute(to.cos)), sin_size = F::all(F::absolute(to.sin));
    for (int at = 0; at < block_lanes; at += F::width) {
      const F cx = row(in.centre_x, at), cz = row(in.centre_z, at);
      const F hx = row(in.half_x, at), hz = row(in.half_z, at);
      const F x = cos * cx + sin * cz + F::all(to.x), z = cos * cz - sin * cx + F::all(to.z);
      const F ex = cos_size * hx + sin_size * hz + slack, ez = sin_size * hx + cos_size * hz + slack;
      (x - ex).store(out.x_low.lane + at);
      (x + ex).store(out.x_high.lane + at);
      (z - ez).store(out.z_low.lane + at);
      (z + ez).store(out.z_high.lane + at);
      (row(in.top, at) + F::all(to.y)).store(out.flat.lane + at);
      (row(in.bottom, at) + F::all(to.y)).store(out.far.lane + at);
      place_plane(in, to, out, at);
    }
  }

  static void place_leaf(const MovingLeaf& in, const BlockPlacement& to, PlacedBlock& out,
                         PlacedCorners& corners)
  {
    const F cos = F::all(to.cos), sin = F::all(to.sin), slack = F::all(to.slack);
    for (int at = 0; at < block_lanes; at += F::width) {
      const F shift = F::all(to.shift);
      const F shift_x = shift * (cos * row(in.shift_x, at) + sin * row(in.shift_z, at));
      const F shift_z = shift * (cos * row(in.shift_z, at) - sin * row(in.shift_x, at));
      F x_low{}, x_high{}, z_low{}, z_high{};
      for (int corner = 0; corner < 3; ++corner) {
        const F vx = row(in.x[corner], at), vz = row(in.z[corner], at);
        const F x = cos * vx + sin * vz + F::all(to.x), z = cos * vz - sin * vx + F::all(to.z);
        (x + shift_x).store(corners.x[corner].lane + at);
        (z + shift_z).store(corners.z[corner].lane + at);
        x_low = corner == 0 ? x : F::least(x_low, x);
        x_high = corner == 0 ? x : F::most(x_high, x);
        z_low = corner == 0 ? z : F::least(z_low, z);
        z_high = corner == 0 ? z : F::most(z_high, z);
      }
      const F reach = row(in.rounding, at) + slack, out_of_reach = row(in.absent, at) - reach;
      (x_low + out_of_reach).store(out.x_low.lane + at);
      (x_high - out_of_reach).store(out.x_high.lane + at);
      (z_low - reach).store(out.z_low.lane + at);
      (z_high + reach).store(out.z_high.lane + at);
      (row(in.top, at) + F::all(to.y)).store(out.flat.lane + at);
      (row(in.bottom, at) + F::all(to.y)).store(out.far.lane + at);
      place_plane(in, to, out, at);
    }
  }
};

// Tests between blocks for a vector type F of F::width floats: bodies of the BlockFunctions. Included only
// by the files compiled for one instruction set each. F is in their anonymous namespaces, so code compiled
// for a newer processor cannot be linked into code for an older one.

template <typename F>
struct TestLanes {
  static F row(const BlockRow& r, int at) { return F::load(r.lane + at); }

  struct Lanes {
    int moving, reference;  // lane; first of F::width lanes
  };

  // One moving lane against F::width reference lanes.
  static unsigned test_lane(const PlacedBlock& r, const PlacedBlock& m, Lanes lanes, float limit,
                            BlockRow& bounds)
  {
    const int lane = lanes.moving, at = lanes.reference;
    const F x_low = F::most(row(r.x_low, at), F::all(m.x_low.lane[lane]));
    const F x_high = F::least(row(r.x_high, at), F::all(m.x_high.lane[lane]));
    const F z_low = F::most(row(r.z_low, at), F::all(m.z_low.lane[lane]));
    const F z_high = F::least(row(r.z_high, at), F::all(m.z_high.lane[lane]));
    const F a = row(r.a, at) - F::all(m.a.lane[lane]);
    const F b = row(r.b, at) - F::all(m.b.lane[lane]);
    const F c = row(r.c, at) - F::all(m.c.lane[lane]);
    const F plane = a + F::least(b * x_low, b * x_high) + F::least(c * z_low, c * z_high);
    const F bound = F::most(plane, row(r.flat, at) - F::all(m.flat.lane[lane]));
    bound.store(bounds.lane + at);
    return F::bits((x_low <= x_high) & (z_low <= z_high) & (bound <= F::all(limit)));
  }

  struct Overlap {
    F x_low, x_high, z_low, z_high;
  };

  static Overlap overlap(const PlacedBlock& lanes, int at, const PlacedBound& one)
  {
    return {F::most(row(lanes.x_low, at), F::all(one.x_low)),
            F::least(row(lanes.x_high, at), F::all(one.x_high)),
            F::most(row(lanes.z_low, at), F::all(one.z_low)),
            F::least(row(lanes.z_high, at), F::all(one.z_high))};
  }

  static bool is_near(const Overlap& o, F a, F b, F c, F flat, float limit)
  {
    const F plane = a + F::least(b * o.x_low, b * o.x_high) + F::least(c * o.z_low, c * o.z_high);
    return F::bits((o.x_low <= o.x_high) & (o.z_low <= o.z_high) & (F::most(plane, flat) <= F::all(limit))) !=
           0;
  }

  static bool reference_near(const PlacedBlock& r, const PlacedBound& m, float limit)
  {
    for (int at = 0; at < block_lanes; at += F::width) {
      if (is_near(overlap(r, at, m), row(r.a, at) - F::all(m.a), row(r.b, at) - F::all(m.b),
                  row(r.c, at) - F::all(m.c), row(r.flat, at) - F::all(m.flat), limit)) {
        return true;
      }
    }
    return false;
  }

  static bool moving_near(const PlacedBlock& m, const PlacedBound& r, float limit)
  {
    for (int at = 0; at < block_lanes; at += F::width) {
      if (is_near(overlap(m, at, r), F::all(r.a) - row(m.a, at), F::all(r.b) - row(m.b, at),
                  F::all(r.c) - row(m.c, at), F::all(r.flat) - row(m.flat, at), limit)) {
        return true;
      }
    }
    return false;
  }

  static bool test(const PlacedBlock& r, const PlacedBlock& m, float limit, BlockPairs& pairs)
  {
    unsigned any = 0;
    for (int lane = 0; lane < block_lanes; ++lane) {
      unsigned hits = 0;
      for (int at = 0; at < block_lanes; at += F::width) {
        hits |= test_lane(r, m, {lane, at}, limit, pairs.bound[lane]) << at;
      }
      pairs.hits[lane] = static_cast<std::uint8_t>(hits);
      any |= hits;
    }
    return any != 0;
  }

  static bool test_ahead(const PlacedBlock& r, const PlacedBlock& m, BlockLimits limits, BlockPairs& pairs)
  {
    if (!test(r, m, limits.most, pairs)) return false;
    unsigned any = 0;
    for (int lane = 0; lane < block_lanes; ++lane) {
      unsigned ahead = 0;
      for (int at = 0; at < block_lanes; at += F::width) {
        ahead |= F::bits(row(r.far, at) - F::all(m.far.lane[lane]) >= F::all(limits.least)) << at;
      }
      pairs.hits[lane] = static_cast<std::uint8_t>(pairs.hits[lane] & ahead);
      any |= pairs.hits[lane];
    }
    return any != 0;
  }

  struct Triangle {
    F x[3], z[3];
  };

  static Triangle reference_triangle(const PlacedCorners& c, int at)
  {
    return {{row(c.x[0], at), row(c.x[1], at), row(c.x[2], at)},
            {row(c.z[0], at), row(c.z[1], at), row(c.z[2], at)}};
  }

  static Triangle moving_triangle(const PlacedCorners& c, int lane)
  {
    return {{F::all(c.x[0].lane[lane]), F::all(c.x[1].lane[lane]), F::all(c.x[2].lane[lane])},
            {F::all(c.z[0].lane[lane]), F::all(c.z[1].lane[lane]), F::all(c.z[2].lane[lane])}};
  }

  // Minimum of a + b x + c z over the corners.
  static F least_over(const Triangle& t, F a, F b, F c)
  {
    F least = a + b * t.x[0] + c * t.z[0];
    for (int k = 1; k < 3; ++k) least = F::least(least, a + b * t.x[k] + c * t.z[k]);
    return least;
  }

  // Conservative test whether the projections overlap, by the edges of `t` as separating axes.
  static F may_overlap(const Triangle& t, const Triangle& other, F slack)
  {
    // Inside, every (edge x (p - corner)) in (z, x) has the sign of the area. For a sliver that sign may be
    // wrong, but an overlapping triangle is on both its sides within the slack.
    const F area = (t.z[1] - t.z[0]) * (t.x[2] - t.x[0]) - (t.x[1] - t.x[0]) * (t.z[2] - t.z[0]);
    const F sign = F::choose(area >= F::all(0.0F), F::all(1.0F), F::all(-1.0F));
    F may = F::all(0.0F) <= slack;
    for (int k = 0; k < 3; ++k) {
      const F ex = (t.x[(k + 1) % 3] - t.x[k]) * sign, ez = (t.z[(k + 1) % 3] - t.z[k]) * sign;
      F inside = ez * (other.x[0] - t.x[k]) - ex * (other.z[0] - t.z[k]);
      for (int i = 1; i < 3; ++i) {
        inside = F::most(inside, ez * (other.x[i] - t.x[k]) - ex * (other.z[i] - t.z[k]));
      }
      const F zero = F::all(0.0F);
      const F size = F::most(ex, zero - ex) + F::most(ez, zero - ez);
      may = may & (inside + size * slack >= zero);
    }
    return may;
  }

  static unsigned screen_lane(const LeafPair& pair, int lane, int at, BlockRow& bounds)
  {
    const PlacedBlock &r = pair.reference, &m = pair.moving;
    const F a = row(r.a, at) - F::all(m.a.lane[lane]);
    const F b = row(r.b, at) - F::all(m.b.lane[lane]);
    const F c = row(r.c, at) - F::all(m.c.lane[lane]);
    const Triangle tr = reference_triangle(pair.reference_corners, at);
    const Triangle tm = moving_triangle(pair.moving_corners, lane);
    // The overlap is within both triangles, so the minimum over either's corners is a lower bound. Rounded
    // ones touch beyond it by at most `beyond`.
    const F zero = F::all(0.0F);
    const F slopes = F::most(b, zero - b) + F::most(c, zero - c);
    const F least = F::most(least_over(tr, a, b, c), least_over(tm, a, b, c));
    F beyond = farthest_beyond_mm(pair);
    for (int i = 0; i < 2; ++i) beyond = beyond_mm(pair, {lane, at}, least - slopes * beyond);
    const F bound = F::most(row(bounds, at), least - slopes * beyond);
    bound.store(bounds.lane + at);
    beyond = beyond + F::all(pair.slack);
    const F overlap = may_overlap(tr, tm, beyond) & may_overlap(tm, tr, beyond);
    return F::bits(overlap & (bound <= F::all(pair.limit)));
  }

  // How far beyond its triangles, across Delta, a rounded pair may touch: the offset, or, where the corners
  // are shifted, twice the offset.
  static F farthest_beyond_mm(const LeafPair& pair)
  {
    return F::all(pair.shift == 0.0F ? pair.rounding : 2.0F * pair.rounding);
  }

  // The same for a pair with the travel of its planes. Where the corners are shifted: with the contact's
  // normal at an angle of alpha from the face's, the contact is r sqrt(2 (1 - cos alpha)) from the shifted
  // face and at least r (1 - cos alpha) above its plane, which `limit` - `by_planes` limits for both
  // triangles together. Steep faces have no plane.
  static F beyond_mm(const LeafPair& pair, Lanes lanes, F by_planes)
  {
    const PlacedBlock &r = pair.reference, &m = pair.moving;
    const int lane = lanes.moving, at = lanes.reference;
    const F farthest = farthest_beyond_mm(pair);
    if (pair.shift == 0.0F || pair.rounding == 0.0F || m.a.lane[lane] == m.flat.lane[lane]) return farthest;
    const F room = F::most(F::all(pair.limit) - by_planes, F::all(0.0F));
    // An infinite limit has no product with a slope of 0.
    const F beyond = F::least(F::root(farthest * room), farthest);
    const F is_steep = (row(r.a, at) <= row(r.flat, at)) & (row(r.a, at) >= row(r.flat, at));
    return F::choose(is_steep, farthest, beyond);
  }

  static void screen(const LeafPair& pair, BlockPairs& pairs)
  {
    for (int lane = 0; lane < block_lanes; ++lane) {
      if (pairs.hits[lane] == 0) continue;
      unsigned kept = 0;
      for (int at = 0; at < block_lanes; at += F::width) {
        kept |= screen_lane(pair, lane, at, pairs.bound[lane]) << at;
      }
      pairs.hits[lane] = static_cast<std::uint8_t>(pairs.hits[lane] & kept);
    }
  }
};

template <typename F>
constexpr BlockFunctions block_functions()
{
  using P = PlaceLanes<F>;
  using T = TestLanes<F>;
  return {P::rotate_inner, P::rotate_leaf, P::place_inner, P::place_leaf, T::reference_near, T::moving_near,
          T::test,         T::test_ahead,  T::screen,      screen_pairs,  screen_apart};
}

#ifdef __AVX2__

/// Eight floats of AVX. The anonymous namespace gives each file that is compiled for it its own copy.
namespace {

struct Float8 {
  static constexpr int width = 8;
  __m256 v;
  static Float8 load(const float* from) { return {_mm256_load_ps(from)}; }
  static Float8 all(float value) { return {_mm256_set1_ps(value)}; }
  static Float8 least(Float8 a, Float8 b) { return {_mm256_min_ps(a.v, b.v)}; }
  static Float8 most(Float8 a, Float8 b) { return {_mm256_max_ps(a.v, b.v)}; }
  static Float8 choose(Float8 mask, Float8 yes, Float8 no) { return {_mm256_blendv_ps(no.v, yes.v, mask.v)}; }
  static Float8 root(Float8 a) { return {_mm256_sqrt_ps(a.v)}; }
  static float absolute(float value) { return value < 0.0F ? -value : value; }
  static unsigned bits(Float8 mask) { return static_cast<unsigned>(_mm256_movemask_ps(mask.v)); }
  void store(float* to) const { _mm256_store_ps(to, v); }
  friend Float8 operator+(Float8 a, Float8 b) { return {_mm256_add_ps(a.v, b.v)}; }
  friend Float8 operator-(Float8 a, Float8 b) { return {_mm256_sub_ps(a.v, b.v)}; }
  friend Float8 operator*(Float8 a, Float8 b) { return {_mm256_mul_ps(a.v, b.v)}; }
  friend Float8 operator/(Float8 a, Float8 b) { return {_mm256_div_ps(a.v, b.v)}; }
  friend Float8 operator<=(Float8 a, Float8 b) { return {_mm256_cmp_ps(a.v, b.v, _CMP_LE_OQ)}; }
  friend Float8 operator>=(Float8 a, Float8 b) { return {_mm256_cmp_ps(a.v, b.v, _CMP_GE_OQ)}; }
  friend Float8 operator&(Float8 a, Float8 b) { return {_mm256_and_ps(a.v, b.v)}; }
};

}  // namespace

#endif

}  // namespace vrda::geometry
