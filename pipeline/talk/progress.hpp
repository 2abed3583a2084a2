/// How far a run is: a bar on a terminal, plain lines elsewhere, or nothing.
#pragma once

#include <chrono>
#include <mutex>
#include <string>

namespace vrda {

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
