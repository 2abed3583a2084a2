#include "job/case.hpp"

#include <gmock/gmock.h>

#include "job/job.hpp"
#include "job/mesh_text.hpp"
#include "support/real_knees.hpp"

namespace vrda::case_test {

using test::refuses;
using testing::ElementsAre;

Mesh lower()
{
  return test::box({0, 0, 0}, {50, 20, 70});
}

using Folder = test::JobFolder;

InputError::Facts facts_with(const Folder& folder, const std::vector<std::string>& overrides = {})
{
  return folder.refused(overrides);
}

TEST(Case, two_boxes)
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

TEST(Case, start_before_contact)
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

TEST(Case, push_fixed_in_reference)
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

TEST(CaseErrors, APushFixedInTheReferenceNeedsThreeKnownRotations)
{
  const Folder folder;
  for (const char* coordinates : {"coordinates={flexion={from=0, to=9, step=9}, varus=0}", "title=grid"}) {
    EXPECT_THAT(facts_with(folder, {"joint=hip", coordinates}),
                refuses({.field = "push.frame", .wanted = "[coordinates]"}));
  }
}

TEST(Case, push_of_a_hip)
{
  const Folder folder;
  for (const bool is_right : {true, false}) {
    const job::Case loaded =
        folder.load({"joint=hip", is_right ? "side=right" : "side=left",
                     "coordinates={flexion={from=0, to=9, step=9}, varus=0, internal=0}"});
    // Opposite to an opening of 45 degrees inclination and 20 degrees anteversion.
    const double s = std::sqrt(0.5) * std::cos(20.0 * M_PI / 180.0);
    EXPECT_LT(
        (loaded.frame.delta - Eigen::Vector3d(-std::sin(20.0 * M_PI / 180.0), s, is_right ? -s : s)).norm(),
        1e-3);  // the default has three decimals
  }
}

TEST(Case, sha256)
{
  // FIPS 180-2, appendix B.1.
  EXPECT_EQ(job::sha256_of("abc"), "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad");
}

TEST(Case, unit_and_axes)
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

TEST(Case, drawn_components)
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
TEST(Case, normals_file)
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

TEST(Case, ANormalsFileThatDoesNotFitIsRefused)
{
  for (const auto& [text, refusal] : std::map<std::string, test::Refusal>{
           {"3\n0 0 1\n0 0 1\n0 0 1\n", {"third.normals", "line 1", "3", "4"}},
           {"4\n0 0 1\n0 0 1\n0 0 x\n0 0 1\n", {"third.normals", "line 4", "\"x\"", "2"}},
           {"4\n0 0 1\n0 0 1\n0 0 1\n0 0 1\n5", {"third.normals", "line 6", "\"5\""}}}) {
    const Folder folder(test::small_job("joint = \"other\"\n", R"(
[[moving.component]]
name = "third"
file = "third.vf"
)"));
    folder.scratch.write("third.vf", "4 4\n0 0 0\n4 0 0\n0 4 0\n0 0 4\n3 0 2 1\n3 0 1 3\n3 0 3 2\n3 1 2 3\n");
    folder.scratch.write("third.normals", text);
    EXPECT_THAT(facts_with(folder), refuses(refusal));
  }
}

TEST(Case, inset_and_shift)
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

TEST(Case, data_folder)
{
  const Folder folder;
  const test::Scratch data;
  data.write("moving.stl", test::binary_stl(test::box({0, 0, 0}, {10, 10, 10})));
  const job::Case loaded = job::load_case(folder.job, {data.path().string(), {}});
  EXPECT_DOUBLE_EQ(loaded.survey[0].volume_mm3, 96000.0);
  EXPECT_DOUBLE_EQ(loaded.survey[1].volume_mm3, 1000.0);
  EXPECT_EQ(loaded.resolved_job, folder.load().resolved_job);
}

TEST(Case, mirrored_mesh)
{
  const std::string head = "[frame]\norigin = [1.1, 2.3, 3.7]\nalign = { rotation_deg = [0, 0, 7] }\n";
  const std::string mirrored_head =
      "side = \"left\"\n[frame]\norigin = [1.1, 2.3, -3.7]\nalign = { rotation_deg = [0, 0, 7] }\n";
  Mesh ball = test::ball(30, 12, 20);
  ball.vertices_mm.col(2).array() += 5.3;
  const Folder right(test::small_job(head)), left(test::small_job(mirrored_head));
  right.scratch.write("reference.stl", test::binary_stl(ball));
  left.scratch.write("reference.stl", test::binary_stl(mirrored_z(ball)));
  left.scratch.write("moving.stl", test::binary_stl(mirrored_z(lower())));
  const std::vector<std::string> tilted{"push.delta=[0.1, 1, 0.2]"}, tilted_left{"push.delta=[0.1, 1, -0.2]"};
  const job::Case a = right.load(tilted), b = left.load(tilted_left);
  const auto expect_same = [&](const Mesh& of_right, const Mesh& of_left) {
    const Mesh right_mesh = solver_mesh(of_right, a.frame), left_mesh = solver_mesh(of_left, b.frame);
    EXPECT_EQ(right_mesh.vertices_mm, left_mesh.vertices_mm);
    EXPECT_EQ(right_mesh.triangles, left_mesh.triangles);
    EXPECT_EQ(right_mesh.normals, left_mesh.normals);
  };
  expect_same(a.reference.contact.mesh, b.reference.contact.mesh);
  expect_same(a.moving.contact.mesh, b.moving.contact.mesh);
  EXPECT_EQ(a.compartment_of_triangle, b.compartment_of_triangle);
}

int count(const job::Case& loaded, Compartment which)
{
  return static_cast<int>(
      std::count(loaded.compartment_of_triangle.begin(), loaded.compartment_of_triangle.end(), which));
}

TEST(Compartments, half_spaces)
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

TEST(Compartments, by_names)
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

TEST(Compartments, BadOnesAreRefused)
{
  const Folder folder;
  const auto facts_of = [&](const std::string& medial, const std::string& lateral) {
    return facts_with(folder, {"compartments.medial." + medial, "compartments.lateral." + lateral});
  };
  EXPECT_THAT(facts_of("components=[\"lowre\"]", "half_space=right"),
              refuses({"", "compartments.medial.components", "\"lowre\"", "\"lower\""}));
  EXPECT_THAT(facts_of("components=[\"lower\"]", "components=[\"lower\"]"),
              refuses({"", "compartments.lateral.components", "\"lower\""}));
  EXPECT_THAT(facts_of("half_space=left", "half_space=left"), refuses({.field = "compartments"}));
}

TEST(CaseErrors, OverridesThatNoMethodSolves)
{
  const Folder folder;
  std::filesystem::create_directory(folder.scratch.path() / "sub.stl");
  for (const auto& [overrides, refusal] : std::vector<std::pair<std::vector<std::string>, test::Refusal>>{
           {{"grid.varus=free", "solver.method=stability-search"},
            {.field = "grid.varus", .wanted = "stability-search"}},
           {{"push.delta={ flexion_deg = [0, 90], value = [[0, 1, 0], [0, -1, 0]] }"},
            {.field = "push.delta", .found = "45"}},
           {{"frame.right=-Z"}, {.field = "frame"}},
           {{"moving.component.0.file=none.stl"}, {"", "moving.component.0.file", "none.stl", "--data"}},
           {{"moving.component.0.file=sub.stl"}, {"", "moving.component.0.file", "folder"}}})
    EXPECT_THAT(facts_with(folder, overrides), refuses(refusal)) << overrides.front();
}

TEST(Case, push_over_flexion)
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

TEST(CaseErrors, AMeshOfFacesWithoutAreaIsRefused)
{
  const Folder folder;
  folder.scratch.write("moving.stl", test::binary_stl(test::box({0, 0, 0}, {10, 0, 0})));
  EXPECT_THAT(facts_with(folder), refuses({"moving.stl", "", "12"}));
}

std::string generated_job(const std::string& shape, const std::string& upper_part,
                          const std::string& lower_part)
{
  return "joint = \"other\"\n[[reference.component]]\nname = \"a\"\ngenerate = { shape = \"" + shape +
         "\", part = \"" + upper_part + "\" }\n[[moving.component]]\nname = \"b\"\ngenerate = { shape = \"" +
         shape + "\", part = \"" + lower_part + "\" }\n";
}

TEST(Generated, parts)
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

TEST(Generated, without_frame)
{
  const Folder folder(generated_job("hip", "socket", "head"));
  const job::Case plain = folder.load();
  const job::Case framed =
      folder.load({"frame.unit=m", "frame.anterior=+Y", "frame.proximal=+Z", "frame.right=+X"});
  EXPECT_EQ(plain.reference.contact.mesh.vertices_mm, framed.reference.contact.mesh.vertices_mm);
  EXPECT_EQ(plain.inputs[0].sha256, framed.inputs[0].sha256);
}

TEST(GeneratedErrors, UnknownShapesPartsAndParameters)
{
  const Folder folder(generated_job("hip", "socket", "head"));
  const std::string generate = "moving.component.0.generate";
  EXPECT_THAT(facts_with(folder, {generate + ".part=haed"}),
              refuses({.field = generate + ".part", .wanted = "\"head\""}));
  EXPECT_THAT(facts_with(folder, {generate + ".shape=hpi"}),
              refuses({folder.job + " with --set " + generate + ".shape", generate, "hpi"}));
  EXPECT_THAT(facts_with(folder, {generate + ".resolution=-1"}),
              refuses({"--set", generate + ".resolution", "-1"}));
}

TEST(Jobs, generic_jobs)
{
  for (const char* name : {"knee-generic.toml", "knee-generic-contact.toml", "hip-generic.toml"}) {
    SCOPED_TRACE(name);
    const job::Case loaded = job::load_case((test::source_directory() / "jobs" / name).string());
    EXPECT_THAT(loaded.warnings, ElementsAre());
    for (const job::ComponentSurvey& part : loaded.survey) {
      EXPECT_EQ(part.n_boundary_edges + part.n_non_manifold_edges, 0) << part.name;
      EXPECT_GT(part.volume_mm3, 0.0) << part.name;
    }
  }
}

TEST(Jobs, both_compartments)
{
  const std::string job = (test::source_directory() / "jobs/knee-generic.toml").string();
  for (const char* side : {"side=right", "side=left"}) {
    const job::Case loaded = job::load_case(job, {"", {side}});
    EXPECT_GT(count(loaded, Compartment::medial), 1000);
    EXPECT_GT(count(loaded, Compartment::lateral), 1000);
    EXPECT_THAT(loaded.warnings, ElementsAre());
  }
}

}  // namespace vrda::case_test
