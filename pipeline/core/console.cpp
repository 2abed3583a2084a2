#include "core/console.hpp"

#include <spdlog/sinks/stdout_sinks.h>
#include <spdlog/spdlog.h>
#include <unistd.h>

#include <atomic>
#include <cmath>
#include <cstdio>
#include <utility>

#include "core/text.hpp"

namespace vrda::inline core {
namespace {

spdlog::logger& stderr_logger()
{
  static const std::shared_ptr<spdlog::logger> logger = [] {
    auto made = spdlog::stderr_logger_mt("vrda");
    made->set_pattern("%v");
    return made;
  }();
  return *logger;
}

std::function<void(bool, const std::string&)>& log_receiver()
{
  static std::function<void(bool, const std::string&)> receiver;
  return receiver;
}

}  // namespace

void set_log_receiver(std::function<void(bool is_warning, const std::string& line)> receiver)
{
  log_receiver() = std::move(receiver);
}

void suppress_info()
{
  stderr_logger().set_level(spdlog::level::warn);
}
void log_info(const std::string& line)
{
  if (log_receiver()) return log_receiver()(false, escape_control_characters(line));
  stderr_logger().info(escape_control_characters(line));
}
void log_warning(const std::string& line)
{
  if (log_receiver()) return log_receiver()(true, escape_control_characters(line));
  stderr_logger().warn("warning: " + escape_control_characters(line));
}

namespace {

std::atomic<bool> interrupted = false;
std::atomic<bool> ignores_repeated_terms = false;
static_assert(std::atomic<bool>::is_always_lock_free, "a signal handler may only touch a lock-free flag");

extern "C" void on_signal(int signal)
{
  interrupted = true;
  // A closed terminal sends SIGHUP twice: by the shell and by the system.
  const bool is_repeated_harmlessly = signal == SIGHUP || (signal == SIGTERM && ignores_repeated_terms);
  if (!is_repeated_harmlessly) std::signal(signal, SIG_DFL);
}

}  // namespace

void install_signal_handlers()
{
  for (const int signal : stop_signals()) std::signal(signal, on_signal);
}

void ignore_repeated_sigterm()
{
  ignores_repeated_terms = true;
}

bool is_interrupted()
{
  return interrupted;
}

void set_interrupted(bool is_set)
{
  interrupted = is_set;
}

namespace {

using std::chrono::steady_clock;
// Intervals of redrawing the bar and of plain lines in a log.
constexpr std::chrono::milliseconds bar_interval{100};
constexpr std::chrono::seconds plain_interval{10};
constexpr int bar_width = 30;

double seconds_between(steady_clock::time_point from, steady_clock::time_point to)
{
  return std::chrono::duration<double>(to - from).count();
}

}  // namespace

ProgressStyle progress_style_of(const std::string& word)
{
  if (word == "bar") return ProgressStyle::bar;
  if (word == "plain") return ProgressStyle::plain;
  if (word == "none") return ProgressStyle::none;
  if (word == "auto") return isatty(STDERR_FILENO) == 1 ? ProgressStyle::bar : ProgressStyle::plain;
  throw InputError({"--progress", "", word, "auto, bar, plain or none"});
}

std::string rate_text(int n_done, double seconds, int n_left)
{
  char text[80];
  if (n_done == 0 || seconds <= 0.0) return "starting";
  const double rate = n_done / seconds;
  const auto left = std::lround(n_left / rate);
  std::snprintf(text, sizeof text, "%.3g/s, %ld:%02ld left", rate, left / 60, left % 60);
  return text;
}

Progress::Progress(ProgressStyle style, std::string what, int n_total, int n_recalled)
    : style_(style),
      what_(std::move(what)),
      n_total_(n_total),
      n_recalled_(n_recalled),
      n_done_(n_recalled),
      start_(steady_clock::now()),
      shown_(start_)
{
}

Progress::~Progress()
{
  if (style_ == ProgressStyle::bar) {
    show(true);
    std::fputc('\n', stderr);
  }
}

void Progress::advance()
{
  const std::lock_guard lock(mutex_);
  ++n_done_;
  if (style_ == ProgressStyle::none) return;
  const steady_clock::time_point now = steady_clock::now();
  const auto interval = style_ == ProgressStyle::bar ? steady_clock::duration(bar_interval)
                                                     : steady_clock::duration(plain_interval);
  if (now - shown_ < interval && n_done_ < n_total_) return;
  shown_ = now;
  show(n_done_ >= n_total_);
}

void Progress::show(bool is_last)
{
  const double seconds = seconds_between(start_, steady_clock::now());
  const std::string rate = rate_text(n_done_ - n_recalled_, seconds, n_total_ - n_done_);
  const std::string counts = std::to_string(n_done_) + '/' + std::to_string(n_total_) + ' ' + what_;
  if (style_ == ProgressStyle::plain) {
    log_info(counts + ", " + rate);
    return;
  }
  const int filled = n_total_ > 0 ? n_done_ * bar_width / n_total_ : bar_width;
  const auto width = static_cast<std::size_t>(filled);
  const std::string bar = std::string(width, '#') + std::string(bar_width - width, '.');
  std::fprintf(stderr, "\r[%s] %s, %s%s", bar.c_str(), counts.c_str(), rate.c_str(),
               is_last ? "   " : "          ");
  std::fflush(stderr);
}

}  // namespace vrda::inline core
