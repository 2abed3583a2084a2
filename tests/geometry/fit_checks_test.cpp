#include "geometry/fit_checks.hpp"

#include <gmock/gmock.h>

#include <random>

#include "core/units.hpp"
#include "geometry/generic_knee.hpp"
#include "geometry/template_knee.hpp"
#include "support/meshes.hpp"

namespace vrda::fit_checks_test {

using namespace geometry;
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

TEST(FitWarnings, AFibulaIsLateral)
{
  const Mesh fibula = geometry::right_template_knee().moving.back().mesh;
  EXPECT_TRUE(is_fibula_lateral(fibula, Side::right));
  EXPECT_FALSE(is_fibula_lateral(fibula, Side::left));
  EXPECT_TRUE(is_fibula_lateral(mirrored_z(fibula), Side::left));
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

TEST(RejectionReasons, OtherBonesAreRefused)
{
  const TemplateKnee reference = generic_template();
  const KneeSurfaces& knee = reference.surfaces;
  const geometry::Shape hip = geometry::generate_shape({"hip", {}, {}});
  const BoneSurfaces head{hip.moving.front().mesh, {}}, socket{hip.reference.front().mesh, {}};
  KneeSurfaces apart = knee;
  for (Mesh* mesh : {&apart.tibia.bone, &apart.tibia.cartilage}) mesh->vertices_mm.col(1).array() -= 60.0;
  for (const KneeSurfaces& other :
       {KneeSurfaces{knee.femur, knee.femur}, KneeSurfaces{knee.tibia, knee.tibia},
        KneeSurfaces{socket, head}, KneeSurfaces{knee.femur, head}, apart}) {
    EXPECT_FALSE(rejection_reasons(fit_knee(other, reference), other).empty());
  }
}

TEST(ProbableCause, NamesExchangedBonesAndASheetWoundInward)
{
  const TemplateKnee reference = generic_template();
  const KneeSurfaces knee = reference.surfaces;
  const KneeSurfaces exchanged{knee.tibia, knee.femur};
  const KneeFit of_exchanged = fit_knee(exchanged, reference);
  EXPECT_FALSE(rejection_reasons(of_exchanged, exchanged).empty());
  EXPECT_THAT(probable_cause(of_exchanged, exchanged, reference), HasSubstr("exchanged"));
  // Open: without the end of its shaft.
  KneeSurfaces inward = knee;
  inward.femur = {cropped(joined(knee.femur), {0, 0, 0}, 50.0), {}};
  inward.femur.bone.triangles.col(1).swap(inward.femur.bone.triangles.col(2));
  inward.femur.bone.normals *= -1.0;
  const KneeFit of_inward = fit_knee(inward, reference);
  EXPECT_FALSE(rejection_reasons(of_inward, inward).empty());
  EXPECT_THAT(probable_cause(of_inward, inward, reference), HasSubstr("the femur is inside out"));
}

}  // namespace vrda::fit_checks_test
