#include "prepare/template_joint.hpp"

#include <gmock/gmock.h>

#include "core/units.hpp"

namespace vrda::frame_check_test {

using prepare::frame_warnings;
using testing::ElementsAre, testing::HasSubstr, testing::IsEmpty, testing::StartsWith;

job::Case moved(const Pose& X, double factor = 1.0)
{
  job::Case knee = prepare::generic_template().joint;
  for (Body* body : {&knee.reference, &knee.moving}) {
    for (Part* part : {&body->contact, &body->visual}) {
      part->mesh = transformed(part->mesh, X);
      part->mesh.vertices_mm *= factor;
    }
  }
  return knee;
}

Pose turned(const Eigen::Matrix3d& R)
{
  Pose X = Pose::Identity();
  X.linear() = R;
  return X;
}

TEST(FrameWarnings, ARightFrameHasNone)
{
  EXPECT_THAT(frame_warnings(moved(turned(rotation_y(rad_from_deg(15.0))))), IsEmpty());
}

TEST(FrameWarnings, wrong_frames)
{
  EXPECT_THAT(frame_warnings(moved(Pose::Identity(), 0.1)),
              ElementsAre(HasSubstr("frame.unit: the bones have the size of a knee in cm")));
  EXPECT_THAT(frame_warnings(moved(turned(rotation_y(rad_from_deg(90.0))))),
              ElementsAre(HasSubstr("frame: the bones are turned by")));
  Pose X = Pose::Identity();
  X.translation().x() = 40.0;
  EXPECT_THAT(frame_warnings(moved(X)), ElementsAre(HasSubstr("frame.origin: 40 mm")));
  job::Case left = moved(Pose::Identity());
  left.frame.side = Side::left;
  EXPECT_THAT(frame_warnings(left), ElementsAre(HasSubstr("side: the bones are those of a right knee")));
}

TEST(FrameWarnings, no_knee)
{
  job::Case other = moved(turned(rotation_y(rad_from_deg(90.0))));
  other.joint = "other";
  EXPECT_THAT(frame_warnings(other), IsEmpty());
  job::Case half = moved(turned(rotation_y(rad_from_deg(90.0))));
  half.moving.contact.mesh = {};
  half.moving.contact.component.clear();
  EXPECT_THAT(frame_warnings(half), IsEmpty());
}

}  // namespace vrda::frame_check_test
