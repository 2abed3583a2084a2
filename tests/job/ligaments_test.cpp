#include <gmock/gmock.h>

#include "job/case.hpp"
#include "job/job.hpp"
#include "job/ligament_files.hpp"
#include "job/mesh_text.hpp"
#include "support/meshes.hpp"
#include "support/real_knees.hpp"
#include "support/refusal.hpp"
#include "support/scratch.hpp"

namespace vrda::ligaments_test {

using test::refuses;

const std::string header =
    "name,femur_x_mm,femur_y_mm,femur_z_mm,tibia_x_mm,tibia_y_mm,tibia_z_mm,stiffness_n_per_strain,"
    "slack_length_mm,wrap\n";

std::string one_wrap(const std::string& changed_key = "", const std::string& value = "")
{
  std::map<std::string, std::string> keys{
      {"name", "\"Round\""},        {"type", "\"WrapEllipsoid\""}, {"body", "\"tibia_proximal_r\""},
      {"translation", "\"1 2 3\""}, {"quadrant", "\"all\""},       {"xyz_body_rotation", "\"0 0 0\""},
      {"unit", "\"mm\""},           {"dimensions", "\"30 18 12\""}};
  if (!changed_key.empty()) keys[changed_key] = value;
  std::string text;
  for (const auto& [key, json] : keys) {
    if (!json.empty()) text += (text.empty() ? "\"" : ",\"") + key + "\":" + json;
  }
  return "[{" + text + "}]";
}

// Two boxes 20 mm apart, with a table and a wrap.
struct Folder : test::JobFolder {
  explicit Folder(const std::string& table, const std::string& wraps = one_wrap(),
                  const std::string& head = "joint = \"other\"\n",
                  const std::string& tail = "[ligaments]\nfibres = \"fibres.csv\"\nwraps = \"wraps.json\"\n")
      : JobFolder(test::small_job(head, tail))
  {
    scratch.write("fibres.csv", table);
    scratch.write("wraps.json", wraps);
  }
};

TEST(LigamentTable, columns)
{
  const std::string table =
      "# a comment\r\n\r\nwrap, slack_length_m "
      ",stiffness_n,moving_z_mm,moving_y_mm,moving_x_mm,reference_x_m,"
      "reference_y_cm,reference_z_mm,bundle,name\r\n ,0.03,1e3,6,5,4,0.001,0.2,3,,ACLam_12\r\n#\n"
      "Round,.04,+800,6,5,4,0.001,0.2,3,MCL,x";
  const std::vector<job::FibreJob> fibres = job::read_ligament_table("f.csv", table);
  ASSERT_EQ(fibres.size(), 2U);
  EXPECT_EQ(fibres[0].name, "ACLam_12");
  EXPECT_EQ(fibres[0].bundle, "");
  EXPECT_LT((fibres[0].reference_native_mm - Eigen::Vector3d(1, 2, 3)).norm(), 1e-15);
  EXPECT_EQ(fibres[0].moving_native_mm, Eigen::Vector3d(4, 5, 6));
  EXPECT_EQ(fibres[0].stiffness_n, 1000.0);
  EXPECT_EQ(fibres[0].slack_length_mm, 30.0);
  EXPECT_EQ(fibres[1].bundle, "MCL");
  EXPECT_EQ(fibres[1].wrap, "Round");
  EXPECT_EQ(fibres[1].field, "line 6");
}

struct BadTable {
  std::string table, field, found = {}, wanted = {};
};

TEST(LigamentTableErrors, NameTheLineAndTheColumn)
{
  const std::string row = "a,0,35,0,0,5,0,1000,30,\n";
  const auto replaced = [](std::string text, const std::string& from, const std::string& to) {
    return text.replace(text.find(from), from.size(), to);
  };
  for (const BadTable& bad : {
           BadTable{replaced(header, "stiffness_n", "stifness_n") + row, "line 1",
                    "\"stifness_n_per_strain\"", "\"stiffness_n_per_strain\""},
           {replaced(header, "femur_y_mm", "femur_y"), "line 1", "\"femur_y\"", "\"femur_y_m"},
           {replaced(header, "wrap", "ax"), "line 1", "\"ax\"", "reference_x_mm"},
           {replaced(header, "femur_y_mm,", "") + row, "line 1, reference_y_mm"},
           {replaced(header, "stiffness_n_per_strain,", ""), "line 1, stiffness_n_per_strain"},
           {replaced(header, "slack_length_mm,", ""), "line 1, slack_length_mm", "", "reference_strain"},
           {replaced(header, "wrap", "reference_x_cm") + row, "line 1, reference_x_cm", "femur_x_mm"},
           {header + replaced(row, "1000", "-5"), "line 2, stiffness_n_per_strain", "-5", "0"},
           {header + replaced(row, "1000", "0"), "line 2, stiffness_n_per_strain", "0", "0"},
           {header + replaced(row, "30", "0"), "line 2, slack_length_mm", "0", "0"},
           {header + replaced(row, "30", "nan"), "line 2, slack_length_mm", "\"nan\""},
           {replaced(header, "slack_length_mm", "slack_length_m") + replaced(row, "30", "1e306"),
            "line 2, slack_length_m", "\"1e306\""},
           {header + replaced(row, "35", "3S"), "line 2, femur_y_mm", "\"3S\""},
           {header + replaced(row, "35", ""), "line 2, femur_y_mm", "nothing"},
           {header + replaced(row, "35,", ""), "line 2", "9", "10"},
           {header + replaced(row, "30", ""), "line 2", "neither", "slack_length_mm"},
           {header + replaced(row, "a", ""), "line 2, name", "nothing"},
           {header, "line 1"},
           {"# nothing\n", "", "no line"},
       }) {
    SCOPED_TRACE(bad.table);
    const InputError::Facts facts = test::input_error([&] { job::read_ligament_table("f.csv", bad.table); });
    EXPECT_THAT(facts, refuses({"f.csv", bad.field, bad.found, bad.wanted}));
  }
}

TEST(LigamentTableErrors, BothALengthAndAStrainOrAStrainOutOfRange)
{
  const std::string both =
      "name,femur_x_mm,femur_y_mm,femur_z_mm,tibia_x_mm,tibia_y_mm,tibia_z_mm,stiffness_n,"
      "slack_length_mm,reference_strain\n";
  const auto facts_of_row = [&](const std::string& row) {
    return test::input_error([&] { job::read_ligament_table("f.csv", both + row); });
  };
  EXPECT_THAT(facts_of_row("a,0,0,0,0,0,0,1,30,0.02"), refuses({.field = "line 2", .found = "both"}));
  EXPECT_THAT(facts_of_row("a,0,0,0,0,0,0,1,,-1"),
              refuses({.field = "line 2, reference_strain", .wanted = "-1"}));
  EXPECT_EQ(job::read_ligament_table("f.csv", both + "a,0,0,0,0,0,0,1,,-0.5\nb,0,0,0,0,0,0,1,30,").size(),
            2U);
}

TEST(Wraps, terms_of_opensim)
{
  const std::string text = R"([
    {"name": "C", "type": "WrapCylinder", "body": "femur_distal_r", "xyz_body_rotation": "0.1 0.2 0.3",
     "translation": "-0.004 0.003 0", "quadrant": "all", "radius": "0.018", "length": "0.5"},
    {"name": "E", "type": "WrapEllipsoid", "body": "shin", "xyz_body_rotation": [0, 0, 0],
     "translation": [1, 2, 3], "dimensions": [3, 2, 1], "unit": "cm"}])";
  const std::vector<model::Wrap> wraps = job::read_wraps("w.json", text, {"thigh", "shin"});
  ASSERT_EQ(wraps.size(), 2U);
  EXPECT_EQ(wraps[0].body, model::WrapBody::reference);
  EXPECT_EQ(wraps[0].shape, model::WrapShape::cylinder);
  EXPECT_LT((wraps[0].radii_mm - Eigen::Vector3d(18, 18, 250)).norm(), 1e-12);
  EXPECT_LT((wraps[0].X_body_wrap.translation() - Eigen::Vector3d(-4, 3, 0)).norm(), 1e-15);
  EXPECT_EQ(Eigen::Matrix3d(wraps[0].X_body_wrap.linear()),
            Eigen::Matrix3d(rotation_x(0.1) * rotation_y(0.2) * rotation_z(0.3)));
  EXPECT_EQ(wraps[1].body, model::WrapBody::moving);
  EXPECT_EQ(wraps[1].radii_mm, Eigen::Vector3d(30, 20, 10));
}

