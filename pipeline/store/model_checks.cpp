#include "store/model_checks.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <limits>
#include <optional>
#include <set>

#include "core/text.hpp"
#include "model/coordinates.hpp"
#include "store/motion.hpp"
#include "store/registry.hpp"

namespace vrda::store {
namespace {

/// Indices in the file are 32-bit.
constexpr std::int64_t largest_dimension = std::numeric_limits<std::int32_t>::max();

constexpr const char* wanted_readable =
    "values that can be read, filtered by gzip, shuffle and fletcher32 only";

std::string shape_text(const std::vector<std::int64_t>& shape)
{
  std::string text = "[";
  for (const std::int64_t size : shape) text += (text.size() > 1 ? ", " : "") + std::to_string(size);
  return text + "]";
}

std::string kind_text(const std::optional<ValueKind>& kind)
{
  return kind ? name_of(*kind) : "another type";
}

struct Format {
  const char* name;
  std::int32_t least_minor_version, minor_version;
};

/// Checks a file's structure while visiting the registry of the content that it builds.
class StructureCheck : public RegistryVisitor {
 public:
  explicit StructureCheck(const H5Reader& reader) : reader_(reader), findings_(reader.rejected()) {}

  bool may_change() const override { return true; }

  template <typename Content>
  Structure<Content> run(const Format& format)
  {
    Structure<Content> result;
    // A file with rejected links is not checked further.
    if (findings_.empty() && is_format(format)) {
      visit_registry(result.content, *this);
      if (value_bytes_ > max_value_bytes) {
        report("/", std::to_string(value_bytes_) + " bytes of values",
               "at most " + std::to_string(max_value_bytes));
      }
    }
    result.sizes = std::move(counted_);
    result.findings = std::move(findings_);
    return result;
  }

  void group(const std::string& path) override
  {
    if (!reader_.is_group(path)) report(path, "nothing", "a group");
  }

  bool has(const std::string& path, bool) override { return reader_.objects().count(path) > 0; }

  void dimension(const std::string& path, const DimensionSize& count) override
  {
    std::int64_t n = size_in_file(path);
    if (n == 0 && count.kind == DimensionSize::Kind::axis) report(path, "no values", "at least one");
    const bool is_fixed = count.kind == DimensionSize::Kind::fixed;
    if (is_fixed && are_sizes_known_ && n != count.n)
      report(path, "size " + std::to_string(n), "size " + std::to_string(count.n));
    if (!is_fixed) counted_.push_back({path, n});
    RegistryVisitor::dimension(path, DimensionSize::fixed(is_fixed ? count.n : n));
  }

 private:
  void visit_attribute(const std::string& object, const std::string& name, Attribute member,
                       const Unit&) override
  {
    const std::optional<AttributeValue> value = checked_attribute(object, name, member);
    if (value) std::visit([&](auto* one) { assign(*value, *one); }, member);
  }

  /// The value is compared after the datasets that it repeats have been read.
  void visit_derived(const std::string& object, const std::string& name, Attribute value) override
  {
    checked_attribute(object, name, value);
  }

  void visit_list(const std::string& group, List list) override
  {
    std::visit([&](auto* elements) { find_elements(group, *elements); }, list);
  }

  template <typename Element>
  void find_elements(const std::string& group, std::vector<Element>& list)
  {
    for (const auto& [path, kind] : reader_.objects()) {
      if (path.rfind(group + "/", 0) != 0 || path.find('/', group.size() + 1) != std::string::npos) continue;
      Element element;
      if (set_group_name(element, path.substr(group.size() + 1))) {
        // In the order of the writer: degree_2 before degree_10.
        list.insert(std::upper_bound(list.begin(), list.end(), element,
                                     [](const Element& a, const Element& b) { return is_before(a, b); }),
                    std::move(element));
      } else if (!is_later_) {
        report(path, "another name", allowed_group_names(element));
      }
    }
  }

  void visit_dataset(const Dataset& dataset, Member member) override
  {
    check_dataset(dataset, store::kind_of(member));
  }

  static bool is_before(const SmoothedSet& a, const SmoothedSet& b) { return a.degree < b.degree; }
  static bool is_before(const AuditSet& a, const AuditSet& b) { return a.name < b.name; }
  static bool is_before(const OfFollower& a, const OfFollower& b) { return a.name < b.name; }
  static bool is_before(const PriorTermRows& a, const PriorTermRows& b)
  {
    return a.coordinate < b.coordinate;
  }

