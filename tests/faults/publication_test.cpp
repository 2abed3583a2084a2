// Results of the commands that write files: two writers of one output, kills at each call that changes a
// name, and outputs that cannot be written.
#include <gmock/gmock.h>

#include <algorithm>
#include <optional>

#include "app/scenes.hpp"
#include "core/files.hpp"
#include "faults/faulty_run.hpp"

namespace vrda::publication_test {

namespace fs = std::filesystem;
using Words = std::vector<std::string>;
using test::Files;

constexpr const char* fit_tables = R"(
[fit]
noise = { anterior_mm = 0.1 }
[[fit.parameter]]
quantity = "reference_strain"
bundle = "ACLpl"
sd = 0.03
from = -0.1
to = 0.1
)";

Words joined(Words words, const Words& more)
{
  words.insert(words.end(), more.begin(), more.end());
  return words;
}

/// Two commands that differ in their last words and write the same output.
struct Pair {
  std::string main;  ///< file of the result that readers open, in the folder "out"
  Words words, first_more, second_more;
  bool refuses_existing = true;

  Words first() const { return joined(words, first_more); }
  Words second() const { return joined(words, second_more); }
  /// The words that allow replacing the result of the other.
  Words replace() const { return refuses_existing ? Words{"--replace"} : Words{}; }
};

class Publications : public testing::Test {
 protected:
  Publications() { fs::create_directory(out_); }
  ~Publications() override { fs::remove_all(out_); }

  // The inputs are made once; each test has a new folder "out".
  static void SetUpTestSuite()
  {
    scratch_.emplace();
    const std::string knee = test::text_of(VRDA_SOURCE_DIR "/jobs/knee-generic.toml");
    for (const char* mm : {"80", "87"})
      scratch_->write(std::string("marks") + mm + ".toml",
                      "[[distance]]\nfrom = \"medial_epicondyle\"\nto = \"lateral_epicondyle\"\nmm = " +
                          std::string(mm) + "\n");
    for (const char* mm : {"0", "1"})
      scratch_->write(std::string("measured") + mm + ".csv",
                      "flexion_deg,varus_deg,internal_deg,ant_mm,prox_mm,lat_mm\n10,0,0," + std::string(mm) +
                          ",0,0\n12,0,0,0,0,0\n");
    scratch_->write("knee.toml", knee + fit_tables);
    succeed({"run", path("knee.toml"), "--set", "grid.flexion.step=30", "--set", "grid.varus=\"free\"",
             "--set", "smooth.degrees=[]", "-o", path("grid.h5"), "-q", "--progress", "none"});
    succeed({"export", path("grid.h5"), "--to", "csv", "-o", path("poses.csv"), "-q"});
    succeed({"import", path("knee.toml"), "--motion", path("poses.csv"), "-o", path("poses.h5"), "-q"});
  }

  static void TearDownTestSuite() { scratch_.reset(); }

  static std::string path(const std::string& name) { return (scratch_->path() / name).string(); }
  static void succeed(const Words& words)
  {
    const test::Ended ended = test::run_vrda(words);
    EXPECT_EQ(ended.exit_code, 0) << testing::PrintToString(words) << ended.err;
  }