TEST(WrapErrors, NameTheWrapAndTheKey)
{
  struct Row {
    std::string text, field, found = {}, wanted = {};
  };
  const std::string twice = one_wrap();
  for (const Row& bad : {
           Row{"[{", "", "invalid JSON"},
           {"[]", "", "[]", "1"},
           {"{}", "", "{}"},
           {"[3]", "wrap.0", "3"},
           {std::string(1000000, '['), "", "1000000 nested keys, lists or tables"},
           {"[{\"name\": 1e999}]", "", "beyond the range"},
           {twice.substr(0, twice.size() - 1) + "," + twice.substr(1), "wrap.1.name"},
           {one_wrap("type", "\"WrapTorus\""), "wrap.0.type", "WrapTorus", "WrapCylinder"},
           {one_wrap("body", "\"pelvis\""), "wrap.0.body", "pelvis", "\"tibmen\""},
           {one_wrap("dimensions", "\"30 0 12\""), "wrap.0.dimensions.1", "0", "0"},
           {one_wrap("dimensions", "[30, 2, 12]"), "wrap.0.dimensions", "30"},
           {one_wrap("dimensions", "\"30 12\""), "wrap.0.dimensions", "[30, 12]"},
           {one_wrap("dimensions", ""), "wrap.0.dimensions", "nothing"},
           {one_wrap("translation", "[1, 2, 1e7]"), "wrap.0.translation.2", "1e+07"},
           {one_wrap("translation", "\"1 b 3\""), "wrap.0.translation", "1"},
           {one_wrap("xyz_body_rotation", "null"), "0.xyz_body_rotation", "null"},
           {one_wrap("quadrant", "\"+x\""), "wrap.0.quadrant", "+x", "\"all\""},
           {one_wrap("unit", "\"inch\""), "wrap.0.unit", "inch", "\"mm\""},
           {one_wrap("name", "\"\""), "wrap.0.name", "\"\""},
           {one_wrap("dimension", "1"), "wrap.0.dimension", "", "\"dimensions\""},
           {one_wrap("type", "\"WrapCylinder\""), "wrap.0.radius", "nothing", "WrapCylinder"},
           {one_wrap("radius", "5"), "wrap.0.radius", "", "WrapEllipsoid"},
       }) {
    SCOPED_TRACE(bad.text);
    const InputError::Facts facts = test::input_error([&] {
      job::read_wraps("w.json", bad.text, {"femur", "tibmen"});
    });
    EXPECT_THAT(facts, refuses({"w.json", bad.field, bad.found, bad.wanted}));
  }
}