  void report(const std::string& where, const std::string& found, const std::string& wanted)
  {
    findings_.push_back({where, found, wanted});
  }

  /// The text of a one-element attribute; empty if none exists.
  std::string text(const std::string& object, const std::string& name) const
  {
    const std::optional<AttributeValue> value = reader_.attribute(object, name);
    return value && value->texts.size() == 1 ? value->texts[0] : std::string();
  }

  /// Both formats have major version 1.
  bool is_format(const Format& wanted)
  {
    const std::string format = text("/", "format");
    if (format != wanted.name) {
      report("/@format", format.empty() ? "nothing" : "\"" + format + "\"",
             "\"" + std::string(wanted.name) + "\"");
      return false;
    }
    const std::string version = text("/", "format_version");
    const char* end = version.data() + version.size();
    std::int32_t major_version = 0, minor_version = 0;
    const std::from_chars_result major = std::from_chars(version.data(), end, major_version);
    const bool has_minor = major.ec == std::errc() && major.ptr != end && *major.ptr == '.';
    const std::from_chars_result minor =
        has_minor ? std::from_chars(major.ptr + 1, end, minor_version) : major;
    const bool is_whole = has_minor && minor.ec == std::errc() && minor.ptr == end;
    is_later_ = minor_version > wanted.minor_version;
    if (is_whole && major_version == 1 && minor_version >= wanted.least_minor_version) return true;
    const std::string least = "1." + std::to_string(wanted.least_minor_version);
    if (major.ec == std::errc() && major_version > 1) {
      report("/@format_version", "\"" + version + "\", a newer format",
             "\"" + least + "\" or a later \"1.\" version, which this program reads");
    } else {
      report("/@format_version", version.empty() ? "nothing" : "\"" + version + "\"",
             "\"" + least + "\" or a later \"1.\" version");
    }
    return false;
  }

  bool is_elsewhere(const std::string& path, const DatasetInfo& facts)
  {
    if (!facts.external_storage.empty()) report(path, facts.external_storage, wanted_readable);
    return !facts.external_storage.empty();
  }

  /// The size of a dimension; 0, with a finding, when it is missing.
  std::int64_t size_in_file(const std::string& path)
  {
    const bool is_there = reader_.is_dataset(path);
    const DatasetInfo facts = is_there ? reader_.dataset_info(path) : DatasetInfo();
    if (!is_there) {
      report(path, "nothing", "a dimension scale");
    } else if (!is_elsewhere(path, facts)) {
      if (facts.scale_name.empty()) report(path, "no dimension scale", "a dimension scale");
      if (facts.shape.size() == 1 && facts.shape[0] >= 0 && facts.shape[0] <= largest_dimension)
        return facts.shape[0];
      report(path, "shape " + shape_text(facts.shape), "one axis of at most 2147483647 entries");
    }
    are_sizes_known_ = false;
    return 0;
  }

  void check_dataset(const Dataset& dataset, ValueKind kind)
  {
    const std::string& path = dataset.path;
    if (!reader_.is_dataset(path)) {
      report(path, reader_.is_group(path) ? "a group" : "nothing",
             std::string("a dataset: ") + dataset.long_name);
      return;
    }
    const DatasetInfo facts = reader_.dataset_info(path);
    if (is_elsewhere(path, facts)) return;
    if (facts.kind != kind) report(path, kind_text(facts.kind), name_of(kind));
    if (are_sizes_known_) check_shape(dataset, facts, bytes_of(kind));
    check_text_attribute(path, "units", dataset.units.name);
    if (dataset.flags() != FlagSet::none) check_flags(path, flag_table(dataset.flags()));
    if (may_be_nan(dataset, kind)) check_fill_value(path);
  }

  void check_shape(const Dataset& dataset, const DatasetInfo& facts, std::uint64_t element_bytes)
  {
    const std::vector<std::int64_t> shape = shape_of(dataset);
    if (facts.shape != shape) {
      report(dataset.path, "shape " + shape_text(facts.shape), "shape " + shape_text(shape));
    } else if (!facts.storage_problem.empty()) {
      report(dataset.path, facts.storage_problem, wanted_readable);
    } else {
      check_scales(dataset, facts);
    }
    std::uint64_t bytes = element_bytes;
    bool is_countable = true;
    for (const std::int64_t size : shape)
      is_countable &= !__builtin_mul_overflow(bytes, static_cast<std::uint64_t>(size), &bytes);
    is_countable &= !__builtin_add_overflow(value_bytes_, bytes, &value_bytes_);
    if (!is_countable) value_bytes_ = std::numeric_limits<std::uint64_t>::max() / 2;
  }

