/// Building blocks of a registry's rows, and the base of its visitors.
#pragma once

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "core/error.hpp"
#include "core/step_record.hpp"
#include "store/dataset.hpp"

namespace vrda::store {

/// CF 1.9 is the first to allow 64-bit integers (row_start).
inline constexpr const char* conventions = "CF-1.9";

/// Base of registry visitors, with empty defaults. A visitor also has `void operator()(const Dataset&,
/// Member&)`, called once per dataset.
class RegistryVisitor {
 public:
  void group(const std::string&) {}
  /// Whether an optional object exists: in the model (`is_there`), or in the file being read.
  bool has(const std::string&, bool is_there) { return is_there; }
  void dimension(const std::string& path, const DimensionSize& count) { sizes_.push_back({path, count.n}); }
  template <typename Member>
  void attribute(const std::string&, const std::string&, Member&, const Unit& = unit::none)
  {
  }
  /// An attribute that repeats a value stored elsewhere in the model.
  template <typename Value>
  void derived_attribute(const std::string&, const std::string&, const Value&)
  {
  }
  /// A list with one group per element below `group`; a reader fills the list.
  template <typename List>
  void list(const std::string&, List&)
  {
  }

  /// Size of a dimension that was visited before.
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

inline ValueRule number()
{
  return {.rule = Rule::number};
}
inline ValueRule number(const ValueCondition& answered)
{
  return {.rule = Rule::number, .condition = answered};
}
inline ValueRule number_or_nan(const ValueCondition& answered = {})
{
  return {.rule = Rule::number_or_nan, .condition = answered};
}
inline ValueRule at_least_0(const ValueCondition& answered)
{
  return {.rule = Rule::number, .condition = answered, .least = 0.0};
}
inline ValueRule above_0()
{
  return {.rule = Rule::number, .least = 0.0, .excludes_least = true};
}
inline ValueRule integer(double least, double largest)
{
  return {.rule = Rule::integer, .least = least, .largest = largest};
}
inline ValueRule count()
{
  return integer(0, std::numeric_limits<std::int32_t>::max());
}
/// Row indices of a table of `n` rows, from `least`.
inline ValueRule row_of(Eigen::Index n, double least = 0)
{
  return integer(least, static_cast<double>(n - 1));
}
inline ValueRule row_starts(std::size_t n_entries)
{
  return {.rule = Rule::row_starts, .largest = static_cast<double>(n_entries)};
}
inline ValueRule rule(Rule rule, const ValueCondition& answered = {})
{
  return {.rule = rule, .condition = answered};
}
inline ValueRule codes(FlagSet flags, const ValueCondition& answered = {})
{
  return {.rule = Rule::codes, .condition = answered, .flags = flags};
}

template <typename Codes>
ValueCondition where_stable(const Codes& status)
{
  return {ValueCondition::When::at_code, values_of(status), status_stable, "where status is stable"};
}

/// Visits one text member of a list's elements as a column; a reader resizes the list.
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

/// Whether an optional part exists; a reader creates it if the file has it.
template <typename Optional, typename Visitor>
bool has_optional(Visitor& visit, const std::string& path, Optional& part)
{
  const bool found = visit.has(path, part.has_value());
  if constexpr (!std::is_const_v<Optional>) {
    if (found && !part) part.emplace();
  }
  return found;
}

/// Centres of contact of the compartments, of the cells or of the zero-varus motion.
template <typename Paths, typename Visitor>
void visit_paths(Paths& paths, const std::string& group, const std::vector<std::string>& dimensions,
                 const ValueCondition& answered, Visitor& visit)
{
  const ValueRule points = rule(Rule::whole_rows, answered);
  visit({group + "/medial_reference", dimensions, unit::mm, points,
         "centre of contact of the medial compartment, canonical axes of the reference body"},
        paths.medial_reference_mm);
  visit({group + "/medial_moving", dimensions, unit::mm, points,
         "centre of contact of the medial compartment, canonical axes of the moving body"},
        paths.medial_moving_mm);
  visit({group + "/lateral_reference", dimensions, unit::mm, points,
         "centre of contact of the lateral compartment, canonical axes of the reference body"},
        paths.lateral_reference_mm);
  visit({group + "/lateral_moving", dimensions, unit::mm, points,
         "centre of contact of the lateral compartment, canonical axes of the moving body"},
        paths.lateral_moving_mm);
}

}  // namespace registry
}  // namespace vrda::store
