/// Runs of `vrda` with an injected fault.
#pragma once

#include <gtest/gtest.h>

#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "support/process.hpp"
#include "support/scratch.hpp"

namespace vrda::test {

/// One fault, in the terms of README.md.
struct Fault {
  std::string what;          ///< kill, torn, short, ...
  std::string call = "any";  ///< write, fsync, ...
  std::string at = "1";      ///< which of these calls; "3+": and all later ones
  std::string file = {};     ///< part of the file's path; empty: every file in the output's folder
};

/// The command with the shim loaded; the fault applies to files whose path contains `file`.
Command with_fault(Command command, const Fault& fault);

/// Number of calls of the fault's kind by all processes of a command.
int n_calls_of(const Command& command, const Fault& fault, const std::filesystem::path& counts);

/// A job of six attitudes, four for a knee, and its method.
struct Setting {
  std::string name;
  std::string method;
  bool is_knee = false;
  std::vector<std::string> words;  ///< added to `vrda run`
};
const Setting& search();
const Setting& equilibrium();
const Setting& traced_search();  ///< writes more files than the search without traces

/// With VRDA_FAULTS_ALL set the tests cover more calls and settings: minutes instead of seconds.
bool runs_full_set();
/// Equilibrium and traced search; all three in the full set.
std::vector<Setting> every_method();
/// One setting, for tests that do not depend on the method.
std::vector<Setting> one_method();
/// `setting`, for files that do not depend on the method; search and equilibrium in the full set.
std::vector<Setting> untraced_or(const Setting& setting);
std::string name_of(const testing::TestParamInfo<Setting>& setting);
std::ostream& operator<<(std::ostream& out, const Setting& setting);

/// A job, its output folder and the files of a fault-free run.
class FaultyRun : public testing::TestWithParam<Setting> {
 protected:
  FaultyRun();

  Command command() const;
  Ended run() const { return test::run(command()); }
  Ended run(const Fault& fault) const { return test::run(with_fault(command(), in_folder(fault))); }
  /// Empties the folder.
  void clear() const;
  /// run() from an empty folder.
  Ended run_from_empty(const Fault& fault) const;

  /// Of a fault-free run from an empty folder; fails the test without any.
  int n_calls(const std::string& call, const std::string& file = "") const;

  /// Runs the command again: it must succeed with the files and bytes of the fault-free run. Returns its
  /// standard error.
  std::string expect_finishes() const;
  /// The folder contains exactly the files of a fault-free run, byte for byte.
  void expect_finished() const;
  /// Standard error without the job's own warning: with the equilibrium it has no ligaments.
  static std::string messages_of(const Ended& ended);
  /// Exit code 2, one line that names a file in the folder; an existing result is complete.
  void expect_refused(const Ended& ended) const;
  /// A model or trace at its final name is complete.
  void expect_no_incomplete_result() const;

  /// The fault, applied to files in the output's folder.
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

  std::map<std::string, std::string> expected_;  ///< result's name -> SHA-256
  std::vector<std::string> expected_names_;
};

}  // namespace vrda::test