  void check_scales(const Dataset& dataset, const DatasetInfo& facts)
  {
    if (dataset.dimensions.size() == 1 && dataset.dimensions[0] == dataset.path) {
      const std::string name = dataset.path.substr(dataset.path.rfind('/') + 1);
      if (facts.scale_name != name)
        report(dataset.path, "scale name \"" + facts.scale_name + "\"", "\"" + name + "\"");
      return;
    }
    for (std::size_t axis = 0; axis < dataset.dimensions.size(); ++axis) {
      if (reader_.is_attached(dataset.path, axis, dataset.dimensions[axis])) continue;
      report(dataset.path, "axis " + std::to_string(axis) + " without its scale",
             "dimension scale " + dataset.dimensions[axis] + " attached");
    }
  }

  void check_text_attribute(const std::string& object, const std::string& name, const std::string& wanted)
  {
    if (wanted.empty()) return;
    const std::string found = text(object, name);
    if (found != wanted) {
      report(object + "@" + name, found.empty() ? "nothing" : "\"" + found + "\"", "\"" + wanted + "\"");
    }
  }

  void check_flags(const std::string& path, const FlagTable& table)
  {
    check_text_attribute(path, "flag_meanings", table.meanings);
    const std::optional<AttributeValue> found = reader_.attribute(path, "flag_values");
    const std::vector<double> wanted(table.values.begin(), table.values.end());
    if (found && found->kind == ValueKind::int8 && found->numbers == wanted) return;
    report(path + "@flag_values", found ? "other values" : "nothing", "the int8 codes of " + table.meanings);
  }

  void check_fill_value(const std::string& path)
  {
    const std::optional<AttributeValue> value = reader_.attribute(path, "_FillValue");
    if (value && value->kind == ValueKind::float64 && value->numbers.size() == 1 &&
        std::isnan(value->numbers[0])) {
      return;
    }
    report(path + "@_FillValue", value ? "another value" : "nothing", "one float64 NaN");
  }

  /// An attribute with the type and size of `member`; empty, with a finding, if it is missing or different.
  std::optional<AttributeValue> checked_attribute(const std::string& object, const std::string& name,
                                                  const Attribute& member)
  {
    const bool is_flag = std::holds_alternative<bool*>(member);
    const bool is_vector = std::holds_alternative<Eigen::Vector3d*>(member);
    const ValueKind kind = std::holds_alternative<std::string*>(member)    ? ValueKind::text
                           : std::holds_alternative<std::int32_t*>(member) ? ValueKind::int32
                           : is_flag                                       ? ValueKind::int8
                                                                           : ValueKind::float64;
    if (reader_.objects().count(object) == 0) return std::nullopt;  // already reported
    const std::string where = object + "@" + name;
    const std::size_t n = is_vector ? 3 : 1;
    const std::string wanted = std::to_string(n) + " of " + name_of(kind);
    const std::optional<AttributeValue> value = reader_.attribute(object, name);
    if (!value) {
      report(where, "nothing", wanted);
    } else if (value->kind != kind) {
      report(where, kind_text(value->kind), wanted);
    } else if (const std::size_t found = value->numbers.size() + value->texts.size(); found != n) {
      report(where, std::to_string(found) + " of " + name_of(kind), wanted);
    } else if (is_flag && value->numbers[0] != 0.0 && value->numbers[0] != 1.0) {
      report(where, "another value", "0 or 1");
    } else {
      return value;
    }
    return std::nullopt;
  }

  static void assign(const AttributeValue& value, std::string& member) { member = value.texts[0]; }
  static void assign(const AttributeValue& value, bool& member) { member = value.numbers[0] != 0.0; }
  static void assign(const AttributeValue& value, double& member) { member = value.numbers[0]; }
  static void assign(const AttributeValue& value, std::int32_t& member)
  {
    member = static_cast<std::int32_t>(value.numbers[0]);
  }
  static void assign(const AttributeValue& value, Eigen::Vector3d& member)
  {
    member = {value.numbers[0], value.numbers[1], value.numbers[2]};
  }