  static Pair prepare()
  {
    return {"knee.toml",
            {"prepare", "--no-ligaments", "-q", "-o", path("out"), "--landmarks"},
            {path("marks80.toml"), "--side", "left"},
            {path("marks87.toml"), "--side", "right"}};
  }
  static Pair fit_to()
  {
    return {"f.toml",
            {"fit", path("knee.toml"), "-q", "--progress", "none", "-o", path("out/f.toml"), "--to"},
            {path("measured0.csv")},
            {path("measured1.csv")}};
  }
  static Pair fit_motion()
  {
    return {"f.toml",
            {"fit", path("knee.toml"), "-q", "--motion", path("poses.csv"), "-o", path("out/f.toml"), "--set",
             "reference.component.0.offset_mm=\"fit\"", "--set"},
            {"title=\"a\""},
            {"title=\"b\""}};
  }
  static Pair repair()
  {
    return {"r.h5",
            {"repair", path("poses.h5"), "-q", "-o", path("out/r.h5"), "--noise-deg", "1", "--noise-mm"},
            {"0.5"},
            {"0.6"}};
  }
  static Pair shape()
  {
    return {"femur.stl",
            {"shape", "knee", "-q", "-o", path("out")},
            {"resolution=0.6"},
            {"resolution=0.5", "side=left"},
            false};
  }
  static Pair exported()
  {
    return {"k.osim",
            {"export", path("grid.h5"), "-q", "--to", "osim", "-o", path("out/k.osim"), "--set"},
            {"raw"},
            {"zero_varus"},
            false};
  }
  static std::vector<Pair> every_pair()
  {
    return {prepare(), fit_to(), fit_motion(), repair(), shape(), exported()};
  }

  Files files() const
  {
    Files all;
    for (const fs::directory_entry& entry : fs::recursive_directory_iterator(out_)) {
      if (entry.is_regular_file())
        all[fs::relative(entry.path(), out_).string()] = test::read_bytes(entry.path());
    }
    return all;
  }
  void clear() const
  {
    fs::remove_all(out_);
    fs::create_directory(out_);
  }
  /// What a command leaves in the empty folder.
  Files files_of(const Words& words) const
  {
    clear();
    succeed(words);
    return files();
  }

  static inline std::optional<test::Scratch> scratch_;
  fs::path out_ = scratch_->path() / "out";
};

TEST_F(Publications, TwoWritersOfOneOutputLoseNothing)
{
  for (const Pair& pair : every_pair()) {
    SCOPED_TRACE(testing::PrintToString(pair.first()));
    const Files first = files_of(pair.first()), second = files_of(pair.second());
    EXPECT_NE(first, second);
    clear();
    std::optional<OutputLock> lock = OutputLock::acquire((out_ / pair.main).string(), "the test", {});
    // Without --quiet, so that they say that they wait.
    const auto without_quiet = [](Words words) {
      std::erase(words, "-q");
      return test::vrda(words);
    };
    test::Process one(without_quiet(pair.first())), other(without_quiet(pair.second()));
    for (test::Process* process : {&one, &other}) {
      EXPECT_TRUE(process->runs_until_said("the test"));
    }
    EXPECT_EQ(files().size(), 1U);  // the lock
    lock.reset();
    const test::Ended a = one.wait(), b = other.wait();
    const int n_done = (a.exit_code == 0 ? 1 : 0) + (b.exit_code == 0 ? 1 : 0);
    EXPECT_EQ(n_done, pair.refuses_existing ? 1 : 2) << a.err << b.err;
    const Files found = files();
    EXPECT_TRUE(found == first || found == second);
    if (!pair.refuses_existing) continue;
    EXPECT_EQ(found, a.exit_code == 0 ? first : second);
    const test::Ended& refused = a.exit_code == 0 ? b : a;
    EXPECT_EQ(refused.exit_code, 2);
    EXPECT_THAT(refused.err, testing::HasSubstr("or --replace"));
  }
}

