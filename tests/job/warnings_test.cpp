#include <gmock/gmock.h>

#include "job/case.hpp"
#include "job/mesh_text.hpp"
#include "support/meshes.hpp"
#include "support/refusal.hpp"
#include "support/scratch.hpp"

namespace vrda::warnings_test {

using test::refuses;
using testing::AllOf;
using testing::Contains;
using testing::ContainsRegex;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::Not;

// Two balls side by side, like femoral condyles, above a box.
Mesh condyles()
{
  Mesh femur = test::ball(22, 24, 48);
  femur.vertices_mm.col(2).array() -= 25.0;
  Mesh right = test::ball(22, 24, 48);
  right.vertices_mm.col(2).array() += 25.0;
  append(femur, right);
  return femur;
}

const std::string search = "solver.method=stability-search";
const std::string equilibrium = "solver.method=equilibrium";

// Uses the stability search unless an override selects another method.
std::vector<std::string> warnings_of(const std::string& job, std::vector<std::string> overrides = {},
                                     const Mesh& reference = condyles(),
                                     const Mesh& moving = test::box({0, -60, 0}, {50, 30, 70}))
{
  overrides.insert(overrides.begin(), search);
  return test::JobFolder(job, reference, moving).load(overrides).warnings;
}

TEST(Warnings, sound_job)
{
  EXPECT_THAT(warnings_of(test::small_job()), ElementsAre());
}

// A resolved job states every key.
TEST(Warnings, search_keys_with_their_defaults)
{
  const std::string every_key =
      "[solver.search]\napproach_step_mm = 1\ntranslation_step_mm = 1\ntranslation_resolution_mm = 0.01\n"
      "rotation_step_deg = 1\nrotation_resolution_deg = 0.01\npoints = \"exact\"\nnormals = \"reference\"\n"
      "max_steps = 100\n";
  EXPECT_THAT(warnings_of(test::small_job("", every_key), {equilibrium}),
              ElementsAre(HasSubstr("nearly free")));
  EXPECT_THAT(warnings_of(test::small_job("", every_key), {equilibrium, "solver.search.max_steps=99"}),
              Contains(HasSubstr("solver.search.max_steps")));
}

TEST(Warnings, edges)
{
  const Mesh sheet = test::sheet(80, 12);
  EXPECT_THAT(warnings_of(test::small_job(), {}, condyles(), sheet), ElementsAre());
  Mesh torn = test::ball(40, 24, 48);
  torn.triangles.conservativeResize(torn.triangles.rows() - 1, 3);
  EXPECT_THAT(warnings_of(test::small_job(), {}, condyles(), torn),
              Contains(AllOf(HasSubstr("small holes"), HasSubstr("boundary edges: 3)"))));
  Mesh twisted = test::ball(40, 24, 48);
  std::swap(twisted.triangles(100, 0), twisted.triangles(100, 1));
  EXPECT_THAT(warnings_of(test::small_job(), {}, condyles(), twisted),
              Contains(AllOf(HasSubstr("more than two faces"), HasSubstr(": 3"))));
}

// A femur with condyles, a head 430 mm above and 45 mm to the left, and a trochanter 80 mm posterior: not
// quite aligned with the proximal axis.
Mesh whole_femur()
{
  Mesh femur = condyles();
  append(femur, test::box({-3, 215, 0}, {30, 410, 30}));
  append(femur, test::box({-80, 405, 35}, {30, 40, 30}));
  Mesh head = test::ball(24, 24, 48);
  head.vertices_mm.rowwise() += Eigen::RowVector3d(10, 430, -45);
  append(femur, head);
  return femur;
}

TEST(Warnings, far_centre_of_a_whole_bone)
{
  // Files: X left, Y posterior, Z up, in cm, far from their own origin.
  const auto in_file = [](Mesh mesh) {
    const Points canonical = mesh.vertices_mm;
    mesh.vertices_mm.col(0) = -0.1 * canonical.col(2).array() + 12.0;
    mesh.vertices_mm.col(1) = -0.1 * canonical.col(0).array() - 7.0;
    mesh.vertices_mm.col(2) = 0.1 * canonical.col(1).array() + 150.0;
    return mesh;
  };
  const std::string job =
      test::small_job("[frame]\nunit = \"cm\"\nanterior = \"-Y\"\nproximal = \"+Z\"\nright = \"-X\"\n");
  const Mesh femur = in_file(whole_femur()), tibia = in_file(test::box({0, -200, 0}, {50, 350, 70}));
  for (const char* origin : {"[0, 0, 0]", "[12, -7, 193]", "[12, -7, 154]"}) {
    SCOPED_TRACE(origin);
    // To 1 mm: facets are inside their sphere.
    EXPECT_THAT(warnings_of(job, {"frame.origin=" + std::string(origin)}, femur, tibia),
                ElementsAre(AllOf(HasSubstr("middle of the condyles"),
                                  ContainsRegex("frame.origin = .(12|11.9.?|12.0.?), -(7|7.0.?|6.9.?), "
                                                "(150|149.9.?|150.0.?).$"))));
  }
  EXPECT_THAT(warnings_of(job, {"frame.origin=[12, -7, 150]"}, femur, tibia), ElementsAre());
}

std::string job_with_menisci(const std::string& side)
{
  return "side = \"" + side + "\"\n[[reference.component]]\nname = \"femur\"\nfile = \"reference.stl\"\n" +
         "[[moving.component]]\nname = \"Meniscus_Medial\"\nfile = \"moving.stl\"\n" +
         "[[moving.component]]\nname = \"meniscus_lateral\"\nfile = \"lateral.stl\"\n";
}

Mesh with_ball(Mesh mesh, const Eigen::Vector3d& centre_mm, double radius_mm)
{
  Mesh ball = test::ball(radius_mm, 6, 8);
  ball.vertices_mm.rowwise() += centre_mm.transpose();
  append(mesh, ball);
  return mesh;
}

// A left-over of a segmentation between the bones changes the motion; other small parts are legitimate.
TEST(Warnings, specks)
{
  const Mesh femur = condyles(),
             tibia = test::box({0, -45, 0}, {50, 30, 70});  // the joint space is from -22 to -30
  const auto found = [&](const Mesh& reference, const Mesh& moving) {
    std::vector<std::string> specks;
    for (const std::string& warning : warnings_of(test::small_job(), {}, reference, moving)) {
      if (warning.find("a separate piece") != std::string::npos) specks.push_back(warning);
    }
    return specks;
  };
  EXPECT_THAT(
      found(with_ball(femur, {0, -26, 25}, 1.0), tibia),
      ElementsAre(AllOf(HasSubstr("upper"), HasSubstr("reference.stl"), HasSubstr(", 2 mm across"),
                        HasSubstr("[0, -26, 25] mm in the axes of the file"), HasSubstr("3 mm from"))));
  EXPECT_THAT(found(femur, with_ball(tibia, {10, -28, -20}, 1.5)), ElementsAre(HasSubstr("moving.stl")));
  // At the back of a condyle, which comes to the tibia in flexion.
  EXPECT_THAT(warnings_of(test::small_job(), {"grid.flexion={from=0,to=90,step=10}"},
                          with_ball(femur, {-25, 0, 25}, 1.0), test::box({0, -40, 0}, {50, 30, 70})),
              Contains(HasSubstr("a separate piece")));
  // Far from the other bone, a part of some size, a void of the bone.
  EXPECT_THAT(found(with_ball(femur, {0, 60, 0}, 4.0), tibia), ElementsAre());
  EXPECT_THAT(found(with_ball(femur, {0, -18, 0}, 10.0), tibia), ElementsAre());
  EXPECT_THAT(found(femur, with_ball(tibia, {10, -40, -20}, 1.5)), ElementsAre());
}

// The bare compartment is lower by the thickness of the cartilage, so the knee tilts.
TEST(Warnings, one_compartment)
{
  const Mesh tibia = test::box({0, -60, 0}, {50, 30, 70});
  const auto with = [&](const Mesh& cartilage) {
    const std::string more =
        "[[moving.component]]\nname = \"cover\"\nfile = \"cartilage.stl\"\nmaterial = \"cartilage\"\n";
    const test::JobFolder folder(test::small_job("", more), condyles(), tibia);
    folder.scratch.write("cartilage.stl", test::binary_stl(cartilage));
    return folder.load({search}).warnings;
  };
  EXPECT_THAT(with(test::box({0, -44, 18}, {40, 2, 30})),
              ElementsAre(AllOf(HasSubstr("one compartment only (\"cover\")"), HasSubstr("inset_mm"))));
  EXPECT_THAT(with(test::box({0, -44, 0}, {40, 2, 66})), ElementsAre());
  // The tibia with other triangles, as its own cartilage.
  Mesh copy = test::box({0, -60, 0}, {50, 30, 70});
  copy.triangles = copy.triangles.colwise().reverse().eval();
  EXPECT_THAT(with(copy), Contains(AllOf(HasSubstr("same surface"), HasSubstr("moving.component.1.file"))));
}

}  // namespace vrda::warnings_test
