/// What the rows of a registry are made of, and what may visit them.
#pragma once

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "core/error.hpp"
#include "core/step_record.hpp"
#include "store/dataset.hpp"

namespace vrda {

/// CF 1.9 is the first to allow 64-bit integers (row_start).
inline constexpr const char* conventions = "CF-1.9";

/// What a visitor of a registry does where it has nothing to do. A visitor also has
/// `void operator()(const Dataset&, Member&)`, called once a dataset.
class RegistryVisitor {
 public:
  void group(const std::string&) {}
  /// Whether an optional object is there: what the model says (`is_there`), or what a file says that is read.
  bool has(const std::string&, bool is_there) { return is_there; }
  void dimension(const std::string& path, const Count& count) { sizes_.push_back({path, count.n}); }
  template <typename Member>
  void attribute(const std::string&, const std::string&, Member&, const Unit& = unit::none)
  {
  }
  /// An attribute that repeats what the model says elsewhere.
  template <typename Value>
  void repeated(const std::string&, const std::string&, const Value&)
  {
  }
  /// One group an element below `group`; a reader makes the list.
  template <typename List>
  void list(const std::string&, List&)
  {
  }

  /// Of a dimension visited before.
  std::int64_t size(const std::string& path) const
  {
    for (const auto& [known, n] : sizes_)
      if (known == path) return n;
    throw InternalError("a dataset uses a dimension that is not in the registry");
  }
  std::vector<std::int64_t> shape_of(const Dataset& dataset) const
  {
    std::vector<std::int64_t> shape;
    for (const std::string& dimension : dataset.dimensions) shape.push_back(size(dimension));
    return shape;
  }

 private:
  std::vector<std::pair<std::string, std::int64_t>> sizes_;
};

namespace registry {

inline Valid number()
{
  return {.rule = Rule::number};
}
inline Valid number(const Answered& answered)
{
  return {.rule = Rule::number, .answered = answered};
}
inline Valid number_or_nan(const Answered& answered = {})
{
  return {.rule = Rule::number_or_nan, .answered = answered};
}
inline Valid at_least_0(const Answered& answered)
{
  return {.rule = Rule::number, .answered = answered, .least = 0.0};
}
inline Valid above_0()
{
  return {.rule = Rule::number, .least = 0.0, .excludes_least = true};
}
inline Valid integer(double least, double largest)
{
  return {.rule = Rule::integer, .least = least, .largest = largest};
}
inline Valid count()
{
  return integer(0, std::numeric_limits<std::int32_t>::max());
}
/// Rows of a table of `n`, from `least`.
inline Valid row_of(Eigen::Index n, double least = 0)
{
  return integer(least, static_cast<double>(n - 1));
}
inline Valid row_starts(std::size_t n_entries)
{
  return {.rule = Rule::row_starts, .largest = static_cast<double>(n_entries)};
}
inline Valid rule(Rule rule, const Answered& answered = {})
{
  return {.rule = rule, .answered = answered};
}
inline Valid codes(FlagSet flags, const Answered& answered = {})
{
  return {.rule = Rule::codes, .answered = answered, .flags = flags};
}

template <typename Codes>
Answered where_stable(const Codes& status)
{
  return {Answered::When::at_code, values_of(status), status_stable, "where status is stable"};
}

/// Visits one text of each element of a list as a column, which a reader makes the list of.
template <typename List, typename Text, typename Visitor>
void visit_column(Visitor& visit, const Dataset& dataset, List& list, Text text)
{
  std::vector<std::string> column;
  for (const auto& element : list) column.push_back(element.*text);
  if constexpr (std::is_const_v<List>) {
    visit(dataset, std::as_const(column));
  } else {
    visit(dataset, column);
    list.resize(column.size());
    for (std::size_t i = 0; i < column.size(); ++i) list[i].*text = column[i];
  }
}

/// Whether an optional part is there; makes it where a file that is read has it.
template <typename Optional, typename Visitor>
bool is_there(Visitor& visit, const std::string& path, Optional& part)
{
  const bool found = visit.has(path, part.has_value());
  if constexpr (!std::is_const_v<Optional>) {
    if (found && !part) part.emplace();
  }
  return found;
}

/// Where the compartments bear: of the cells, and of the zero-varus motion.
template <typename Paths, typename Visitor>
void visit_paths(Paths& paths, const std::string& group, const std::vector<std::string>& dimensions,
                 const Answered& answered, Visitor& visit)
{
  const Valid points = rule(Rule::whole_rows, answered);
  visit({group + "/medial_reference", dimensions, unit::mm, points,
         "where the medial compartment bears, canonical axes of the reference body"},
        paths.medial_reference_mm);
  visit({group + "/medial_moving", dimensions, unit::mm, points,
         "where the medial compartment bears, canonical axes of the moving body"},
        paths.medial_moving_mm);
  visit({group + "/lateral_reference", dimensions, unit::mm, points,
         "where the lateral compartment bears, canonical axes of the reference body"},
        paths.lateral_reference_mm);
  visit({group + "/lateral_moving", dimensions, unit::mm, points,
         "where the lateral compartment bears, canonical axes of the moving body"},
        paths.lateral_moving_mm);
}

}  // namespace registry
}  // namespace vrda
