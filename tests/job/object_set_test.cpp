#include "job/thesis_files.hpp"

#include <gmock/gmock.h>

#include "support/refusal.hpp"
#include "support/scratch.hpp"

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

// A set with one changed text, and the expected refusal.
struct BadSet {
  job::NamedText job::ObjectSetTexts::*part;
  std::string from;
  std::string to;
  const char* line;
  test::Values found = {};
  test::Values wanted = {};
};

void expect_refused(const BadSet& row)
{
  SCOPED_TRACE(row.from + " -> " + row.to);
  job::ObjectSetTexts texts = two_components();
  job::NamedText& part = texts.*row.part;
  const std::size_t at = part.text.find(row.from);
  ASSERT_NE(at, std::string::npos);
  part.text.replace(at, row.from.size(), row.to);
  EXPECT_THAT(test::input_error([&] { job::parse_object_set(texts); }),
              test::refuses({part.file, row.line, row.found, row.wanted}));
}

TEST(ObjectSetErrors, Coordinates)
{
  const auto part = &job::ObjectSetTexts::coordinates;
  expect_refused({part, "5\n", "6\n", "line 2", "6", "5"});
  expect_refused({part, "5\n", "1000000000000\n", "line 2", "1000000000000", "5"});
  expect_refused({part, "5\n", "-5\n", "line 2", "-5", "5"});
  expect_refused({part, "3, 1, 1, 0", "3, 1, 1", "line 5", "3"});
  expect_refused({part, "3, 1, 1, 0", "3, 1, 1, 0, 7", "line 5", "5"});
  expect_refused({part, "3, 1, 1, 0", "3, 1, one, 0", "line 5", "\"one\""});
  expect_refused({part, "3, 1, 1, 0", "3, nan, 1, 0", "line 5", "\"nan\""});
  expect_refused({part, "3, 1, 1, 0", "3, 1, 1e999, 0", "line 5", "\"1e999\""});
  expect_refused({part, "3, 1, 1, 0", "3, -2e9, 1, 0", "line 5", "-2e+09", "1e9"});
  expect_refused({part, "3, 1, 1, 0\n", "", "line 5", "4", "3"});
  expect_refused({part, "1, 0", "7, 0", "line 3", "7", {"1", "0"}});
}

TEST(ObjectSetErrors, Normals)
{
  const auto part = &job::ObjectSetTexts::normals;
  expect_refused({part, "5 0 0 5\n", "", "line 4", "4", "5"});
  expect_refused({part, "5 0 0 5\n", "5 0 0 5\n6 0 0 6\n", "line 6", "", "5"});
  expect_refused({part, "1 0 0 1\n2", "0 0 0 1\n1", "line 1", "0", "1"});
  expect_refused({part, "3 0 0 3", "3 0 0 x", "line 3", "\"x\""});
}

TEST(ObjectSetErrors, Elements)
{
  const auto part = &job::ObjectSetTexts::elements;
  expect_refused({part, "3\n", "4\n", "line 1", "4", "3"});
  expect_refused({part, "Femur 2 5 3", "2 5 3", "line 3", "\"2\""});
  expect_refused({part, "Femur 2 5 3", "../Femur 2 5 3", "line 3", "\"../Femur\""});
  expect_refused({part, "Femur 2 5 3", "Femur 2 6 3", "line 3", "6", {"1", "5"}});
  expect_refused({part, "Femur 2 5 3", "Femur 2 0 3", "line 3", "0", {"1", "5"}});
  expect_refused({part, "Femur 2 5 3", "Femur 2 -1 3", "line 3", "-1", {"1", "5"}});
  expect_refused({part, "Femur 2 5 3", "Femur 2 5.5 3", "line 3", "\"5.5\""});
  expect_refused({part, "Femur 2 5 3", "Femur 2 5", "line 3", "2", {"3", "1000"}});
  expect_refused({part, "Femur 2 5 3", "Femur", "line 3", "0", {"3", "1000"}});
  expect_refused({part, "Femur 2 5 3", "Femur 2 5 2", "line 3", {"\"Femur\"", "2"}, "3"});
}

TEST(ObjectSetErrors, AMissingFileOfTheThreeIsNamed)
{
  for (const std::string missing : {".coor", ".norm", ".elem"}) {
    SCOPED_TRACE(missing);
    const test::Scratch scratch;
    for (const std::string extension : {".coor", ".norm", ".elem"}) scratch.write("k" + extension, "1\n");
    std::filesystem::remove(scratch.path() / ("k" + missing));
    const std::string prefix = (scratch.path() / "k").string();
    EXPECT_THAT(test::input_error([&] { job::read_object_set(prefix); }),
                test::refuses({prefix + missing, "", "no file"}));
  }
}

TEST(ObjectSetErrors, EmptyFilesAndTooManyComponents)
{
  for (const auto part :
       {&job::ObjectSetTexts::coordinates, &job::ObjectSetTexts::normals, &job::ObjectSetTexts::elements}) {
    job::ObjectSetTexts texts = two_components();
    (texts.*part).text = "# nothing\n";
    EXPECT_THAT(test::input_error([&] { job::parse_object_set(texts); }),
                test::refuses({(texts.*part).file, "line 1"}));
  }
  job::ObjectSetTexts texts = two_components();
  texts.elements.text.clear();
  for (std::size_t c = 0; c <= job::max_object_components; ++c)
    texts.elements.text += "part" + std::to_string(c) + " 1 2 3\n";
  EXPECT_THAT(test::input_error([&] { job::parse_object_set(texts); }),
              test::refuses({.field = "line 1001", .wanted = "1000"}));
}

}  // namespace vrda::object_set_test
