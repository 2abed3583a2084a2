#include "store/structure.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <limits>
#include <optional>

#include "store/derived_layout.hpp"
#include "store/trace_layout.hpp"

namespace vrda {
namespace {

constexpr const char* equilibrium = "equilibrium";

/// Indices in the file are 32-bit.
constexpr std::int64_t largest_dimension = std::numeric_limits<std::int32_t>::max();

constexpr const char* readable = "values that can be read, filtered by gzip, shuffle and fletcher32 only";

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

class StructureCheck {
 public:
  explicit StructureCheck(const H5Reader& reader) : reader_(reader) {}

  Structure run()
  {
    result_.findings = reader_.refused();
    if (!is_format(format_name)) return result_;
    read_shape();
    if (!result_.findings.empty()) return result_;
    result_.layout = layout_of(result_.shape);
    check_layout();
    for (const SmoothedShape& smoothed : result_.shape.smoothed) check_set(smoothed);
    if (result_.shape.n_landmarks) check_yes_no("/job/scaling", "keeps_steps");
    return result_;
  }

  Structure run_trace()
  {
    result_.findings = reader_.refused();
    if (!is_format(trace_format_name)) return result_;
    const TraceShape shape{size_of("/searches/search"), size_of("/moves/move"), size_of("/contacts/contact"),
                           size_of("/job/input")};
    if (!result_.findings.empty()) return result_;
    result_.layout = trace_layout_of(shape);
    check_layout();
    return result_;
  }

 private:
  void check_layout()
  {
    for (const std::string& group : result_.layout.groups) {
      if (!reader_.is_group(group)) find(group, "nothing", "a group");
    }
    for (const DimensionSpec& dimension : result_.layout.dimensions) check_dimension(dimension);
    for (const DatasetSpec& spec : result_.layout.datasets) check_dataset(spec);
    for (const AttributeSpec& spec : result_.layout.attributes) check_attribute(spec);
    const std::uint64_t bytes = value_bytes(result_.layout, result_.shape);
    if (bytes <= largest_value_bytes) return;
    find("/", std::to_string(bytes) + " bytes of values", "at most " + std::to_string(largest_value_bytes));
  }

  void find(const std::string& where, const std::string& found, const std::string& wanted)
  {
    result_.findings.push_back({where, found, wanted});
  }

  /// The one text of an attribute, or an empty one.
  std::string text(const std::string& object, const std::string& name) const
  {
    const std::optional<AttributeValue> value = reader_.attribute(object, name);
    return value && value->texts.size() == 1 ? value->texts[0] : std::string();
  }

  /// Both formats are in their first major version. Keeps the minor one.
  bool is_format(const std::string& wanted)
  {
    const std::string format = text("/", "format");
    if (format != wanted) {
      find("/@format", format.empty() ? "nothing" : "\"" + format + "\"", "\"" + wanted + "\"");
      return false;
    }
    const std::string version = text("/", "format_version");
    const char* end = version.data() + version.size();
    if (version.rfind("1.", 0) == 0) {
      const std::from_chars_result parsed = std::from_chars(version.data() + 2, end, minor_version_);
      if (parsed.ec == std::errc() && parsed.ptr == end && minor_version_ >= 0) return true;
    }
    std::int32_t major_version = 0;
    const bool is_newer =
        std::from_chars(version.data(), end, major_version).ec == std::errc() && major_version > 1;
    find("/@format_version",
         version.empty() ? "nothing" : "\"" + version + "\"" + (is_newer ? ", a newer format" : ""),
         is_newer ? "\"1.\" and a minor version, which is what this program reads"
                  : "\"1.\" and a minor version");
    return false;
  }

  bool is_elsewhere(const std::string& path, const DatasetFacts& facts)
  {
    if (!facts.elsewhere.empty()) find(path, facts.elsewhere, readable);
    return !facts.elsewhere.empty();
  }

  /// The size of a dimension; a finding and 0 when there is none.
  std::int64_t size_of(const std::string& path)
  {
    if (!reader_.is_dataset(path)) {
      find(path, "nothing", "a dimension scale");
      return 0;
    }
    const DatasetFacts facts = reader_.facts(path);
    if (is_elsewhere(path, facts)) return 0;
    if (facts.scale_name.empty()) find(path, "no dimension scale", "a dimension scale");
    if (facts.shape.size() == 1 && facts.shape[0] >= 0 && facts.shape[0] <= largest_dimension)
      return facts.shape[0];
    find(path, "shape " + shape_text(facts.shape), "one axis of at most 2147483647 entries");
    return 0;
  }

  /// The same of an axis of a grid, where 0 is a finding.
  std::int64_t axis_size(const std::string& path)
  {
    const std::int64_t size = size_of(path);
    if (size == 0) find(path, "no values", "at least one");
    return size;
  }

