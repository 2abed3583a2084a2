/// Rotation and placement of blocks for a vector type F of F::width floats: bodies of the BlockFunctions.
/// Included only by the files compiled for one instruction set each. F is in their anonymous namespaces, so
/// code compiled for a newer processor cannot be linked into code for an older one.
#pragma once

#include "geometry/gap_blocks.hpp"

namespace vrda::geometry {

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

}  // namespace vrda::geometry
