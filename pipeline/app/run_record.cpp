#include "app/run_record.hpp"

#include <unistd.h>

#include <array>
#include <ctime>
#include <nlohmann/json.hpp>
#include <thread>

#include "app/output_file.hpp"

namespace vrda {
namespace {

std::string utc(std::chrono::system_clock::time_point when)
{
  const std::time_t seconds = std::chrono::system_clock::to_time_t(when);
  std::tm parts{};
  gmtime_r(&seconds, &parts);
  std::array<char, 32> text{};
  std::strftime(text.data(), text.size(), "%Y-%m-%dT%H:%M:%SZ", &parts);
  return text.data();
}

std::string host()
{
  std::array<char, 256> name{};
  return gethostname(name.data(), name.size() - 1) == 0 ? name.data() : "";
}

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
  const nlohmann::ordered_json record = {{"begun", utc(begun_)},
                                         {"seconds", elapsed.count()},
                                         {"solving_seconds", solving_.count()},
                                         {"solving_processor_seconds", solving_processor_s_},
                                         {"threads", n_threads_},
                                         {"steps_recalled", n_recalled_},
                                         {"host", host()},
                                         {"processors", std::thread::hardware_concurrency()}};
  write_file(path, record.dump(2) + '\n');
}

}  // namespace vrda
