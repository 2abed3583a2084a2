// Thesis 4.2.2: a four-faced cap turns and slides until it sits in a sink of the same slopes.
#include <gtest/gtest.h>

#include <cmath>

#include "core/units.hpp"
#include "validation/scene_case.hpp"

namespace vrda::test {
namespace {

TEST(CapInSink, SitsInTheSinkFromEveryAngle)
{
  Tally tally{.scene = "pyramidal cap in a sink",
              .claim = "turned back by the shorter way",
              .measure = "turn left over what the resolutions allow",
              .seed = 201,
              .allowed = 1.0};
  Draw draw(tally.seed);
  for (int k = 0; k < 300; ++k) {
    const double turn_deg = draw.sign() * draw.uniform(0.0, 44.0), scale = draw.uniform(0.5, 0.95);
    const ShapeRequest request{"cap-in-sink",
                               {{"turn", turn_deg},
                                {"offset_x", draw.uniform(-3, 3)},
                                {"offset_z", draw.uniform(-3, 3)},
                                {"edges", 1},
                                {"cap_scale", scale}},
                               {}};
    const SearchOptions options;
    const Solved solved = solve(scene_of(request), options);
    ++tally.outcomes[std::string(name_of(solved.record.status))];
    const double left_deg = std::abs(deg_from_rad(solved.record.pose.theta_rad) + turn_deg);
    const double allowed_deg = 0.1 + deg_from_rad(0.1 / (20.0 * scale));
    EXPECT_TRUE(tally.add(left_deg / allowed_deg))
        << "case " << k << " turn " << turn_deg << " scale " << scale << " left " << left_deg;
  }
  report(tally);
}

}  // namespace
}  // namespace vrda::test
