#include "core/process.hpp"

#include <gtest/gtest.h>
#include <sched.h>

#include <algorithm>
#include <thread>

#include "support/scratch.hpp"

namespace vrda::test {
namespace {

// More threads than processors wait for each other.
TEST(UsableProcessors, QuotasOfCgroups)
{
  struct Row {
    const char *name, *mounts, *cgroups, *folder;  ///< with the quota
    const char *quota, *period;                    ///< of version 1; of version 2 no period
    int expected;                                  ///< 0: all
  };
  const char* const unified = "31 23 0:28 / /sys/fs/cgroup rw - cgroup2 cgroup2 rw,nsdelegate\n";
  const char* const split = "33 31 0:30 / /sys/fs/cgroup/cpu,cpuacct rw - cgroup cgroup rw,cpu,cpuacct\n";
  const char* const container =
      "33 31 0:30 /docker/7 /sys/fs/cgroup/cpu ro master:9 - cgroup cgroup rw,cpu\n";
  const Row rows[] = {
      {"none", unified, "0::/user\n", "", "", "", 0},
      {"own", unified, "0::/user/job\n", "/sys/fs/cgroup/user/job/cpu.max", "100000 100000", "", 1},
      {"above", unified, "0::/user/job\n", "/sys/fs/cgroup/user/cpu.max", "5000 10000", "", 1},
      {"top of a container", unified, "0::/\n", "/sys/fs/cgroup/cpu.max", "100000 100000", "", 1},
      {"rounded up", unified, "0::/a\n", "/sys/fs/cgroup/a/cpu.max", "150000 100000", "", 2},
      {"unlimited", unified, "0::/a\n", "/sys/fs/cgroup/a/cpu.max", "max 100000", "", 0},
      {"another's", unified, "0::/a\n", "/sys/fs/cgroup/b/cpu.max", "100000 100000", "", 0},
      {"version 1", split, "5:memory:/m\n4:cpu,cpuacct:/a\n", "/sys/fs/cgroup/cpu,cpuacct/a/cpu.cfs_",
       "100000", "100000", 1},
      {"version 1, unlimited", split, "4:cpu,cpuacct:/a\n", "/sys/fs/cgroup/cpu,cpuacct/a/cpu.cfs_", "-1",
       "100000", 0},
      {"version 1 in a container", container, "3:cpu:/docker/7/b\n0::/\n", "/sys/fs/cgroup/cpu/cpu.cfs_",
       "40000", "50000", 1},
  };
  const int all = usable_processors();
  for (const Row& row : rows) {
    SCOPED_TRACE(row.name);
    const Scratch root;
    root.write("proc/self/mountinfo", std::string("22 1 8:1 / / rw - ext4 /dev/sda rw\n") + row.mounts);
    root.write("proc/self/cgroup", row.cgroups);
    const std::string file = std::string(row.folder).substr(*row.folder == '/' ? 1 : 0);
    const bool is_version_1 = *row.period != '\0';
    if (!file.empty()) root.write(file + (is_version_1 ? "quota_us" : ""), row.quota);
    if (is_version_1) root.write(file + "period_us", row.period);
    EXPECT_EQ(usable_processors(root.path()), row.expected == 0 ? all : std::min(all, row.expected));
  }
}

TEST(UsableProcessors, Affinity)
{
  cpu_set_t before, one;
  ASSERT_EQ(sched_getaffinity(0, sizeof before, &before), 0);
  CPU_ZERO(&one);
  int first = 0;
  while (!CPU_ISSET(first, &before)) ++first;
  CPU_SET(first, &one);
  int n = 0;
  std::thread([&] {  // of this thread alone
    if (sched_setaffinity(0, sizeof one, &one) == 0) n = usable_processors();
  })
      .join();
  EXPECT_EQ(n, 1);
}

}  // namespace
}  // namespace vrda::test