TEST(WrapErrors, ARadiusOfZero)
{
  const std::string text =
      R"([{"name": "C", "type": "WrapCylinder", "body": "femur", "radius": "0", "length": 1,
    "xyz_body_rotation": "0 0 0", "translation": [0, 0, 0]}])";
  EXPECT_THAT(test::input_error([&] {
                job::read_wraps("w.json", text, {"a", "b"});
              }),
              refuses({.field = "wrap.0.radius", .found = "0"}));
}

TEST(CaseLigaments, axes_of_the_frame)
{
  // The meshes are in metres with Z up; the table is in mm.
  const Folder folder(header + "a1,1,2,30,4,5,6,1000,30,Round\n",
                      one_wrap("xyz_body_rotation", "[0, 0, 0.5]"),
                      "joint = \"other\"\n[frame]\nunit = \"m\"\nanterior = \"-Y\"\nproximal = \"+Z\"\n"
                      "right = \"-X\"\nalign = { translation_mm = [10, 0, 0] }\n");
  folder.scratch.write("reference.stl", test::binary_stl(test::box({0, 0, 0.04}, {0.06, 0.08, 0.02})));
  folder.scratch.write("moving.stl", test::binary_stl(test::box({0, 0, 0}, {0.05, 0.07, 0.02})));
  const model::Ligaments ligaments = folder.load().ligaments;
  ASSERT_EQ(ligaments.fibres.size(), 1U);
  const model::Fibre& fibre = ligaments.fibres[0];
  EXPECT_EQ(fibre.reference_mm, Eigen::Vector3d(-2, 30, -11));
  EXPECT_EQ(fibre.moving_mm, Eigen::Vector3d(-5, 6, -14));
  EXPECT_EQ(fibre.bundle, "a");
  EXPECT_EQ(fibre.wrap, 0);
  const Pose& X = ligaments.wraps.at(0).X_body_wrap;
  EXPECT_EQ(Eigen::Vector3d(X.translation()), Eigen::Vector3d(-2, 3, -11));
  // The wrap's own Z stays up.
  EXPECT_EQ(Eigen::Vector3d(X.linear().col(2)), Eigen::Vector3d(0, 1, 0));
}

