// The same job gives the same bytes, model and trace, for any number of threads and processor, however it is
// killed, interrupted and damaged on its way, and in shards.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <csignal>

#include "app/scenes.hpp"
#include "store/journal.hpp"
#include "store/motion_model.hpp"
#include "store/trace.hpp"
#include "support/messages.hpp"

namespace vrda::same_bytes_test {

namespace fs = std::filesystem;
using test::Scratch;

/// A kind of job that is solved in its own way.
struct Kind {
  const char* name;
  std::function<fs::path(const Scratch&)> job;
  std::vector<std::string> words;  ///< more of `vrda run`
  std::uintmax_t n_bytes = 0;      ///< of the journal when it is first killed; 0: too short to be killed
  bool has_trace = false;
};

fs::path longer_knee(const Scratch& scratch)
{
  return test::longer_knee_job(scratch);
}

/// Frames of a motion up and down again instead of a grid.
fs::path frames(const Scratch& scratch)
{
  const fs::path file = test::small_knee_job(scratch, "right");
  scratch.write("motion.csv",
                "time_s,flexion_deg,internal_deg\n0.0,0,0.5\n0.1,2,0.2\n0.2,4,-0.4\n0.3,2,-0.1\n0.5,1,0.3\n");
  test::edit(file, "flexion = { from = 0, to = 12, step = 2 }\nvarus = { from = -2, to = 2, step = 1 }\n",
             "");
  test::edit(file, "[grid]\n",
             "[frames]\nfile = \"motion.csv\"\n[coordinates]\nflexion = { column = \"flexion_deg\" }\n"
             "internal = { column = \"internal_deg\" }\n");
  return file;
}

/// A knee with ligaments, whose stiffnesses and strains are uncertain.
fs::path uncertain_knee(const Scratch& scratch)
{
  return scratch.write("uncertain.toml", test::coarse_knee_text + test::stiffness_and_strain);
}

/// The same knee with a prior, whose curve and the cartilage are uncertain.
fs::path knee_with_prior(const Scratch& scratch)
{
  return scratch.write("prior.toml", test::coarse_knee_text + test::prior_and_its_spread);
}

fs::path knee_with_sesamoid(const Scratch& scratch)
{
  return test::sesamoid_job(scratch, test::longer_knee_job(scratch));
}

/// The tension of its lines and the stiffness of its tendon are uncertain, and pull on the tibia.
fs::path knee_with_uncertain_sesamoid(const Scratch& scratch)
{
  const fs::path job = test::sesamoid_job(scratch, test::small_knee_job(scratch, "right"));
  scratch.write(job.filename().string(), test::text_of(job) + test::uncertain_sesamoid);
  test::edit(job, "tension_n = 20", "tension_n = 20\nreaction = true");
  return job;
}

const std::vector<std::string> equilibrium{"--set", "solver.method=equilibrium"};

std::vector<std::string> equilibrium_and(const std::vector<std::string>& more)
{
  std::vector<std::string> words = equilibrium;
  words.insert(words.end(), more.begin(), more.end());
  return words;
}

const std::vector<Kind> kinds{
    {"search", longer_knee, {"--trace"}, 3000, true},
    {"equilibrium", longer_knee, equilibrium_and({"--trace"}), 20000, true},
    {"scaled", longer_knee, equilibrium_and({"--set", "scaling.factor=1.07"}), 20000},
    {"offset", longer_knee, equilibrium_and({"--set", "reference.component.0.offset_mm=0.8"}), 20000},
    {"soft", longer_knee,
     equilibrium_and(
         {"--set", "moving.component.0.overlap_mm=0.5", "--set", "solver.equilibrium.branch=continuous"}),
     20000},
    {"follower", knee_with_sesamoid, equilibrium_and({"--trace"}), 40000, true},
    {"reaction", knee_with_sesamoid,
     equilibrium_and({"--set", "follower.0.reaction=true", "--set", "solver.equilibrium.branch=continuous"}),
     40000},
    {"frames", frames, equilibrium},
    {"samples", uncertain_knee, {}, 12000},
    {"sampled_follower", knee_with_uncertain_sesamoid, equilibrium_and({"--set", "grid.varus=free"}), 12000},
    {"prior", knee_with_prior, {}, 12000},
    {"prepared",
     knee_with_prior,
     {"--set", "solver.equilibrium.contact.model=compliant", "--set", "solver.equilibrium.branch=continuous"},
     12000},
};

class SameBytes : public testing::TestWithParam<Kind> {
 protected:
  test::Command command(const std::string& name, const std::vector<std::string>& more = {}) const
  {
    std::vector<std::string> words{"run", job_.string(), "-o", output(name), "--progress", "none"};
    words.insert(words.end(), GetParam().words.begin(), GetParam().words.end());
    words.insert(words.end(), more.begin(), more.end());
    return test::vrda(words);
  }
  std::string output(const std::string& name) const { return (scratch_.path() / (name + ".h5")).string(); }

