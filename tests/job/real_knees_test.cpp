#include "support/real_knees.hpp"

#include <gmock/gmock.h>

#include "job/auto_frame.hpp"
#include "job/case.hpp"
#include "job/mesh_text.hpp"
#include "support/refusal.hpp"

namespace vrda::real_knees_test {

using testing::Contains;
using testing::ElementsAre;
using testing::HasSubstr;

job::Case load_knee(const std::string& name, const std::vector<std::string>& overrides = {})
{
  return job::load_case((test::source_directory() / ("jobs/knee-" + name + ".toml")).string(),
                        {test::data_directory()->string(), overrides});
}

const std::vector<std::string> all_knees{"jam-smith2019", "pymskt-dess", "vhf-left", "vhf-right"};

TEST(RealKnees, whole_meshes)
{
  VRDA_REQUIRE_REAL_KNEES();
  for (const std::string& name : all_knees) {
    SCOPED_TRACE(name);
    const job::Case loaded = load_knee(name);
    EXPECT_EQ(loaded.grid.flexion_deg.size(), 19U);
    EXPECT_EQ(loaded.grid.varus_deg.size(), 5U);
    for (const job::ComponentSurvey& part : loaded.survey) {
      EXPECT_EQ(part.n_degenerate, 0) << part.name;
      EXPECT_FALSE(part.was_flipped) << part.name;
      EXPECT_GT((part.box.max_mm - part.box.min_mm).norm(), 20.0) << part.name;
    }
    for (const Compartment which : {Compartment::medial, Compartment::lateral}) {
      EXPECT_GT(
          std::count(loaded.compartment_of_triangle.begin(), loaded.compartment_of_triangle.end(), which),
          5000);
    }
  }
}

TEST(RealKnees, known_edges)
{
  VRDA_REQUIRE_REAL_KNEES();
  EXPECT_THAT(load_knee("jam-smith2019").warnings, ElementsAre());
  EXPECT_THAT(load_knee("pymskt-dess").warnings,
              ElementsAre(HasSubstr("small holes"), HasSubstr("more than two faces"),
                          HasSubstr("small holes"), HasSubstr("more than two faces")));
  EXPECT_THAT(load_knee("vhf-left").warnings, ElementsAre());
  EXPECT_THAT(load_knee("vhf-right").warnings, ElementsAre());
}

TEST(RealKnees, condyle_spheres)
{
  VRDA_REQUIRE_REAL_KNEES();
  // posterior_condyle_spheres_canonical_mm of each dataset.json, left then right, without alignment.
  struct Row {
    const char* name;
    Eigen::Vector3d left_mm, right_mm;
  };
  const std::vector<Row> rows{{"jam-smith2019", {0.038, 1.405, -21.979}, {0.128, 2.966, 24.492}},
                              {"pymskt-dess", {0.932, 14.15, 53.605}, {6.289, 15.947, 94.609}},
                              {"vhf-left", {434.124, 506.156, 448.957}, {439.481, 512.136, 500.011}},
                              {"vhf-right", {427.95, 508.723, 593.074}, {421.07, 514.516, 645.783}}};
  // Condyles are not spheres: two methods of face selection differ by this much.
  constexpr double centre_mm = 7.0, middle_mm = 3.0;
  for (const Row& row : rows) {
    SCOPED_TRACE(row.name);
    const job::Case loaded = load_knee(row.name, {"frame.align.rotation_deg=[0, 0, 0]"});
    const std::optional<job::CondyleSpheres> spheres = job::condyle_spheres(loaded.reference.contact.mesh);
    ASSERT_TRUE(spheres.has_value());
    EXPECT_LT((spheres->left.centre_mm - row.left_mm).norm(), centre_mm);
    EXPECT_LT((spheres->right.centre_mm - row.right_mm).norm(), centre_mm);
    EXPECT_LT((spheres->left.centre_mm + spheres->right.centre_mm - row.left_mm - row.right_mm).norm() / 2.0,
              middle_mm);
  }
}

TEST(RealKnees, alignment)
{
  VRDA_REQUIRE_REAL_KNEES();
  // The sphere centres of the data sets, mapped by the job: their line must be along Z.
  struct Row {
    const char* name;
    Eigen::Vector3d left_mm, right_mm;
  };
  const std::vector<Row> rows{{"vhf-left", {434.124, 506.156, 448.957}, {439.481, 512.136, 500.011}},
                              {"vhf-right", {427.95, 508.723, 593.074}, {421.07, 514.516, 645.783}}};
  constexpr double rounded_deg = 0.1;  // the angles in the job have one decimal
  for (const Row& row : rows) {
    // The rotation centre is mapped like the meshes; native axes: X right, Y anterior, Z up.
    const auto mapped = [&](const Eigen::Vector3d& p) {
      const std::string origin = "frame.origin=[" + std::to_string(p.z()) + "," + std::to_string(p.x()) +
                                 "," + std::to_string(p.y()) + "]";
      return load_knee(row.name, {origin}).frame.rotation_centre_mm;
    };
    const Eigen::Vector3d line = (mapped(row.right_mm) - mapped(row.left_mm)).normalized();
    EXPECT_GT(line.z(), 0.0);
    EXPECT_LT(line.head<2>().norm(), rad_from_deg(rounded_deg));
  }
}

}  // namespace vrda::real_knees_test