  PartShape part_shape(const std::string& group)
  {
    return {size_of(group + "/vertex"), size_of(group + "/triangle"),
            reader_.objects().count(group + "/normals") > 0};
  }

  BodyShape body_shape(const std::string& group)
  {
    BodyShape shape;
    shape.n_components = size_of(group + "/member");
    shape.contact = part_shape(group);
    shape.has_visual = reader_.objects().count(group + "/visual") > 0;
    if (shape.has_visual) shape.visual = part_shape(group + "/visual");
    return shape;
  }

  void read_smoothed_shapes()
  {
    const std::string prefix = "/smoothed/degree_";
    for (const auto& [path, kind] : reader_.objects()) {
      if (path.rfind(prefix, 0) != 0 || path.find('/', prefix.size()) != std::string::npos) continue;
      SmoothedShape smoothed;
      const char* end = path.data() + path.size();
      const std::from_chars_result parsed =
          std::from_chars(path.data() + prefix.size(), end, smoothed.degree);
      if (parsed.ec != std::errc() || parsed.ptr != end || smoothed_group(smoothed.degree) != path) {
        find(path, "a name without a degree", "\"degree_\" and a whole number");
        continue;
      }
      smoothed.n_terms = size_of(path + "/term");
      if (result_.shape.minor_version >= 2) {
        smoothed.has_varus = reader_.objects().count(smoothed_path(smoothed.degree, "varus")) > 0;
        smoothed.has_recontact = reader_.objects().count(path + "/recontact") > 0;
      }
      result_.shape.smoothed.push_back(smoothed);
    }
    std::sort(result_.shape.smoothed.begin(), result_.shape.smoothed.end(),
              [](const SmoothedShape& a, const SmoothedShape& b) { return a.degree < b.degree; });
  }

  void read_audit_shapes()
  {
    const std::string prefix = audit_group("");
    for (const auto& [path, kind] : reader_.objects()) {
      if (path.rfind(prefix, 0) != 0 || path.find('/', prefix.size()) != std::string::npos) continue;
      const std::string name = path.substr(prefix.size());
      if (!is_audit_name(name)) {
        // Of a later minor version it may be a motion that we do not know.
        if (minor_version_ > result_.shape.minor_version) continue;
        find(path, "no name of a motion", "raw, zero_varus, degree_N or degree_N_recontacted");
        continue;
      }
      result_.shape.audits.push_back({name, axis_size(path + "/flexion"), axis_size(path + "/varus")});
    }
  }

  void read_mechanics_shape()
  {
    if (text("/", "method") == equilibrium) result_.shape.n_forces = size_of("/equilibrium/forces/force");
    if (reader_.objects().count("/ligaments") == 0) return;
    result_.shape.ligaments = {size_of("/ligaments/fibre"), size_of("/ligaments/wrapping")};
  }

  void read_shape()
  {
    FileShape& shape = result_.shape;
    // Of a later minor version we read what we know.
    shape.minor_version = std::min(minor_version_, shape.minor_version);
    shape.n_flexion = axis_size("/flexion");
    shape.n_varus = axis_size("/varus");
    const std::optional<AttributeValue> compartments = reader_.attribute("/", "has_compartments");
    if (!compartments || compartments->numbers.size() != 1) {
      find("/@has_compartments", "nothing", "one int8, 0 or 1");
    } else {
      shape.has_compartments = compartments->numbers[0] != 0;
    }
    shape.n_contacts = size_of("/contacts/contact");
    if (shape.minor_version >= 1) {
      read_mechanics_shape();
    } else if (text("/", "method") == equilibrium) {
      find("/@method", "\"equilibrium\"", "\"stability-search\", which is all that version 1.0 knew");
    }
    shape.reference = body_shape("/bodies/reference");
    shape.moving = body_shape("/bodies/moving");
    shape.n_inputs = size_of("/job/input");
    read_smoothed_shapes();
    if (shape.minor_version < 2) return;
    shape.has_zero_varus = reader_.objects().count("/zero_varus") > 0;
    read_audit_shapes();
    if (shape.minor_version >= 3 && reader_.objects().count("/job/scaling") > 0)
      shape.n_landmarks = size_of("/job/scaling/pair");
  }

  void check_dimension(const DimensionSpec& dimension)
  {
    const std::int64_t size = size_of(dimension.path);
    if (reader_.is_dataset(dimension.path) && size != dimension.size) {
      find(dimension.path, "size " + std::to_string(size), "size " + std::to_string(dimension.size));
    }
  }

