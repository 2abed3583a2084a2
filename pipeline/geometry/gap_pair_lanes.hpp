/// Rejects pairs of triangles in double, before the exact kernel: four at a time, since the intermediate
/// values of eight spill from the registers and take three times as long. Included only by the files compiled
/// for one instruction set each; the anonymous namespace gives each file its own copy.
#pragma once

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
}  // namespace vrda::geometry