TEST_F(Publications, AKillLeavesOneResultOrNoneAndIsRepeated)
{
  struct Row {
    Pair pair;
    std::string call;
    bool is_replacing;
    int n_kills;  ///< before the last calls; earlier ones are in the hidden folder
  };
  for (const auto& [pair, call, is_replacing, n_kills] :
       {Row{prepare(), "rename", true, 8}, Row{fit_to(), "rename", false, 4},
        Row{fit_to(), "rename", true, 4}, Row{fit_to(), "unlink", true, 4}, Row{shape(), "rename", true, 8},
        Row{shape(), "unlink", true, 3}}) {
    const Words words = is_replacing ? joined(pair.second(), pair.replace()) : pair.second();
    SCOPED_TRACE(call + " of " + testing::PrintToString(words));
    const Files old = is_replacing ? files_of(pair.first()) : Files(), made = files_of(pair.second());
    const auto start = [&] {
      clear();
      for (const auto& [name, bytes] : old) scratch_->write("out/" + name, bytes);
    };
    start();
    const int n = test::n_calls_of(test::vrda(words), {"count", call, "1", out_.string()}, path("counts"));
    ASSERT_GE(n, n_kills);
    for (int k = n - n_kills + 1; k <= n; ++k) {
      if (!test::runs_full_set() && k != n - n_kills / 2 && k != n) continue;
      SCOPED_TRACE(k);
      start();
      const test::Fault fault{"kill", call, std::to_string(k), out_.string()};
      EXPECT_EQ(test::run(test::with_fault(test::vrda(words), fault)).exit_code, -1);
      // Readers open the main file: with it, all is of one result.
      Files found = files();
      std::erase_if(found,
                    [&](const auto& file) { return old.count(file.first) + made.count(file.first) == 0; });
      const bool is_whole = found.count(pair.main) > 0;
      EXPECT_TRUE(!is_whole || found == made || found == old);
      // The same command again; an interrupted result needs no --replace.
      succeed(is_whole ? joined(pair.second(), pair.replace()) : pair.second());
      EXPECT_EQ(files(), made);
    }
  }
}

TEST_F(Publications, AnOutputThatCannotBeWrittenIsAnInputError)
{
  const std::string long_name(300, 'x');
  fs::create_symlink("loop", scratch_->path() / "loop");
  const auto replaced = [](Words words, const std::string& from, const std::string& to) {
    std::ranges::replace(words, from, to);
    return words;
  };
  for (const Pair& pair : every_pair()) {
    SCOPED_TRACE(testing::PrintToString(pair.first()));
    const std::string output = *(std::ranges::find(pair.words, "-o") + 1);
    const std::string end = fs::path(output).extension().string();
    for (const std::string& name : {path(long_name + end), path("loop" + (end.empty() ? "" : "/a" + end))})
      EXPECT_EQ(test::run_vrda(replaced(pair.first(), output, name)).exit_code, 2) << name;
    if (pair.main == "r.h5" || pair.main == "k.osim") continue;
    // A folder in the place of each file: nothing is published.
    for (const auto& [name, bytes] : files_of(pair.first())) {
      if (!test::runs_full_set() && name != pair.main && !name.ends_with(".json") &&
          !name.ends_with("tibia.stl"))
        continue;
      clear();
      fs::create_directories(out_ / name);
      const test::Ended ended = test::run_vrda(joined(pair.first(), pair.replace()));
      EXPECT_THAT(ended, test::refuses({.file = fs::path(name).filename().string()}));
      EXPECT_EQ(files(), Files()) << name;
    }
  }
}

TEST_F(Publications, AStageOfADeadWriterIsRemovedByTheNext)
{
  fs::create_directory(out_ / ".vrda-abcdef");
  scratch_->write("out/.vrda-abcdef/femur.stl", "old");
  EXPECT_EQ(files_of(prepare().first()).count(".vrda-abcdef/femur.stl"), 0U);
  fs::create_directory(out_ / ".vrda-abcdef");
  scratch_->write("out/mine.txt", "kept");
  succeed(joined(prepare().second(), {"--replace"}));
  EXPECT_FALSE(fs::exists(out_ / ".vrda-abcdef"));
  EXPECT_TRUE(fs::exists(out_ / "mine.txt"));
}

TEST_F(Publications, APathThatIsNotUtf8CanBePrintedAsJson)
{
  const std::string table = (out_ / "a\xff.csv").string();
  succeed({"export", path("grid.h5"), "--to", "csv", "-o", table, "--json"});
  EXPECT_TRUE(fs::exists(table));
}

}  // namespace vrda::publication_test
