// Commands that add to a motion model: the old one or the new one stands there, whatever call goes wrong.
#include <gmock/gmock.h>

#include <fstream>

#include "app/scenes.hpp"
#include "faults/faulty_run.hpp"

namespace vrda::test::model_faults_test {

namespace fs = std::filesystem;
using testing::ElementsAre;

class ModelFaults : public FaultyRun {
 protected:
  Command add_to_model(const std::string& what) const
  {
    const std::string file = folder_ / "a.h5";
    if (what == "smooth") return vrda({"smooth", file, "--degree", "1", "--robust", "--quiet"});
    return vrda({"reduce", file, "--set", "degree_1", "--quiet"});
  }

  void put(const std::string& bytes) const { std::ofstream(folder_ / "a.h5", std::ios::binary) << bytes; }
};

TEST_P(ModelFaults, TheOldModelStandsOrTheNewOne)
{
  fs::remove(folder_ / "a.h5.run.json");
  const std::string old_bytes = read_bytes(folder_ / "a.h5");
  for (const auto& [what, fault] :
       {std::pair{"smooth", "kill"}, std::pair{"smooth", "eio"}, std::pair{"reduce", "kill"}}) {
    put(old_bytes);
    const Command command = add_to_model(what);
    const int n = n_calls_of(command, in_folder({"count"}), scratch_.path() / "counts");
    EXPECT_GT(n, 6);
    const std::string new_bytes = read_bytes(folder_ / "a.h5");
    EXPECT_FALSE(new_bytes == old_bytes);
    for (int k = 1; k <= n; ++k) {
      SCOPED_TRACE(std::string(what) + " " + fault + " " + std::to_string(k));
      put(old_bytes);
      const Ended ended = test::run(with_fault(command, in_folder({fault, "any", std::to_string(k)})));
      // Errors of closing folders and of removing names that are gone already do not matter.
      EXPECT_THAT(ended.exit_code, testing::AnyOf(-1, 0, 2));
      EXPECT_EQ(n_lines(ended.err), ended.exit_code == 2 ? 1 : 0) << ended.err;
      const std::string there = read_bytes(folder_ / "a.h5");
      EXPECT_TRUE(there == new_bytes || (there == old_bytes && ended.exit_code != 0));
      EXPECT_EQ(test::run(command).exit_code, 0);
      EXPECT_TRUE(read_bytes(folder_ / "a.h5") == new_bytes);
      EXPECT_THAT(names(), ElementsAre("a.h5"));
    }
  }
}

INSTANTIATE_TEST_SUITE_P(All, ModelFaults, testing::Values(equilibrium()), name_of);

}  // namespace vrda::test::model_faults_test
