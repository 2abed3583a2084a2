// Typical mistakes in a new job: each causes a warning or an error that names the key and the correct value.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "app/newcomer.hpp"

namespace vrda::newcomer_test {

const std::string lcl = "LCL1,LCL,-2,0,41.5,-15,-42.5,44,2400,";

const std::vector<Mistake> mistakes{
    {"MetresReadAsMillimetres",
     [](const Folder& f) { f.scale_meshes(0.001F); },
     2,
     "frame.unit",
     {"\"mm\"", "frame.unit = \"m\""}},
    {"MillimetresReadAsMetres",
     [](const Folder& f) { f.set("unit = \"mm\"", "unit = \"m\""); },
     2,
     "frame.unit",
     {"\"m\"", "frame.unit = \"mm\""}},
    {"CentimetresReadAsMillimetres",
     [](const Folder& f) {
       f.scale_meshes(0.1F);
       f.set("[ligaments]\nfibres = \"ligaments.csv\"\n", "");
     },
     0,
     "",
     {"\"mm\"", "frame.unit = \"cm\""}},
    {"OneMeshInAnotherUnit",
     [](const Folder& f) { f.scale_mesh("femur.stl", 0.001F); },
     2,
     "",
     {"frame.unit", "\"femur.stl\"", "mm", "m"}},
    {"FibresInMetres",
     [](const Folder& f) {
       f.one_fibre("slack_length_mm\nLCL1,LCL,-.002,0,.0415,-.015,-.0425,.044,2400,40\n");
     },
     2,
     "line 2, reference_mm",
     {"mm", "reference_x_m"}},
    {"CentreOfTheScanner",
     [](const Folder& f) { f.set("origin = [0, 0, 0]", "origin = [400, 200, -900]"); },
     0,
     "frame.origin",
     {"frame.origin = ["}},
    {"CentreInMillimetresWithMetres",
     [](const Folder& f) {
       f.scale_meshes(0.001F);
       f.set("unit = \"mm\"", "unit = \"m\"");
       f.set("origin = [0, 0, 0]", "origin = [0, 1.5, 0]");
     },
     0,
     "frame.origin",
     {"frame.origin = [-0.001, -0.0034, "}},
    {"CentreOfAnotherJoint",
     [](const Folder& f) {
       f.set("joint = \"knee\"", "joint = \"other\"");
       f.set("origin = [0, 0, 0]", "origin = [0, 430, 0]");
     },
     0,
     "frame.origin",
     {"frame.origin = ["}},
    {"AKneeThatIsOther",
     [](const Folder& f) { f.set("joint = \"knee\"", "joint = \"other\""); },
     0,
     "joint",
     {"\"other\"", "joint = \"knee\""}},
    {"AHipThatIsAKnee",
     [](const Folder& f) { f.set("name = \"femur\"\n[[", "name = \"pelvis\"\n[["); },
     0,
     "joint",
     {"\"knee\"", "joint = \"hip\""}},
    {"WrongProximalAxis",
     [](const Folder& f) {
       f.set("unit = \"mm\"", "unit = \"mm\"\nanterior = \"+Y\"\nproximal = \"+Z\"\nright = \"+X\"");
       f.set("[ligaments]\nfibres = \"ligaments.csv\"\n", "");
     },
     0,
     "",
     {"frame.proximal = \"+Y\""}},
    {"LeftHandedAxes",
     [](const Folder& f) { f.set("unit = \"mm\"", "right = \"-Z\""); },
     2,
     "frame",
     {"right = \"+Z\""}},
    {"BodiesExchanged",
     [](const Folder& f) {
       f.set("file = \"femur.stl\"", "file = \"x\"");
       f.set("file = \"tibia.stl\"", "file = \"femur.stl\"");
       f.set("file = \"x\"", "file = \"tibia.stl\"");
       f.set("name = \"tibia\"\nfile", "name = \"femur\"\nfile");
       f.set("[ligaments]\nfibres = \"ligaments.csv\"\n", "");
       for (const char* side : {"medial", "lateral"}) {
         const std::string name = "meniscus_" + std::string(side);
         f.set("[[moving.component]]\nname = \"" + name + "\"\nfile = \"" + name + ".stl\"\n", "");
       }
     },
     0,
     "",
     {"frame.proximal", "[reference]", "[moving]"}},
    {"WrongSide",
     [](const Folder& f) { f.set("side = \"right\"", "side = \"left\""); },
     0,
     "side",
     {"\"left\"", "side = \"right\""}},
    {"OneFileTwice",
     [](const Folder& f) { f.set("\"meniscus_lateral.stl\"", "\"meniscus_medial.stl\""); },
     0,
     "",
     {"moving.component.2.file", "\"meniscus_lateral\""}},
    {"PushTheWrongWay",
     [](const Folder& f) { f.set("delta = [0, 1, 0]", "delta = [0, -1, 0]"); },
     0,
     "push.delta",
     {"push.delta = [0, 1, 0]"}},
    {"StartWithinTheBone",
     [](const Folder& f) { f.set("[[moving", "initial = { translation_mm = [0, 10, 0] }\n[[moving"); },
     0,
     "moving.initial.translation_mm",
     {"moving.initial.translation_mm = [0"}},
    {"AFibreBesideItsBone",
     [](const Folder& f) { f.one_fibre("slack_length_mm\nLCL1,LCL,-2,0,80,-15,-42.5,44,2400,60\n"); },
     0,
     "",
     {"line 2, reference_mm", "femur", "20 mm"}},
    {"AFibreWithAWrongSign",
     [](const Folder& f) {
       std::string rows = "slack_length_mm\n";
       for (const char* z : {"40", "41", "-42"})
         rows += std::string("LCL") + z + ",LCL,-2,0," + z + ",-15,-42,40,900,55\n";
       f.one_fibre(rows);
     },
     0,
     "",
     {"line 4, reference_mm", "\"LCL\""}},
    {"AStrainOfNineTenths",
     [](const Folder& f) { f.one_fibre("reference_strain\n" + lcl + "0.9\n"); },
     0,
     "",
     {"line 2, reference_strain", "0.9", "reference_strain = 0.03"}},
    {"AStrainInPercent",
     [](const Folder& f) { f.one_fibre("reference_strain\n" + lcl + "3\n"); },
     2,
     "line 2, reference_strain",
     {"3", "0.03"}},
    {"ASlackLengthInCentimetres",
     [](const Folder& f) { f.one_fibre("slack_length_mm\n" + lcl + "4.2\n"); },
     0,
     "",
     {"line 2, slack_length_mm", "slack_length_mm ="}},
    {"AStiffnessPerMillimetre",
     [](const Folder& f) { f.one_fibre("slack_length_mm\nLCL1,LCL,-2,0,41.5,-15,-42.5,44,60,43\n"); },
     0,
     "",
     {"line 2, stiffness_n", "stiffness_n = 2580"}},
    {"AStepThatMissesTheEnd",
     [](const Folder& f) { f.set("step = 10", "step = 7"); },
     0,
     "grid.flexion",
     {"7", "90", "to = 84", "to = 91"}},
    {"AngleInRadians",
     [](const Folder& f) { f.set("to = 90, step = 10", "to = 1.57, step = 0.1570"); },
     0,
     "",
     {"grid.flexion", "to = 90"}},
    {"GeneratedMenisciAmongFiles",
     [](const Folder& f) {
       f.set("file = \"meniscus_medial.stl\"", "generate = { shape = \"knee\", part = \"meniscus_medial\" }");
     },
     0,
     "",
     {"moving.component.1 (\"meniscus_medial\")", "file = \"...\"", "generate"}},
    {"GeneratedLigamentsAmongFiles",
     [](const Folder& f) { f.set("fibres = \"ligaments.csv\"", "generate = { shape = \"knee\" }"); },
     0,
     "",
     {"ligaments.generate", "fibres = \"ligaments.csv\""}},
    {"NothingThatHoldsRotation",
     [](const Folder& f) { f.set("[ligaments]\nfibres = \"ligaments.csv\"\n", ""); },
     0,
     "ligaments",
     {"fibres = \"ligaments.csv\""}},
    {"LigamentsForTheSearch",
     [](const Folder& f) { f.set("[smooth]", "[solver]\nmethod = \"stability-search\"\n[smooth]"); },
     0,
     "ligaments",
     {"stability search"}},
    {"FreeVarusForTheSearch",
     [](const Folder& f) {
       f.set("varus = { from = -9, to = 9, step = 3 }", "varus = \"free\"");
       f.set("[smooth]", "[solver]\nmethod = \"stability-search\"\n[smooth]");
     },
     2,
     "grid.varus",
     {"\"free\"", "from", "to", "step"}},
    {"ADegreeForMoreAngles",
     [](const Folder& f) { f.set("degrees = [3]", "degrees = [8]"); },
     0,
     "smooth.degrees",
     {"8", "9"}},
    {"AMisspeltKey",
     [](const Folder& f) { f.set("[reference]\nname", "[reference]\nnmae"); },
     2,
     "reference.nmae",
     {"\"reference.name\""}},
    {"AMeshThatIsNotThere",
     [](const Folder& f) { f.set("femur.stl", "Femur.stl"); },
     2,
     "",
     {"reference.component.0.file", "Femur.stl"}},
    {"AMeshInsteadOfAJob",
     [](const Folder& f) { fs::copy_file(f.file("femur.stl"), f.job, fs::copy_options::overwrite_existing); },
     2,
     "my-knee.toml",
     {"wanted"}},
};

TEST(Newcomer, ASoundJobHasNoWarning)
{
  const Folder folder;
  const test::Ended ended = test::run_vrda({"check", folder.job.string()});
  EXPECT_EQ(ended.exit_code, 0) << ended.err;
  EXPECT_THAT(ended.out, testing::Not(test::warns("")));
}

class NewcomerMistake : public testing::TestWithParam<Mistake> {};

TEST_P(NewcomerMistake, IsAnsweredWithKeyAndRemedy)
{
  expect_answer(GetParam());
}

INSTANTIATE_TEST_SUITE_P(Each, NewcomerMistake, testing::ValuesIn(mistakes),
                         [](const auto& mistake) { return std::string(mistake.param.name); });

TEST(CheckPicture, IsAPngOfBothViewsAndLeavesOtherFilesAlone)
{
  const Folder folder;
  const std::string picture = folder.file("knee.png").string();
  const auto draw = [&](const std::vector<std::string>& more) {
    std::vector<std::string> words{"check", folder.job.string(), "--picture", picture};
    words.insert(words.end(), more.begin(), more.end());
    EXPECT_EQ(test::run_vrda(words).exit_code, 0);
    return test::read_bytes(picture);
  };
  const std::string first = draw({});
  EXPECT_EQ(first.substr(0, 4), "\x89PNG");
  EXPECT_EQ(first.substr(16, 8), std::string("\0\0\x06\x40\0\0\x03\xe8", 8));  // 1600 x 1000
  EXPECT_EQ(draw({}), first);
  EXPECT_NE(draw({"--set", "frame.origin=[0, 300, 0]"}), first);
  EXPECT_NE(draw({"--set", "side=left"}), first);
  EXPECT_NE(draw({"--set", "push.delta=[1, 0, 0]"}), first);
  const test::Ended refused =
      test::run_vrda({"check", folder.job.string(), "--picture", folder.job.string()});
  EXPECT_THAT(refused, test::refuses({"my-knee.toml", "", "PNG"}));
  EXPECT_EQ(test::text_of(folder.job), sound_job);
}

}  // namespace vrda::newcomer_test
