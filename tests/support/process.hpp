/// Runs a program and captures its output.
#pragma once

#include <sys/types.h>

#include <filesystem>
#include <functional>
#include <map>
#include <string>
#include <vector>

namespace vrda::test {

struct Ended {
  int exit_code = -1;  ///< -1: ended by a signal
  std::string out;
  std::string err;
  long peak_kb = 0;          ///< largest resident memory of the process or of a child it waited for
  double processor_s = 0.0;  ///< of the process and those children
};

struct Command {
  std::filesystem::path program;
  std::vector<std::string> arguments;
  std::map<std::string, std::string> environment;  ///< added to that of the caller
  std::filesystem::path folder;                    ///< working directory; empty: unchanged
};

/// A running program. The destructor kills and reaps it, by process id.
class Process {
 public:
  explicit Process(const Command& command);
  ~Process();
  Process(const Process&) = delete;
  Process& operator=(const Process&) = delete;

  bool is_running();
  void send(int signal) const;
  /// Standard error so far.
  std::string said() const;
  /// Waits until the file exists; false if the program ends first.
  bool runs_until_file(const std::filesystem::path& file);
  /// Waits until standard error has the text; false if the program ends first.
  bool runs_until_said(const std::string& text);
  /// Waits until the program ends.
  Ended wait();

 private:
  bool runs_until(const std::function<bool()>& condition);
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