  const H5Reader& reader_;
  std::vector<Finding> findings_;
  std::vector<std::pair<std::string, std::int64_t>> counted_;
  bool are_sizes_known_ = true;  ///< whether every dimension so far was found
  bool is_later_ = false;        ///< later minor version, which may have more names
  std::uint64_t value_bytes_ = 0;
};

}  // namespace

Structure<MotionModel> structure_of_model(const H5Reader& reader)
{
  return StructureCheck(reader).run<MotionModel>({format_name, least_minor_version, format_minor_version});
}

Structure<Trace> structure_of_trace(const H5Reader& reader)
{
  return StructureCheck(reader).run<Trace>(
      {trace_format_name, trace_format_minor_version, trace_format_minor_version});
}

namespace {

// Checks the values of each dataset of a registry against the rule of its row.

class RowCheck : public RegistryVisitor {
 public:
  explicit RowCheck(ValueFindings& findings) : findings_(findings) {}

 private:
  void visit_dataset(const Dataset& dataset, Member member) override
  {
    with_values(member, [&]<typename Scalar>(std::span<Scalar> values) {
      if constexpr (std::is_same_v<Scalar, std::string>) {
        check_texts(dataset, values);
      } else if constexpr (std::is_floating_point_v<Scalar>) {
        check_numbers(dataset, std::span<const Scalar>(values));
      } else {
        check_integers(dataset, std::span<const Scalar>(values));
      }
    });
  }

  void check_texts(const Dataset& dataset, std::span<const std::string> texts)
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

/// Tolerance of smoothed values against their polynomial: sums of at most 231 terms of up to 1e3 mm.
constexpr double smoothed_tolerance = 1e-9;

// For sums of squares that may be accumulated in another order.
bool is_near(double a, double b)
{
  return std::abs(a - b) <= exact_tolerance * (1.0 + std::abs(b));
}

/// Rules beyond the rows of the registry: attributes, and relations between datasets.
class ModelRules {
 public:
  ModelRules(const MotionModel& model, ValueFindings& findings)
      : model_(model),
        findings_(findings),
        n_varus_(model.varus_deg.size()),
        n_cells_(model.flexion_deg.size() * model.varus_deg.size())
  {
  }

  void check_root_attributes()
  {
    one_of("/@joint", model_.joint, {joint_kind_names.begin(), joint_kind_names.end()});
    one_of("/@side", model_.side, {"right", "left"});
    one_of("/@method", model_.method, {"stability-search", "equilibrium", "import"});
    findings_.report_not_finite("/@rotation_centre_mm", model_.rotation_centre_mm.data(), 3);
    const double length = model_.delta.norm();
    if (!(std::abs(length - 1.0) <= exact_tolerance)) {
      findings_.add("/@delta", "a vector of length " + text_of(length), "length 1");
    } else if ((model_.push.delta.row(0).transpose() - model_.delta).norm() > exact_tolerance) {
      findings_.add("/@delta", "a different direction", "that of the first row of /push/delta");
    }
    if (!(model_.contact_resolution_mm > 0.0) || !is_number(model_.contact_resolution_mm)) {
      findings_.add("/@contact_resolution_mm", text_of(model_.contact_resolution_mm), "a positive length");
    }
  }

  void run()
  {
    check_cells();
    if (model_.frames) check_frames(*model_.frames);
    if (model_.repair && !model_.frames) findings_.add("/repair", "a repair", "nothing without /frame");
    findings_.report_not_finite("/push@point_mm", model_.push.point_mm.data(), 3);
    if (model_.equilibrium) check_equilibrium(*model_.equilibrium);
    if (model_.ligaments &&
        !(is_number(model_.ligaments->transition_strain) && model_.ligaments->transition_strain > 0.0)) {
      findings_.add("/ligaments@transition_strain", text_of(model_.ligaments->transition_strain),
                    "a strain above 0");
    }
    for (const auto& [group, body] :
         {std::pair("/bodies/reference", &model_.reference), std::pair("/bodies/moving", &model_.moving)}) {
      if (body->contact.mesh.triangles.rows() == 0)
        findings_.add(std::string(group) + "/triangles", "no triangles", "at least one");
    }
    for (const SmoothedSet& set : model_.smoothed) check_smoothed(set);
    if (model_.zero_varus) check_zero_varus(*model_.zero_varus);
    for (const AuditSet& audit : model_.audits) check_audit(audit);
    if (model_.job.scaling) check_scaling(*model_.job.scaling);
    if (model_.default_motion && !is_audit_name(model_.default_motion->set))
      findings_.add("/default_motion@set", "\"" + model_.default_motion->set + "\"",
                    allowed_group_names(AuditSet()));
  }

