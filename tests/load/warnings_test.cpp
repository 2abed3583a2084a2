#include <gmock/gmock.h>

#include "load/case.hpp"
#include "load/mesh_text.hpp"
#include "support/meshes.hpp"
#include "support/scratch.hpp"

namespace vrda::warnings_test {

using testing::AllOf;
using testing::Contains;
using testing::ElementsAre;
using testing::HasSubstr;

// Two balls side by side, as femoral condyles lie, over a box.
Mesh condyles()
{
  Mesh femur = test::ball(22, 24, 48);
  femur.vertices_mm.col(2).array() -= 25.0;
  Mesh right = test::ball(22, 24, 48);
  right.vertices_mm.col(2).array() += 25.0;
  append(femur, right);
  return femur;
}

std::vector<std::string> warnings_of(const std::string& job, const std::vector<std::string>& overrides = {},
                                     const Mesh& reference = condyles(),
                                     const Mesh& moving = test::box({0, -60, 0}, {50, 30, 70}))
{
  const test::Scratch scratch;
  scratch.write("reference.stl", test::binary_stl(reference));
  scratch.write("moving.stl", test::binary_stl(moving));
  return load_case(scratch.write("job.toml", job).string(), {"", overrides}).warnings;
}

TEST(Warnings, ASoundJobHasNone)
{
  EXPECT_THAT(warnings_of(test::small_job()), ElementsAre());
}

const std::string search = "solver.method=stability-search";

TEST(Warnings, StepsOfTheSearchHaveNoEffectOnTheEquilibrium)
{
  EXPECT_THAT(warnings_of(test::small_job(), {"solver.search.rotation_step_deg=0.5"}),
              ElementsAre(AllOf(HasSubstr("solver.search.rotation_step_deg"), HasSubstr("equilibrium"))));
}

TEST(Warnings, ACampaignIsNotRun)
{
  EXPECT_THAT(warnings_of(test::small_job("", "[campaign]\n[[campaign.method]]\nname = \"a\"\n")),
              ElementsAre(AllOf(HasSubstr("vrda plan"), HasSubstr("vrda submit"))));
}

TEST(Warnings, StepsUnderTenResolutions)
{
  EXPECT_THAT(warnings_of(test::small_job(), {search, "solver.search.translation_resolution_mm=0.2"}),
              ElementsAre(AllOf(HasSubstr("translation step"), HasSubstr("5.0 times"))));
  EXPECT_THAT(warnings_of(test::small_job(), {search, "solver.search.rotation_step_deg=0.5"}),
              ElementsAre(AllOf(HasSubstr("rotation step"), HasSubstr("5.0 times"))));
}

TEST(Warnings, LigamentsHaveNoEffectOnTheStabilitySearch)
{
  const std::string fibre =
      "[[ligaments.fibre]]\nname = \"acl\"\nreference_mm = [0, 0, 0]\nmoving_mm = [0, -50, 9]\n"
      "stiffness_n = 1000\nslack_length_mm = 30\n";
  EXPECT_THAT(warnings_of(test::small_job("", fibre), {search}), ElementsAre(HasSubstr("no effect")));
}

TEST(Warnings, ADegreeTheGridCannotCarry)
{
  EXPECT_THAT(warnings_of(test::small_job(), {"grid.varus.step=5"}),
              ElementsAre(AllOf(HasSubstr("degree 6 needs 7"), HasSubstr("5 of varus"))));
}

TEST(Warnings, OpenSheetsAndHolesAndBadEdges)
{
  const Mesh sheet = test::sheet(80, 12);
  EXPECT_THAT(warnings_of(test::small_job(), {}, condyles(), sheet),
              ElementsAre(AllOf(HasSubstr("open sheet, which is fine"), HasSubstr("48"))));
  Mesh torn = test::ball(40, 24, 48);
  torn.triangles.conservativeResize(torn.triangles.rows() - 1, 3);
  EXPECT_THAT(warnings_of(test::small_job(), {}, condyles(), torn),
              ElementsAre(AllOf(HasSubstr("small holes"), HasSubstr("3)"))));
  Mesh twisted = test::ball(40, 24, 48);
  std::swap(twisted.triangles(100, 0), twisted.triangles(100, 1));
  EXPECT_THAT(warnings_of(test::small_job(), {}, condyles(), twisted),
              ElementsAre(AllOf(HasSubstr("more than two faces"), HasSubstr(": 3"))));
}

TEST(Warnings, MetresReadAsMillimetresAndTheOtherWayRound)
{
  Mesh femur_m = condyles(), tibia_m = test::box({0, -60, 0}, {50, 30, 70});
  femur_m.vertices_mm *= 1e-3;
  tibia_m.vertices_mm *= 1e-3;
  const std::vector<std::string> small = warnings_of(test::small_job(), {}, femur_m, tibia_m);
  EXPECT_THAT(small,
              Contains(AllOf(HasSubstr("\"upper\""), HasSubstr("says \"mm\""), HasSubstr("suggests \"m\""))));
  EXPECT_THAT(small, Contains(AllOf(HasSubstr("\"lower\""), HasSubstr("suggests \"m\""))));
  EXPECT_THAT(warnings_of(test::small_job(), {"frame.unit=m"}, femur_m, tibia_m), ElementsAre());
  const std::vector<std::string> large = warnings_of(test::small_job(), {"frame.unit=m"});
  EXPECT_THAT(large,
              Contains(AllOf(HasSubstr("\"upper\""), HasSubstr("says \"m\""), HasSubstr("suggests \"mm\""))));
}

TEST(Warnings, AFarRotationCentre)
{
  EXPECT_THAT(warnings_of(test::small_job(), {"frame.origin=[0, 29, 0]"}), ElementsAre());
  EXPECT_THAT(warnings_of(test::small_job(), {"frame.origin=[0, 31, 0]"}),
              ElementsAre(AllOf(HasSubstr("frame.origin"), HasSubstr("31.0 mm"))));
  EXPECT_THAT(warnings_of(test::small_job("joint = \"other\"\n"), {"frame.origin=[0, 31, 0]"}),
              ElementsAre());
}

std::string job_with_menisci(const std::string& side)
{
  return "side = \"" + side + "\"\n[[reference.component]]\nname = \"femur\"\nfile = \"reference.stl\"\n" +
         "[[moving.component]]\nname = \"Meniscus_Medial\"\nfile = \"moving.stl\"\n" +
         "[[moving.component]]\nname = \"meniscus_lateral\"\nfile = \"lateral.stl\"\n";
}

TEST(Warnings, NamesThatContradictTheSide)
{
  const test::Scratch scratch;
  scratch.write("reference.stl", test::binary_stl(condyles()));
  scratch.write("moving.stl", test::binary_stl(test::box({0, -40, -25}, {30, 5, 20})));
  scratch.write("lateral.stl", test::binary_stl(test::box({0, -40, 25}, {30, 5, 20})));
  EXPECT_THAT(load_case(scratch.write("right.toml", job_with_menisci("right")).string()).warnings,
              ElementsAre());
  EXPECT_THAT(load_case(scratch.write("left.toml", job_with_menisci("left")).string()).warnings,
              ElementsAre(AllOf(HasSubstr("the job says left"), HasSubstr("as in a right knee"))));
}

}  // namespace vrda::warnings_test
