#include "run/run_record.hpp"

#include <ctime>
#include <nlohmann/json.hpp>
#include <thread>

#include "cluster/task_state.hpp"
#include "core/whole_file.hpp"

namespace vrda {
namespace {

// User and system time of all threads so far.
double processor_s()
{
  timespec spent{};
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &spent);
  return static_cast<double>(spent.tv_sec) + 1e-9 * static_cast<double>(spent.tv_nsec);
}

}  // namespace

RunRecord::RunRecord(int n_threads, int n_recalled)
    : begun_(std::chrono::system_clock::now()),
      start_(std::chrono::steady_clock::now()),
      processor_start_s_(processor_s()),
      n_threads_(n_threads),
      n_recalled_(n_recalled)
{
}

void RunRecord::note_solved()
{
  solving_ = std::chrono::steady_clock::now() - start_;
  solving_processor_s_ = processor_s() - processor_start_s_;
}

void RunRecord::write(const std::string& path) const
{
  const std::chrono::duration<double> elapsed = std::chrono::steady_clock::now() - start_;
  const nlohmann::ordered_json record = {{"begun", utc_text(begun_)},
                                         {"seconds", elapsed.count()},
                                         {"solving_seconds", solving_.count()},
                                         {"solving_processor_seconds", solving_processor_s_},
                                         {"threads", n_threads_},
                                         {"steps_recalled", n_recalled_},
                                         {"host", host_name()},
                                         {"processors", std::thread::hardware_concurrency()}};
  write_whole(path, {record.dump(2) + '\n'});
}

}  // namespace vrda