 private:
  bool is_stable(std::size_t cell) const { return model_.status.data()[cell] == status_stable; }

  void one_of(const std::string& where, const std::string& value, const std::vector<std::string>& allowed)
  {
    if (std::find(allowed.begin(), allowed.end(), value) != allowed.end()) return;
    std::string wanted;
    for (const std::string& word : allowed) wanted += (wanted.empty() ? "\"" : ", \"") + word + "\"";
    findings_.add(where, "\"" + value + "\"", "one of " + wanted);
  }

  void check_cells()
  {
    check_plausibility("/plausibility", model_.status, model_.plausibility);
    for (const FollowerRows& follower : model_.followers) {
      if (follower.plausibility.size() > 0)
        check_plausibility("/followers/" + follower.name + "/plausibility", follower.status,
                           follower.plausibility);
    }
    findings_.report_each(
        "/is_spine", model_.flexion_deg.size(), "at most one spine cell per flexion",
        [&](std::size_t i) { return (model_.is_spine.row(static_cast<Eigen::Index>(i)) == 1).count() > 1; },
        [&](std::size_t) { return "several spine cells"; });
    if (n_varus_ == 1) return;
    const double* solved_deg = model_.varus_solved_deg.data();
    findings_.report_numbers("/varus_solved", solved_deg, n_cells_,
                             "the cell's varus where the axis has several", [&](std::size_t cell) {
                               const double wanted_deg = model_.varus_deg[cell % n_varus_];
                               return is_stable(cell) && is_number(wanted_deg) &&
                                      std::abs(solved_deg[cell] - wanted_deg) > exact_tolerance;
                             });
  }

  void check_plausibility(const std::string& where, const GridB& status, const GridB& plausibility)
  {
    findings_.report_each(
        where, n_cells_, "-1 where status is not stable",
        [&](std::size_t cell) {
          return status.data()[cell] != status_stable && plausibility.data()[cell] != plausibility_not_judged;
        },
        [&](std::size_t cell) { return std::to_string(plausibility.data()[cell]); });
  }

  /// A motion derived over flexion has no meaning where flexion may repeat.
  void check_frames(const FrameSequence& frames)
  {
    if (!is_key_name(frames.key_name)) {
      findings_.add("/frame@key_name", "\"" + frames.key_name + "\"",
                    "a lower-case letter, then at most 39 lower-case letters, digits and underscores");
    }
    if (n_varus_ != 1 || model_.varus_deg[0] != 0.0)
      findings_.add("/varus", "other values", "the single value 0 in a sequence of frames");
    const char* wanted = "nothing in a sequence of frames";
    if (!model_.smoothed.empty()) findings_.add("/smoothed", "a smoothed motion", wanted);
    if (model_.two_sided) findings_.add("/two_sided", "a two-sided motion", wanted);
    if (model_.zero_varus) findings_.add("/zero_varus", "a zero-varus motion", wanted);
    for (const AuditSet& audit : model_.audits)
      if (audit.name != "raw") findings_.add(audit_group(audit.name), "an audit", wanted);
  }

  void check_equilibrium(const EquilibriumSurfaces& equilibrium)
  {
    if (!(equilibrium.band_moment_nmm >= 0.0) || !is_number(equilibrium.band_moment_nmm))
      findings_.add("/equilibrium@band_moment_nmm", text_of(equilibrium.band_moment_nmm), "0 or a moment");
    const std::vector<std::int64_t>& start = equilibrium.forces.row_start;
    const auto n = static_cast<std::int64_t>(equilibrium.forces.along_delta_n.size());
    const bool are_rows_sound =
        std::is_sorted(start.begin(), start.end()) && start.front() == 0 && start.back() == n;
    if (are_rows_sound) check_directions(equilibrium.forces);
    check_branches(equilibrium.spine);
  }

  void check_branches(const FreeSpine& spine)
  {
    const SpineBranches& branches = spine.branches;
    const std::vector<std::int64_t>& start = branches.row_start;
    const auto n = static_cast<std::int64_t>(branches.energy_nmm.size());
    if (!std::is_sorted(start.begin(), start.end()) || start.front() != 0 || start.back() != n) return;
    const auto n_chosen = [&](std::size_t i) {
      return std::count(branches.is_chosen.begin() + start[i], branches.is_chosen.begin() + start[i + 1], 1);
    };
    findings_.report_each(
        "/equilibrium/spine/branches/is_chosen", spine.status.size(),
        "one chosen equilibrium where the spine is stable, else none",
        [&](std::size_t i) { return n_chosen(i) != (spine.status[i] == status_stable ? 1 : 0); },
        [&](std::size_t i) { return std::to_string(n_chosen(i)); });
    findings_.report_each(
        "/equilibrium/spine/branches/row_start", spine.status.size(), "n_optima equilibria",
        [&](std::size_t i) { return start[i + 1] - start[i] != spine.n_optima[i]; },
        [&](std::size_t i) { return std::to_string(start[i + 1] - start[i]) + " equilibria"; });
  }

