/// Runs of `vrda` with an injected fault.
#pragma once

#include <gtest/gtest.h>

#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "support/process.hpp"
#include "support/refusal.hpp"
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

/// Equilibrium and traced search; all three in the full set.
std::vector<Setting> every_method();
/// One setting, for tests that do not depend on the method.
std::vector<Setting> one_method();
/// `setting`, for files that do not depend on the method; search and equilibrium in the full set.
std::vector<Setting> untraced_or(const Setting& setting);
std::string name_of(const testing::TestParamInfo<Setting>& setting);
std::ostream& operator<<(std::ostream& out, const Setting& setting);

using Files = std::map<std::string, std::string>;  ///< name -> bytes

/// A command with the files of its folder before it, and after it without a fault.
struct Stage {
  std::string name;
  Command command;
  Files before = {}, after = {};
};

/// How a command ends that gets a fault.
enum class Ending {
  killed,
  refused,    ///< exit code 2 and one line that names a file of the folder
  warned,     ///< exit code 0 and one line, a warning
  unchanged,  ///< exit code 0 and the files of a run without a fault
  done,       ///< exit code 0
  either,     ///< exit code 0 or 2
};

/// One row of a table of faults. `fault.at`: "each" call from the first to the last in turn, "each+": that
/// and all later ones, or a number.
struct FaultRow {
  Fault fault;
  Ending ending;
  Values said = {};    ///< in the line of a refusal or warning
  int n_last = 0;      ///< calls at the end without the fault
  int stride = 1;      ///< every n-th call, in the full set each
  int n_recalled = 0;  ///< at least so many steps are recalled by the repeated command
};

/// A job, its output folder and the files of a fault-free run.
class FaultyRun : public testing::TestWithParam<Setting> {
 protected:
  FaultyRun();

  Command command() const;
  Ended run() const { return test::run(command()); }
  Ended run(const Fault& fault) const { return test::run(with_fault(command(), in_folder(fault))); }
  /// Empties the folder.
  void clear() const { put({}); }
  /// run() from an empty folder.
  Ended run_from_empty(const Fault& fault) const;

  /// The folder's files, and the folder with these files only.
  Files files() const;
  void put(const Files& files) const;

  /// Of a fault-free run from an empty folder.
  const Stage& whole_run() const { return whole_run_; }
  /// Runs the command from these files; it must succeed.
  Stage stage(const std::string& name, const Command& command, const Files& before) const;
  /// Number of calls by a fault-free run of the stage; fails the test without any.
  int n_calls(const Stage& stage, const Fault& fault) const;
  /// Runs the stage with the faults of the row in turn: it must end like that, leave no incomplete result,
  /// and give its files, if need be when it is run again.
  void expect_survives(const Stage& stage, const FaultRow& row) const;
  /// Runs the stage's command again, which must succeed and give its files. Returns its standard error.
  std::string expect_finishes(const Stage& stage) const;
  std::string expect_finishes() const { return expect_finishes(whole_run_); }
  /// The folder contains exactly these files; of run records only their existence counts, of journals the
  /// union of their steps, since a step that is derived from others may be in any of them.
  void expect_same(const Files& wanted) const;
  void expect_finished() const { expect_same(whole_run_.after); }

  /// Standard error without the job's own warning: with the equilibrium it has no ligaments.
  static std::string messages_of(const Ended& ended);
  /// Ending::refused; an existing result is complete.
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
  void expect_ending(const Ended& ended, const FaultRow& row) const;

  Stage whole_run_;
};

/// A process held at a fault "hold" until it is released, ends or is signalled.
class HeldProcess {
 public:
  /// Starts the command and waits until it is held; fails the test if it ends before.
  HeldProcess(const Scratch& scratch, Command command, const Fault& fault);

  void send(int signal) const { process_.send(signal); }
  /// Lets it go on and waits until it ends.
  Ended release();

 private:
  std::filesystem::path gate_;
  Process process_;
};

}  // namespace vrda::test
