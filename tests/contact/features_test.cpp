#include "contact/features.hpp"

#include <gtest/gtest.h>

#include "core/frames.hpp"
#include "support/meshes.hpp"

namespace vrda::features_test {

TEST(SurfaceFeatures, ABoxBendsByARightAngleAtItsEdgesAndNotOnItsDiagonals)
{
  const Mesh box = test::box({0, 0, 0}, {2, 4, 6});
  const SurfaceFeatures features(box);
  int n_sharp = 0, n_flat = 0;
  for (std::int32_t t = 0; t < 12; ++t) {
    for (int k = 0; k < 3; ++k) {
      const double bend = features.bend({FeatureKind::edge, features.edge_of(t, k)});
      const bool is_diagonal = bend < 0.5;
      EXPECT_NEAR(bend, is_diagonal ? 0.0 : 1.0, 1e-12);
      (is_diagonal ? n_flat : n_sharp) += 1;
    }
  }
  EXPECT_EQ(n_sharp, 24);
  EXPECT_EQ(n_flat, 12);
  for (std::int32_t v = 0; v < 8; ++v) EXPECT_NEAR(features.bend({FeatureKind::vertex, v}), 1.0, 1e-12);
  EXPECT_EQ(features.bend({FeatureKind::face, 3}), 0.0);
}

TEST(SurfaceFeatures, OpenEdgesAreSharpest)
{
  const Mesh sheet = test::sheet(4, 2);
  const SurfaceFeatures features(sheet);
  EXPECT_EQ(features.bend({FeatureKind::vertex, 0}), 2.0);
  EXPECT_NEAR(features.bend({FeatureKind::vertex, 4}), 0.0, 1e-12) << "the middle";
  EXPECT_EQ(features.star({FeatureKind::vertex, 4}).size(), 6u);
}

TEST(SurfaceFeatures, PointsAreFoundOnTheirFeature)
{
  const Mesh sheet = test::sheet(4, 1);  // triangles (0, 1, 3) and (0, 3, 2)
  const SurfaceFeatures features(sheet);
  const auto corner = corners(sheet, 0);
  const auto at = [&](double a, double b, double c) {
    return feature_at(sheet, features, 0, a * corner[0] + b * corner[1] + c * corner[2], corner);
  };
  EXPECT_EQ(at(0.3, 0.3, 0.4).kind, FeatureKind::face);
  EXPECT_EQ(at(0.5, 0.5, 0.0), (Feature{FeatureKind::edge, features.edge_of(0, 0)}));
  EXPECT_EQ(at(0.0, 0.5, 0.5), (Feature{FeatureKind::edge, features.edge_of(0, 1)}));
  EXPECT_EQ(at(0.5, 0.0, 0.5), (Feature{FeatureKind::edge, features.edge_of(0, 2)}));
  EXPECT_EQ(at(0.0, 1.0, 0.0), (Feature{FeatureKind::vertex, 1}));
  EXPECT_EQ(features.edge_of(0, 2), features.edge_of(1, 0)) << "the shared diagonal";
}

}  // namespace vrda::features_test