  /// The force is along_delta * normal / -(normal . Delta): it exists where the normal opposes Delta.
  void check_directions(const ForceRows& forces)
  {
    const std::size_t n_varus = model_.varus_deg.size();
    findings_.report_each(
        "/equilibrium/forces/normal", n_cells_, "normals that oppose Delta",
        [&](std::size_t cell) {
          const Eigen::RowVector3d delta = model_.push.delta.row(static_cast<Eigen::Index>(cell / n_varus));
          for (std::int64_t row = forces.row_start[cell]; row < forces.row_start[cell + 1]; ++row) {
            if (forces.normal_world.row(row).dot(delta) >= 0.0) return true;
          }
          return false;
        },
        [&](std::size_t) { return "a normal that does not oppose Delta"; });
  }

  /// Number of pairs (i, j) with i + j <= degree; an axis with one value has its constant only.
  std::size_t wanted_terms(std::int32_t degree) const
  {
    const bool has_flexion = model_.flexion_deg.size() > 1, has_varus = model_.varus_deg.size() > 1;
    const std::size_t n = static_cast<std::size_t>(degree);
    if (has_flexion && has_varus) return (n + 1) * (n + 2) / 2;
    return has_flexion || has_varus ? n + 1 : 1;
  }

  bool has_right_terms(const SmoothedSet& set, const std::string& group)
  {
    const std::size_t n_terms = static_cast<std::size_t>(set.exponents.rows());
    const std::size_t wanted = wanted_terms(set.degree);
    if (n_terms != wanted) {
      findings_.add(
          group + "/exponents", std::to_string(n_terms) + " terms",
          std::to_string(wanted) + " terms for degree " + std::to_string(set.degree) + " on this grid");
      return false;
    }
    std::set<std::pair<std::int32_t, std::int32_t>> seen;
    const std::size_t before = findings_.size();
    findings_.report_each(
        group + "/exponents", n_terms, "each pair of degrees up to the total degree exactly once",
        [&](std::size_t k) {
          const std::int32_t i = set.exponents(static_cast<Eigen::Index>(k), 0);
          const std::int32_t j = set.exponents(static_cast<Eigen::Index>(k), 1);
          // Compared separately: the sum of two arbitrary values could overflow.
          return i < 0 || j < 0 || i > set.degree || j > set.degree - i ||
                 (i > 0 && model_.flexion_deg.size() == 1) || (j > 0 && model_.varus_deg.size() == 1) ||
                 !seen.insert({i, j}).second;
        },
        [&](std::size_t k) {
          return std::to_string(set.exponents(static_cast<Eigen::Index>(k), 0)) + ", " +
                 std::to_string(set.exponents(static_cast<Eigen::Index>(k), 1));
        });
    return findings_.size() == before;
  }

  void check_smoothed(const SmoothedSet& set)
  {
    const std::string group = smoothed_group(set.degree);
    if (set.degree < 0 || set.degree > max_smoothed_degree) {
      findings_.add(group, "degree " + std::to_string(set.degree),
                    "a degree from 0 to " + std::to_string(max_smoothed_degree));
      return;
    }
    if (set.surfaces.size() == 5 && n_varus_ > 1) {
      findings_.add(smoothed_path(set.degree, "varus"), "a surface",
                    "no such surface where /varus has several values");
    }
    if (model_.frames || !has_right_terms(set, group)) return;
    const AxisRanges ranges = axis_ranges(model_.flexion_deg, model_.varus_deg);
    const auto check_surface = [&](const SmoothedSurface& surface, const std::string& path) {
      const double* values = surface.values.data();
      findings_.report_numbers(path, values, n_cells_, "the value of the polynomial", [&](std::size_t cell) {
        const double wanted = evaluate(set, surface, ranges, model_.flexion_deg[cell / n_varus_],
                                       model_.varus_deg[cell % n_varus_]);
        return !(std::abs(values[cell] - wanted) <= smoothed_tolerance * (1.0 + std::abs(wanted)));
      });
    };
    for (const SmoothedSurface& surface : set.surfaces)
      check_surface(surface, smoothed_path(set.degree, surface.name));
    for (const SmoothedFollower& follower : set.followers) {
      for (const SmoothedSurface& surface : follower.surfaces)
        check_surface(surface, group + "/followers/" + follower.name + "/" + surface.name);
    }
  }

