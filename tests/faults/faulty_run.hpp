/// Runs of `vrda` in which a system call goes wrong.
#pragma once

#include <gtest/gtest.h>

#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "support/process.hpp"
#include "support/scratch.hpp"

namespace vrda::test {

/// One fault, in the words of README.md.
struct Fault {
  std::string what;          ///< kill, torn, short, ...
  std::string call = "any";  ///< write, fsync, ...
  std::string at = "1";      ///< which of these calls; "3+": and all later ones
  std::string file = {};     ///< part of the file's path; empty: every file in the output's folder
};

/// The command with the shim loaded, so that it meets the fault at files whose path has `file` in it.
Command with_fault(Command command, const Fault& fault);

/// How many calls of the fault's kind a command makes until it ends: one number, all processes together.
int n_calls_of(const Command& command, const Fault& fault, const std::filesystem::path& counts);

/// A job of six attitudes by one way of solving.
struct Setting {
  std::string name;
  std::string method;
  bool is_knee = false;
  std::vector<std::string> words;  ///< added to `vrda run`
};
const Setting& search();
const Setting& equilibrium();
const Setting& traced_search();  ///< more files than the search without

/// With VRDA_FAULTS_ALL set the tests go through more calls and settings: minutes instead of seconds.
bool asks_for_all();
/// Equilibrium and traced search; all three where all is asked for.
std::vector<Setting> every_method();
/// One, for what does not depend on the method.
std::vector<Setting> one_method();
std::string name_of(const testing::TestParamInfo<Setting>& setting);
std::ostream& operator<<(std::ostream& out, const Setting& setting);

/// A job, the folder its output goes to and what an undisturbed run leaves there.
class FaultyRun : public testing::TestWithParam<Setting> {
 protected:
  FaultyRun();

  Command command() const;
  Ended run() const { return test::run(command()); }
  Ended run(const Fault& fault) const { return test::run(with_fault(command(), in_folder(fault))); }
  /// Empties the folder.
  void clear() const;
  /// run() from an empty folder.
  Ended run_anew(const Fault& fault) const;

  /// Of an undisturbed run from an empty folder; more than none, or the test has failed.
  int n_calls(const std::string& call, const std::string& file = "") const;

  /// The command once more: it must end well, in the bytes of the undisturbed run, and leave nothing else.
  /// Returns what it said on standard error.
  std::string expect_finishes() const;
  /// The folder holds what an undisturbed run leaves, byte for byte, and nothing else.
  void expect_finished() const;
  /// Exit code 2, one line that names a file in the folder; a result that is there is whole.
  void expect_refused(const Ended& ended) const;
  /// A model or trace at its final name is whole.
  void expect_no_part_of_a_result() const;

  /// The fault at files in the output's folder.
  Fault in_folder(Fault fault) const;

  /// Names in the output's folder.
  std::vector<std::string> names() const;
  int n_steps_recalled() const;
  std::string journal() const { return (folder_ / "a.h5.journal").string(); }

  Scratch scratch_;
  std::filesystem::path job_;
  std::filesystem::path folder_ = scratch_.path() / "out";

 private:
  std::map<std::string, std::string> hashes() const;

  std::map<std::string, std::string> undisturbed_;  ///< result's name -> SHA-256
  std::vector<std::string> undisturbed_names_;
};

}  // namespace vrda::test
