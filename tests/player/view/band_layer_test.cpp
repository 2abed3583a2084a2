#include <gtest/gtest.h>

#include "core/units.hpp"
#include "player/view/layer_models.hpp"
#include "view/scene.hpp"

namespace vrda::band_layer_test {

using test::drawable_of;
using test::layered_model;
using test::Stage;

TEST(BandLayer, IsTheMovingObjectOfTheSamplesAtBothEnds)
{
  for (const std::string side : {"right", "left"}) {
    for (const view::FixedObject held :
         {view::FixedObject::moving, view::FixedObject::reference, view::FixedObject::push}) {
      Stage stage(layered_model(side));
      stage.held = held;
      stage.show({30.0, 1.0}, {view::Layer::band});
      const view::Drawable& body = drawable_of(stage.scene, "block");
      const view::Drawable& low = drawable_of(stage.scene, "block, quantile_5");
      const view::Drawable& high = drawable_of(stage.scene, "block, quantile_95");
      EXPECT_TRUE(body.is_shown && low.is_shown && high.is_shown);
      EXPECT_LT(low.material.opacity, 1.0F);
      EXPECT_GT(low.depth_offset_mm, 0.0);
      // The samples are 1 and 3 mm anterior, at zero varus and rotation.
      const Eigen::Vector3d apart_mm = high.X_world_mesh.translation() - low.X_world_mesh.translation();
      EXPECT_NEAR(apart_mm.norm(), 2.0, 1e-9);
      const store::Motion sample(stage.model, "quantile_5");
      const view::JointFrames frames = view::frames_of(
          stage.motion.at({rad_from_deg(30.0), rad_from_deg(1.0)}), held, stage.model.rotation_centre_mm);
      const Pose expected =
          frames.X_world_reference * sample.at({rad_from_deg(30.0), 0.0}).X_reference_moving;
      EXPECT_LT((low.X_world_mesh.linear() - expected.linear()).norm(), 1e-12);
      EXPECT_LT((low.X_world_mesh * Eigen::Vector3d(-low.origin_mm) - expected.translation()).norm(), 1e-9);
    }
  }
}

}  // namespace vrda::band_layer_test
