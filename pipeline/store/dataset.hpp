/// Description of one dataset in the registry (registry.hpp, trace_registry.hpp), and a finding of a check.
#pragma once

#include <Eigen/Core>
#include <Eigen/LU>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <span>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "core/fields.hpp"
#include "core/text.hpp"

namespace vrda::store {

enum class ValueKind { float64, float32, int64, int32, int8, text };
inline constexpr Named<ValueKind> value_kind_names[] = {
    {ValueKind::float64, "float64"}, {ValueKind::float32, "float32"},
    {ValueKind::int64, "int64"},     {ValueKind::int32, "int32"},
    {ValueKind::int8, "int8"},       {ValueKind::text, "variable-length UTF-8 text"}};
constexpr const auto& names_of(ValueKind)
{
  return value_kind_names;
}

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

/// Bytes of one value; a text counts as its length field.
inline std::uint64_t bytes_of(ValueKind kind)
{
  if (kind == ValueKind::float64 || kind == ValueKind::int64) return 8;
  return kind == ValueKind::int8 ? 1 : 4;
}

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
  std::string long_name;

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
template <typename Member>
auto values_of(Member& member)
{
  if constexpr (std::is_same_v<std::remove_const_t<Member>, std::string>) {
    return std::span(&member, 1);
  } else {
    if constexpr (requires { Member::IsRowMajor; })
      static_assert(Member::IsRowMajor, "arrays have one order in memory and in the file");
    return std::span(member.data(), static_cast<std::size_t>(member.size()));
  }
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

// Findings about the values of a file's datasets: one per dataset and rule, with the first wrong entry and
// the number of wrong entries.

/// Unit vectors may be stored in single precision.
inline constexpr double normal_tolerance = 1e-5;

/// Deviation of R R^T from the identity, an entry. Products of three rotations in double reach a few 1e-16;
/// rotations rounded to text or float exceed 1e-9, and would displace points so far that contacts overlap. At
/// 500 mm from the origin 1e-9 is half a nanometre.
inline constexpr double exact_tolerance = 1e-9;

/// In mm, degrees, N or N mm: larger than in any joint, and small enough that values computed from a model
/// cannot overflow.
inline constexpr double max_magnitude = 1e9;
inline constexpr double min_axis_step_deg = 1e-6;

/// Whether `value` is finite and of magnitude up to max_magnitude.
inline bool is_number(double value)
{
  return std::abs(value) <= max_magnitude;
}

/// Whether 16 numbers, row by row, are a rotation and a translation.
inline bool is_rigid_pose(const double* entries)
{
  using Matrix4 = Eigen::Matrix<double, 4, 4, Eigen::RowMajor>;
  const Matrix4 X = Eigen::Map<const Matrix4>(entries);
  if (!(X.array().abs() <= max_magnitude).all()) return false;
  const Eigen::Matrix3d R = X.topLeftCorner<3, 3>();
  const Eigen::Matrix3d error = R * R.transpose() - Eigen::Matrix3d::Identity();
  return error.cwiseAbs().maxCoeff() <= exact_tolerance && R.determinant() > 0.0 &&
         X.row(3) == Eigen::RowVector4d(0, 0, 0, 1);
}

/// The text of a number in findings.
inline std::string text_of(double value)
{
  return rounded_text(value, 10);
}

/// Collects findings in the order in which they are added.
class ValueFindings {
 public:
  bool empty() const { return findings_.empty(); }
  std::size_t size() const { return findings_.size(); }
  std::vector<Finding> take() { return std::move(findings_); }

  void add(const std::string& where, const std::string& found, const std::string& wanted)
  {
    findings_.push_back({where, found, wanted});
  }

  /// Adds one finding for all wrong entries of a dataset; `show` returns the text of the first.
  template <typename IsWrong, typename Show>
  void report_each(const std::string& where, std::size_t size, const std::string& wanted, IsWrong is_wrong,
                   Show show)
  {
    std::size_t n_wrong = 0, first = 0;
    for (std::size_t i = size; i-- > 0;) {
      if (!is_wrong(i)) continue;
      first = i;
      ++n_wrong;
    }
    if (n_wrong == 0) return;
    const std::string more = n_wrong == 1 ? "" : " (the first of " + std::to_string(n_wrong) + ")";
    add(where, std::string(show(first)) + " at entry " + std::to_string(first) + more, wanted);
  }

  /// The same for numbers, the first of which is shown.
  template <typename Real, typename IsWrong>
  void report_numbers(const std::string& where, const Real* values, std::size_t size,
                      const std::string& wanted, IsWrong is_wrong)
  {
    report_each(where, size, wanted, is_wrong, [&](std::size_t i) { return text_of(values[i]); });
  }

  /// Integers outside [low, high].
  template <typename Integer>
  void report_out_of_range(const std::string& where, const Integer* values, std::size_t size,
                           std::int64_t low, std::int64_t high)
  {
    report_each(
        where, size, "a value from " + std::to_string(low) + " to " + std::to_string(high),
        [&](std::size_t i) { return values[i] < low || values[i] > high; },
        [&](std::size_t i) { return std::to_string(values[i]); });
  }

  /// Numbers for which is_number() is false.
  template <typename Real>
  void report_not_finite(const std::string& where, const Real* values, std::size_t size)
  {
    report_numbers(where, values, size, "finite numbers of magnitude up to 1e9",
                   [&](std::size_t i) { return !is_number(static_cast<double>(values[i])); });
  }

 private:
  std::vector<Finding> findings_;
};

}  // namespace vrda::store
