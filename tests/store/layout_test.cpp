// The table in layout.cpp and the page schemas/motion-model.md say the same.
#include "store/layout.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <set>
#include <sstream>

#include "core/error.hpp"
#include "store/page_paths.hpp"
#include "support/real_knees.hpp"
#include "support/scratch.hpp"

namespace vrda {
namespace {

FileShape full_shape()
{
  FileShape shape;
  shape.n_flexion = 4;
  shape.n_varus = 3;
  shape.has_compartments = true;
  shape.n_contacts = 5;
  shape.n_forces = 4;
  shape.ligaments = {55, 3};
  shape.reference = {2, {10, 16, true}, true, {8, 12, true}};
  shape.moving = shape.reference;
  shape.smoothed = {{6, 28}};
  shape.n_inputs = 2;
  return shape;
}

std::string replaced(std::string text, const std::string& old, const std::string& now)
{
  for (std::size_t at = text.find(old); at != std::string::npos; at = text.find(old, at + now.size())) {
    text.replace(at, old.size(), now);
  }
  return text;
}

/// As the page writes it: B for both bodies, N for the degree.
std::string on_page(const std::string& path)
{
  return replaced(replaced(replaced(path, "/bodies/reference", "/bodies/B"), "/bodies/moving", "/bodies/B"),
                  "degree_6", "degree_N");
}

TEST(Layout, IsThePageOfTheSpecification)
{
  const std::string page = test::read_bytes(test::source_directory() / "schemas" / "motion-model.md");
  const FileLayout layout = layout_of(full_shape());
  std::set<std::string> wanted;
  for (const DatasetSpec& spec : layout.datasets) wanted.insert(on_page(spec.path));
  for (const DimensionSpec& dimension : layout.dimensions) wanted.insert(on_page(dimension.path));
  EXPECT_EQ(test::paths_of_page(page), wanted);
  for (const AttributeSpec& attribute : layout.attributes) {
    EXPECT_THAT(page, ::testing::HasSubstr("`" + attribute.name + "`")) << attribute.object;
  }
  EXPECT_THAT(page, ::testing::HasSubstr(std::string("format version ") + format_version));
  EXPECT_THAT(page, ::testing::HasSubstr(std::string("`") + conventions + "`"));
}

TEST(Layout, TheStatusCodesAreThoseOfThePage)
{
  const std::string page = test::read_bytes(test::source_directory() / "schemas" / "motion-model.md");
  const FlagTable table = flag_table(FlagSet::status);
  std::istringstream words(table.meanings);
  std::string row, word;
  for (const std::int8_t value : table.values) {
    ASSERT_TRUE(words >> word);
    row += (row.empty() ? "" : ", ") + std::to_string(value) + " " + word;
  }
  EXPECT_THAT(page, ::testing::HasSubstr(row));
}

TEST(Layout, VersionOneZeroIsTheSameWithoutWhatCameLater)
{
  FileShape first = full_shape();
  first.minor_version = 0;
  std::set<std::string> old, added;
  for (const DatasetSpec& spec : layout_of(first).datasets) old.insert(spec.path);
  for (const DatasetSpec& spec : layout_of(full_shape()).datasets) {
    if (old.count(spec.path) == 0) added.insert(spec.path.substr(0, spec.path.find('/', 1)));
  }
  EXPECT_EQ(added, (std::set<std::string>{"/varus_solved", "/push", "/contact_paths", "/equilibrium",
                                          "/ligaments"}));
  EXPECT_EQ(flag_table(FlagSet::search_status).values, (std::vector<std::int8_t>{-1, 0, 1, 2, 3}));
  EXPECT_EQ(flag_table(FlagSet::status).values, (std::vector<std::int8_t>{-1, 0, 1, 2, 3, 4}));
}

TEST(Layout, EveryDatasetFindsItsDimensions)
{
  const FileShape shape = full_shape();
  const FileLayout layout = layout_of(shape);
  for (const DatasetSpec& spec : layout.datasets) {
    SCOPED_TRACE(spec.path);
    EXPECT_FALSE(spec.long_name.empty());
    EXPECT_EQ(spec.units.empty(), spec.kind == ValueKind::text || spec.flags != FlagSet::none);
    for (const std::string& dimension : spec.dimensions)
      EXPECT_GT(dimension_size(layout, shape, dimension), 0);
  }
  EXPECT_THROW(dimension_size(layout, shape, "/nothing"), InternalError);
}

}  // namespace
}  // namespace vrda
