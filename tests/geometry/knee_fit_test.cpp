#include <gmock/gmock.h>

#include <random>

#include "core/units.hpp"
#include "geometry/generated_knee.hpp"
#include "geometry/generic_knee.hpp"
#include "geometry/knee_fit.hpp"
#include "support/meshes.hpp"

namespace vrda::knee_fit_test {

using namespace geometry;
using test::angle_between_rad, test::generated_knee, test::generated_template, test::moved, test::pose;

// The last step of a fit (bone_fit.cpp), times the few steps that it may still need.
constexpr double fit_rad = 1e-4, fit_mm = 1e-2;

TEST(KneeFit, FindsUnitSideAndFramesOfAMovedKnee)
{
  const KneeSurfaces knee = generated_knee();
  struct Row {
    Eigen::Vector4d quaternion;
    Eigen::Vector3d t_mm;
    double unit_mm;
  };
  for (const Row& row : {Row{{0, 0, 0, 1}, {0, 0, 0}, 1.0}, Row{{1, 2, -1, 1}, {500, -300, 80}, 10.0},
                         Row{{-3, 1, 1, 2}, {0, 900, 0}, 1000.0}, Row{{1, 0, 0, 0}, {-70, 5, 2}, 1.0},
                         Row{{1, -1, 1, -1}, {1, 2, 3}, 10.0}, Row{{0, 1, 0, 0}, {300, 300, 300}, 1000.0}}) {
    SCOPED_TRACE(row.quaternion.transpose());
    const Pose X = pose(row.quaternion, row.t_mm);
    const KneeFit fit = fit_knee(moved(knee, X, X, row.unit_mm), generated_template());
    EXPECT_DOUBLE_EQ(fit.unit_mm, row.unit_mm);
    EXPECT_EQ(fit.side, Side::right);
    EXPECT_GT(fit.side_margin, 1.05);
    EXPECT_LT(angle_between_rad(X, fit.X_scan_femur), fit_rad);
    EXPECT_LT(angle_between_rad(X, fit.X_scan_tibia), fit_rad);
    EXPECT_LT((X.translation() - fit.X_scan_femur.translation()).norm(), fit_mm);
    EXPECT_LT((X.translation() - fit.X_scan_tibia.translation()).norm(), fit_mm);
  }
}

TEST(KneeFit, AMirroredKneeGivesTheMirroredFrames)
{
  const Pose X_femur = pose({1, 2, 3, 9}, {30, 20, 10}), X_tibia = pose({1, 2, 4, 9}, {30, 21, 10});
  const KneeSurfaces right = moved(generated_knee(), X_femur, X_tibia);
  const KneeFit of_right = fit_knee(right, generated_template());
  const KneeFit of_left = fit_knee(mirrored_z(right), generated_template());
  EXPECT_EQ(of_right.side, Side::right);
  EXPECT_EQ(of_left.side, Side::left);
  const auto mirrored = [](const Pose& X) {
    Pose Y = Pose::Identity();
    const Eigen::Vector3d flip(1, 1, -1);
    Y.linear() = flip.asDiagonal() * X.linear() * flip.asDiagonal();
    Y.translation() = flip.cwiseProduct(X.translation());
    return Y;
  };
  EXPECT_LT(angle_between_rad(mirrored(of_right.X_scan_femur), of_left.X_scan_femur), fit_rad);
  EXPECT_LT(angle_between_rad(mirrored(of_right.X_scan_tibia), of_left.X_scan_tibia), fit_rad);
  EXPECT_NEAR(of_right.scanned.internal_rotation_rad, of_left.scanned.internal_rotation_rad, fit_rad);
  EXPECT_NEAR(of_right.scanned.varus_rad, of_left.scanned.varus_rad, fit_rad);
  EXPECT_NEAR(of_right.scanned.lateral_mm, of_left.scanned.lateral_mm, fit_mm);
}

TEST(KneeFit, TwoThreadsGiveTheSameBits)
{
  KneeFitOptions both_at_once;
  both_at_once.n_threads = 2;
  const KneeFit one = fit_knee(generated_knee(), generated_template());
  const KneeFit two = fit_knee(generated_knee(), generated_template(), both_at_once);
  EXPECT_EQ(one.X_scan_femur.matrix(), two.X_scan_femur.matrix());
  EXPECT_EQ(one.X_scan_tibia.matrix(), two.X_scan_tibia.matrix());
}

TEST(KneeFit, TheScannedPoseIsReportedAndDoesNotMoveTheFrames)
{
  for (const double flexion_deg : {30.0, 60.0, 90.0}) {
    SCOPED_TRACE(flexion_deg);
    Pose X_femur = Pose::Identity();
    X_femur.linear() = rotation_z(rad_from_deg(flexion_deg)) * rotation_x(rad_from_deg(-3.0));
    const KneeFit fit = fit_knee(moved(generated_knee(), X_femur, Pose::Identity()), generated_template());
    EXPECT_LT(angle_between_rad(X_femur, fit.X_scan_femur), fit_rad);
    EXPECT_LT(angle_between_rad(Pose::Identity(), fit.X_scan_tibia), fit_rad);
    const Pose X_femur_tibia = X_femur.inverse();
    const ClinicalCoordinates expected =
        clinical_coordinates(X_femur_tibia, Side::right, Eigen::Vector3d::Zero());
    EXPECT_NEAR(fit.scanned.flexion_rad, expected.flexion_rad, fit_rad);
    EXPECT_NEAR(fit.scanned.varus_rad, expected.varus_rad, fit_rad);
    EXPECT_NEAR(fit.scanned.internal_rotation_rad, expected.internal_rotation_rad, fit_rad);
  }
}

TEST(KneeFit, FindsAScaleAnAxis)
{
  KneeSurfaces knee = generated_knee();
  const Eigen::Vector3d scale(1.08, 1.0, 0.94);
  for (Mesh* mesh : {&knee.femur.bone, &knee.tibia.bone}) {
    mesh->vertices_mm = mesh->vertices_mm * scale.asDiagonal();
    mesh->normals = vertex_normals(*mesh);
  }
  const KneeFit fit = fit_knee(knee, generated_template());
  for (const BoneFit* bone : {&fit.femur, &fit.tibia}) {
    // The weight on equal factors draws them to their mean, by less than a third of the deviation.
    EXPECT_LT((bone->scale - scale).cwiseAbs().maxCoeff(), 0.3 * 0.08);
    EXPECT_LT(bone->residual_mm, 0.5);
  }
  EXPECT_LT(angle_between_rad(Pose::Identity(), fit.X_scan_femur), rad_from_deg(1.0));
}

TEST(KneeFit, ASideAndAUnitThatAreGivenAreUsed)
{
  KneeFitOptions options;
  options.side = Side::left;
  options.unit_mm = 10.0;
  const KneeFit fit = fit_knee(moved(generated_knee(), Pose::Identity(), Pose::Identity(), 10.0),
                               generated_template(), options);
  EXPECT_EQ(fit.side, Side::left);
  EXPECT_LT(fit.side_margin, 1.0);  // the geometry says right
  EXPECT_DOUBLE_EQ(fit.unit_mm, 10.0);
}

TEST(KneeFit, CartilageAloneTakesTheScaleOfTheOtherBone)
{
  KneeSurfaces knee = generated_knee();
  for (Mesh* mesh : {&knee.femur.bone, &knee.tibia.bone}) mesh->vertices_mm *= 1.1;
  knee.femur = {{}, cropped(knee.femur.bone, {0, -15, 0}, 45.0)};
  const KneeFit fit = fit_knee(knee, generated_template());
  EXPECT_NEAR(fit.tibia.scale.mean(), 1.1, 1e-3);
  EXPECT_DOUBLE_EQ(fit.femur.scale.x(), 0.5 * (fit.tibia.scale.x() + fit.tibia.scale.z()));
  EXPECT_LT(angle_between_rad(Pose::Identity(), fit.X_scan_femur), rad_from_deg(1.0));
}

// A ball's turn is left open by its surface.
TEST(BoneFitTest, KnownPointsDecideWhatTheSurfaceLeavesOpen)
{
  const Mesh ball = test::ball(20.0, 64, 128);
  const Pose X = pose({0.97, 0.1, -0.2, 0.05}, {3, -2, 1});
  BoneFitOptions options{ScaleFreedom::held, 0.95};
  for (const Eigen::Vector3d& p_mm :
       {Eigen::Vector3d(20, 0, 0), Eigen::Vector3d(0, 12, 16), Eigen::Vector3d(0, -20, 0)})
    options.known.push_back({p_mm, X * p_mm});
  const BoneFit fit =
      fit_bone(sample_surface(ball, 2000), NearestSurface(transformed(ball, X)), {BoneFit{}}, options);
  EXPECT_LT((fit.R - X.linear()).norm(), 1e-3);
  EXPECT_LT((fit.t_mm - X.translation()).norm(), 1e-2);
}

TEST(KneeFit, AKnownPointDrawsItsBoneAndOneFarOffDoesNot)
{
  const KneeSurfaces knee = generated_knee();
  const auto fit_with = [&](const Eigen::Vector3d& off_mm) {
    KneeFitOptions options;
    const Eigen::Vector3d epicondyle_mm(0, 5, -40);
    options.femur_points = {{epicondyle_mm, 0.1 * (epicondyle_mm + off_mm)}};
    return fit_knee(moved(knee, Pose::Identity(), Pose::Identity(), 10.0), generated_template(), options);
  };
  const KneeFit right = fit_with(Eigen::Vector3d::Zero());
  EXPECT_LT(angle_between_rad(Pose::Identity(), right.X_scan_femur), fit_rad);
  const Eigen::Vector3d off_mm(0, 6, 0);
  const KneeFit drawn = fit_with(off_mm);
  const double by_mm = (drawn.femur(Eigen::Vector3d(0, 5, -40)) - Eigen::Vector3d(0, 5, -40)).y();
  EXPECT_GT(by_mm, 0.1);
  EXPECT_LT(by_mm, 3.0);
  EXPECT_LT(angle_between_rad(Pose::Identity(), drawn.X_scan_tibia), fit_rad);
  const KneeFit other = fit_with(Eigen::Vector3d(300, 0, 0));
  EXPECT_LT(angle_between_rad(Pose::Identity(), other.X_scan_femur), rad_from_deg(0.1));
}

// A fit of thousands of overlapping triangles takes minutes, so each of its searches asks.
TEST(KneeFit, EndsSoonAfterItIsStopped)
{
  int n_polls = 0;
  KneeFitOptions options;
  options.is_stopped = [&] { return ++n_polls > 1000; };
  const KneeFit fit = fit_knee(generated_knee(), generated_template(), options);
  EXPECT_GT(n_polls, 1000);
  EXPECT_LT(n_polls, 1100);  // one for each of the fits that were left
  const int n_before = n_polls;
  EXPECT_EQ(probable_cause(fit, generated_knee(), generated_template(), options), "");
  EXPECT_LT(n_polls, n_before + 500);
}

using testing::ElementsAre, testing::HasSubstr, testing::IsEmpty;

KneeSurfaces generated()
{
  return generic_template().surfaces;
}

KneeFit good_fit()
{
  KneeFit fit;
  fit.side_margin = 1.3;
  fit.coarse_residual_mm = 1.0;
  fit.femur.residual_mm = fit.tibia.residual_mm = 0.5;  // not the template itself, whose stump is no reason
  return fit;
}

TEST(RejectionReasons, EachLimitIsNamed)
{
  const KneeSurfaces knee = generated();
  EXPECT_THAT(rejection_reasons(good_fit(), knee), IsEmpty());
  const auto with = [&](const auto& change) {
    KneeFit fit = good_fit();
    change(fit);
    return rejection_reasons(fit, knee);
  };
  EXPECT_THAT(with([](KneeFit& f) { f.coarse_residual_mm = 3.6; }), ElementsAre(HasSubstr("both bones")));
  EXPECT_THAT(with([](KneeFit& f) { f.coarse_residual_mm = INFINITY; }),
              ElementsAre(HasSubstr("both bones")));
  EXPECT_THAT(with([](KneeFit& f) { f.femur.residual_mm = 2.0; }), ElementsAre(HasSubstr("femur: residual")));
  EXPECT_THAT(with([](KneeFit& f) { f.tibia.residual_mm = 2.0; }), ElementsAre(HasSubstr("tibia: residual")));
  EXPECT_THAT(with([](KneeFit& f) { f.scanned.varus_rad = rad_from_deg(-11); }),
              ElementsAre(HasSubstr("varus")));
  EXPECT_THAT(with([](KneeFit& f) { f.scanned.internal_rotation_rad = rad_from_deg(31); }),
              ElementsAre(HasSubstr("internal rotation")));
  EXPECT_THAT(with([](KneeFit& f) { f.scanned.flexion_rad = rad_from_deg(121); }),
              ElementsAre(HasSubstr("flexion 121 degrees")));
  EXPECT_THAT(with([](KneeFit& f) { f.scanned.flexion_rad = rad_from_deg(-16); }),
              ElementsAre(HasSubstr("flexion")));
  EXPECT_THAT(with([](KneeFit& f) { f.nearest_mm = 30; }), ElementsAre(HasSubstr("one pose")));
  KneeSurfaces stump = knee;
  stump.tibia.bone.vertices_mm.col(1) = stump.tibia.bone.vertices_mm.col(1).cwiseMax(-55.0);
  EXPECT_THAT(rejection_reasons(good_fit(), stump), ElementsAre(HasSubstr("tibia: 35 mm of bone")));
}

// A search of the nearest point visits all of such triangles: 8,000 took minutes.
TEST(TangleIn, RandomTrianglesAreNoSurfaceAndNestedWallsAre)
{
  const Mesh ball = test::ball(20.0);
  Mesh walls = ball;
  for (int k = 1; k < 10; ++k) append(walls, test::ball(20.0 - k));
  EXPECT_EQ(tangle_in(Mesh()), "");
  EXPECT_EQ(tangle_in(ball), "");
  EXPECT_EQ(tangle_in(walls), "");
  Mesh tangle = ball;
  std::mt19937 random(1);  // its numbers are the standard's
  tangle.vertices_mm =
      tangle.vertices_mm.unaryExpr([&](double) { return 0.01 * static_cast<double>(random() % 4096); });
  Mesh all = tangle;
  for (int k = 0; k < 5; ++k) append(all, tangle);
  EXPECT_THAT(tangle_in(all), HasSubstr("times the area"));
  all.vertices_mm *= 1000.0;
  EXPECT_THAT(tangle_in(all), HasSubstr("times the area"));
}

TEST(FitWarnings, ShortBonesCartilageOnlyAndAnUncertainSide)
{
  KneeSurfaces knee = generated();
  EXPECT_THAT(fit_warnings(good_fit(), knee, false), IsEmpty());
  KneeFit fit = good_fit();
  fit.side_margin = 1.04;
  EXPECT_THAT(fit_warnings(fit, knee, false), ElementsAre(HasSubstr("give --side")));
  EXPECT_THAT(fit_warnings(fit, knee, true), IsEmpty());
  fit.side_margin = 0.8;
  EXPECT_THAT(fit_warnings(fit, knee, true), ElementsAre(HasSubstr("other side")));
  knee.femur.bone.vertices_mm.col(1) = knee.femur.bone.vertices_mm.col(1).cwiseMin(23.0);
  EXPECT_THAT(fit_warnings(good_fit(), knee, false), ElementsAre(HasSubstr("femur: only 43 mm of bone")));
  knee.femur = {{}, knee.femur.bone};
  EXPECT_THAT(fit_warnings(good_fit(), knee, false), ElementsAre(HasSubstr("femur: cartilage only")));
}

TEST(PartChecks, APartLiesOnItsOwnBone)
{
  // Flat bones 10 mm apart, with sheets of cartilage 2 mm from their own.
  const auto at_height = [](double y_mm) {
    Mesh sheet = test::sheet(40.0, 20);
    sheet.vertices_mm.col(1).array() += y_mm;
    return sheet;
  };
  const Mesh femur = at_height(10.0), tibia = at_height(0.0);
  EXPECT_EQ(cartilage_check(at_height(8.0), CartilageOf::femur, femur, tibia).rejection, "");
  EXPECT_EQ(cartilage_check(at_height(8.0), CartilageOf::femur, femur, tibia).doubt, "");
  EXPECT_THAT(cartilage_check(at_height(2.0), CartilageOf::femur, femur, {}).doubt, IsEmpty());
  EXPECT_THAT(cartilage_check(at_height(2.0), CartilageOf::femur, femur, tibia).rejection,
              HasSubstr("2 mm on average"));
  EXPECT_THAT(cartilage_check(at_height(20.0), CartilageOf::femur, femur, tibia).doubt,
              HasSubstr("more than 10 mm"));
  EXPECT_THAT(cartilage_check(at_height(45.0), CartilageOf::femur, femur, tibia).rejection,
              HasSubstr("35 mm from the bone"));
  EXPECT_EQ(cartilage_check(at_height(45.0), CartilageOf::femur, {}, tibia).rejection, "");
  EXPECT_EQ(meniscus_check(at_height(12.0), tibia).doubt, "");
  EXPECT_THAT(meniscus_check(at_height(20.0), tibia).doubt, HasSubstr("more than 20 mm"));
  EXPECT_THAT(meniscus_check(at_height(31.0), tibia).rejection, HasSubstr("31 mm from the tibia"));
  EXPECT_THAT(fibula_rejection(at_height(-20.0), at_height(-20.0)), HasSubstr("the surface of the tibia"));
}

// Between the bones, near both.
TEST(PartChecks, AMeniscusIsNoCartilage)
{
  const geometry::Shape knee = geometry::generate_shape({"knee", {}, {}});
  const Mesh &femur = knee.reference.front().mesh, &tibia = knee.moving.front().mesh;
  int n_menisci = 0;
  for (const geometry::ShapePart& part : knee.moving) {
    if (!part.name.starts_with("meniscus")) continue;
    ++n_menisci;
    EXPECT_THAT(cartilage_check(part.mesh, CartilageOf::femur, femur, tibia).rejection, HasSubstr("bone"));
    EXPECT_THAT(cartilage_check(part.mesh, CartilageOf::femur, {}, tibia).rejection, HasSubstr("meniscus"));
  }
  EXPECT_EQ(n_menisci, 2);
  // Nearer to a femur with cartilage than to the tibia, and yet no part of it.
  const auto at_height = [](double y_mm) {
    Mesh sheet = test::sheet(40.0, 20);
    sheet.vertices_mm.col(1).array() += y_mm;
    return sheet;
  };
  EXPECT_THAT(cartilage_check(at_height(4.0), CartilageOf::femur, at_height(6.5), at_height(0.0)).rejection,
              HasSubstr("as a meniscus is"));
  EXPECT_THAT(cartilage_check(at_height(3.5), CartilageOf::tibia, at_height(0.0), at_height(8.0)).rejection,
              HasSubstr("as a meniscus is"));
  // A closed layer of 2 mm on a condyle is no copy.
  Mesh layer = test::ball(22), bone = test::ball(20);
  append(layer, bone);
  Mesh below = test::sheet(60, 20);
  below.vertices_mm.col(1).array() -= 26.0;
  EXPECT_EQ(cartilage_check(layer, CartilageOf::femur, bone, below).rejection, "");
  EXPECT_FALSE(is_part_of(layer, bone));
  EXPECT_TRUE(is_part_of(cropped(bone, {0, -20, 0}, 10.0), test::ball(20, 32, 64)));
}

TEST(ProbableCause, NamesASheetWoundInward)
{
  const TemplateKnee reference = generic_template();
  const KneeSurfaces knee = reference.surfaces;
  // Open: without the end of its shaft.
  KneeSurfaces inward = knee;
  inward.femur = {cropped(joined(knee.femur), {0, 0, 0}, 50.0), {}};
  inward.femur.bone.triangles.col(1).swap(inward.femur.bone.triangles.col(2));
  inward.femur.bone.normals *= -1.0;
  const KneeFit of_inward = fit_knee(inward, reference);
  EXPECT_FALSE(rejection_reasons(of_inward, inward).empty());
  EXPECT_THAT(probable_cause(of_inward, inward, reference), HasSubstr("the femur is inside out"));
}

}  // namespace vrda::knee_fit_test
