/// Description of one dataset in the registry (registry.hpp, trace_registry.hpp), and a finding of a check.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <limits>
#include <span>
#include <string>
#include <type_traits>
#include <vector>

namespace vrda::store {

enum class ValueKind { float64, float32, int64, int32, int8, text };
const char* name_of(ValueKind kind);

/// The type in the file of values of type `Scalar`.
template <typename Scalar>
constexpr ValueKind value_kind()
{
  if constexpr (std::is_same_v<Scalar, double>) return ValueKind::float64;
  if constexpr (std::is_same_v<Scalar, float>) return ValueKind::float32;
  if constexpr (std::is_same_v<Scalar, std::int64_t>) return ValueKind::int64;
  if constexpr (std::is_same_v<Scalar, std::int32_t>) return ValueKind::int32;
  if constexpr (std::is_same_v<Scalar, std::int8_t>) return ValueKind::int8;
  if constexpr (std::is_same_v<Scalar, std::string>) return ValueKind::text;
}

struct Unit {
  const char* name;
  int length_power;  ///< power of a uniform length scale, at equal forces: 1 or 0
};
namespace unit {
inline constexpr Unit none{"", 0}, one{"1", 0}, mm{"mm", 1}, degree{"degree", 0}, n{"N", 0}, nmm{"N mm", 1};
/// Distances between landmarks: input to the scaling, not its result.
inline constexpr Unit landmark_mm{"mm", 0};
}  // namespace unit

/// The codes of an int8 dataset; written as CF flag_values and flag_meanings.
enum class FlagSet {
  none,
  status,
  solver_status,  ///< without `overlapping`: of the spine with free varus
  search_status,  ///< also without `unbounded`: of a trace's searches
  plausibility,
  optional_yes_no,
  yes_no,
  compartment,
  move_kind,
  node,
  wrap_shape,
  body,
  load_frame,
  audit_state,
  zero_varus_source,
  two_sided_contact,
  coordinate_role,
  repair_status,
  case_status,  ///< of an index: schemas/campaign.md
};

struct FlagTable {
  std::vector<std::int8_t> values;
  std::string meanings;  ///< one word per value, in order, separated by blanks
};
FlagTable flag_table(FlagSet set);

/// Where a dataset has values: a condition on codes, one code per entry along the leading dimensions.
struct ValueCondition {
  enum class When { always, at_code, not_at_code, between };
  When when = When::always;
  std::span<const std::int8_t> codes = {};
  std::int8_t code = 0;
  const char* text = "";  ///< "where status is stable"

  /// Number of leading entries; with `between`, one per pair of neighbouring codes.
  std::size_t size() const { return codes.size() - (when == When::between ? 1 : 0); }
  bool at(std::size_t entry) const
  {
    if (when == When::always) return true;
    if (when == When::at_code) return codes[entry] == code;
    return codes[entry] != code && (when == When::not_at_code || codes[entry + 1] != code);
  }
};

enum class Rule {
  any,            ///< also where a rule between datasets applies (values.cpp)
  number,         ///< finite, at most 1e9 in size, from `least`, which `excludes_least`
  number_or_nan,  ///< such a number or NaN
  whole_rows,     ///< rows of numbers or of NaN, one per leading entry of the condition
  rigid,          ///< 4 x 4 matrices, row by row: a rotation and a translation
  unit_rows,      ///< rows of length 1
  unit_or_zero_rows,
  exact_unit_rows,
  axis,        ///< degrees, strictly increasing
  ascending,   ///< keys of frames, strictly increasing
  integer,     ///< from `least` to `largest`
  row_starts,  ///< of compressed rows: non-decreasing from 0 to `largest`
  codes,       ///< of `flags`; with a condition: 0 or 1 there, -1 elsewhere
  names,       ///< not empty
  unique_names,
  sha256,
};

/// Rule of a dataset's values. Where the condition does not hold, numbers are NaN and codes -1.
struct ValueRule {
  Rule rule = Rule::any;
  ValueCondition condition = {};
  double least = -std::numeric_limits<double>::infinity();
  bool excludes_least = false;
  double largest = std::numeric_limits<double>::infinity();
  FlagSet flags = FlagSet::none;
};

/// Text of the rule for messages and the pages in schemas/; empty where every value is valid.
std::string rule_text(const ValueRule& valid);

struct Dataset {
  std::string path;                     ///< "/bodies/reference/vertices"
  std::vector<std::string> dimensions;  ///< paths of the scales, slowest first; empty: one value
  Unit units;
  ValueRule valid;
  const char* long_name;

  FlagSet flags() const { return valid.flags; }
};

/// Whether the dataset has a NaN `_FillValue`.
bool may_be_nan(const Dataset& dataset, ValueKind kind);

/// The size of a dimension.
struct DimensionSize {
  enum class Kind { fixed, counted, axis };
  Kind kind;       ///< fixed: known from the specification or other dimensions; axis: counted, at least 1
  std::int64_t n;  ///< for `counted` and `axis`: size in this model, unknown before it is read

  static DimensionSize fixed(std::int64_t n) { return {Kind::fixed, n}; }
  static DimensionSize counted(std::size_t n) { return {Kind::counted, static_cast<std::int64_t>(n)}; }
  static DimensionSize axis(std::size_t n) { return {Kind::axis, static_cast<std::int64_t>(n)}; }
};

/// The values of a model's member as a span.
template <typename Scalar>
auto values_of(std::vector<Scalar>& member)
{
  return std::span<Scalar>(member);
}
template <typename Scalar>
auto values_of(const std::vector<Scalar>& member)
{
  return std::span<const Scalar>(member);
}
inline auto values_of(std::string& member)
{
  return std::span<std::string>(&member, 1);
}
inline auto values_of(const std::string& member)
{
  return std::span<const std::string>(&member, 1);
}
template <typename Derived>
auto values_of(Eigen::PlainObjectBase<Derived>& member)
{
  static_assert(Derived::IsRowMajor, "arrays have one order in memory and in the file");
  return std::span<typename Derived::Scalar>(member.data(), static_cast<std::size_t>(member.size()));
}
template <typename Derived>
auto values_of(const Eigen::PlainObjectBase<Derived>& member)
{
  static_assert(Derived::IsRowMajor, "arrays have one order in memory and in the file");
  return std::span<const typename Derived::Scalar>(member.data(), static_cast<std::size_t>(member.size()));
}

template <typename Member>
constexpr ValueKind member_kind()
{
  return value_kind<typename decltype(values_of(std::declval<const Member&>()))::value_type>();
}

/// Resizes a member to the shape of its dataset.
template <typename Scalar>
void resize(std::vector<Scalar>& member, const std::vector<std::int64_t>& shape)
{
  std::int64_t count = 1;
  for (const std::int64_t size : shape) count *= size;
  member.resize(static_cast<std::size_t>(count));
}
inline void resize(std::string&, const std::vector<std::int64_t>&) {}
template <typename Derived>
void resize(Eigen::PlainObjectBase<Derived>& member, const std::vector<std::int64_t>& shape)
{
  member.resize(shape.at(0), shape.at(1));
}

/// One departure of an HDF5 file from its specification (schemas/motion-model.md, trace.md).
struct Finding {
  std::string where;  ///< path of the object in the file, "@name" for an attribute
  std::string found;
  std::string wanted;
};

}  // namespace vrda::store
