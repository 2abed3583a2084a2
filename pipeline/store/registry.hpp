/// Visitors of a registry's rows.
#pragma once

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <set>
#include <string>
#include <type_traits>
#include <utility>
#include <variant>
#include <vector>

#include "core/text.hpp"
#include "model/frames.hpp"
#include "model/step_record.hpp"
#include "store/dataset.hpp"
#include "store/motion_model.hpp"
#include "store/trace.hpp"

namespace vrda::store {

/// CF 1.9 is the first to allow 64-bit integers (row_start).
inline constexpr const char* conventions = "CF-1.9";

/// Base of registry visitors, with empty defaults. A visitor also has `void operator()(const Dataset&,
/// Member&)`, called once per dataset; attributes, lists and datasets may be templates over the member.
class RegistryVisitor {
 public:
  void group(const std::string&) {}
  /// Whether an optional object exists: in the model (`is_there`), or in the file being read.
  bool has(const std::string&, bool is_there) { return is_there; }
  void dimension(const std::string& path, const DimensionSize& count) { sizes_.push_back({path, count.n}); }
  template <typename Member>
  void attribute(const std::string&, const std::string&, Member&, const Unit&)
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

/// What the rows call, so that they are compiled once for all visitors.
class RowVisitor {
 public:
  using Member =
      std::variant<std::string*, std::vector<std::string>*, std::vector<double>*, std::vector<float>*,
                   std::vector<std::int8_t>*, std::vector<std::int32_t>*, std::vector<std::int64_t>*, GridD*,
                   GridB*, GridI*, Exponents*, Points*, Points32*, Triangles*>;
  using Attribute = std::variant<std::string*, bool*, double*, std::int32_t*, Eigen::Vector3d*>;
  using Value = std::variant<double, std::int32_t>;
  using List = std::variant<std::vector<SmoothedSet>*, std::vector<AuditSet>*>;

  virtual ~RowVisitor() = default;
  /// Whether the members may be changed.
  virtual bool may_change() const = 0;
  virtual void group(const std::string& path) = 0;
  virtual bool has(const std::string& path, bool is_there) = 0;
  virtual void dimension(const std::string& path, const DimensionSize& count) = 0;
  virtual std::int64_t size(const std::string& path) const = 0;
  virtual void derived_attribute(const std::string& object, const std::string& name, const Value& value) = 0;

  template <typename Type>
  void attribute(const std::string& object, const std::string& name, Type& value,
                 const Unit& units = unit::none)
  {
    visit_attribute(object, name, &value, units);
  }
  template <typename Type>
  void list(const std::string& group, Type& elements)
  {
    visit_list(group, &elements);
  }
  template <typename Type>
  void operator()(const Dataset& dataset, Type& member)
  {
    visit_dataset(dataset, &member);
  }

 private:
  virtual void visit_attribute(const std::string& object, const std::string& name, Attribute value,
                               const Unit& units) = 0;
  virtual void visit_list(const std::string& group, List elements) = 0;
  virtual void visit_dataset(const Dataset& dataset, Member member) = 0;
};

/// Calls a RegistryVisitor, with const members if `is_const`.
template <typename Visitor, bool is_const>
class RowVisitorOf final : public RowVisitor {
 public:
  explicit RowVisitorOf(Visitor& visitor) : visitor_(visitor) {}

  bool may_change() const override { return !is_const; }
  void group(const std::string& path) override { visitor_.group(path); }
  bool has(const std::string& path, bool is_there) override { return visitor_.has(path, is_there); }
  void dimension(const std::string& path, const DimensionSize& count) override
  {
    visitor_.dimension(path, count);
  }
  std::int64_t size(const std::string& path) const override { return visitor_.size(path); }
  void derived_attribute(const std::string& object, const std::string& name, const Value& value) override
  {
    std::visit([&](const auto& one) { visitor_.derived_attribute(object, name, one); }, value);
  }

 private:
  template <typename Type>
  using Seen = std::conditional_t<is_const, const Type, Type>;