TEST(CaseLigaments, reference_strain)
{
  std::string strains = header;
  strains.replace(strains.find("slack_length_mm"), 15, "reference_strain");
  const Folder folder(strains + "a,0,35,0,0,5,0,1000,0.25,\nb,0,25,10,0,-25,10,1000,-0.2,Round\n");
  const job::Case loaded = folder.load();
  EXPECT_DOUBLE_EQ(loaded.ligaments.fibres[0].slack_length_mm, 24.0);
  const std::vector<model::FibreState> states = model::fibre_states(loaded.ligaments, {}, {});
  EXPECT_TRUE(states[1].is_wrapped);
  EXPECT_NEAR(states[0].strain, 0.25, 1e-14);
  EXPECT_NEAR(states[1].strain, -0.2, 1e-14);
}

TEST(CaseLigaments, inline_fibres)
{
  const job::Case from_table = Folder(header + "a1,0,35,0,0,5,0,1000,30,Round\n").load();
  const std::string fibre =
      "[ligaments]\nwraps = \"wraps.json\"\n[[ligaments.fibre]]\nname = \"a1\"\nreference_mm = [0, 35, 0]\n"
      "moving_mm = [0, 5, 0]\nstiffness_n = 1000\nslack_length_mm = 30\nwrap = \"Round\"\n";
  const job::Case inline_case = Folder("", one_wrap(), "joint = \"other\"\n", fibre).load();
  const model::Fibre& a = from_table.ligaments.fibres.at(0);
  const model::Fibre& b = inline_case.ligaments.fibres.at(0);
  EXPECT_EQ(a.name + a.bundle, b.name + b.bundle);
  EXPECT_EQ(a.reference_mm, b.reference_mm);
  EXPECT_EQ(a.moving_mm, b.moving_mm);
  EXPECT_EQ(a.slack_length_mm, b.slack_length_mm);
  EXPECT_EQ(a.wrap, b.wrap);
}

TEST(CaseLigaments, generated)
{
  const test::Scratch scratch;
  const std::string job =
      scratch
          .write("job.toml",
                 "[[reference.component]]\nname = \"femur\"\ngenerate = { shape = \"knee\", "
                 "part = \"femur\" }\n[[moving.component]]\nname = \"tibia\"\ngenerate = { "
                 "shape = \"knee\", part = \"tibia\" }\n[ligaments]\ngenerate = { shape = "
                 "\"knee\" }\n")
          .string();
  const job::Case right = job::load_case(job),
                  left = job::load_case(job, {"", {"side=left", "frame.unit=m"}});
  ASSERT_FALSE(right.ligaments.fibres.empty());
  ASSERT_EQ(right.ligaments.fibres.size(), left.ligaments.fibres.size());
  for (std::size_t i = 0; i < right.ligaments.fibres.size(); ++i) {
    const Eigen::Vector3d m(1, 1, -1);
    EXPECT_EQ(left.ligaments.fibres[i].reference_mm,
              Eigen::Vector3d(m.cwiseProduct(right.ligaments.fibres[i].reference_mm)));
    EXPECT_EQ(left.ligaments.fibres[i].slack_length_mm, right.ligaments.fibres[i].slack_length_mm);
  }
  EXPECT_EQ(right.inputs.back().name, "knee side=right ligaments");
  EXPECT_THAT(test::input_error([&] {
                job::load_case(job, {"", {"ligaments.generate.shape=hip"}});
              }),
              refuses({.field = "ligaments.generate"}));
}