  void expect_solved(const test::Command& run) const
  {
    const test::Ended ended = test::run(run);
    EXPECT_EQ(ended.exit_code, 0) << ended.err;
  }
  void expect_same(const std::string& name) const
  {
    EXPECT_EQ(test::sha256_of_file(output(name)), test::sha256_of_file(output("whole"))) << name;
    if (!GetParam().has_trace) return;
    EXPECT_EQ(test::sha256_of_file(store::trace_name(output(name))),
              test::sha256_of_file(store::trace_name(output("whole"))))
        << name;
  }
  /// Starts the run and sends the signal once its journal has grown; returns how it ended.
  test::Ended stopped(const std::string& name, int signal) const
  {
    const std::string journal = output(name) + ".journal";
    std::error_code none;
    const std::uintmax_t before = fs::exists(journal, none) ? fs::file_size(journal, none) : 0;
    test::Process process(command(name, {"--threads", "1"}));
    test::wait_for_bytes(process, journal, before + (before == 0 ? GetParam().n_bytes : 2000));
    EXPECT_TRUE(process.is_running()) << "ended before it could be stopped";
    process.send(signal);
    return process.wait();
  }

  /// Killed and interrupted on its way, with a damaged journal.
  void expect_same_after_stops() const
  {
    const std::string file = output("stopped"), journal = file + ".journal";
    std::signal(SIGHUP, SIG_DFL);  // as if not under nohup
    EXPECT_EQ(stopped("stopped", SIGKILL).exit_code, -1);
    EXPECT_FALSE(fs::exists(file));
    EXPECT_THAT(store::validate_hdf5(file + ".start.h5"), testing::IsEmpty());
    for (const int signal : {SIGTERM, SIGHUP}) {
      const test::Ended ended = stopped("stopped", signal);
      EXPECT_EQ(ended.exit_code, 4);
      EXPECT_THAT(ended.err, test::reports("interrupted", journal));
    }
    // The tail is torn, and damaged before; a trace must have every step of the journal.
    if (!GetParam().has_trace) {
      std::string bytes = test::read_bytes(journal);
      bytes.resize(bytes.size() - 100);
      bytes[bytes.size() - 200] = static_cast<char>(bytes[bytes.size() - 200] ^ 0x10);
      scratch_.write("stopped.h5.journal", bytes);
    }
    const test::Ended last = test::run(command("stopped"));
    EXPECT_EQ(last.exit_code, 0) << last.err;
    EXPECT_THAT(last.err, test::reports("resuming", journal));
    EXPECT_EQ(test::names_value(last.err, "warning: " + journal), !GetParam().has_trace);
    expect_same("stopped");
  }

  void SetUp() override { expect_solved(command("whole", {"--threads", "1"})); }

  Scratch scratch_;
  fs::path job_ = GetParam().job(scratch_);
};

// Another number of threads, on a processor without vector instructions; a job that takes long enough is
// stopped; shards have no trace, and shard_test.cpp has the other jobs.
TEST_P(SameBytes, HoweverItIsSolved)
{
  test::Command plain = command("plain", {"--threads", "3"});
  plain.environment["GLIBC_TUNABLES"] = "glibc.cpu.hwcaps=-AVX2,-FMA,-AVX2_Usable,-FMA_Usable";
  expect_solved(plain);
  expect_same("plain");
  if (GetParam().n_bytes > 0) expect_same_after_stops();
  if (GetParam().has_trace) return;
  for (const char* shard : {"1/3", "2/3", "3/3"}) expect_solved(command("parts", {"--shard", shard}));
  expect_solved(test::vrda({"merge", "-o", output("parts")}));
  expect_same("parts");
}

std::string name_of(const testing::TestParamInfo<Kind>& kind)
{
  return kind.param.name;
}

INSTANTIATE_TEST_SUITE_P(Each, SameBytes, testing::ValuesIn(kinds), name_of);

}  // namespace vrda::same_bytes_test