  void visit_attribute(const std::string& object, const std::string& name, Attribute value,
                       const Unit& units) override
  {
    std::visit([&]<typename Type>(
                   Type* one) { visitor_.attribute(object, name, static_cast<Seen<Type>&>(*one), units); },
               value);
  }
  void visit_list(const std::string& group, List elements) override
  {
    std::visit([&]<typename Type>(Type* all) { visitor_.list(group, static_cast<Seen<Type>&>(*all)); },
               elements);
  }
  void visit_dataset(const Dataset& dataset, Member member) override
  {
    std::visit([&]<typename Type>(Type* all) { visitor_(dataset, static_cast<Seen<Type>&>(*all)); }, member);
  }

  Visitor& visitor_;
};

// Registry of the motion model's datasets: one row per dataset, in the order of the file (registry.cpp and
// registry_*.cpp). Writing, reading, checking, scaling and comparing motion models all visit it. A new
// dataset is a new row there. The tables of the specification, schemas/motion-model.md, are generated from
// these rows.

void visit_rows(MotionModel& model, RowVisitor& visit);

/// Visits every row of a motion model: const for writing, non-const for reading.
template <typename Model, typename Visitor>
void visit_motion_model(Model& model, Visitor&& visitor)
{
  RowVisitorOf<std::remove_reference_t<Visitor>, std::is_const_v<Model>> rows(visitor);
  visit_rows(const_cast<MotionModel&>(model), rows);  // a const one is passed on as const
}

// Building blocks of a registry's rows, and the parts of the motion model's.

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
template <typename List, typename Text>
void visit_column(RowVisitor& visit, const Dataset& dataset, List& list, Text text)
{
  std::vector<std::string> column;
  for (const auto& element : list) column.push_back(element.*text);
  visit(dataset, column);
  if (!visit.may_change()) return;
  list.resize(column.size());
  for (std::size_t i = 0; i < column.size(); ++i) list[i].*text = column[i];
}

/// Whether an optional part exists; a reader creates it if the file has it.
template <typename Optional>
bool has_optional(RowVisitor& visit, const std::string& path, Optional& part)
{
  const bool found = visit.has(path, part.has_value());
  if (found && !part) part.emplace();
  return found;
}

/// Translation in the world frame and rotation about Delta of a motion's poses.
template <typename Poses>
void visit_poses(Poses& poses, const std::string& group, const std::vector<std::string>& dimensions,
                 const ValueRule& valid, RowVisitor& visit)
{
  visit({group + "/tx", dimensions, unit::mm, valid, "translation along X of the world frame W"},
        poses.tx_mm);
  visit({group + "/ty", dimensions, unit::mm, valid, "translation along Y of the world frame W"},
        poses.ty_mm);
  visit({group + "/tz", dimensions, unit::mm, valid, "translation along Z of the world frame W"},
        poses.tz_mm);
  visit({group + "/theta", dimensions, unit::degree, valid, "rotation about Delta, right-knee sign"},
        poses.theta_deg);
}

/// Centres of contact of the compartments, of the cells or of the zero-varus motion.
template <typename Paths>
void visit_paths(Paths& paths, const std::string& group, const std::vector<std::string>& dimensions,
                 const ValueCondition& answered, RowVisitor& visit)
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

struct AuditedModel {
  bool has_compartments, has_frames;
};

void visit_smoothed(SmoothedSet& set, RowVisitor& visit);
void visit_two_sided(TwoSided& motion, RowVisitor& visit);
void visit_repair(RepairedFrames& repair, RowVisitor& visit);
void visit_zero_varus(ZeroVarus& motion, bool has_compartments, RowVisitor& visit);
void visit_audit(AuditSet& audit, const AuditedModel& model, RowVisitor& visit);
void visit_push(PushRows& push, RowVisitor& visit);
void visit_equilibrium(MotionModel& model, RowVisitor& visit);
void visit_coordinates(MotionModel& model, RowVisitor& visit);
void visit_ligaments(MotionModel& model, RowVisitor& visit);
void visit_uncertainty(UncertainMotion& motion, bool has_fibres, RowVisitor& visit);
void visit_inputs(std::vector<InputFile>& inputs, RowVisitor& visit);

}  // namespace registry

// Registry of the trace's datasets: one row per dataset, in the order of the file (schemas/trace.md).

inline constexpr const char* trace_format_name = "vrda search trace";
inline constexpr const char* trace_format_version = "1.1";
inline constexpr int trace_format_minor_version = 1;

void visit_rows(Trace& trace, RowVisitor& visit);

/// Visits every row of a trace: const for writing, non-const for reading.
template <typename ATrace, typename Visitor>
void visit_trace(ATrace& trace, Visitor&& visitor)
{
  RowVisitorOf<std::remove_reference_t<Visitor>, std::is_const_v<ATrace>> rows(visitor);
  visit_rows(const_cast<Trace&>(trace), rows);
}

// Checks the values of each dataset of a registry against the rule of its row.

class RowCheck : public RegistryVisitor {
 public:
  explicit RowCheck(ValueFindings& findings) : findings_(findings) {}

