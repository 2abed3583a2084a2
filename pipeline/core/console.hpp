/// Messages on standard error (data use standard output), progress of a run, and signals for an orderly end.
#pragma once

#include <chrono>
#include <csignal>
#include <functional>
#include <mutex>
#include <string>
#include <vector>

namespace vrda::inline core {

enum class ExitCode : int {
  done = 0,
  bad_input = 2,    ///< usage, job, mesh, file
  incomplete = 3,   ///< finished with unsolved attitudes or tests, or a fit or repair that did not converge
  interrupted = 4,  ///< resumable
  internal_error = 5,
};

/// Suppresses log_info(); warnings and errors are still printed.
void suppress_info();

/// Print one line; control characters are printed as \x1b.
void log_info(const std::string& line);
void log_warning(const std::string& line);

/// Receives the lines instead of standard error, from any thread; before the first of them.
void set_log_receiver(std::function<void(bool is_warning, const std::string& line)> receiver);

/// Installs handlers: the first SIGINT, SIGTERM or SIGHUP sets the flag; a second SIGINT or SIGTERM ends the
/// process. SIGHUP stays ignored under nohup.
void install_signal_handlers();

/// Makes a second SIGTERM harmless: a batch system signals all processes of a task, and the task's script
/// forwards the signal. SIGKILL still ends the process.
void ignore_repeated_sigterm();

bool is_interrupted();

/// Sets or clears the flag of the signals, for a host program that handles them itself.
void set_interrupted(bool is_set);

/// Progress output: a bar for a terminal, plain lines for a log, or nothing.
enum class ProgressStyle { bar, plain, none };

/// "auto", "bar", "plain" or "none"; auto selects bar if standard error is a terminal. Throws InputError.
ProgressStyle progress_style_of(const std::string& word);

class Progress {
 public:
  /// `n_recalled` of `n_total` steps were solved in an earlier run and are not part of the rate.
  /// `what`: plural name of the steps.
  Progress(ProgressStyle style, std::string what, int n_total, int n_recalled);
  ~Progress();
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;

  /// Counts one finished step. Thread-safe.
  void advance();

 private:
  void show(bool is_last);

  ProgressStyle style_;
  std::string what_;
  int n_total_;
  int n_recalled_;
  int n_done_;
  std::mutex mutex_;
  std::chrono::steady_clock::time_point start_;
  std::chrono::steady_clock::time_point shown_;
};

/// "38/s, 0:36 left" for `n_done` steps in `seconds` with `n_left` remaining.
std::string rate_text(int n_done, double seconds, int n_left);

// The signals that end a program in an orderly way.

/// SIGINT, SIGTERM and, unless it is ignored (nohup), SIGHUP of a closed terminal.
inline std::vector<int> stop_signals()
{
  struct sigaction hangup {};
  const bool is_ignored = sigaction(SIGHUP, nullptr, &hangup) == 0 && hangup.sa_handler == SIG_IGN;
  return is_ignored ? std::vector<int>{SIGINT, SIGTERM} : std::vector<int>{SIGINT, SIGTERM, SIGHUP};
}

}  // namespace vrda::inline core
