/// Rejects pairs of triangles in double, before the exact kernel: four at a time, since the intermediate
/// values of eight spill from the registers and take three times as long. Included only by the files compiled
/// for one instruction set each; the anonymous namespace gives each file its own copy.
#pragma once

#include "proximity/gap_blocks.hpp"

namespace vrda::proximity {
namespace {

// The compiler splits them into the registers of the instruction set.
using Double4 = double __attribute__((vector_size(32), may_alias));
using Mask4 = long long __attribute__((vector_size(32)));

/// Bit k: pair `at` + k may touch within `limit_mm`. Coordinates are those of the exact kernel to the last
/// bit. Slacks of 1e-9 of a triangle and 1e-6 mm of travel exceed the rounding of all but narrow, steep or
/// near-parallel features, which are never rejected.
unsigned screen_half(const PairBatch& batch, int at, const PairPlacement& place, double limit_mm)
{
  const auto row = [at](const double* from) -> const Double4& {
    return *reinterpret_cast<const Double4*>(from + at);
  };
  const Double4 zero{}, slack = zero - 1e-9;
  Double4 rx[3], ry[3], rz[3], mx[3], my[3], mz[3];
  for (int k = 0; k < 3; ++k) {
    const Double4 &x = row(batch.reference[3 * k]), &y = row(batch.reference[3 * k + 1]),
                  &z = row(batch.reference[3 * k + 2]);
    rx[k] = place.R[0][0] * x + place.R[0][1] * y + place.R[0][2] * z;
    ry[k] = place.R[1][0] * x + place.R[1][1] * y + place.R[1][2] * z;
    rz[k] = place.R[2][0] * x + place.R[2][1] * y + place.R[2][2] * z;
    const Double4 &u = row(batch.moving[3 * k]), &v = row(batch.moving[3 * k + 1]),
                  &w = row(batch.moving[3 * k + 2]);
    mx[k] = place.cos * u + place.sin * w + place.x;
    my[k] = v + place.y;
    mz[k] = place.cos * w - place.sin * u + place.z;
  }
  // Edges in projection, and on which side of each the other triangle's corners are.
  Double4 rex[3], rez[3], mex[3], mez[3], side_of_r[3][3], side_of_m[3][3];
  for (int k = 0; k < 3; ++k) {
    const int next = (k + 1) % 3;
    rex[k] = rx[next] - rx[k];
    rez[k] = rz[next] - rz[k];
    mex[k] = mx[next] - mx[k];
    mez[k] = mz[next] - mz[k];
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
  Mask4 may_touch = ((r_area < r_least) & (-r_area < r_least)) | ((m_area < m_least) & (-m_area < m_least));
  const Double4 limit = zero + (limit_mm + 1e-6), r_inverse = 1.0 / r_area, m_inverse = 1.0 / m_area;
  for (int j = 0; j < 3; ++j) {
    const Double4 u = side_of_r[1][j] * r_inverse, v = side_of_r[2][j] * r_inverse,
                  w = side_of_r[0][j] * r_inverse;
    may_touch |=
        (u >= slack) & (v >= slack) & (w >= slack) & (u * ry[0] + v * ry[1] + w * ry[2] - my[j] <= limit);
    const Double4 p = side_of_m[1][j] * m_inverse, q = side_of_m[2][j] * m_inverse,
                  s = side_of_m[0][j] * m_inverse;
    may_touch |=
        (p >= slack) & (q >= slack) & (s >= slack) & (ry[j] - (p * my[0] + q * my[1] + s * my[2]) <= limit);
  }
  for (int k = 0; k < 3; ++k) {
    const int r_next = (k + 1) % 3;
    for (int j = 0; j < 3; ++j) {
      const int m_next = (j + 1) % 3;
      // A crossing at an end of an edge is a vertex over the other face.
      const Mask4 crosses = ((side_of_r[k][j] > zero) ^ (side_of_r[k][m_next] > zero)) &
                            ((side_of_m[j][k] > zero) ^ (side_of_m[j][r_next] > zero));
      const Double4 cross = side_of_r[k][j] - side_of_r[k][m_next];
      const Double4 along_m = side_of_r[k][j] / cross;
      const Double4 along_r = side_of_m[j][k] / (side_of_m[j][k] - side_of_m[j][r_next]);
      const Double4 travel =
          (ry[k] + along_r * (ry[r_next] - ry[k])) - (my[j] + along_m * (my[m_next] - my[j]));
      const Double4 parallel = 1e-6 * (rex[k] * rex[k] + rez[k] * rez[k] + mex[j] * mex[j] + mez[j] * mez[j]);
      may_touch |= crosses & ((travel <= limit) | ((cross < parallel) & (-cross < parallel)));
    }
  }
  unsigned bits = 0;
  for (int k = 0; k < 4; ++k) bits |= may_touch[k] != 0 ? 1U << k : 0U;
  return bits;
}

/// Both halves of the batch.
unsigned screen_pairs(const PairBatch& batch, const PairPlacement& place, double limit_mm)
{
  return screen_half(batch, 0, place, limit_mm) | screen_half(batch, 4, place, limit_mm) << 4U;
}

}  // namespace
}  // namespace vrda::proximity