  void check_dataset(const DatasetSpec& spec)
  {
    if (!reader_.is_dataset(spec.path)) {
      find(spec.path, reader_.is_group(spec.path) ? "a group" : "nothing", "a dataset: " + spec.long_name);
      return;
    }
    const DatasetFacts facts = reader_.facts(spec.path);
    if (is_elsewhere(spec.path, facts)) return;
    if (facts.kind != spec.kind) find(spec.path, kind_text(facts.kind), name_of(spec.kind));
    std::vector<std::int64_t> shape;
    for (const std::string& dimension : spec.dimensions) {
      shape.push_back(dimension_size(result_.layout, result_.shape, dimension));
    }
    if (facts.shape != shape) {
      find(spec.path, "shape " + shape_text(facts.shape), "shape " + shape_text(shape));
    } else if (!facts.storage_problem.empty()) {
      find(spec.path, facts.storage_problem, readable);
    } else {
      check_scales(spec, facts);
    }
    check_text_attribute(spec.path, "units", spec.units);
    if (spec.flags != FlagSet::none) check_flags(spec);
    if (spec.may_be_nan) check_fill_value(spec.path);
  }

  void check_scales(const DatasetSpec& spec, const DatasetFacts& facts)
  {
    if (spec.dimensions.size() == 1 && spec.dimensions[0] == spec.path) {
      const std::string name = spec.path.substr(spec.path.rfind('/') + 1);
      if (facts.scale_name != name)
        find(spec.path, "scale name \"" + facts.scale_name + "\"", "\"" + name + "\"");
      return;
    }
    for (std::size_t axis = 0; axis < spec.dimensions.size(); ++axis) {
      if (reader_.is_attached(spec.path, axis, spec.dimensions[axis])) continue;
      find(spec.path, "axis " + std::to_string(axis) + " without its scale",
           "dimension scale " + spec.dimensions[axis] + " attached");
    }
  }

  void check_text_attribute(const std::string& object, const std::string& name, const std::string& wanted)
  {
    if (wanted.empty()) return;
    const std::string found = text(object, name);
    if (found != wanted) {
      find(object + "@" + name, found.empty() ? "nothing" : "\"" + found + "\"", "\"" + wanted + "\"");
    }
  }

  void check_flags(const DatasetSpec& spec)
  {
    const FlagTable table = flag_table(spec.flags);
    check_text_attribute(spec.path, "flag_meanings", table.meanings);
    const std::optional<AttributeValue> found = reader_.attribute(spec.path, "flag_values");
    const std::vector<double> wanted(table.values.begin(), table.values.end());
    if (found && found->kind == ValueKind::int8 && found->numbers == wanted) return;
    find(spec.path + "@flag_values", found ? "other values" : "nothing",
         "the int8 codes of " + table.meanings);
  }

  void check_fill_value(const std::string& path)
  {
    const std::optional<AttributeValue> value = reader_.attribute(path, "_FillValue");
    if (value && value->kind == ValueKind::float64 && value->numbers.size() == 1 &&
        std::isnan(value->numbers[0])) {
      return;
    }
    find(path + "@_FillValue", value ? "another value" : "nothing", "one float64 NaN");
  }

  void check_attribute(const AttributeSpec& spec)
  {
    const std::string where = spec.object + "@" + spec.name;
    const std::string wanted = std::to_string(spec.size) + " of " + name_of(spec.kind);
    if (reader_.objects().count(spec.object) == 0) return;  // its absence is a finding already
    const std::optional<AttributeValue> value = reader_.attribute(spec.object, spec.name);
    if (!value) {
      find(where, "nothing", wanted);
    } else if (value->kind != spec.kind) {
      find(where, kind_text(value->kind), wanted);
    } else if (const std::size_t size = value->numbers.size() + value->texts.size();
               size != static_cast<std::size_t>(spec.size)) {
      find(where, std::to_string(size) + " of " + name_of(spec.kind), wanted);
    }
  }

  void check_set(const SmoothedShape& smoothed)
  {
    const std::string group = smoothed_group(smoothed.degree);
    if (!reader_.is_group(group)) return;  // a finding already
    const std::optional<AttributeValue> value = reader_.attribute(group, "degree");
    if (value && value->numbers.size() == 1 && value->numbers[0] != smoothed.degree)
      find(group + "@degree", "another degree", std::to_string(smoothed.degree));
    if (result_.shape.minor_version >= 2) check_yes_no(group, "is_robust");
  }

  void check_yes_no(const std::string& group, const std::string& name)
  {
    const std::optional<AttributeValue> value = reader_.attribute(group, name);
    if (!value || value->numbers.size() != 1) return;  // a finding already
    if (value->numbers[0] != 0.0 && value->numbers[0] != 1.0)
      find(group + "@" + name, "another value", "0 or 1");
  }

  const H5Reader& reader_;
  std::int32_t minor_version_ = 0;
  Structure result_;
};

}  // namespace

Structure structure_of(const H5Reader& reader)
{
  return StructureCheck(reader).run();
}

Structure trace_structure_of(const H5Reader& reader)
{
  return StructureCheck(reader).run_trace();
}

}  // namespace vrda
