#include "core/process.hpp"

#include <gtest/gtest.h>

#include <filesystem>

namespace vrda::process_test {

namespace fs = std::filesystem;

TEST(RunProgram, CapturesOutputsAndHowItEnds)
{
  const fs::path here = fs::canonical(fs::temp_directory_path());
  ProcessOptions options;
  options.folder = here;
  const ProgramResult said = run_program({"/bin/bash", "-c", "pwd; echo err >&2; exit 7"}, options);
  EXPECT_EQ(said.exit_code, 7);
  EXPECT_EQ(said.out, here.string() + "\n");
  EXPECT_EQ(said.err, "err\n");
  EXPECT_FALSE(said.is_not_found);
  EXPECT_TRUE(run_program({"no-such-program-here"}, {}).is_not_found);
  EXPECT_EQ(run_program({"/bin/bash", "-c", "kill -KILL $$"}, {}).exit_code, -1);
}

TEST(OwnProgram, IsTheExecutableByItsRealPath)
{
  const fs::path own = own_program();
  EXPECT_EQ(own, fs::canonical(own));
  EXPECT_EQ(own.filename(), "test_cluster");
}

TEST(OwnProgram, IsTheLauncherWhereALoaderRunsIt)
{
  EXPECT_EQ(program_to_start("/a/bin/vrda", "vrda"), "/a/bin/vrda");
  EXPECT_EQ(program_to_start("/a/lib/glibc/ld-linux-x86-64.so.2", "/a/with-glibc/vrda"),
            "/a/with-glibc/vrda");
  EXPECT_EQ(program_to_start("/ld-linux/vrda", "vrda"), "/ld-linux/vrda");
}

}  // namespace vrda::process_test
