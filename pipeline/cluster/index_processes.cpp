#include "cluster/index_processes.hpp"

#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <csignal>
#include <cstring>
#include <nlohmann/json.hpp>
#include <sstream>

#include "core/error.hpp"
#include "core/units.hpp"

namespace vrda {
namespace {

using Json = nlohmann::ordered_json;

// A process that makes every n-th row, and the memory it leaves them in, a line each.
struct Worker {
  pid_t pid = -1;
  int memory = -1;
};

void write_all(int descriptor, const std::string& bytes)
{
  std::size_t n_written = 0;
  while (n_written < bytes.size()) {
    const ssize_t n = ::write(descriptor, bytes.data() + n_written, bytes.size() - n_written);
    if (n < 0 && errno == EINTR) continue;
    if (n <= 0) throw InputError({"index", "", std::strerror(errno), "room in memory for the rows"});
    n_written += static_cast<std::size_t>(n);
  }
}

std::string read_all(int descriptor)
{
  std::string bytes;
  char buffer[1 << 16];
  off_t at = 0;
  for (ssize_t n = 0; (n = ::pread(descriptor, buffer, sizeof buffer, at)) > 0; at += n) {
    bytes.append(buffer, static_cast<std::size_t>(n));
  }
  return bytes;
}

// Ends the copy of the process without its parent's farewells.
[[noreturn]] void work(const Worker& worker, std::size_t first, std::size_t step, std::size_t n_rows,
                       const std::function<IndexRow(std::size_t)>& row_of)
{
  ::prctl(PR_SET_PDEATHSIG, SIGKILL);  // nobody would read the rows
  try {
    for (std::size_t k = first; k < n_rows; k += step)
      write_all(worker.memory, text_of_row(row_of(k)) + "\n");
  } catch (const std::exception& error) {
    const std::string line = std::string("vrda: index: ") + error.what() + "\n";
    [[maybe_unused]] const ssize_t ignored = ::write(STDERR_FILENO, line.data(), line.size());
    _exit(1);
  }
  _exit(0);
}

bool has_ended_well(pid_t pid)
{
  int status = 0;
  while (::waitpid(pid, &status, 0) < 0) {
    if (errno != EINTR) return false;
  }
  return WIFEXITED(status) && WEXITSTATUS(status) == 0;
}

void take_rows(const std::string& text, std::size_t first, std::size_t step, std::vector<IndexRow>& rows)
{
  std::istringstream lines(text);
  std::size_t k = first;
  for (std::string line; std::getline(lines, line); k += step) rows.at(k) = row_of_text(line);
  check(k >= rows.size(), "every process of an index makes all of its rows");
}

Json number_or_null(double value)
{
  return std::isnan(value) ? Json() : Json(value);
}

}  // namespace

std::string text_of_row(const IndexRow& row)
{
  Json json = {{"name", row.name},     {"levels", row.levels}, {"status", static_cast<int>(row.status)},
               {"remark", row.remark}, {"title", row.title},   {"joint", row.joint},
               {"side", row.side},     {"solver", row.solver}, {"curve", row.curve},
               {"sha256", row.sha256}, {"file", row.file},     {"numbers", Json::array()}};
  for (const double number : row.numbers) json["numbers"].push_back(number_or_null(number));
  if (row.times) {
    const CaseTimes& t = *row.times;
    json["times"] = {t.begun,     t.host,         t.seconds,   t.solving_processor_seconds,
                     t.n_threads, t.n_processors, t.n_recalled};
  }
  // A path may hold any bytes.
  return json.dump(-1, ' ', true, Json::error_handler_t::replace);
}

IndexRow row_of_text(const std::string& text)
{
  const Json json = Json::parse(text);
  IndexRow row;
  row.name = json.at("name");
  row.levels = json.at("levels").get<std::vector<std::string>>();
  row.status = static_cast<CaseStatus>(json.at("status").get<int>());
  row.remark = json.at("remark");
  row.title = json.at("title");
  row.joint = json.at("joint");
  row.side = json.at("side");
  row.solver = json.at("solver");
  row.curve = json.at("curve");
  row.sha256 = json.at("sha256");
  row.file = json.at("file");
  for (const Json& number : json.at("numbers")) {
    row.numbers.push_back(number.is_null() ? nan : number.get<double>());
  }
  if (json.contains("times")) {
    const Json& t = json.at("times");
    row.times = CaseTimes{t.at(0), t.at(1), t.at(2), t.at(3), t.at(4), t.at(5), t.at(6)};
  }
  return row;
}

std::vector<IndexRow> rows_by_processes(std::size_t n_rows,
                                        const std::function<IndexRow(std::size_t)>& row_of, int n_processes)
{
  std::vector<IndexRow> rows(n_rows);
  const std::size_t n_workers = std::min(n_rows, static_cast<std::size_t>(std::max(1, n_processes)));
  if (n_workers <= 1) {
    for (std::size_t k = 0; k < n_rows; ++k) rows[k] = row_of(k);
    return rows;
  }
  std::vector<Worker> workers;
  for (std::size_t w = 0; w < n_workers; ++w) {
    Worker worker;
    worker.memory = memfd_create("vrda index", MFD_CLOEXEC);
    if (worker.memory >= 0) worker.pid = ::fork();
    if (worker.pid == 0) work(worker, w, n_workers, n_rows, row_of);
    workers.push_back(worker);
  }
  bool are_well = true;
  for (const Worker& worker : workers) are_well = worker.pid > 0 && has_ended_well(worker.pid) && are_well;
  for (std::size_t w = 0; w < workers.size(); ++w) {
    if (are_well) take_rows(read_all(workers[w].memory), w, n_workers, rows);
    if (workers[w].memory >= 0) ::close(workers[w].memory);
  }
  check(are_well, "every process of an index ends well");
  return rows;
}

}  // namespace vrda