  void check_zero_varus(const ZeroVarus& motion)
  {
    const std::size_t n = motion.source.size();
    const auto is = [&](std::size_t i, ZeroVarusSource source) {
      return motion.source[i] == code_of(source);
    };
    if (!is_audit_name(motion.set) || motion.set == "zero_varus")
      findings_.add("/zero_varus@set", motion.set, "raw, degree_N or degree_N_recontacted");
    findings_.report_each(
        "/zero_varus/source", n, "free only where /varus has one value",
        [&](std::size_t i) { return is(i, ZeroVarusSource::free) && n_varus_ > 1; },
        [](std::size_t) { return "free"; });
    const std::vector<double>&varus = motion.varus_deg, &first = motion.varus_first_deg,
          &last = motion.varus_last_deg;
    findings_.report_numbers("/zero_varus/varus_last", last.data(), n, "at least varus_first",
                             [&](std::size_t i) { return last[i] < first[i]; });
    findings_.report_numbers(
        "/zero_varus/varus", varus.data(), n, "the mean of varus_first and varus_last", [&](std::size_t i) {
          const double mean_deg = 0.5 * (first[i] + last[i]);
          return is(i, ZeroVarusSource::both_touch) && std::abs(varus[i] - mean_deg) > exact_tolerance;
        });
    const auto length = [&](std::size_t i) {
      return Eigen::Map<const Eigen::Vector3d>(&motion.helical_direction[3 * i]).norm();
    };
    findings_.report_each(
        "/zero_varus/helical_direction", motion.helical_direction.size() / 3, "unit vectors",
        [&](std::size_t i) { return is_number(length(i)) && std::abs(length(i) - 1.0) > exact_tolerance; },
        [&](std::size_t i) { return "a vector of length " + text_of(length(i)); });
  }

  void check_audit(const AuditSet& audit)
  {
    const std::string group = audit_group(audit.name);
    if (audit.refine < 1) findings_.add(group + "@refine", std::to_string(audit.refine), "at least 1");
    const double* penetration_mm = audit.penetration_mm.data();
    findings_.report_numbers(group + "/penetration", penetration_mm,
                             static_cast<std::size_t>(audit.penetration_mm.size()),
                             "0 where state is free or nothing_ahead", [&](std::size_t i) {
                               const std::int8_t state = audit.state.data()[i];
                               return state != code_of(AuditState::overlapping) &&
                                      state != code_of(AuditState::no_pose) && penetration_mm[i] > 0.0;
                             });
  }

  void check_scaling(const Scaling& scaling)
  {
    const std::string group = "/job/scaling";
    const std::size_t n = scaling.landmark.size();
    findings_.report_numbers(group + "@factor", scaling.factor.data(), 3, "numbers above 0",
                             [&](std::size_t i) {
                               const double factor = scaling.factor.data()[i];
                               return !is_number(factor) || factor <= 0.0;
                             });
    if ((scaling.keeps_steps || n > 0) && !is_uniform(scaling.factor)) {
      findings_.add(group + "@factor", "unequal numbers",
                    "three equal numbers where steps are kept or landmarks fitted");
    }
    findings_.report_numbers(group + "/residual", scaling.residual_mm.data(), n,
                             "the subject's distance minus the factor times the model's", [&](std::size_t i) {
                               return is_number(scaling.residual_mm[i]) &&
                                      !is_near(
                                          scaling.residual_mm[i],
                                          scaling.subject_mm[i] - scaling.factor.x() * scaling.model_mm[i]);
                             });
    double sum_sq_mm2 = 0.0;
    for (const double residual_mm : scaling.residual_mm) sum_sq_mm2 += residual_mm * residual_mm;
    const double rms_mm = std::sqrt(sum_sq_mm2 / static_cast<double>(n));
    const double found_mm = scaling.residual_rms_mm, error = scaling.standard_error;
    if (n == 0 ? !std::isnan(found_mm) : !is_near(found_mm, rms_mm)) {
      findings_.add(group + "@residual_rms_mm", text_of(found_mm),
                    n == 0 ? "NaN without landmarks" : text_of(rms_mm) + ", the value from the residuals");
    }
    if (n < 2 ? !std::isnan(error) : !(is_number(error) && error >= 0.0)) {
      findings_.add(group + "@standard_error", text_of(error),
                    n < 2 ? "NaN with fewer than two pairs of landmarks" : "a number of at least 0");
    }
  }

