/// What the program says (data to standard output, talk to standard error), how far a run is, and Ctrl-C,
/// which asks it to end in good order.
#pragma once

#include <chrono>
#include <mutex>
#include <string>

namespace vrda {

enum class ExitCode : int {
  done = 0,
  bad_input = 2,          ///< usage, job, mesh, file
  too_many_unsolved = 3,  ///< finished, but more attitudes unsolved than the job allows
  interrupted = 4,        ///< resumable
  our_mistake = 5,
};

/// Silences say(); warnings and errors stay.
void be_quiet();

/// One line each; control characters are printed as \x1b.
void say(const std::string& line);
void warn(const std::string& line);

/// From now on the first SIGINT or SIGTERM only sets the flag; a second one ends the process.
void watch_for_interrupts();

/// A second SIGTERM changes nothing either, from now on: a batch system tells all processes of a task, and
/// the script that is one of them passes it on. Who means it sends SIGKILL.
void bear_repeated_terms();

bool is_interrupted();

/// How far a run is: a bar on a terminal, plain lines elsewhere, or nothing.
enum class ProgressStyle { bar, plain, none };

/// "auto", "bar", "plain" or "none"; auto asks whether standard error is a terminal.
ProgressStyle progress_style_of(const std::string& word);

class Progress {
 public:
  /// `n_recalled` of `n_total` steps were solved in an earlier run and do not count for the rate.
  /// `what`: the steps' name, in the plural.
  Progress(ProgressStyle style, std::string what, int n_total, int n_recalled);
  ~Progress();
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;

  /// One step done. From any thread.
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

/// "38/s, 0:36 left" for `n_done` steps in `seconds` with `n_left` to go.
std::string rate_text(int n_done, double seconds, int n_left);

}  // namespace vrda