  template <typename Member>
  void operator()(const Dataset& dataset, const Member& member)
  {
    const auto values = values_of(member);
    using Scalar = typename decltype(values)::value_type;
    if constexpr (std::is_same_v<Scalar, std::string>) {
      check_texts(dataset, values);
    } else if constexpr (std::is_floating_point_v<Scalar>) {
      check_numbers(dataset, values);
    } else {
      check_integers(dataset, values);
    }
  }

 private:
  template <typename Scalar>
  void check_texts(const Dataset& dataset, std::span<const Scalar> texts)
  {
    std::set<std::string> seen;
    const auto is_sha256 = [](const std::string& text) {
      return text.size() == 64 && text.find_first_not_of("0123456789abcdef") == std::string::npos;
    };
    findings_.report_each(
        dataset.path, texts.size(), rule_text(dataset.valid),
        [&](std::size_t i) {
          switch (dataset.valid.rule) {
            case Rule::names:
              return texts[i].empty();
            case Rule::unique_names:
              return texts[i].empty() || !seen.insert(texts[i]).second;
            case Rule::sha256:
              return !is_sha256(texts[i]);
            default:
              return false;
          }
        },
        [&](std::size_t i) { return "\"" + texts[i] + "\""; });
  }

  template <typename Scalar>
  void check_integers(const Dataset& dataset, std::span<const Scalar> values)
  {
    const ValueRule& valid = dataset.valid;
    const std::vector<std::int8_t> codes = flag_table(dataset.flags()).values;
    const std::size_t width = width_of(valid.condition, values.size());
    const auto is_wrong = [&](std::size_t i) {
      if (valid.rule == Rule::any) return false;
      if (valid.rule == Rule::row_starts) {
        const bool is_last = i + 1 == values.size();
        return (i == 0 && values[i] != 0) || (i > 0 && values[i] < values[i - 1]) ||
               (is_last && static_cast<double>(values[i]) != valid.largest);
      }
      if (valid.rule == Rule::integer) {
        const auto value = static_cast<double>(values[i]);
        return value < valid.least || value > valid.largest;
      }
      if (valid.condition.when != ValueCondition::When::always)
        return valid.condition.at(i / width) ? values[i] != 0 && values[i] != 1 : values[i] != -1;
      return std::find(codes.begin(), codes.end(), values[i]) == codes.end();
    };
    findings_.report_each(dataset.path, values.size(), rule_text(valid), is_wrong,
                          [&](std::size_t i) { return std::to_string(values[i]); });
  }

  template <typename Scalar>
  void check_numbers(const Dataset& dataset, std::span<const Scalar> values)
  {
    switch (dataset.valid.rule) {
      case Rule::any:
        return;
      case Rule::axis:
        check_axis(dataset, values, min_axis_step_deg);
        return;
      case Rule::ascending:
        check_axis(dataset, values, min_key_step);
        return;
      case Rule::number:
      case Rule::number_or_nan:
        check_each_number(dataset, values);
        return;
      case Rule::rigid:
        check_rows(dataset, values, 16);
        return;
      case Rule::whole_rows:
        check_rows(dataset, values, width_of(dataset.valid.condition, values.size()));
        return;
      default:
        check_lengths(dataset, values);
    }
  }

