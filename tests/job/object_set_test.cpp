#include "job/thesis_files.hpp"

#include <gmock/gmock.h>

namespace vrda::object_set_test {

// Two components that share the edge between vertices 2 and 3: a square and an adjacent triangle.
job::ObjectSetTexts two_components()
{
  return {{"k.coor", "# a knee\n5\n1, 0, 0, 0\n2, 1, 0, 0\n3, 1, 1, 0\n4, 0, 1, 0\n5, 2, 0.5, 0\n"},
          {"k.norm", "1 0 0 1\n2 0 0 2\n3 0 0 3\n4 0 0 4\n5 0 0 5\n"},
          {"k.elem", "3\nTibia 1 2 3\nFemur 2 5 3\nTibia 1 3 4\n"}};
}

TEST(ObjectSet, two_components)
{
  const std::vector<job::ObjectComponent> components = job::parse_object_set(two_components());
  ASSERT_EQ(components.size(), 2u);
  EXPECT_EQ(components[0].name, "Tibia");
  EXPECT_EQ(components[0].mesh.vertices.rows(), 4);
  EXPECT_EQ(components[0].mesh.corner, (std::vector<std::int32_t>{0, 1, 2, 0, 2, 3}));
  EXPECT_EQ(components[0].mesh.size, (std::vector<std::int32_t>{3, 3}));
  EXPECT_EQ(components[1].name, "Femur");
  EXPECT_EQ(components[1].mesh.vertices, (Points(3, 3) << 1, 0, 0, 1, 1, 0, 2, 0.5, 0).finished());
  EXPECT_EQ(components[1].mesh.normals, (Points(3, 3) << 0, 0, 2, 0, 0, 3, 0, 0, 5).finished());
  EXPECT_EQ(components[1].mesh.corner, (std::vector<std::int32_t>{0, 2, 1}));
}

TEST(ObjectSet, numbers_from_zero)
{
  const std::vector<job::ObjectComponent> components =
      job::parse_object_set({{"k.coor", "0 0 0 0\r\n1 1 0 0\r\n2 0 1 0\r\n"},
                             {"k.norm", "0 0 0 1\r\n1 0 0 1\r\n2 0 0 1\r\n"},
                             {"k.elem", "\r\nTibia\t0 1 2 # the only face\r\n"}});
  ASSERT_EQ(components.size(), 1u);
  EXPECT_EQ(components[0].mesh.corner, (std::vector<std::int32_t>{0, 1, 2}));
  EXPECT_EQ(components[0].mesh.vertices.row(2), Eigen::RowVector3d(0, 1, 0));
}

}  // namespace vrda::object_set_test
