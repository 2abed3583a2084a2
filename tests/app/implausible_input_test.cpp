// Inputs that are valid and wrong: ligaments, ranges and meshes of which a check warns, with the number and
// the remedy; and a run that prints and keeps the warnings of a check.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <random>

#include "app/newcomer.hpp"
#include "store/motion_model.hpp"

namespace vrda::implausible_input_test {

namespace fs = std::filesystem;
using newcomer_test::Folder;
using newcomer_test::Mistake;

const std::string stiffness = "stiffness_n_per_strain", stiffness_key = "stiffness_n";

// Moves the vertices of the femur, by their places: equal corners stay equal.
void add_noise(const Folder& f, double deviation_mm)
{
  std::array<float, 3> corner{};
  std::mt19937 engine;
  std::map<std::array<float, 3>, std::array<float, 3>> moved;
  std::string bytes = test::read_bytes(f.file("femur.stl"));
  for (std::size_t at = 84; at < bytes.size(); at += 50) {
    for (std::size_t k = 1; k < 4; ++k) {
      std::memcpy(corner.data(), bytes.data() + at + 12 * k, 12);
      const auto [found, is_new] = moved.emplace(corner, corner);
      if (is_new) {
        std::normal_distribution<double> noise_mm(0.0, deviation_mm);
        for (float& value : found->second) value += static_cast<float>(noise_mm(engine));
      }
      std::memcpy(bytes.data() + at + 12 * k, found->second.data(), 12);
    }
  }
  f.scratch.write("femur.stl", bytes);
}

const std::vector<Mistake> mistakes{
    {"StiffnessesTimesALength",
     [](const Folder& f) { f.scale_fibres("", stiffness, 30.0); },
     0,
     "",
     {"line 2, " + stiffness_key, "\"ACLam1\"", "at most 25000", "multiplied"}},
    {"StiffnessesInKilonewtons",
     [](const Folder& f) { f.scale_fibres("", stiffness, 0.001); },
     0,
     "",
     {"line 2, " + stiffness_key, "at least 300"}},
    {"OneSoftFibre",
     [](const Folder& f) { f.scale_fibres("MCLs2", stiffness, 0.03); },
     0,
     "",
     {stiffness_key, "\"MCLs2\"", "22.5", "750"}},
    {"AStiffFibreInASoftBundle",
     [](const Folder& f) { f.scale_fibres("LCL4", stiffness, 10.0); },
     0,
     "",
     {stiffness_key, "\"LCL4\"", "6000", "600"}},
    {"AStiffFibreBeyondItsBundle",
     [](const Folder& f) { f.scale_fibres("ACLpl3", stiffness, 28.0); },
     0,
     "",
     {stiffness_key, "\"ACLpl3\"", "the other fibres"}},
    {"TheTableOfTheOtherSide",
     [](const Folder& f) {
       f.scale_fibres("", "reference_z_mm", -1.0);
       f.scale_fibres("", "moving_z_mm", -1.0);
     },
     2,
     "ligaments",
     {"left knee", "side = \"right\"", "changes its sign"}},
    {"OneCollateralOnTheOtherSide",
     [](const Folder& f) {
       f.scale_fibres("MCL", "reference_z_mm", -1.0);
       f.scale_fibres("MCL", "moving_z_mm", -1.0);
     },
     2,
     "ligaments",
     {"MCL on the lateral side", "frame.right"}},
    {"NoLateralCollateral",
     [](const Folder& f) { f.change_fibres("LCL", [](Folder::Row& row) { row.clear(); }); },
     0,
     "ligaments",
     {"LCL", "cut"}},
    {"NoAnteromedialBundle",
     [](const Folder& f) { f.change_fibres("ACLam", [](Folder::Row& row) { row.clear(); }); },
     0,
     "ligaments",
     {"ACLam", "same ligament"}},
    {"NoDeepBundle",
     [](const Folder& f) { f.change_fibres("MCLd", [](Folder::Row& row) { row.clear(); }); },
     0,
     "ligaments",
     {"MCLd", "same ligament"}},
    {"SlackLengthsTooLong",
     [](const Folder& f) { f.scale_fibres("", "slack_length_mm", 1.2); },
     0,
     "ligaments",
     {"every fibre is slack", "reference_strain"}},
    {"SlackLengthsOfOneLigamentTooLong",
     [](const Folder& f) { f.scale_fibres("PCL", "slack_length_mm", 1.2); },
     0,
     "ligaments",
     {"PCL", "-0.169", "reference_strain"}},
    {"FlexionBeyondAKnee",
     [](const Folder& f) { f.set("to = 90", "to = 150"); },
     0,
     "grid.flexion",
     {"150", "-15 to 145", "to = 145"}},
    {"ExtensionBeyondAKnee",
     [](const Folder& f) { f.set("from = 0, to = 90", "from = -40, to = 90"); },
     0,
     "grid.flexion",
     {"-40", "from = -15"}},
    {"VarusBeyondAKnee",
     [](const Folder& f) { f.set("from = -9, to = 9", "from = -30, to = 9"); },
     0,
     "grid.varus",
     {"-30", "-25 to 25"}},
    {"CoarseMeshes",
     [](const Folder& f) {
       // 888 triangles; the mean edge is no longer than that of flat plates in use
       test::run_vrda({"shape", "knee", "-o", f.scratch.path().string(), "resolution=0.75"});
     },
     0,
     "femur component \"femur\" (femur.stl)",
     {"coarse", "6.2", "0.24", "at most 0.17", "2 degrees"}},
    {"NoisyMeshes",
     [](const Folder& f) { add_noise(f, 0.3); },
     0,
     "femur component \"femur\" (femur.stl)",
     {"rough", "at most 0.14", "degrees"}},
    {"FineNoisyMeshes",
     [](const Folder& f) {
       test::run_vrda({"shape", "knee", "-o", f.scratch.path().string(), "resolution=2.5"});
       add_noise(f, 0.12);
     },
     0,
     "femur component \"femur\" (femur.stl)",
     {"rough", "at most 0.07", "degrees"}},
    {"MeshesWithHoles",
     [](const Folder& f) {
       std::string bytes = test::read_bytes(f.file("femur.stl"));
       std::string kept = bytes.substr(0, 84);
       for (std::size_t at = 84, k = 0; at < bytes.size(); at += 50, ++k)
         if (k % 20 != 0) kept += bytes.substr(at, 50);
       const auto n = static_cast<std::uint32_t>((kept.size() - 84) / 50);
       std::memcpy(kept.data() + 80, &n, 4);
       f.scratch.write("femur.stl", kept);
     },
     0,
     "femur component \"femur\" (femur.stl)",
     {"holes of ", " % of its surface", "close them"}},
    {"MeshesFarFromTheirOrigin",
     [](const Folder& f) {
       for (const char* name : {"femur.stl", "tibia.stl", "meniscus_medial.stl", "meniscus_lateral.stl"})
         f.change_mesh(name, [](float value, int axis) { return axis == 0 ? value + 1e6F : value; });
       f.set("origin = [0, 0, 0]", "origin = [1000000, 0, 0]");
       f.set("[ligaments]\nfibres = \"ligaments.csv\"\n", "");
     },
     0,
     "femur component \"femur\" (femur.stl)",
     {"1000033", "0.063", "0.03"}},
};

class ImplausibleInput : public testing::TestWithParam<Mistake> {};

TEST_P(ImplausibleInput, IsAnsweredWithNumberAndRemedy)
{
  newcomer_test::expect_answer(GetParam());
}

INSTANTIATE_TEST_SUITE_P(Each, ImplausibleInput, testing::ValuesIn(mistakes),
                         [](const auto& mistake) { return std::string(mistake.param.name); });

// The warnings of the model, in the order of the file.
std::vector<std::string> kept_warnings(const fs::path& file)
{
  return store::read_motion_model(file.string()).job.warnings;
}

TEST(Warnings, ARunPrintsAndKeepsTheWarningsOfACheck)
{
  const Folder folder;
  // A wrong side, a start within the bone, too few angles.
  folder.set("side = \"right\"", "side = \"left\"");
  folder.set("[[moving", "initial = { translation_mm = [0, 10, 0] }\n[[moving");
  folder.set("to = 90, step = 10", "to = 10, step = 10");
  folder.set("from = -9, to = 9", "from = 0, to = 3");
  const std::string job = folder.job.string(), whole = folder.file("whole.h5").string(),
                    merged = folder.file("merged.h5").string();
  const test::Ended check = test::run_vrda({"check", job}), run = test::run_vrda({"run", job, "-o", whole});
  EXPECT_EQ(run.exit_code, 0) << run.err;
  const std::vector<std::string> kept = kept_warnings(whole);
  std::string as_checked;
  for (const std::string& warning : kept) as_checked += "warning: " + warning + "\n";
  EXPECT_THAT(kept, testing::IsSupersetOf({testing::HasSubstr("side: the job has \"left\""),
                                           testing::HasSubstr("the objects overlap in the initial pose"),
                                           testing::HasSubstr("degree 3 needs 4 angles")}));
  EXPECT_THAT(check.out, testing::EndsWith(as_checked));
  EXPECT_THAT(run.err, testing::StartsWith(as_checked));
  EXPECT_THAT(run.err.substr(as_checked.size()), testing::Not(testing::HasSubstr("smooth.degrees")));
  const test::Ended info = test::run_vrda({"info", whole});
  EXPECT_THAT(info.out, testing::HasSubstr(as_checked));
  // In parts it is the same model, bit for bit.
  for (const char* part : {"1/2", "2/2"})
    EXPECT_EQ(test::run_vrda({"run", job, "-o", merged, "--shard", part}).exit_code, 0);
  EXPECT_EQ(test::run_vrda({"merge", "-o", merged, "--job", job}).exit_code, 0);
  EXPECT_EQ(test::read_bytes(merged), test::read_bytes(whole));
  EXPECT_EQ(test::run_vrda({"validate", whole}).exit_code, 0);
}

}  // namespace vrda::implausible_input_test
