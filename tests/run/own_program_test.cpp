#include "run/local_run.hpp"

#include <gtest/gtest.h>

#include <filesystem>

namespace vrda::own_program_test {

namespace fs = std::filesystem;

TEST(OwnProgram, IsTheExecutableByItsRealPath)
{
  const fs::path own = run::own_program();
  EXPECT_EQ(own, fs::canonical(own));
  EXPECT_EQ(own.filename(), "test_cluster");
}

TEST(OwnProgram, IsTheLauncherWhereALoaderRunsIt)
{
  EXPECT_EQ(run::program_to_start("/a/bin/vrda", "vrda"), "/a/bin/vrda");
  EXPECT_EQ(run::program_to_start("/a/lib/glibc/ld-linux-x86-64.so.2", "/a/with-glibc/vrda"),
            "/a/with-glibc/vrda");
  EXPECT_EQ(run::program_to_start("/ld-linux/vrda", "vrda"), "/ld-linux/vrda");
}

}  // namespace vrda::own_program_test
