/// Checks the values of each dataset of a registry against the rule of its row.
#pragma once

#include <algorithm>
#include <cmath>
#include <set>
#include <string>

#include "store/registry_visitor.hpp"
#include "store/value_findings.hpp"

namespace vrda::store {

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
