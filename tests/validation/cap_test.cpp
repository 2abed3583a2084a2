// Thesis 4.2.2 and 3.7: a four-faced cap rotates and translates into a sink of the same slopes.
#include <gtest/gtest.h>

#include <cmath>

#include "core/units.hpp"
#include "validation/scene_case.hpp"

namespace vrda::test::cap_test {

struct CapCase {
  geometry::ShapeRequest request;
  SearchOptions options;
  double turn_deg = 0.0;    ///< of the cap at the start
  double half_mm = 0.0;     ///< half the edge of the cap's base
  double slope_sine = 0.0;  ///< of the faces
  Eigen::Vector3d tip_mm;   ///< of the cap, in the moving mesh
};

CapCase drawn(Draw& draw, double turn_deg, int edges)
{
  CapCase result;
  const double base_mm = draw.uniform(20, 60), depth_mm = base_mm * draw.uniform(0.3, 0.7);
  const double scale = draw.uniform(0.5, 0.95), reach_mm = 0.075 * base_mm;
  const double x_mm = draw.uniform(-reach_mm, reach_mm), z_mm = draw.uniform(-reach_mm, reach_mm);
  result.turn_deg = turn_deg;
  result.half_mm = 0.5 * scale * base_mm;
  result.slope_sine = std::sin(std::atan2(depth_mm, 0.5 * base_mm));
  result.tip_mm = {x_mm, -depth_mm - 5.0, z_mm};
  result.request = {"cap-in-sink",
                    {{"base", base_mm},
                     {"depth", depth_mm},
                     {"cap_scale", scale},
                     {"turn", turn_deg},
                     {"offset_x", x_mm},
                     {"offset_z", z_mm},
                     {"edges", edges}},
                    {}};
  // Steps at least ten times their resolutions (thesis 4.2.2).
  result.options.translation_step_mm = draw.log_uniform(1.0, 5.0);
  result.options.rotation_step_rad = rad_from_deg(draw.log_uniform(1.0, 4.0));
  return result;
}

// A cap rotated by a from its seat is in contact at its corners, half_mm from the axis, with its tip
// half_mm * a * sin(slope) from the faces. Once that is within the contact band, the tip's contacts balance
// the corners'. Plus one rotation resolution for the last step.
double allowed_deg(const CapCase& cap)
{
  return deg_from_rad(cap.options.rotation_resolution_rad +
                      cap.options.translation_resolution_mm / (cap.half_mm * cap.slope_sine));
}

double turn_left_deg(const CapCase& cap, const Solved& solved)
{
  return std::abs(deg_from_rad(solved.record.pose.theta_rad) + cap.turn_deg);
}

TEST(CapInSink, SitsInTheSinkFromEveryAngle)
{
  Tally tally{.scene = "pyramidal cap in a sink",
              .claim = "rotates back by the shorter way",
              .measure = "remaining rotation over the allowed one",
              .seed = 201,
              .allowed = 1.0};
  Tally tip{.scene = "pyramidal cap in a sink",
            .claim = "tips coincide",
            .measure = "distance of the tips perpendicular to Delta, translation resolutions",
            .seed = 201,
            .allowed = 2.0};
  Draw draw(tally.seed);
  for (int k = 0; k < n_tested(400); ++k) {
    // One triangle per face (edges 1): the sink's triangles are not split.
    const CapCase cap = drawn(draw, draw.sign() * draw.uniform(0.0, 44.5), k % 2 == 0 ? 1 : draw.whole(2, 4));
    const Solved solved = solve(scene_of(cap.request), cap.options);
    ++tally.outcomes[std::string(name_of(solved.record.status))];
    ++tally.outcomes[cap.turn_deg > 0.0 ? "rotated against Delta" : "rotated about Delta"];
    const Eigen::Vector3d top_mm = placed(solved, cap.tip_mm);
    SCOPED_TRACE(testing::Message() << "case " << k << " " << testing::PrintToString(cap.request.numbers));
    EXPECT_TRUE(tally.add(turn_left_deg(cap, solved) / allowed_deg(cap))) << turn_left_deg(cap, solved);
    EXPECT_TRUE(tip.add(std::hypot(top_mm.x(), top_mm.z()) / cap.options.translation_resolution_mm));
    EXPECT_TRUE(solved.record.theta_determined);
  }
  EXPECT_GT(tally.outcomes["rotated about Delta"], n_tested(150));
  EXPECT_GT(tally.outcomes["rotated against Delta"], n_tested(150));
  report(tally);
  report(tip);
}

// At 45 degrees the corners are over the middles of the faces: every reaction passes through the axis.
TEST(CapInSink, AtFortyFiveDegreesTheTurnIsUndetermined)
{
  Tally tally{.scene = "pyramidal cap at 45 degrees",
              .claim = "rotation is undetermined, and reported as such",
              .measure = "cells with theta reported as determined",
              .seed = 202};
  Draw draw(tally.seed);
  for (int k = 0; k < n_tested(100); ++k) {
    CapCase cap = drawn(draw, draw.sign() * 45.0, draw.whole(1, 4));
    cap.request.numbers["offset_x"] = cap.request.numbers["offset_z"] = 0.0;
    const Solved solved = solve(scene_of(cap.request), cap.options);
    ++tally.outcomes[std::string(name_of(solved.record.status))];
    tally.outcomes["turned"] += solved.moves.count(MoveKind::rotate) > 0 ? 1 : 0;
    EXPECT_TRUE(tally.add(solved.record.theta_determined ? 1.0 : 0.0)) << "case " << k;
  }
  EXPECT_EQ(tally.outcomes["turned"], 0);
  report(tally);
}

// Vertex normals of the slopes only: computed ones would include the walls, whose diagonals tilt them.
Mesh with_slope_normals(Mesh mesh, double outward)
{
  for (Eigen::Index v = 0; v < mesh.vertices_mm.rows(); ++v) {
    const Eigen::Vector3d p = mesh.vertices_mm.row(v);
    const Eigen::Vector3d sideways(p.x() > 0.0 ? 1.0 : -1.0, 0.0, p.z() > 0.0 ? 1.0 : -1.0);
    const bool is_tip = std::abs(p.x()) < 1e-9 && std::abs(p.z()) < 1e-9;
    const Eigen::Vector3d up = Eigen::Vector3d::UnitY();
    mesh.normals.row(v) = outward * (is_tip ? up : (sideways + up).normalized());
  }
  return mesh;
}

// Thesis 3.7: with triangle centres, a face of one triangle applies its normal at its centre, and the line
// of action passes through the axis, for sink and cap alike: there is no torque, whereas the exact points
// rotate the cap.
TEST(CapInSink, TriangleCentresDoNotTurnTheCapAsTheThesisFound)
{
  Tally tally{.scene = "pyramidal cap, points at triangle centres (3.7)",
              .claim = "fails: no rotation; exact points rotate it",
              .measure = "rotations with triangle centres",
              .seed = 203,
              .allowed = 0.0};
  Draw draw(tally.seed);
  for (int k = 0; k < n_tested(200); ++k) {
    CapCase cap = drawn(draw, draw.sign() * draw.uniform(10.0, 44.0), 1);
    cap.request.numbers["turn"] = 0.0;
    cap.request.numbers["offset_x"] = cap.request.numbers["offset_z"] = 0.0;
    Scene scene = scene_of(cap.request);
    scene.reference = with_slope_normals(scene.reference, -1.0);
    scene.moving = with_slope_normals(scene.moving, 1.0);
    const MovingPose seed{Eigen::Vector3d::Zero(), rad_from_deg(cap.turn_deg)};
    const Solved exact = solve(scene, cap.options, seed);
    EXPECT_LE(std::abs(deg_from_rad(exact.record.pose.theta_rad)), allowed_deg(cap)) << "case " << k;
    cap.options.points = ContactPoints::triangle_centre;
    cap.options.normals = k % 2 == 0 ? ContactNormals::reference : ContactNormals::moving;
    const Solved solved = solve(scene, cap.options, seed);
    ++tally.outcomes[std::string(name_of(solved.record.status))];
    const auto turns = solved.moves.find(MoveKind::rotate);
    EXPECT_TRUE(tally.add(turns == solved.moves.end() ? 0.0 : turns->second)) << "case " << k;
  }
  report(tally);
}

}  // namespace vrda::test::cap_test
