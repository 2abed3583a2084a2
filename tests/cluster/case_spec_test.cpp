#include "cluster/case_spec.hpp"

#include <gtest/gtest.h>

#include <filesystem>

#include "support/input_error.hpp"
#include "support/scratch.hpp"

namespace vrda::case_spec_test {

TEST(CaseSpec, IsNamedAfterItsJobAndKnowsWholePaths)
{
  const CaseSpec spec = case_of_job("jobs/../jobs/knee.v2.toml", "data", {"a=1"});
  EXPECT_EQ(spec.name, "knee.v2");
  EXPECT_EQ(spec.job_file, std::filesystem::current_path() / "jobs/knee.v2.toml");
  EXPECT_EQ(spec.data_directory, std::filesystem::current_path() / "data");
  EXPECT_EQ(case_of_job("a.toml", "", {}).data_directory, "");
}

TEST(CaseSpec, TheFileGivesItBack)
{
  const test::Scratch scratch;
  const std::string path = case_file_of(scratch.path() / "knee.h5");
  EXPECT_EQ(path, scratch.path() / "knee.h5.case.json");
  const CaseSpec spec{
      "a \"b\"", "/tmp/with space/j\\ob.toml", "/d", {"title=\"x=y\"", "grid.flexion.step=5"}};
  write_case_file(path, {spec, "abc"});
  EXPECT_EQ(read_case_file(path).spec, spec);
  EXPECT_EQ(read_case_file(path).merged_sha256, "abc");
}

TEST(CaseSpec, OtherFilesAreRefused)
{
  const test::Scratch scratch;
  EXPECT_EQ(test::input_error([&] { read_case_file(scratch.path() / "none"); }).found, "no file");
  for (const std::string bytes :
       {"", "{", "[1]", R"({"name": 3})", R"({"name": "a", "job": "b", "data": "c"})"}) {
    const std::string path = scratch.write("bad.json", bytes);
    EXPECT_EQ(test::input_error([&] { read_case_file(path); }).file, path) << bytes;
  }
}

}  // namespace vrda::case_spec_test
