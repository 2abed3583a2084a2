#include "faults/faulty_run.hpp"

#include <gmock/gmock.h>

#include <algorithm>
#include <cstdlib>
#include <fstream>
#include <iostream>
#include <nlohmann/json.hpp>
#include <sstream>

#include "app/scenes.hpp"
#include "support/messages.hpp"

namespace vrda::test {

namespace fs = std::filesystem;

namespace {

/// Number of trials by test suite, command and fault, printed when the program ends: results/fuzz.md.
struct Trials {
  std::map<std::string, int> n;
  ~Trials()
  {
    for (const auto& [name, n_trials] : n) std::cout << "trials: " << name << ": " << n_trials << '\n';
  }
};

void count_trial(const Command& command, const std::string& what)
{
  static Trials trials;
  const testing::TestSuite* suite = testing::UnitTest::GetInstance()->current_test_suite();
  std::string name = suite == nullptr ? "none" : suite->name();
  for (const std::string& word : command.arguments) {
    if (&word == &command.arguments.front() || word == "--spine" || word == "--shard") name += " " + word;
  }
  ++trials.n[name + " " + what];
}

}  // namespace

Command with_fault(Command command, const Fault& fault)
{
  if (fault.what != "count") count_trial(command, fault.what);
  std::map<std::string, std::string>& variables = command.environment;
  variables["LD_PRELOAD"] = VRDA_FAULT_SHIM;
  // The address sanitizer's library must otherwise be loaded first.
  variables["ASAN_OPTIONS"] = "verify_asan_link_order=0";
  variables["VRDA_FAULT_FILE"] = fault.file;
  variables["VRDA_FAULT_CALL"] = fault.call;
  variables["VRDA_FAULT_AT"] = fault.at;
  variables["VRDA_FAULT_DO"] = fault.what;
  return command;
}

int n_calls_of(const Command& command, const Fault& fault, const fs::path& counts)
{
  fs::remove(counts);
  Command counted = with_fault(command, {"count", fault.call, "1", fault.file});
  counted.environment["VRDA_FAULT_COUNT"] = counts.string();
  const Ended ended = run(counted);
  EXPECT_EQ(ended.exit_code, 0) << ended.err;
  std::istringstream lines(read_bytes(counts));
  int n = 0;
  for (int of_process = 0; lines >> of_process;) n += of_process;
  EXPECT_GT(n, 0) << fault.call << " of " << fault.file;
  return n;
}

const Setting& search()
{
  static const Setting setting{"search", "stability-search", false, {}};
  return setting;
}

const Setting& equilibrium()
{
  static const Setting setting{
      "equilibrium", "equilibrium", true, {"--set", "solver.equilibrium.restarts=1"}};
  return setting;
}

const Setting& traced_search()
{
  static const Setting setting{"trace", "stability-search", false, {"--trace"}};
  return setting;
}

bool runs_full_set()
{
  return std::getenv("VRDA_FAULTS_ALL") != nullptr;
}

std::vector<Setting> every_method()
{
  if (runs_full_set()) return {search(), equilibrium(), traced_search()};
  return {equilibrium(), traced_search()};
}

std::vector<Setting> one_method()
{
  return runs_full_set() ? every_method() : std::vector{traced_search()};
}

std::vector<Setting> untraced_or(const Setting& setting)
{
  if (runs_full_set()) return {search(), equilibrium()};
  return {setting};
}

std::string name_of(const testing::TestParamInfo<Setting>& setting)
{
  return setting.param.name;
}

std::ostream& operator<<(std::ostream& out, const Setting& setting)
{
  return out << setting.name;
}

FaultyRun::FaultyRun()
{
  job_ = GetParam().is_knee ? small_knee_job(scratch_, "right") : small_job(scratch_);
  fs::create_directory(folder_);
  const Ended ended = run();
  EXPECT_EQ(ended.exit_code, 0) << ended.err;
  expected_ = hashes();
  expected_names_ = names();
  EXPECT_EQ(expected_.size(), expected_names_.size() - 1);  // all but the run record
}

Command FaultyRun::command() const
{
  std::vector<std::string> words{"run",     job_.string(), "-o", (folder_ / "a.h5").string(),
                                 "--quiet", "--threads",   "1"};
  for (const std::string& value :
       {"solver.method=\"" + GetParam().method + "\"",
        std::string("grid.flexion={from=0,step=2,to=") + (GetParam().is_knee ? "2}" : "4}"),
        std::string("grid.varus={from=0,to=2,step=2}"), std::string("smooth.degrees=[1]")}) {
    words.insert(words.end(), {"--set", value});
  }
  words.insert(words.end(), GetParam().words.begin(), GetParam().words.end());
  return vrda(words);
}

Fault FaultyRun::in_folder(Fault fault) const
{
  fault.file = folder_.string() + (fault.file.empty() ? "" : "/" + fault.file);
  return fault;
}

void FaultyRun::clear() const
{
  fs::remove_all(folder_);
  fs::create_directory(folder_);
}

Ended FaultyRun::run_from_empty(const Fault& fault) const
{
  clear();
  return run(fault);
}

int FaultyRun::n_calls(const std::string& call, const std::string& file) const
{
  clear();
  return n_calls_of(command(), in_folder({"count", call, "1", file}), scratch_.path() / "counts");
}

std::map<std::string, std::string> FaultyRun::hashes() const
{
  std::map<std::string, std::string> all;
  for (const std::string name : {"a.h5", "a.trace.h5"}) {
    if (fs::exists(folder_ / name)) all[name] = sha256_of_file(folder_ / name);
  }
  return all;
}

std::vector<std::string> FaultyRun::names() const
{
  std::vector<std::string> all;
  for (const auto& entry : fs::directory_iterator(folder_)) all.push_back(entry.path().filename());
  std::sort(all.begin(), all.end());
  return all;
}

std::string FaultyRun::expect_finishes() const
{
  const Ended ended = run();
  EXPECT_EQ(ended.exit_code, 0) << ended.err;
  expect_finished();
  return ended.err;
}

void FaultyRun::expect_finished() const
{
  EXPECT_EQ(hashes(), expected_);
  EXPECT_EQ(names(), expected_names_);
}

std::string FaultyRun::messages_of(const Ended& ended)
{
  const bool is_warned = ended.err.rfind("warning: ligaments: found none", 0) == 0;
  return is_warned ? ended.err.substr(ended.err.find('\n') + 1) : ended.err;
}

void FaultyRun::expect_refused(const Ended& ended) const
{
  const std::string error = messages_of(ended);
  EXPECT_EQ(ended.exit_code, 2) << ended.err;
  EXPECT_EQ(n_lines(error), 1) << ended.err;
  const InputError::Facts facts = printed_facts(error);
  EXPECT_TRUE(facts.file.starts_with(folder_.string() + "/a.")) << error;
  EXPECT_FALSE(facts.found.empty()) << error;
  EXPECT_EQ(ended.out, "");
  expect_no_incomplete_result();
}

void FaultyRun::expect_no_incomplete_result() const
{
  for (const auto& [name, hash] : hashes()) EXPECT_EQ(hash, expected_.at(name)) << name;
}

int FaultyRun::n_steps_recalled() const
{
  const auto record = nlohmann::json::parse(read_bytes(folder_ / "a.h5.run.json"));
  return record.at("steps_recalled");
}

}  // namespace vrda::test
