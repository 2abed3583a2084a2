/// Replaces Slurm's programs that vrda calls.
#pragma once

#include <gtest/gtest.h>

#include <filesystem>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "app/scenes.hpp"

namespace vrda::test {

/// Programs with Slurm's names that record their calls; sbatch runs the script immediately if `runs` is set.
class FakeSlurm : public testing::Test {
 protected:
  FakeSlurm()
  {
    program("sbatch", R"(
echo "sbatch $*" >> "$fake/calls"
id=$(($(cat "$fake/last" 2>/dev/null || echo 100) + 1)); echo $id > "$fake/last"
if [ "$id" = "${refused:-}" ]; then echo 'sbatch: error: Job violates policy' >&2; exit 1; fi
echo $id
[ -n "${runs:-}" ] || exit 0
array=
while [[ $1 == --* ]]; do
  case $1 in --array=*) array=${1#--array=}; array=${array%\%*} ;; --output=*) log=${1#--output=} ;; esac
  shift
done
export SLURM_JOB_ID=$id SLURM_CPUS_PER_TASK=1
if [ -z "$array" ]; then bash "$@" >> "${log}" 2>&1; exit 0; fi
export SLURM_ARRAY_JOB_ID=$id
for part in ${array//,/ }; do
  for SLURM_ARRAY_TASK_ID in $(seq ${part%-*} ${part#*-}); do
    export SLURM_ARRAY_TASK_ID
    bash "$@" >> "${log//%a/$SLURM_ARRAY_TASK_ID}" 2>&1
  done
done
exit 0)");
    program("squeue", "cat \"$fake/queue\" 2>/dev/null; true");
    program("scontrol", "echo 'MaxArraySize = 11'; echo 'MaxJobCount = 40'");
    program("scancel", "echo \"scancel $*\" >> \"$fake/calls\"");
  }

  void program(const std::string& name, const std::string& body)
  {
    std::filesystem::permissions(scratch_.write("bin/" + name, "#!/bin/bash\n" + body + "\n"),
                                 std::filesystem::perms::owner_all);
  }

  Ended run(std::vector<std::string> words, const std::map<std::string, std::string>& environment = {})
  {
    Command command = vrda(std::move(words));
    command.environment = environment;
    command.environment["fake"] = scratch_.path().string();
    command.environment["PATH"] = (scratch_.path() / "bin").string() + ":/usr/bin:/bin";
    return test::run(command);
  }

  Ended submit(const std::vector<std::string>& more,
               const std::map<std::string, std::string>& environment = {})
  {
    std::vector<std::string> words{"submit", job_.string(), "-o",    folder_.string(),
                                   "--time", "10",          "--mem", "200M"};
    words.insert(words.end(), more.begin(), more.end());
    return run(words, environment);
  }

  void queue(const std::string& lines) { scratch_.write("queue", lines); }
  std::string calls() const { return text_of(scratch_.path() / "calls"); }
  void forget_calls() const { std::filesystem::remove(scratch_.path() / "calls"); }

  Scratch scratch_;
  std::filesystem::path job_ = small_knee_job(scratch_, "right");
  std::filesystem::path folder_ = scratch_.path() / "it's a \"folder\"";
};

}  // namespace vrda::test
