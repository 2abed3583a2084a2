// The table in layout.cpp and the page schemas/motion-model.md say the same.
#include "store/layout.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <set>
#include <sstream>

#include "core/error.hpp"
#include "store/derived.hpp"
#include "store/page_paths.hpp"
#include "support/real_knees.hpp"
#include "support/scratch.hpp"

namespace vrda::layout_test {

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
  shape.smoothed = {{6, 28, true, true}};
  shape.has_zero_varus = true;
  shape.audits = {{"raw", 7, 5}};
  shape.n_inputs = 2;
  shape.n_landmarks = 3;
  return shape;
}

FileShape version_one_three()
{
  FileShape shape = full_shape();
  shape.minor_version = 3;
  return shape;
}

FileShape version_one_two()
{
  FileShape shape = version_one_three();
  shape.minor_version = 2;
  shape.n_landmarks.reset();
  return shape;
}

FileShape version_one_one()
{
  FileShape shape = version_one_two();
  shape.minor_version = 1;
  shape.smoothed = {{6, 28}};
  shape.has_zero_varus = false;
  shape.audits.clear();
  return shape;
}

std::string replaced(std::string text, const std::string& old, const std::string& now)
{
  for (std::size_t at = text.find(old); at != std::string::npos; at = text.find(old, at + now.size())) {
    text.replace(at, old.size(), now);
  }
  return text;
}

/// As the page writes it: B for both bodies, N for the degree, NAME for the audited motion.
std::string on_page(const std::string& path)
{
  const std::string body =
      replaced(replaced(path, "/bodies/reference", "/bodies/B"), "/bodies/moving", "/bodies/B");
  return replaced(replaced(body, "degree_6", "degree_N"), "/audit/raw", "/audit/NAME");
}

std::set<std::string> dataset_paths(const FileShape& shape)
{
  std::set<std::string> paths;
  for (const DatasetSpec& spec : layout_of(shape).datasets) paths.insert(spec.path);
  return paths;
}

/// Codes and words as the page lists them.
std::string listed(const FlagTable& table, const std::string& separator)
{
  std::istringstream words(table.meanings);
  std::string row, word;
  for (const std::int8_t value : table.values) {
    words >> word;
    row += (row.empty() ? "" : separator) + std::to_string(value) + " " + word;
  }
  return row;
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

TEST(Layout, TheCodesAreThoseOfThePage)
{
  const std::string page = test::read_bytes(test::source_directory() / "schemas" / "motion-model.md");
  EXPECT_THAT(page, ::testing::HasSubstr(listed(flag_table(FlagSet::status), ", ")));
  EXPECT_THAT(page, ::testing::HasSubstr(listed(flag_table(FlagSet::plausibility), ", ")));
  EXPECT_THAT(page, ::testing::HasSubstr(listed(flag_table(FlagSet::audit_state), ", ")));
  const FlagTable source = flag_table(FlagSet::zero_varus_source);
  EXPECT_EQ(source.values, (std::vector<std::int8_t>{-1, 0, 1, 2}));
  for (const char* code : {"-1 none: ", "0 both_touch: ", "1 interpolated: ", "2 free: "}) {
    EXPECT_THAT(page, ::testing::HasSubstr(code));
  }
}

TEST(Layout, TheCodesAreThoseOfTheEnumerations)
{
  EXPECT_EQ(listed(flag_table(FlagSet::audit_state), " "), "-1 no_pose 0 free 1 overlapping 2 nothing_ahead");
  EXPECT_EQ(static_cast<int>(AuditState::no_pose), -1);
  EXPECT_EQ(static_cast<int>(AuditState::free), 0);
  EXPECT_EQ(static_cast<int>(AuditState::overlapping), 1);
  EXPECT_EQ(static_cast<int>(AuditState::nothing_ahead), 2);
  EXPECT_EQ(listed(flag_table(FlagSet::zero_varus_source), " "),
            "-1 none 0 both_touch 1 interpolated 2 free");
  EXPECT_EQ(static_cast<int>(ZeroVarusSource::none), -1);
  EXPECT_EQ(static_cast<int>(ZeroVarusSource::both_touch), 0);
  EXPECT_EQ(static_cast<int>(ZeroVarusSource::interpolated), 1);
  EXPECT_EQ(static_cast<int>(ZeroVarusSource::free), 2);
}

TEST(Layout, VersionOneZeroIsThatOfOneOneWithoutWhatCameLater)
{
  FileShape first = version_one_one();
  first.minor_version = 0;
  const std::set<std::string> old = dataset_paths(first);
  std::set<std::string> added;
  for (const std::string& path : dataset_paths(version_one_one())) {
    if (old.count(path) == 0) added.insert(path.substr(0, path.find('/', 1)));
  }
  EXPECT_EQ(added, (std::set<std::string>{"/varus_solved", "/push", "/contact_paths", "/equilibrium",
                                          "/ligaments"}));
  EXPECT_EQ(flag_table(FlagSet::search_status).values, (std::vector<std::int8_t>{-1, 0, 1, 2, 3}));
  EXPECT_EQ(flag_table(FlagSet::solver_status).values, (std::vector<std::int8_t>{-1, 0, 1, 2, 3, 4}));
}

TEST(Layout, VersionOneTwoAddsWhatIsMadeOfTheSurfaces)
{
  const std::set<std::string> old = dataset_paths(version_one_one());
  std::set<std::string> added;
  for (const std::string& path : dataset_paths(version_one_two())) {
    const std::string group = path.substr(0, path.find('/', 1));
    if (old.count(path) == 0) added.insert(group == "/smoothed" ? path : group);
  }
  EXPECT_EQ(added, (std::set<std::string>{"/zero_varus", "/audit", "/smoothed/degree_6/recontact",
                                          "/smoothed/degree_6/varus_solved",
                                          "/smoothed/degree_6/coefficients_varus_solved"}));
  // Where nothing has been made, the only news is is_robust.
  FileShape plain = version_one_one();
  plain.minor_version = 2;
  EXPECT_EQ(dataset_paths(plain), old);
  EXPECT_EQ(layout_of(plain).groups, layout_of(version_one_one()).groups);
  EXPECT_EQ(layout_of(plain).attributes.size(), layout_of(version_one_one()).attributes.size() + 1);
}

TEST(Layout, VersionOneThreeAddsHowTheJobScales)
{
  const std::set<std::string> old = dataset_paths(version_one_two());
  std::set<std::string> added;
  for (const std::string& path : dataset_paths(version_one_three())) {
    if (old.count(path) == 0) added.insert(path.substr(0, path.rfind('/')));
  }
  EXPECT_EQ(added, std::set<std::string>{"/job/scaling"});
  FileShape plain = version_one_two();
  plain.minor_version = 3;
  EXPECT_EQ(dataset_paths(plain), old) << "where the job does not scale";
}

TEST(Layout, VersionOneFourAddsPlausibilityAndAStatus)
{
  std::set<std::string> wanted = dataset_paths(version_one_three());
  wanted.insert("/plausibility");
  EXPECT_EQ(dataset_paths(full_shape()), wanted);
  EXPECT_EQ(flag_table(FlagSet::status).values, (std::vector<std::int8_t>{-1, 0, 1, 2, 3, 4, 5}));
  EXPECT_EQ(listed(flag_table(FlagSet::plausibility), " "),
            "-1 not_judged 0 nothing_found 1 nothing_ahead 2 unstable_balance");
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

}  // namespace vrda::layout_test
