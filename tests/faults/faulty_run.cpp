#include "faults/faulty_run.hpp"

#include <gmock/gmock.h>

#include <algorithm>
#include <cstdlib>
#include <fstream>
#include <iostream>
#include <nlohmann/json.hpp>
#include <set>
#include <sstream>

#include "app/scenes.hpp"
#include "core/framed_file.hpp"
#include "store/journal.hpp"
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

namespace {

constexpr const char* all_steps = "steps of all journals";

/// The content of files that must not depend on faults.
Files essence_of(const Files& files)
{
  Files all;
  std::set<std::string> steps;
  for (const auto& [name, bytes] : files) {
    const bool is_journal = name.ends_with(".journal");
    all[name] = is_journal || name == "a.h5.run.json" ? "" : bytes;
    if (!is_journal) continue;
    const store::JournalContent content = store::parse_journal(name, bytes);
    EXPECT_EQ(content.dropped_reason, "") << name;
    for (const StepRecord& record : content.records) steps.insert(core::bytes_of_value(record));
  }
  for (const std::string& step : steps) all[all_steps] += step;
  return all;
}

/// 1 to `n` for "each", or the one call of the fault.
std::vector<std::string> calls_of(const FaultRow& row, int n)
{
  const std::string& at = row.fault.at;
  if (!at.starts_with("each")) return {at};
  std::vector<std::string> calls;
  const int n_faulty = n - row.n_last;
  constexpr int most_calls = 3;  // of a row
  const int wanted_stride = std::max(row.stride, (n_faulty + most_calls - 1) / most_calls);
  const int stride = runs_full_set() ? 1 : std::clamp(wanted_stride, 1, std::max(1, n_faulty));
  for (int k = 1; k <= n_faulty; ++k) {
    // Other faults of a table get other calls.
    if ((k + static_cast<int>(row.fault.what.size())) % stride == 0)
      calls.push_back(std::to_string(k) + (at == "each+" ? "+" : ""));
  }
  EXPECT_FALSE(calls.empty());
  return calls;
}

}  // namespace

FaultyRun::FaultyRun()
{
  job_ = GetParam().is_knee ? small_knee_job(scratch_, "right") : small_job(scratch_);
  whole_run_ = stage("run", command(), {});
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

void FaultyRun::put(const Files& files) const
{
  fs::remove_all(folder_);
  fs::create_directory(folder_);
  for (const auto& [name, bytes] : files) std::ofstream(folder_ / name, std::ios::binary) << bytes;
}

Files FaultyRun::files() const
{
  Files all;
  for (const std::string& name : names()) all[name] = read_bytes(folder_ / name);
  return all;
}

Ended FaultyRun::run_from_empty(const Fault& fault) const
{
  clear();
  return run(fault);
}

Stage FaultyRun::stage(const std::string& name, const Command& command, const Files& before) const
{
  put(before);
  const Ended ended = test::run(command);
  EXPECT_EQ(ended.exit_code, 0) << name << ": " << ended.err;
  return {name, command, before, files()};
}

int FaultyRun::n_calls(const Stage& stage, const Fault& fault) const
{
  put(stage.before);
  return n_calls_of(stage.command, in_folder(fault), scratch_.path() / "counts");
}

void FaultyRun::expect_survives(const Stage& stage, const FaultRow& row) const
{
  const bool is_each = row.fault.at.starts_with("each");
  for (const std::string& at : calls_of(row, is_each ? n_calls(stage, row.fault) : 1)) {
    Fault fault = row.fault;
    fault.at = at;
    SCOPED_TRACE(stage.name + ": " + fault.what + " at " + fault.call + " " + at + " " + fault.file);
    put(stage.before);
    expect_ending(test::run(with_fault(stage.command, in_folder(fault))), row);
    expect_no_incomplete_result();
    if (row.ending == Ending::unchanged) {
      expect_same(stage.after);
    } else {
      expect_finishes(stage);
    }
    if (row.n_recalled > 0) {
      EXPECT_GE(n_steps_recalled(), row.n_recalled);
    }
  }
}

void FaultyRun::expect_ending(const Ended& ended, const FaultRow& row) const
{
  const std::string said = messages_of(ended);
  switch (row.ending) {
    case Ending::killed:
      EXPECT_EQ(ended.exit_code, -1);
      return;
    case Ending::refused:
      expect_refused(ended);
      EXPECT_THAT(said, reports("", row.said));
      return;
    case Ending::warned:
      EXPECT_EQ(ended.exit_code, 0);
      EXPECT_EQ(n_lines(said), 1) << ended.err;
      EXPECT_THAT(said, warns("", row.said));
      return;
    case Ending::unchanged:
    case Ending::done:
      EXPECT_EQ(ended.exit_code, 0) << ended.err;
      return;
    case Ending::either:
      EXPECT_THAT(ended.exit_code, testing::AnyOf(0, 2)) << ended.err;
      if (ended.exit_code == 0) return;
      EXPECT_TRUE(printed_facts(ended.err).file.starts_with(folder_.string() + "/a.")) << ended.err;
      return;
  }
}

std::vector<std::string> FaultyRun::names() const
{
  std::vector<std::string> all;
  for (const auto& entry : fs::directory_iterator(folder_)) all.push_back(entry.path().filename());
  std::sort(all.begin(), all.end());
  return all;
}

std::string FaultyRun::expect_finishes(const Stage& stage) const
{
  const Ended ended = test::run(stage.command);
  EXPECT_EQ(ended.exit_code, 0) << ended.err;
  expect_same(stage.after);
  return ended.err;
}

void FaultyRun::expect_same(const Files& wanted) const
{
  const Files found = essence_of(files()), expected = essence_of(wanted);
  EXPECT_THAT(found, testing::SizeIs(expected.size()));
  for (const auto& [name, bytes] : expected)
    EXPECT_TRUE(found.contains(name) && found.at(name) == bytes) << name << " is missing or differs";
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
  for (const char* name : {"a.h5", "a.trace.h5"}) {
    if (!fs::exists(folder_ / name)) continue;
    EXPECT_TRUE(read_bytes(folder_ / name) == whole_run_.after.at(name)) << name << " is incomplete";
  }
}

int FaultyRun::n_steps_recalled() const
{
  const auto record = nlohmann::json::parse(read_bytes(folder_ / "a.h5.run.json"));
  return record.at("steps_recalled");
}

namespace {

Command held_at(Command command, const fs::path& gate)
{
  fs::remove(gate);
  fs::remove(gate.string() + ".held");
  command.environment["VRDA_FAULT_GATE"] = gate.string();
  return command;
}

}  // namespace

HeldProcess::HeldProcess(const Scratch& scratch, Command command, const Fault& fault)
    : gate_(scratch.path() / "gate"), process_(held_at(with_fault(std::move(command), fault), gate_))
{
  EXPECT_TRUE(process_.runs_until_file(gate_.string() + ".held"))
      << "it never came to " << fault.call << " of " << fault.file;
}

Ended HeldProcess::release()
{
  std::ofstream{gate_};
  return process_.wait();
}

}  // namespace vrda::test