  template <typename Scalar>
  void check_axis(const Dataset& dataset, std::span<const Scalar> values, double min_step)
  {
    findings_.report_numbers(
        dataset.path, values.data(), values.size(), rule_text(dataset.valid), [&](std::size_t i) {
          return !is_number(values[i]) || (i > 0 && !(values[i] - values[i - 1] >= min_step));
        });
  }

  template <typename Scalar>
  void check_each_number(const Dataset& dataset, std::span<const Scalar> values)
  {
    const ValueRule& valid = dataset.valid;
    const std::size_t width = width_of(valid.condition, values.size());
    findings_.report_numbers(
        dataset.path, values.data(), values.size(), rule_text(valid), [&](std::size_t i) {
          const auto value = static_cast<double>(values[i]);
          if (!valid.condition.at(i / width)) return !std::isnan(value);
          if (std::isnan(value)) return valid.rule != Rule::number_or_nan;
          return !is_number(value) || value < valid.least || (valid.excludes_least && value == valid.least);
        });
  }

  /// Checks poses, or rows that are all numbers or all NaN.
  template <typename Scalar>
  void check_rows(const Dataset& dataset, std::span<const Scalar> values, std::size_t width)
  {
    const ValueRule& valid = dataset.valid;
    if (values.empty()) return;
    const auto all = [&](std::size_t row, auto&& is) {
      return std::all_of(values.begin() + static_cast<std::ptrdiff_t>(row * width),
                         values.begin() + static_cast<std::ptrdiff_t>((row + 1) * width), is);
    };
    findings_.report_each(
        dataset.path, values.size() / width, rule_text(valid),
        [&](std::size_t row) {
          const bool are_nan = all(row, [](double x) { return std::isnan(x); });
          if (!valid.condition.at(row)) return !are_nan;
          if (valid.rule == Rule::rigid) return !is_rigid(values.subspan(16 * row, 16));
          return !are_nan && !all(row, [](double x) { return is_number(x); });
        },
        [&](std::size_t row) {
          if (!valid.condition.at(row)) return "numbers";
          return valid.rule == Rule::rigid ? "not a rigid pose" : "not numbers";
        });
  }

  template <typename Scalar>
  static bool is_rigid(std::span<const Scalar> entries)
  {
    double copy[16];
    std::copy(entries.begin(), entries.end(), copy);
    return is_rigid_pose(copy);
  }

  /// Checks the lengths of 3-vectors.
  template <typename Scalar>
  void check_lengths(const Dataset& dataset, std::span<const Scalar> values)
  {
    const Rule rule = dataset.valid.rule;
    const double tolerance = rule == Rule::exact_unit_rows ? exact_tolerance : normal_tolerance;
    const auto length = [&](std::size_t i) {
      return Eigen::Map<const Eigen::Matrix<Scalar, 3, 1>>(&values[3 * i]).template cast<double>().norm();
    };
    findings_.report_each(
        dataset.path, values.size() / 3, rule_text(dataset.valid),
        [&](std::size_t i) {
          const bool may_be_zero = rule == Rule::unit_or_zero_rows;
          return !(std::abs(length(i) - 1.0) <= tolerance) && !(may_be_zero && length(i) == 0.0);
        },
        [&](std::size_t i) { return "a vector of length " + text_of(length(i)); });
  }

  /// Number of values per leading entry.
  static std::size_t width_of(const ValueCondition& answered, std::size_t n_values)
  {
    if (answered.when == ValueCondition::When::always || answered.size() == 0) return 1;
    return std::max<std::size_t>(1, n_values / answered.size());
  }

  ValueFindings& findings_;
};

}  // namespace vrda::store
