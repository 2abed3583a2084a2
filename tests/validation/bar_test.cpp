// Thesis 4.2.3: a bar pushed up against two adjacent pyramids rotates until it is between them.
// Domain: no tip of a pyramid may be under the bar at the start, since a flat top on a tip is an
// equilibrium (the search never tilts; last test). The bar's long edges, not its ends, must be in contact
// with both pyramids: a bar with only an end on a pyramid is correctly pushed off lengthwise.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "core/units.hpp"
#include "validation/scene_case.hpp"

namespace vrda::test::bar_test {

// A bar under two pyramids whose bases are along X. Lengths in mm.
struct BarCase {
  double base = 0.0, height = 0.0, gap = 0.0;  ///< of the pyramids
  double length = 0.0, width = 0.0;            ///< of the bar
  double turn_rad = 0.0;                       ///< of the bar relative to Z, about +Y
  double along = 0.0, across = 0.0;            ///< the bar's centre from the scene's, on its own axes
  int edges = 1;
  SearchOptions options{};

  double tip() const { return 0.5 * (gap + base); }  ///< x of the tip of the pyramid on the right
};

Eigen::Vector3d along_bar(double angle_rad)
{
  return {std::sin(angle_rad), 0.0, std::cos(angle_rad)};
}

Eigen::Vector3d across_bar(double angle_rad)
{
  return {std::cos(angle_rad), 0.0, -std::sin(angle_rad)};
}

Eigen::Vector3d start_mm(const BarCase& bar)
{
  const double apart_mm = 5.0;
  return bar.along * along_bar(bar.turn_rad) + bar.across * across_bar(bar.turn_rad) -
         (bar.height + apart_mm) * Eigen::Vector3d::UnitY();
}

geometry::ShapeRequest request_of(const BarCase& bar)
{
  const Eigen::Vector3d start = start_mm(bar);
  return {"bar-on-pyramids",
          {{"base", bar.base},
           {"height", bar.height},
           {"gap", bar.gap},
           {"bar_length", bar.length},
           {"bar_width", bar.width},
           {"turn", deg_from_rad(bar.turn_rad)},
           {"offset_x", start.x()},
           {"offset_z", start.z()},
           {"edges", bar.edges}},
          {}};
}

// Final pose of a bar.
struct Rest {
  double angle_rad = 0.0;
  Eigen::Vector3d middle_mm;  ///< of its upper face
};

Rest rest_of(const BarCase& bar, const Solved& solved)
{
  return {bar.turn_rad + solved.record.pose.theta_rad, placed(solved, start_mm(bar))};
}

// Height of first contact for a given pose, in closed form. The pyramids' surface is below the base plate
// by the height times 1 - t / half the base, t the larger of the distances from the tip in x and z; so the
// relevant quantity is the smallest square about each tip, edges along x and z, that intersects the bar.
// Two rectangles are disjoint exactly if an edge of one separates them.
double touch_y_mm(const BarCase& bar, const Rest& rest)
{
  const Eigen::Vector3d along = along_bar(rest.angle_rad), across = across_bar(rest.angle_rad);
  double y_mm = 0.0;
  for (const double side : {-1.0, 1.0}) {
    const Eigen::Vector3d tip = Eigen::Vector3d(side * bar.tip(), 0.0, 0.0) - rest.middle_mm;
    const double half_x = 0.5 * (bar.width * std::abs(across.x()) + bar.length * std::abs(along.x()));
    const double half_z = 0.5 * (bar.width * std::abs(across.z()) + bar.length * std::abs(along.z()));
    const double share =
        std::abs(along.x()) + std::abs(along.z());  // of a square's half edge, on either axis
    const double away = std::max({0.0, std::abs(tip.x()) - half_x, std::abs(tip.z()) - half_z,
                                  (std::abs(tip.dot(across)) - 0.5 * bar.width) / share,
                                  (std::abs(tip.dot(along)) - 0.5 * bar.length) / share});
    y_mm = std::min(y_mm, -bar.height * (1.0 - away / (0.5 * bar.base)));
  }
  return y_mm;
}

BarCase drawn_pyramids(Draw& draw)
{
  BarCase bar;
  bar.base = draw.uniform(12, 40);
  bar.height = bar.base * draw.uniform(0.4, 1.0);
  bar.gap = draw.uniform(4, 20);
  bar.edges = draw.whole(1, 4);
  return bar;
}

// How far along the bar from the scene's centre its edges touch the pyramids, at its angle or straight. For
// a rotation a, the square about a tip that touches the bar's edge (see touch_y_mm) does so with its
// corner.
double reach_mm(const BarCase& bar)
{
  const double c = std::cos(bar.turn_rad), s = std::abs(std::sin(bar.turn_rad));
  const double straight = 0.5 * (bar.gap + bar.base - bar.width);
  const double square = (bar.tip() * c - 0.5 * bar.width + std::abs(bar.across)) / (c + s);
  return std::max({straight, 0.5 * bar.base, bar.tip() * s + square * (c - s)});
}

// A random start in the domain for a bar of the given width. A twentieth of the base is kept between the
// bar's ends and critical positions: rotations of whole degrees end slightly beyond the seat.
void draw_place(Draw& draw, BarCase& bar)
{
  const double steepest_rad = std::acos(bar.width / (bar.gap + bar.base));
  bar.turn_rad = draw.sign() * steepest_rad * draw.uniform(0.0, 0.95);
  const double clear = bar.tip() * std::cos(bar.turn_rad) - 0.5 * bar.width;
  bar.across = draw.sign() * draw.uniform(0.0, 0.9) * clear;
  const double half_mm = reach_mm(bar) + 0.05 * bar.base;
  bar.length = std::max(bar.width, 2.0 * half_mm) * draw.uniform(1.05, 3.0);
  bar.along = draw.sign() * draw.uniform(0.0, 0.5 * bar.length - half_mm);
}

// True if contacts push in both directions.
bool is_held_from_both_sides(const StepRecord& record)
{
  const auto pushes = [&](double side) {
    return std::any_of(record.contacts.begin(), record.contacts.end(),
                       [&](const ContactRecord& c) { return side * c.normal_solver.x() > 1e-6; });
  };
  return pushes(1.0) && pushes(-1.0);
}

// The approach stops a hundredth of the translation resolution short of contact. Returns the deviation from
// that, in units of the same hundredth.
double height_off(const BarCase& bar, const Rest& rest, double touch_mm)
{
  const double standoff_mm = 0.01 * bar.options.translation_resolution_mm;
  return std::abs(rest.middle_mm.y() - touch_mm + standoff_mm) / standoff_mm;
}

// Both edges of a straight bar are on flanks over twice the lever. A rotation ends when the far ends of
// both come within the contact band, a translation resolution: with the flanks' slope n_x, an angle of the
// resolution over 2 lever n_x; the rotation itself is accurate to the rotation resolution.
double seat_angle_rad(const BarCase& bar, const Rest& rest)
{
  const double straight = 0.5 * (bar.gap + bar.base - bar.width);
  const double lever = 0.5 * (std::min(straight, rest.middle_mm.z() + 0.5 * bar.length) -
                              std::max(-straight, rest.middle_mm.z() - 0.5 * bar.length));
  const double n_x = bar.height / std::hypot(bar.height, 0.5 * bar.base);
  return bar.options.rotation_resolution_rad + bar.options.translation_resolution_mm / (2.0 * lever * n_x);
}

TEST(BarOnPyramids, AWideBarIsTurnedIntoItsSeat)
{
  const std::string scene = "bar wider than the gap";
  Tally angle{.scene = scene,
              .claim = "ends along Z, held by both pyramids",
              .measure = "angle over the allowed one",
              .seed = 301,
              .allowed = 1.0};
  Tally aside{.scene = scene,
              .claim = "ends centred between the pyramids",
              .measure = "offset perpendicular to the bar, translation resolutions",
              .seed = 301,
              .allowed = 2.0};  // halving from 1 mm can leave an error of 1.25
  Tally seat{.scene = scene,
             .claim = "height is determined by the flanks",
             .measure = "height error over the allowed one",
             .seed = 301,
             .allowed = 1.0};
  Tally touch{.scene = scene,
              .claim = "exact contact",
              .measure = "height error at contact, stand-offs",
              .seed = 301,
              .allowed = 0.01};  // rounding: 1e-5 mm
  Draw draw(angle.seed);
  for (int k = 0; k < n_tested(300); ++k) {
    SCOPED_TRACE(k);
    BarCase bar = drawn_pyramids(draw);
    bar.width = bar.gap + bar.base * draw.uniform(0.1, 0.7);
    draw_place(draw, bar);
    const Solved solved = solve(scene_of(request_of(bar)), bar.options);
    const Rest rest = rest_of(bar, solved);
    ++angle.outcomes[std::string(name_of(solved.record.status))];
    ++angle.outcomes[solved.moves.contains(MoveKind::rotate) ? "turned" : "not turned"];
    EXPECT_EQ(solved.record.status, StepStatus::stable);
    EXPECT_TRUE(is_held_from_both_sides(solved.record));
    EXPECT_TRUE(solved.record.theta_determined);
    const double allowed_rad = seat_angle_rad(bar, rest),
                 resolution_mm = bar.options.translation_resolution_mm;
    EXPECT_TRUE(angle.add(std::abs(rest.angle_rad) / allowed_rad));
    EXPECT_TRUE(aside.add(std::abs(rest.middle_mm.x()) / resolution_mm));
    // An edge deviates from its seat by the offset and by its end's share of the angle; the flank converts
    // that into height.
    const double steepness = bar.height / (0.5 * bar.base);
    const double seat_mm = -bar.height * (bar.width - bar.gap) / bar.base;
    const double edge_mm = 2.0 * resolution_mm + 0.5 * (bar.gap + bar.base) * allowed_rad;
    EXPECT_TRUE(seat.add(std::abs(rest.middle_mm.y() - seat_mm) / (steepness * edge_mm)));
    EXPECT_TRUE(touch.add(height_off(bar, rest, touch_y_mm(bar, rest))));
  }
  EXPECT_GT(angle.outcomes["turned"], n_tested(200));
  for (const Tally& tally : {angle, aside, seat, touch}) report(tally);
}

// The steepest angle at which a strip of a given width passes between the two bases, by the facing corners:
// gap cos(a) - base sin(a) = width.
double passing_rad(const BarCase& bar, double width_mm)
{
  return std::acos(width_mm / std::hypot(bar.gap, bar.base)) - std::atan2(bar.base, bar.gap);
}

TEST(BarOnPyramids, ANarrowBarTurnsUntilItPassesBetweenTheBases)
{
  Tally turned{.scene = "bar narrower than the gap, too steep",
               .claim = "rotates until it passes, without an extra step",
               .measure = "angle outside the allowed range, rotation resolutions",
               .seed = 302,
               .allowed = 0.01};  // the stand-off, one or two micrometres, over the base
  // A bar that passes touches one pyramid at a time, which causes no rotation. If it does so within the
  // contact band of the base plate, the plate's contacts have no moment and the pyramid's alone decides:
  // this causes one rotation, after which the pyramid is outside the band.
  Tally kept{.scene = "bar narrower than the gap, at an angle at which it passes",
             .claim = "keeps its angle, except for one step near the base plate",
             .measure = "rotation, rotation steps",
             .seed = 302,
             .allowed = 1.0 + 1e-9};  // rounding
  Tally touch{.scene = "bar narrower than the gap",
              .claim = "ends on the base plate",
              .measure = "height error at contact, stand-offs",
              .seed = 302,
              .allowed = 0.01};  // rounding: 1e-5 mm
  Draw draw(turned.seed);
  for (int k = 0; k < n_tested(800); ++k) {
    SCOPED_TRACE(k);
    BarCase bar = drawn_pyramids(draw);
    const double passing = draw.uniform(0.05, 0.9) * std::atan2(bar.gap, bar.base);
    bar.width = bar.gap * std::cos(passing) - bar.base * std::sin(passing);
    draw_place(draw, bar);
    if (k % 2 == 0) bar.turn_rad *= 0.98 * passing / std::acos(bar.width / (bar.gap + bar.base));
    const Solved solved = solve(scene_of(request_of(bar)), bar.options);
    const Rest rest = rest_of(bar, solved);
    EXPECT_EQ(solved.record.status, StepStatus::stable);
    EXPECT_TRUE(touch.add(height_off(bar, rest, 0.0)));
    // Both bases are in the contact bands while the clearance is below two bands, so the bar may rotate by
    // one more step.
    const double felt = passing_rad(bar, bar.width + 2.0 * bar.options.translation_resolution_mm);
    const double start = std::abs(bar.turn_rad), end = std::abs(rest.angle_rad);
    if (start < felt) {
      kept.add(std::abs(solved.record.pose.theta_rad) / bar.options.rotation_step_rad);
      ++kept.outcomes[solved.record.pose.theta_rad == 0.0 ? "not turned" : "turned"];
    } else {
      const double least = felt - bar.options.rotation_step_rad;
      turned.add(std::max({0.0, end - passing, least - end}) / bar.options.rotation_resolution_rad);
      ++turned.outcomes[start > passing ? "too steep" : "passes with clearance below two resolutions"];
    }
  }
  EXPECT_GT(kept.outcomes["not turned"], n_tested(200));
  EXPECT_GT(turned.outcomes["too steep"], n_tested(200));
  for (const Tally& tally : {turned, kept, touch}) report(tally);
}

TEST(BarOnPyramids, AFlatTopRestsOnATip)
{
  Tally tally{.scene = "bar above a tip",
              .claim = "equilibrium on the tip without rotation; angle reported as undetermined",
              .measure = "height error at contact, stand-offs",
              .seed = 303,
              .allowed = 0.01};  // rounding: 1e-5 mm
  Draw draw(tally.seed);
  for (int k = 0; k < n_tested(200); ++k) {
    SCOPED_TRACE(k);
    BarCase bar = drawn_pyramids(draw);
    bar.length = draw.uniform(10, 60);
    bar.width = draw.uniform(2, 40);
    bar.turn_rad = draw.uniform(-pi, pi);
    // Position of a tip under the bar, then of the bar.
    const Eigen::Vector3d tip(draw.sign() * bar.tip(), 0.0, 0.0);
    bar.along = tip.dot(along_bar(bar.turn_rad)) + draw.uniform(-0.49, 0.49) * bar.length;
    bar.across = tip.dot(across_bar(bar.turn_rad)) + draw.uniform(-0.49, 0.49) * bar.width;
    const Solved solved = solve(scene_of(request_of(bar)), bar.options);
    EXPECT_EQ(solved.record.status, StepStatus::stable);
    EXPECT_FALSE(solved.record.theta_determined);
    EXPECT_EQ(solved.record.pose.theta_rad, 0.0);
    EXPECT_TRUE(tally.add(height_off(bar, rest_of(bar, solved), -bar.height)));
    ++tally.outcomes[solved.record.contacts.size() > 1 ? "on both tips" : "on one tip"];
  }
  EXPECT_GT(tally.outcomes["on both tips"], n_tested(5));
  EXPECT_GT(tally.outcomes["on one tip"], n_tested(50));
  report(tally);
}

}  // namespace vrda::test::bar_test
