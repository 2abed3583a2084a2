#include <gmock/gmock.h>

#include "job/case.hpp"
#include "job/job.hpp"
#include "job/ligament_files.hpp"
#include "job/mesh_text.hpp"
#include "support/meshes.hpp"
#include "support/real_knees.hpp"
#include "support/refusal.hpp"
#include "support/scratch.hpp"

namespace vrda::case_test {

using test::refuses;
using testing::ElementsAre;

Mesh lower()
{
  return test::box({0, 0, 0}, {50, 20, 70});
}

using Folder = test::JobFolder;

TEST(Case, TwoBoxesArriveWhole)
{
  const Folder folder;
  const job::Case loaded = folder.load();
  EXPECT_EQ(loaded.joint, "other");
  EXPECT_EQ(loaded.method, "equilibrium");
  EXPECT_EQ(loaded.reference.contact.mesh.triangles.rows(), 12);
  EXPECT_EQ(loaded.reference.contact.component, std::vector<std::int32_t>(12, 0));
  EXPECT_EQ(loaded.reference.visual.mesh.triangles.rows(), 0);
  EXPECT_EQ(loaded.moving.components.at(0).name, "lower");
  EXPECT_EQ(loaded.frame.delta, Eigen::Vector3d::UnitY());
  EXPECT_EQ(loaded.grid.flexion_deg.size(), 91U);
  EXPECT_TRUE(loaded.compartment_of_triangle.empty());
  ASSERT_EQ(loaded.survey.size(), 2U);
  EXPECT_EQ(loaded.survey[0].n_welded, 28);
  EXPECT_EQ(loaded.survey[0].source, "reference.stl");
  EXPECT_DOUBLE_EQ(loaded.survey[0].volume_mm3, 96000.0);
  EXPECT_DOUBLE_EQ(loaded.survey[0].area_mm2, 2.0 * (1200 + 1600 + 4800));
  EXPECT_EQ(loaded.job_text, test::read_bytes(folder.job));
  ASSERT_EQ(loaded.inputs.size(), 2U);
  EXPECT_EQ(loaded.inputs[1].name, "moving.stl");
  EXPECT_EQ(loaded.inputs[1].sha256, job::sha256_of(test::binary_stl(lower())));
  EXPECT_THAT(loaded.warnings, ElementsAre(testing::HasSubstr("nearly free")));
}

TEST(Case, AnotherJointStartsFromTheMeshesJustBeforeContact)
{
  const Folder folder;
  const auto start = [&](const std::vector<std::string>& overrides) {
    return folder.load(overrides).initial.translation_mm;
  };
  const auto is_near = [](const Eigen::Vector3d& found_mm, const Eigen::Vector3d& wanted_mm) {
    return (found_mm - wanted_mm).norm() < 1e-12;  // rounding of lengths of 20 mm
  };
  // The boxes are 20 mm apart along Y, 25 mm along (3, 4, 0); 0.1 mm remain.
  EXPECT_TRUE(is_near(start({}), {0, 19.9, 0}));
  EXPECT_TRUE(is_near(start({"joint=ankle"}), {0, 19.9, 0}));
  EXPECT_TRUE(is_near(start({"push.delta={flexion_deg=[0, 90], value=[[3, 4, 0], [0, 1, 0]]}"}),
                      24.9 * Eigen::Vector3d(0.6, 0.8, 0)));
  EXPECT_TRUE(is_near(start({"moving.component.0.shift_mm=[0, 25, 0]"}), {0, -5.1, 0})) << "overlap";
  EXPECT_EQ(start({"push.delta=[0, -1, 0]"}).norm(), 0.0) << "nothing ahead";
  EXPECT_EQ(start({"push.delta=[0, 0, -2]", "moving.initial.translation_mm=[1, 2, 3]"}),
            Eigen::Vector3d(1, 2, 3));
  EXPECT_EQ(start({"joint=knee", "push.delta=[0, 0, -2]"}), Eigen::Vector3d(0, -20, 0));
  EXPECT_EQ(start({"joint=knee", "moving.initial.translation_mm=auto"}), start({}));
  EXPECT_THAT(folder.load().resolved_job, testing::HasSubstr("translation_mm = \"auto\""));
}

TEST(Case, APushFixedInTheReferenceTurnsWithIt)
{
  const Folder folder;
  const auto pushed = [&](const std::string& side, const std::string& coordinates) {
    return folder
        .load({"joint=hip", "push.delta=[0, 0.6, 0.8]", "push.force_n=10", "side=" + side,
               "coordinates={" + coordinates + "}"})
        .push;
  };
  // A quarter of a turn about Z takes the thigh backwards: its X points distally in the pelvis.
  const std::vector<job::Push> bent =
      pushed("right", "flexion={from=0, to=90, step=90}, varus=0, internal=0");
  ASSERT_EQ(bent.size(), 2U);
  EXPECT_TRUE(bent[0].delta.isApprox(Eigen::Vector3d(0, 0.6, 0.8), 1e-15));
  EXPECT_TRUE(bent[1].delta.isApprox(Eigen::Vector3d(-0.6, 0, 0.8), 1e-15));
  EXPECT_TRUE(bent[1].force_n.isApprox(Eigen::Vector3d(-6, 0, 8), 1e-15));
  // Internal rotation takes X to the left on a right side, to the right on a left one.
  const std::string turned = "flexion={from=0, to=1, step=1}, varus=0, internal=90";
  EXPECT_TRUE(pushed("right", turned)[0].delta.isApprox(Eigen::Vector3d(-0.8, 0.6, 0), 1e-15));
  EXPECT_TRUE(pushed("left", turned)[0].delta.isApprox(Eigen::Vector3d(0.8, 0.6, 0), 1e-15));
}

TEST(Case, Sha256IsTheStandards)
{
  // FIPS 180-2, appendix B.1.
  EXPECT_EQ(job::sha256_of("abc"), "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad");
}

TEST(Case, UnitAxesAndOriginApplyToEverything)
{
  const Folder folder(
      test::small_job("joint = \"other\"\n[frame]\nunit = \"cm\"\nanterior = \"-Y\"\nproximal = "
                      "\"+Z\"\nright = \"-X\"\norigin = [1, 2, 3]\n"));
  const job::Case loaded = folder.load();
  EXPECT_EQ(loaded.frame.rotation_centre_mm, Eigen::Vector3d(-20, 30, -10));
  // Native x -30..30, y 30..50, z -40..40 cm.
  EXPECT_EQ(loaded.survey[0].box.min_mm, Eigen::Vector3d(-500, -400, -300));
  EXPECT_EQ(loaded.survey[0].box.max_mm, Eigen::Vector3d(-300, 400, 300));
}

TEST(Case, DrawnComponentsGoToTheVisualPart)
{
  const Folder folder(test::small_job("joint = \"other\"\n", R"(
[[moving.component]]
name = "drawn"
file = "reference.stl"
material = "shaft"
contact = false
[[moving.component]]
name = "third"
file = "moving.stl"
)"));
  const job::Case loaded = folder.load();
  EXPECT_EQ(loaded.moving.contact.mesh.triangles.rows(), 24);
  EXPECT_EQ(loaded.moving.visual.mesh.triangles.rows(), 12);
  EXPECT_EQ(loaded.moving.visual.component, std::vector<std::int32_t>(12, 1));
  EXPECT_EQ(loaded.moving.contact.component.back(), 2);
  EXPECT_EQ(loaded.moving.components[1].material, "shaft");
  EXPECT_EQ(loaded.moving.contact.mesh.normals.rows(), loaded.moving.contact.mesh.vertices_mm.rows());
}

// A tetrahedron as Vertices-Faces; of the four normals of its file one points inward.
TEST(Case, TheNormalsFileOfAVerticesFacesMeshIsRead)
{
  const Folder folder(test::small_job("joint = \"other\"\n", R"(
[[moving.component]]
name = "third"
file = "third.vf"
)"));
  folder.scratch.write("third.vf", "4 4\n0 0 0\n4 0 0\n0 4 0\n0 0 4\n3 0 2 1\n3 0 1 3\n3 0 3 2\n3 1 2 3\n");
  folder.scratch.write("third.normals", "4\n-1 -1 -2\n2 0 0\n0 3 0\n0 0 -4\n");
  const job::Case loaded = folder.load();
  const Mesh& mesh = loaded.moving.contact.mesh;
  for (Eigen::Index v = mesh.vertices_mm.rows() - 4; v < mesh.vertices_mm.rows(); ++v) {
    // The file's order is not kept; its last normal points inward.
    const Eigen::RowVector3d p = mesh.vertices_mm.row(v);
    const Eigen::RowVector3d expected = p.isZero() ? Eigen::RowVector3d(-1, -1, -2).normalized() : p / 4.0;
    EXPECT_LT((mesh.normals.row(v) - expected).norm(), 1e-12) << p;
  }
  EXPECT_EQ(loaded.inputs[2].name, "third.vf");
  EXPECT_EQ(loaded.inputs[3].name, "third.normals");
}

TEST(Case, AComponentMayBeThinnedAndShifted)
{
  // Each vertex moves along its area-weighted normal.
  const Folder plain,
      moved(test::small_job("joint = \"other\"\n") + "inset_mm = 0.5\nshift_mm = [1, -2, 3]\n");
  const Mesh before = plain.load().moving.contact.mesh, after = moved.load().moving.contact.mesh;
  const Points normals = vertex_normals(before);
  ASSERT_EQ(before.vertices_mm.rows(), after.vertices_mm.rows());
  for (Eigen::Index v = 0; v < before.vertices_mm.rows(); ++v) {
    const Eigen::RowVector3d wanted =
        before.vertices_mm.row(v) - 0.5 * normals.row(v) + Eigen::RowVector3d(1, -2, 3);
    EXPECT_LT((after.vertices_mm.row(v) - wanted).norm(), 1e-12) << v;
    EXPECT_NEAR(normals.row(v).norm(), 1.0, 1e-12);
  }
  EXPECT_LT(signed_volume_mm3(after), signed_volume_mm3(before));
}

TEST(Case, TheDataFolderComesBeforeTheJobsOwn)
{
  const Folder folder;
  const test::Scratch data;
  data.write("moving.stl", test::binary_stl(test::box({0, 0, 0}, {10, 10, 10})));
  const job::Case loaded = job::load_case(folder.job, {data.path().string(), {}});
  EXPECT_DOUBLE_EQ(loaded.survey[0].volume_mm3, 96000.0);
  EXPECT_DOUBLE_EQ(loaded.survey[1].volume_mm3, 1000.0);
  EXPECT_EQ(loaded.resolved_job, folder.load().resolved_job);
}

int count(const job::Case& loaded, Compartment which)
{
  return static_cast<int>(
      std::count(loaded.compartment_of_triangle.begin(), loaded.compartment_of_triangle.end(), which));
}

TEST(Compartments, AKneesAreHalfSpacesByTheRotationCentre)
{
  const Folder folder(test::small_job());
  const job::Case right = folder.load();
  ASSERT_EQ(right.compartment_of_triangle.size(), 12U);
  for (Eigen::Index t = 0; t < 12; ++t) {
    const auto [a, b, c] = corners(right.moving.contact.mesh, t);
    const double z_mm = a.z() + b.z() + c.z();
    EXPECT_EQ(right.compartment_of_triangle[static_cast<std::size_t>(t)],
              z_mm < 0 ? Compartment::medial : Compartment::lateral);
  }
  EXPECT_EQ(count(right, Compartment::medial), 6);
  const job::Case left = folder.load({"side=left"});
  EXPECT_EQ(count(left, Compartment::lateral), 6);
  EXPECT_NE(left.compartment_of_triangle, right.compartment_of_triangle);
  // The whole moving box is to the left of a centre at z = 100.
  EXPECT_EQ(count(folder.load({"frame.origin=[0, 0, 100]"}), Compartment::medial), 12);
}

TEST(Compartments, ByNamesAndByNamesBeforeHalfSpaces)
{
  const std::string tail = "[[moving.component]]\nname = \"disc\"\nfile = \"reference.stl\"\n";
  const Folder folder(test::small_job("joint = \"other\"\n", tail));
  const job::Case named = folder.load(
      {"compartments.medial.components=[\"lower\"]", "compartments.lateral.components=[\"disc\"]"});
  EXPECT_EQ(count(named, Compartment::medial), 12);
  EXPECT_EQ(count(named, Compartment::lateral), 12);
  const job::Case mixed =
      folder.load({"compartments.medial.components=[\"lower\"]", "compartments.lateral.half_space=left"});
  EXPECT_EQ(count(mixed, Compartment::medial), 12);
  EXPECT_EQ(count(mixed, Compartment::lateral), 6);
  EXPECT_EQ(count(mixed, Compartment::none), 6);
}

TEST(Case, APushOverFlexionIsLinearBetweenItsRowsAndHeldBeyond)
{
  const Folder folder;
  const job::Case loaded =
      folder.load({"solver.method=equilibrium", "grid.flexion={ from = 0, to = 90, step = 30 }",
                   "grid.varus=free", "push.delta={ flexion_deg = [30, 60], value = [[0, 1, 0], [1, 1, 0]] }",
                   "push.force_n={ flexion_deg = [0, 90], value = [10, 40] }", "push.lateral_force_n=[3, -4]",
                   "push.moment_nmm={ flexion_deg = [60, 90], value = [-7, 8] }", "push.varus_moment_nmm=9"});
  ASSERT_EQ(loaded.push.size(), 4U);
  EXPECT_TRUE(loaded.is_varus_free);
  EXPECT_EQ(loaded.method, "equilibrium");
  const double half = std::sqrt(0.5);
  for (const std::size_t i : {0U, 1U}) EXPECT_EQ(loaded.push[i].delta, Eigen::Vector3d::UnitY());
  for (const std::size_t i : {2U, 3U})
    EXPECT_LT((loaded.push[i].delta - Eigen::Vector3d(half, half, 0)).norm(), 1e-15);
  EXPECT_LT((loaded.push[1].force_n - Eigen::Vector3d(3, 20, -4)).norm(), 1e-12);
  // The lateral force is across Delta: half-way to anterior its first axis points half-way down.
  EXPECT_LT((loaded.push[3].force_n - Eigen::Vector3d(43 * half, 37 * half, -4)).norm(), 1e-12);
  EXPECT_EQ(loaded.push[0].moment_nmm, -7.0);
  EXPECT_EQ(loaded.push[2].moment_nmm, -7.0);
  EXPECT_EQ(loaded.push[3].moment_nmm, 8.0);
  EXPECT_EQ(loaded.push[3].varus_moment_nmm, 9.0);
}

std::string generated_job(const std::string& shape, const std::string& upper_part,
                          const std::string& lower_part)
{
  return "joint = \"other\"\n[[reference.component]]\nname = \"a\"\ngenerate = { shape = \"" + shape +
         "\", part = \"" + upper_part + "\" }\n[[moving.component]]\nname = \"b\"\ngenerate = { shape = \"" +
         shape + "\", part = \"" + lower_part + "\" }\n";
}

TEST(Generated, PartsAreFoundByNameAndHashedByContent)
{
  const Folder folder(generated_job("knee", "femur", "tibia"));
  const job::Case loaded = folder.load(), left = folder.load({"side=left"});
  EXPECT_EQ(loaded.inputs[1].name, "knee side=right part=tibia");
  EXPECT_EQ(left.inputs[1].name, "knee side=left part=tibia");
  EXPECT_EQ(loaded.inputs[1].sha256.size(), 64U);
  EXPECT_NE(loaded.inputs[1].sha256, left.inputs[1].sha256);
  EXPECT_NE(loaded.inputs[1].sha256, loaded.inputs[0].sha256);
  EXPECT_EQ(loaded.survey[0].n_boundary_edges, 0);
}

TEST(Generated, SkipTheFramesUnitAndAxes)
{
  const Folder folder(generated_job("hip", "socket", "head"));
  const job::Case plain = folder.load();
  const job::Case framed =
      folder.load({"frame.unit=m", "frame.anterior=+Y", "frame.proximal=+Z", "frame.right=+X"});
  EXPECT_EQ(plain.reference.contact.mesh.vertices_mm, framed.reference.contact.mesh.vertices_mm);
  EXPECT_EQ(plain.inputs[0].sha256, framed.inputs[0].sha256);
}

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
struct LigamentFolder : test::JobFolder {
  explicit LigamentFolder(
      const std::string& table, const std::string& wraps = one_wrap(),
      const std::string& head = "joint = \"other\"\n",
      const std::string& tail = "[ligaments]\nfibres = \"fibres.csv\"\nwraps = \"wraps.json\"\n")
      : JobFolder(test::small_job(head, tail))
  {
    scratch.write("fibres.csv", table);
    scratch.write("wraps.json", wraps);
  }
};

TEST(LigamentTable, ColumnsComeInAnyOrderAndUnit)
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

TEST(Wraps, AreReadInOpenSimsTerms)
{
  const std::string text = R"([
    {"name": "C", "type": "WrapCylinder", "body": "femur_distal_r", "xyz_body_rotation": "0.1 0.2 0.3",
     "translation": "-0.004 0.003 0", "quadrant": "all", "radius": "0.018", "length": "0.5"},
    {"name": "E", "type": "WrapEllipsoid", "body": "shin", "xyz_body_rotation": [0, 0, 0],
     "translation": [1, 2, 3], "dimensions": [3, 2, 1], "unit": "cm"}])";
  const std::vector<model::Wrap> wraps = job::read_wraps("w.json", text, {"thigh", "shin"});
  ASSERT_EQ(wraps.size(), 2U);
  EXPECT_EQ(wraps[0].body, BodyIndex::reference);
  EXPECT_EQ(wraps[0].shape, model::WrapShape::cylinder);
  EXPECT_LT((wraps[0].radii_mm - Eigen::Vector3d(18, 18, 250)).norm(), 1e-12);
  EXPECT_LT((wraps[0].X_body_wrap.translation() - Eigen::Vector3d(-4, 3, 0)).norm(), 1e-15);
  EXPECT_EQ(Eigen::Matrix3d(wraps[0].X_body_wrap.linear()),
            Eigen::Matrix3d(rotation_x(0.1) * rotation_y(0.2) * rotation_z(0.3)));
  EXPECT_EQ(wraps[1].body, BodyIndex::moving);
  EXPECT_EQ(wraps[1].radii_mm, Eigen::Vector3d(30, 20, 10));
}

TEST(CaseLigaments, GoThroughTheFramesAxesButKeepTheirUnit)
{
  // The meshes are in metres with Z up; the table is in mm.
  const LigamentFolder folder(
      header + "a1,1,2,30,4,5,6,1000,30,Round\n", one_wrap("xyz_body_rotation", "[0, 0, 0.5]"),
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

TEST(CaseLigaments, AReferenceStrainHoldsAtThePoseOfTheMeshes)
{
  std::string strains = header;
  strains.replace(strains.find("slack_length_mm"), 15, "reference_strain");
  const LigamentFolder folder(strains + "a,0,35,0,0,5,0,1000,0.25,\nb,0,25,10,0,-25,10,1000,-0.2,Round\n");
  const job::Case loaded = folder.load();
  EXPECT_DOUBLE_EQ(loaded.ligaments.fibres[0].slack_length_mm, 24.0);
  const std::vector<model::FibreState> states = model::fibre_states(loaded.ligaments, {}, {});
  EXPECT_TRUE(states[1].is_wrapped);
  EXPECT_NEAR(states[0].strain, 0.25, 1e-14);
  EXPECT_NEAR(states[1].strain, -0.2, 1e-14);
}

TEST(CaseLigaments, InlineFibresAreTheSameAsATables)
{
  const job::Case from_table = LigamentFolder(header + "a1,0,35,0,0,5,0,1000,30,Round\n").load();
  const std::string fibre =
      "[ligaments]\nwraps = \"wraps.json\"\n[[ligaments.fibre]]\nname = \"a1\"\nreference_mm = [0, 35, 0]\n"
      "moving_mm = [0, 5, 0]\nstiffness_n = 1000\nslack_length_mm = 30\nwrap = \"Round\"\n";
  const job::Case inline_case = LigamentFolder("", one_wrap(), "joint = \"other\"\n", fibre).load();
  const model::Fibre& a = from_table.ligaments.fibres.at(0);
  const model::Fibre& b = inline_case.ligaments.fibres.at(0);
  EXPECT_EQ(a.name + a.bundle, b.name + b.bundle);
  EXPECT_EQ(a.reference_mm, b.reference_mm);
  EXPECT_EQ(a.moving_mm, b.moving_mm);
  EXPECT_EQ(a.slack_length_mm, b.slack_length_mm);
  EXPECT_EQ(a.wrap, b.wrap);
}

TEST(CaseLigaments, GeneratedOnesAreOfTheJobsSideAndSkipTheFrame)
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

TEST(RealKnees, LigamentsOfSmith2019HaveTheirSourcesReferenceStrains)
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

}  // namespace vrda::case_test