  const MotionModel& model_;
  ValueFindings& findings_;
  std::size_t n_varus_;
  std::size_t n_cells_;
};

}  // namespace

void check_rows(const MotionModel& model, ValueFindings& findings)
{
  RowCheck rows(findings);
  visit_registry(model, rows);
}

void check_rows(const Trace& trace, ValueFindings& findings)
{
  RowCheck rows(findings);
  visit_registry(trace, rows);
}

std::vector<Finding> check_values(const MotionModel& model)
{
  ValueFindings findings;
  ModelRules rules(model, findings);
  rules.check_root_attributes();
  check_rows(model, findings);
  rules.run();
  return findings.take();
}

void require_no_findings(const std::vector<Finding>& findings, const std::string& file)
{
  if (findings.empty()) return;
  throw InputError({file, findings[0].where, findings[0].found, findings[0].wanted});
}

namespace {

template <typename Content>
Content read_values(const H5Reader& reader, Structure<Content> structure)
{
  Hdf5ReadVisitor values(reader, structure.sizes);
  visit_registry(structure.content, values);
  if constexpr (std::is_same_v<Content, MotionModel>)
    if (!structure.content.has_compartments) set_no_compartments(structure.content);
  return std::move(structure.content);
}

/// Checks an attribute that repeats a number computed from the group's datasets.
void check_repeated(const H5Reader& reader, const std::string& group, const std::string& name, double wanted,
                    std::vector<Finding>& findings)
{
  const std::optional<AttributeValue> attribute = reader.attribute(group, name);
  check(attribute && attribute->numbers.size() == 1, "the structure must have been checked");
  const double found = attribute->numbers[0];
  if (found == wanted || (std::isnan(found) && std::isnan(wanted))) return;
  findings.push_back(
      {group + "@" + name, text_of(found), text_of(wanted) + ", the value from the group's datasets"});
}

std::vector<Finding> findings_of(const H5Reader& reader, const MotionModel& model)
{
  std::vector<Finding> findings;
  for (const SmoothedSet& set : model.smoothed)
    check_repeated(reader, smoothed_group(set.degree), "degree", set.degree, findings);
  for (const AuditSet& audit : model.audits) {
    const AuditSummary summary = summary_of(audit);
    const std::string group = audit_group(audit.name);
    check_repeated(reader, group, "largest_penetration", summary.largest_penetration_mm, findings);
    check_repeated(reader, group, "largest_gap", summary.largest_gap_mm, findings);
  }
  for (Finding& finding : check_values(model)) findings.push_back(std::move(finding));
  return findings;
}

}  // namespace

MotionModel parse_motion_model(const Hdf5Content& content)
{
  const H5Reader reader(content);
  Structure<MotionModel> structure = structure_of_model(reader);
  require_no_findings(structure.findings, content.file);
  MotionModel model = read_values(reader, std::move(structure));
  require_no_findings(findings_of(reader, model), content.file);
  return model;
}

Trace parse_trace(const Hdf5Content& content)
{
  const H5Reader reader(content);
  Structure<Trace> structure = structure_of_trace(reader);
  require_no_findings(structure.findings, content.file);
  Trace trace = read_values(reader, std::move(structure));
  require_no_findings(check_values(trace), content.file);
  return trace;
}

std::vector<Finding> findings_in(const Hdf5Content& content)
{
  const H5Reader reader(content);
  const std::optional<AttributeValue> format = reader.attribute("/", "format");
  try {
    if (format && format->texts == std::vector<std::string>{trace_format_name}) {
      Structure<Trace> structure = structure_of_trace(reader);
      if (!structure.findings.empty()) return structure.findings;
      return check_values(read_values(reader, std::move(structure)));
    }
    Structure<MotionModel> structure = structure_of_model(reader);
    if (!structure.findings.empty()) return structure.findings;
    return findings_of(reader, read_values(reader, std::move(structure)));
  } catch (const InputError& error) {
    // A damaged chunk is detected only when its values are read.
    return {{error.facts().field, error.facts().found, error.facts().wanted}};
  }
}

}  // namespace vrda::store
