#include "guide/refusal.hpp"

#include <algorithm>
#include <optional>

#include "calibration/viewport_fit.hpp"
#include "guide/marks.hpp"
#include "guide/optics_tasks.hpp"
#include "settings/settings_text.hpp"

namespace vrda {
namespace {

using Indices = std::vector<std::size_t>;

template <typename Is>
Indices those(const std::vector<Task>& tasks, Is is)
{
  Indices found;
  for (std::size_t k = 0; k < tasks.size(); ++k) {
    if (is(tasks[k])) found.push_back(k);
  }
  return found;
}

/// N of "reading N" in `text`, from 1; nothing where there is none.
std::optional<std::size_t> number_after(const std::string& text, const std::string& word)
{
  const std::size_t at = text.find(word + " ");
  if (at == std::string::npos) return std::nullopt;
  std::size_t number = 0;
  for (std::size_t k = at + word.size() + 1; k < text.size() && text[k] >= '0' && text[k] <= '9'; ++k)
    number = 10 * number + static_cast<std::size_t>(text[k] - '0');
  return number == 0 ? std::nullopt : std::optional<std::size_t>(number);
}

/// The one of `which` that is counted from 1, or all of them.
Indices nth_or_all(const Indices& which, const std::optional<std::size_t>& number)
{
  return number && *number <= which.size() ? Indices{which[*number - 1]} : which;
}

bool has(const std::string& text, const std::string& part)
{
  return text.find(part) != std::string::npos;
}

/// "left.edge_left": an edge's readings; "left.screen": the ruler's.
Indices of_viewport(const InputError::Facts& facts, const std::vector<Task>& tasks)
{
  const bool is_right = facts.field.starts_with("right.");
  if (has(facts.field, ".screen"))
    return those(tasks, [&](const Task& t) { return t.kind == TaskKind::number && t.is_right == is_right; });
  for (std::size_t edge = 0; edge < n_edges; ++edge) {
    const std::string name = name_of(static_cast<Edge>(edge));
    if (!facts.field.ends_with("." + name) && !facts.field.ends_with("_" + name)) continue;
    const auto is_scan = [&](const Task& t) {
      return t.kind == TaskKind::scan_line && t.is_right == is_right && t.index == static_cast<int>(edge);
    };
    return nth_or_all(those(tasks, is_scan), number_after(facts.found, "reading"));
  }
  return {};
}

/// "left.distortion: node (-3, 2)"
Indices of_distortion(const InputError::Facts& facts, const std::vector<Task>& tasks)
{
  const bool is_right = facts.field.starts_with("right");
  return those(tasks, [&](const Task& t) {
    const std::string node =
        "node (" + rounded_text(t.node.x(), 2) + ", " + rounded_text(t.node.y(), 2) + ")";
    return t.kind == TaskKind::point && t.is_right == is_right && facts.field.ends_with(node);
  });
}

/// "mark 3" of the eye that the field names.
Indices of_eye(const std::string& text, bool is_right, const std::string& word,
               const std::vector<Task>& tasks)
{
  const std::optional<std::size_t> number = number_after(text, word);
  if (!number) return {};
  return nth_or_all(those(tasks, [&](const Task& t) { return t.is_right == is_right; }), number);
}

Indices of_name(const std::string& name, const std::vector<Task>& tasks)
{
  return those(tasks, [&](const Task& t) { return t.name == name; });
}

Indices named_marks(const InputError::Facts& facts, CalibrationPart part, const std::vector<Task>& tasks)
{
  switch (part) {
    case CalibrationPart::viewport:
      return of_viewport(facts, tasks);
    case CalibrationPart::distortion:
      return of_distortion(facts, tasks);
    case CalibrationPart::eyepoints:
      return of_eye(facts.found, facts.field.starts_with("right"), "mark", tasks);
    case CalibrationPart::bullseye:
    case CalibrationPart::head:
      return of_eye(facts.field, has(facts.field, "right eye"), "bull's-eye", tasks);
    case CalibrationPart::rails:
      return of_name(facts.field == "x_rail" ? "x rail" : "z rail", tasks);
    default:
      return of_name(facts.field, tasks);
  }
}

bool is_first(Edge edge)
{
  return edge == Edge::left || edge == Edge::top;
}

Edge opposite(Edge edge)
{
  switch (edge) {
    case Edge::left:
      return Edge::right;
    case Edge::right:
      return Edge::left;
    case Edge::top:
      return Edge::bottom;
    case Edge::bottom:
      return Edge::top;
  }
  return edge;
}

}  // namespace

std::vector<std::size_t> doubted_marks(const InputError& error, CalibrationPart part,
                                       const std::vector<Task>& tasks, const TaskRound& round)
{
  Indices named = named_marks(error.facts(), part, tasks);
  if (!named.empty()) return named;
  for (std::size_t k = round.begin; k < round.end; ++k) named.push_back(k);
  return named;
}

std::vector<std::size_t> crossed_edges(const std::vector<Task>& tasks, const CalibrationRecord& record,
                                       std::size_t done)
{
  const Task& last = tasks[done];
  if (last.kind != TaskKind::scan_line) return {};
  const auto edge = static_cast<Edge>(last.index);
  const double at_px = mark_of(record, last.name)->rows[0][0];
  const auto is_of = [&](const Task& t, Edge of) {
    return t.kind == TaskKind::scan_line && t.is_right == last.is_right && t.index == static_cast<int>(of);
  };
  bool is_crossed = false;
  for (const Task& t : tasks) {
    const CalibrationMark* mark = is_of(t, opposite(edge)) ? mark_of(record, t.name) : nullptr;
    if (mark == nullptr) continue;
    const double other_px = mark->rows[0][0];
    is_crossed = is_crossed || (is_first(edge) ? at_px >= other_px : at_px <= other_px);
  }
  if (!is_crossed) return {};
  return those(tasks, [&](const Task& t) {
    return (is_of(t, edge) || is_of(t, opposite(edge))) && mark_of(record, t.name) != nullptr;
  });
}

std::string crossed_text(const Task& task)
{
  const auto edge = static_cast<Edge>(task.index);
  return "crossed edges of the " + eye_text(task.is_right) + ": " + name_of(edge) + " beyond " +
         name_of(opposite(edge));
}

std::string words_of(const InputError& error)
{
  const InputError::Facts& facts = error.facts();
  return (facts.field.empty() ? "" : facts.field + ": ") + "found " + facts.found + ", wanted " +
         facts.wanted;
}

}  // namespace vrda
