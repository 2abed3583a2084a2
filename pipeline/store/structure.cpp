#include "store/structure.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <limits>
#include <optional>

#include "store/registry.hpp"
#include "store/trace_registry.hpp"

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

std::uint64_t bytes_of(ValueKind kind)
{
  if (kind == ValueKind::float64 || kind == ValueKind::int64) return 8;
  return kind == ValueKind::int8 ? 1 : 4;  // a text counts as its length field
}

/// Checks a file's structure while visiting the registry of the content that it builds.
class StructureCheck : public RegistryVisitor {
 public:
  explicit StructureCheck(const H5Reader& reader) : reader_(reader), findings_(reader.rejected()) {}

  template <typename Content, typename Visit>
  Structure<Content> run(const Format& format, const Visit& visit)
  {
    Structure<Content> result;
    // A file with rejected links is not checked further.
    if (findings_.empty() && is_format(format)) {
      visit(result.content, *this);
      if (value_bytes_ > max_value_bytes) {
        report("/", std::to_string(value_bytes_) + " bytes of values",
               "at most " + std::to_string(max_value_bytes));
      }
    }
    result.sizes = std::move(counted_);
    result.findings = std::move(findings_);
    return result;
  }

  void group(const std::string& path)
  {
    if (!reader_.is_group(path)) report(path, "nothing", "a group");
  }

  bool has(const std::string& path, bool) { return reader_.objects().count(path) > 0; }

  void dimension(const std::string& path, const DimensionSize& count)
  {
    std::int64_t n = size_in_file(path);
    if (n == 0 && count.kind == DimensionSize::Kind::axis) report(path, "no values", "at least one");
    const bool is_fixed = count.kind == DimensionSize::Kind::fixed;
    if (is_fixed && are_sizes_known_ && n != count.n)
      report(path, "size " + std::to_string(n), "size " + std::to_string(count.n));
    if (!is_fixed) counted_.push_back({path, n});
    RegistryVisitor::dimension(path, DimensionSize::fixed(is_fixed ? count.n : n));
  }

  template <typename Member>
  void attribute(const std::string& object, const std::string& name, Member& member, const Unit&)
  {
    if (const std::optional<AttributeValue> value = checked_attribute(object, name, member)) {
      assign(*value, member);
    }
  }

  /// The value is compared after the datasets that it repeats have been read.
  template <typename Value>
  void derived_attribute(const std::string& object, const std::string& name, const Value& value)
  {
    checked_attribute(object, name, value);
  }

  template <typename List>
  void list(const std::string& group, List& list)
  {
    for (const auto& [path, kind] : reader_.objects()) {
      if (path.rfind(group + "/", 0) != 0 || path.find('/', group.size() + 1) != std::string::npos) continue;
      typename List::value_type element;
      if (set_group_name(element, path.substr(group.size() + 1))) {
        list.push_back(std::move(element));
      } else if (!is_later_) {
        report(path, "another name", allowed_group_names(element));
      }
    }
    // In the order of the writer: degree_2 before degree_10.
    std::stable_sort(list.begin(), list.end(), [](const auto& a, const auto& b) { return is_before(a, b); });
  }

  template <typename Member>
  void operator()(const Dataset& dataset, const Member&)
  {
    check_dataset(dataset, member_kind<Member>());
  }

 private:
  static bool is_before(const SmoothedSet& a, const SmoothedSet& b) { return a.degree < b.degree; }
  static bool is_before(const AuditSet& a, const AuditSet& b) { return a.name < b.name; }

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
  template <typename Member>
  std::optional<AttributeValue> checked_attribute(const std::string& object, const std::string& name,
                                                  const Member&)
  {
    constexpr bool is_flag = std::is_same_v<Member, bool>;
    constexpr bool is_vector = std::is_same_v<Member, Eigen::Vector3d>;
    constexpr ValueKind kind = is_flag ? ValueKind::int8
                               : is_vector
                                   ? ValueKind::float64
                                   : value_kind<std::conditional_t<is_flag || is_vector, double, Member>>();
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
  return StructureCheck(reader).run<MotionModel>(
      {format_name, least_minor_version, format_minor_version},
      [](MotionModel& model, StructureCheck& check) { visit_motion_model(model, check); });
}

Structure<Trace> structure_of_trace(const H5Reader& reader)
{
  return StructureCheck(reader).run<Trace>(
      {trace_format_name, trace_format_minor_version, trace_format_minor_version},
      [](Trace& trace, StructureCheck& check) { visit_trace(trace, check); });
}

}  // namespace vrda::store
