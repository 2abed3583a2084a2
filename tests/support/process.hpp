/// Runs a program and keeps what it said.
#pragma once

#include <sys/types.h>

#include <filesystem>
#include <map>
#include <string>
#include <vector>

namespace vrda::test {

struct Ended {
  int exit_code = -1;  ///< -1: ended by a signal
  std::string out;
  std::string err;
  long peak_kb = 0;          ///< largest memory that it or a process it waited for held
  double processor_s = 0.0;  ///< that it and those took
};

struct Command {
  std::filesystem::path program;
  std::vector<std::string> arguments;
  std::map<std::string, std::string> environment;  ///< added to our own
  std::filesystem::path folder;                    ///< to run in; empty: here
};

/// A program under way. Its destructor kills and reaps it, by process id.
class Process {
 public:
  explicit Process(const Command& command);
  ~Process();
  Process(const Process&) = delete;
  Process& operator=(const Process&) = delete;

  bool is_running();
  void send(int signal) const;
  /// What stands on its standard error so far.
  std::string said() const;
  /// Waits for the end.
  Ended wait();

 private:
  void reap(int options);

  pid_t pid_ = -1;
  int status_ = 0;
  bool is_reaped_ = false;
  long peak_kb_ = 0;
  double processor_s_ = 0.0;
  std::filesystem::path out_;
  std::filesystem::path err_;
};

Ended run(const Command& command);

}  // namespace vrda::test
