#include "follow/job_views.hpp"

#include <charconv>
#include <cmath>
#include <optional>

namespace vrda {
namespace {

/// "key = value" of one line; empty where it is none.
struct Entry {
  std::string_view key, value;
};

Entry entry_of(std::string_view line)
{
  constexpr std::string_view equals = " = ";
  const std::size_t at = line.find(equals);
  if (at == std::string_view::npos) return {};
  return {line.substr(0, at), line.substr(at + equals.size())};
}

/// The number at the beginning of `text`, and what follows it.
std::optional<double> take_number(std::string_view& text)
{
  double value = 0.0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || !std::isfinite(value)) return std::nullopt;
  text.remove_prefix(static_cast<std::size_t>(end - text.data()));
  return value;
}

/// The first numbers of a list; all zero where there are fewer.
template <int n>
Eigen::Matrix<double, n, 1> numbers_of(std::string_view text)
{
  Eigen::Matrix<double, n, 1> numbers = Eigen::Matrix<double, n, 1>::Zero();
  for (Eigen::Index i = 0; i < n; ++i) {
    const std::size_t at = text.find_first_not_of("[, ");
    if (at == std::string_view::npos) return Eigen::Matrix<double, n, 1>::Zero();
    text.remove_prefix(at);
    const std::optional<double> value = take_number(text);
    if (!value) return Eigen::Matrix<double, n, 1>::Zero();
    numbers[i] = *value;
  }
  return numbers;
}

void read(JobViews& job, const Entry& entry)
{
  if (entry.key == "zoom") {
    std::string_view text = entry.value;
    const double zoom = take_number(text).value_or(1.0);
    if (zoom > 0.0) job.zoom = zoom;
  }
  if (entry.key == "display_px") {
    // The schema's bound: no display is larger, and a picture may be smaller yet.
    const Eigen::Vector2d size = numbers_of<2>(entry.value).cwiseMin(16384.0).cwiseMax(0.0);
    job.width_px = static_cast<int>(size.x());
    job.height_px = static_cast<int>(size.y());
  }
  if (entry.key == "render" && entry.value.size() > 2)
    job.render = entry.value.substr(1, entry.value.size() - 2);
}

void read(JobView& view, const Entry& entry)
{
  std::string_view text = entry.value;
  if (entry.key == "number") view.number = static_cast<int>(take_number(text).value_or(0.0));
  if (entry.key == "shift_mm") view.shift_mm = numbers_of<3>(text);
  if (entry.key == "orientation_deg") view.orientation_deg = numbers_of<3>(text);
}

}  // namespace

JobViews job_views(std::string_view resolved_job)
{
  enum class Table { other, player, view };
  JobViews job;
  Table table = Table::other;
  while (!resolved_job.empty()) {
    const std::size_t end = resolved_job.find('\n');
    const std::string_view line = resolved_job.substr(0, end);
    resolved_job.remove_prefix(end == std::string_view::npos ? resolved_job.size() : end + 1);
    if (line == "[[player.view]]") {
      table = Table::view;
      job.views.emplace_back();
    } else if (line.starts_with('[')) {
      table = line == "[player]" ? Table::player : Table::other;
    } else if (table == Table::player) {
      read(job, entry_of(line));
    } else if (table == Table::view) {
      read(job.views.back(), entry_of(line));
    }
  }
  return job;
}

}  // namespace vrda
