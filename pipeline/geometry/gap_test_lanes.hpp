/// Tests between blocks for a vector type F of F::width floats: bodies of the BlockFunctions. Included only
/// by the files compiled for one instruction set each. F is in their anonymous namespaces, so code compiled
/// for a newer processor cannot be linked into code for an older one.
#pragma once

#include "geometry/gap_blocks.hpp"
#include "geometry/gap_pair_lanes.hpp"
#include "geometry/gap_place_lanes.hpp"

namespace vrda::geometry {

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

}  // namespace vrda::geometry
