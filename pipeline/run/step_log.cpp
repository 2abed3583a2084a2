#include "run/step_log.hpp"

#include <chrono>
#include <filesystem>
#include <thread>
#include <utility>

#include "core/error.hpp"
#include "talk/interrupt.hpp"
#include "talk/talk.hpp"

namespace vrda {
namespace {

StepLog log_of(const std::string& path, OpenJournal opened)
{
  const JournalContent& content = opened.content;
  if (!content.dropped_why.empty()) {
    warn(path + ": dropped " + std::to_string(content.dropped_bytes) + " bytes at the end (" +
         content.dropped_why + "); those steps are solved again");
  }
  StepLog log{path, std::move(opened.writer), {}, {}};
  for (const StepRecord& r : content.records) log.known.emplace(r.key, r);
  if (!log.known.empty()) say("resuming: " + std::to_string(log.known.size()) + " steps found in " + path);
  return log;
}

bool is_in_place(const StepLog& log)
{
  return log.writer.is_in_place() && (!log.traces || log.traces->is_in_place());
}

}  // namespace

StepLog open_log(const std::string& path, const std::string& key, bool is_fresh)
{
  if (is_fresh) return {path, JournalWriter::create(path, key), {}, {}};
  return log_of(path, JournalWriter::open(path, key));
}

std::optional<StepLog> open_log_waiting(const std::string& path, const std::string& key, bool is_fresh,
                                        const Patience& patience)
{
  if (is_fresh) return open_log(path, key, true);
  constexpr std::chrono::milliseconds pause{100};
  for (std::chrono::milliseconds waited{0};; waited += pause) {
    if (is_interrupted()) return std::nullopt;
    if (std::optional<OpenJournal> opened = JournalWriter::try_open(path, key)) {
      return log_of(path, std::move(*opened));
    }
    if (waited == pause) {
      say("waiting for the run that writes " + path);
      patience.begins();
    }
    if (waited >= patience.longest) return std::nullopt;
    std::this_thread::sleep_for(pause);
  }
}

std::optional<StepRecord> recalled(const StepLog& log, const StepKey& key)
{
  const auto found = log.known.find(key);
  return found == log.known.end() ? std::nullopt : std::optional(found->second);
}

void put_back_lost(const StepLog& log, const std::string& output)
{
  if (is_in_place(log)) return;
  const std::string found = "a folder that was deleted or moved during the run";
  try {
    if (!log.writer.is_in_place()) log.writer.restore();
    if (log.traces && !log.traces->is_in_place()) log.traces->restore();
  } catch (const InputError& error) {
    throw InputError(
        {output, "folder", found, std::string("it left alone; what was solved is lost: ") + error.what()});
  }
  const std::size_t n = read_journal(log.path).records.size();
  throw InputError({output, "folder", found,
                    "it left alone; it is there again with the journal of all " + std::to_string(n) +
                        " steps solved, and the same command goes on from them"});
}

}  // namespace vrda