TEST(CaseLigaments, GeneratedOnesAwayFromOtherBonesAreRefusedWithTheirKey)
{
  const test::JobFolder folder(test::small_job("", "[ligaments]\ngenerate = { shape = \"knee\" }\n"),
                               test::box({0, 300, 0}, {60, 40, 80}), test::box({0, 250, 0}, {60, 40, 80}));
  EXPECT_THAT(folder.refused(),
              refuses({.field = "ligaments.generate", .found = "generated", .wanted = "ligaments.csv"}));
}

TEST(CaseLigamentErrors, NameFileAndLine)
{
  const std::string good = "a,0,35,0,0,5,0,1000,30,\n";
  EXPECT_THAT(Folder(header + good + "b,0,35,0,0,5,0,1000,30,\n" + good).refused(),
              refuses({"fibres.csv", "line 4, name", "\"a\""}));
  EXPECT_THAT(Folder(header + "a,0,35,0,0,5,0,1000,30,Rund\n").refused(),
              refuses({.field = "line 2, wrap", .wanted = "\"Round\""}));
  // Metres read as millimetres times a thousand.
  std::string metres = header;
  metres.replace(metres.find("tibia_y_mm"), 10, "tibia_y_m");
  for (const char* found : {"\"a\"", "(0, 5000, 0)"})
    EXPECT_THAT(Folder(metres + good).refused(), refuses({"", "line 2, moving_mm", found, "35 mm"}));
  EXPECT_EQ(Folder(header + "a,0,95,0,0,5,0,1000,30,\n").refused().field, "line 2, reference_mm");
  std::string strains = header;
  strains.replace(strains.find("slack_length_mm"), 15, "reference_strain");
  EXPECT_THAT(Folder(strains + "a,0,20,0,0,20,0,1000,0,\n").refused(),
              refuses({.field = "line 2, reference_strain"}));
}

TEST(CaseLigamentErrors, InlineFibresNameTheirKey)
{
  const auto facts_with = [](const std::string& changed) {
    const std::string fibre =
        "{name=\"a\",reference_mm=[0,35,0],moving_mm=[0,5,0],stiffness_n=1" + changed + "}";
    return test::JobFolder(test::small_job("joint = \"other\"\n", "[ligaments]\nfibre = [" + fibre + "]\n"))
        .refused();
  };
  EXPECT_EQ(facts_with("").field, "ligaments.fibre.0");
  EXPECT_THAT(facts_with(",slack_length_mm=1,reference_strain=0"),
              refuses({.field = "ligaments.fibre.0", .found = "both"}));
  EXPECT_EQ(facts_with(",slack_length_mm=0").field, "ligaments.fibre.0.slack_length_mm");
  EXPECT_EQ(facts_with(",slack_length_mm=1,wrap=\"x\"").field, "ligaments.fibre.0.wrap");
}

TEST(RealKnees, ligaments_of_smith2019)
{
  VRDA_REQUIRE_REAL_KNEES();
  const std::string folder = "knees/jam-smith2019/";
  const job::Case loaded = job::load_case(
      (test::source_directory() / "jobs/knee-jam-smith2019.toml").string(),
      {test::data_directory()->string(),
       {"ligaments.fibres=\"" + folder + "ligaments.csv\"", "ligaments.wraps=\"" + folder + "wraps.json\""}});
  ASSERT_EQ(loaded.ligaments.fibres.size(), 55U);
  // Attachments are in mm of the frame that the meshes have in m.
  EXPECT_EQ(loaded.ligaments.fibres[0].reference_mm, Eigen::Vector3d(-1.7455, -0.45737, -37.269));
  // The source chose slack lengths so that strains are whole percents at this pose, by OpenSim's own
  // wrapping (its ellipsoids by segments) and six digits.
  constexpr double source_digits = 3e-5;
  int n_wrapped = 0;
  for (const model::FibreState& state : model::fibre_states(loaded.ligaments, {}, {})) {
    EXPECT_NEAR(100.0 * state.strain, std::round(100.0 * state.strain), 100.0 * source_digits);
    n_wrapped += state.is_wrapped;
  }
  EXPECT_EQ(n_wrapped, 16);
}

}  // namespace vrda::ligaments_test
