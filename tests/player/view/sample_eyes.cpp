#include "player/view/sample_eyes.hpp"

namespace vrda::test {

view::Eye sample_eye(double k1, double k2)
{
  view::Eye eye;
  eye.window = {640, 544, 640, 480};
  eye.visible = {660, 560, 590, 440};
  eye.distance_px = 880.0;
  eye.pixel_aspect = 1.04;
  eye.sight_px = {957.3, 781.6};
  eye.position_head_mm = {32.0, 1.5, -4.0};
  eye.distortion = {k1, k2, {955.0, 780.0}, 320.0, 1.04};
  return eye;
}

}  // namespace vrda::test
