// Every command on an unusable motion model: one line, exit code 2, nothing written.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "app/scenes.hpp"
#include "support/damaged_models.hpp"

namespace vrda::unusable_models_test {

namespace fs = std::filesystem;
using testing::AnyOf;

class UnusableModels : public testing::Test {
 protected:
  std::string solved(const std::string& name, const std::vector<std::string>& more, int exit_code)
  {
    const std::string file = (scratch_.path() / name).string();
    std::vector<std::string> words{"run", test::small_knee_job(scratch_, "right").string(), "-o", file};
    words.insert(words.end(), more.begin(), more.end());
    EXPECT_EQ(test::run_vrda(words).exit_code, exit_code);
    return file;
  }

  void expect_refused(const std::string& file, const testing::Matcher<const test::Ended&>& refusal) const
  {
    const std::string output = (scratch_.path() / "output").string(), before = test::sha256_of_file(file);
    for (const std::vector<std::string>& words :
         {std::vector<std::string>{"smooth", file, "--degree", "2"},
          {"smooth", file, "--degree", "2", "--recontact"},
          {"audit", file},
          {"compare", file},
          {"compare", file, "--recontact", "--json"},
          {"reduce", file},
          {"reduce", file, "--json"},
          {"report", file, "-o", output},
          {"report", whole_, file, "-o", output},
          {"export", file, "--to", "sto", "-o", output + ".sto"},
          {"export", file, "--to", "mot", "-o", output + ".mot"},
          {"export", file, "--to", "csv", "-o", output + ".csv"},
          {"export", file, "--to", "csv", "--full", "-o", output + ".csv"},
          {"export", file, "--to", "gltf", "-o", output + ".glb"},
          {"export", file, "--to", "vtk", "-o", output + ".pvd"}}) {
      SCOPED_TRACE(testing::PrintToString(words));
      const test::Ended ended = test::run_vrda(words);
      EXPECT_THAT(ended, refusal);
      EXPECT_EQ(ended.out, "");
      EXPECT_EQ(test::n_lines(ended.err), 1) << ended.err;
      EXPECT_FALSE(test::printed_facts(ended.err).wanted.empty()) << ended.err;
    }
    EXPECT_EQ(test::sha256_of_file(file), before);
    for (const fs::directory_entry& entry : fs::directory_iterator(scratch_.path()))
      EXPECT_NE(entry.path().stem(), "output") << entry.path();
  }

  test::Scratch scratch_;
  std::string whole_ = solved("whole.h5", {}, 0);
};

TEST_F(UnusableModels, Damaged)
{
  const std::string bytes = test::text_of(whole_);
  expect_refused(scratch_.write("half.h5", bytes.substr(0, bytes.size() / 2)).string(),
                 test::refuses({.file = "half.h5", .found = "truncated"}));
  struct Row {
    const char *damage, *field;
  };
  for (const Row& row : {Row{"newer_format", "/@format_version"}, Row{"no_clinical", "/clinical"},
                         Row{"no_bodies", "/bodies"}, Row{"no_job", "/job"}}) {
    SCOPED_TRACE(row.damage);
    expect_refused(test::damaged_copy(whole_, scratch_.path(), row.damage),
                   test::refuses({std::string(row.damage) + ".h5", row.field}));
  }
}

TEST_F(UnusableModels, OfObjectsThatNeverMet)
{
  const std::vector<std::string> apart{"--set", "moving.initial.translation_mm=[500, -40, 0]"};
  const auto names = [](const char* field) { return test::refuses({"apart.h5", field}); };
  expect_refused(
      solved("apart.h5", apart, 3),
      AnyOf(test::refuses({"apart.h5", "/status", {"35", "no_contact"}}), names("status"), names("raw"),
            names("contact_medial, contact_lateral, gap_medial_mm, gap_lateral_mm")));
}

}  // namespace vrda::unusable_models_test
