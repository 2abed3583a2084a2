/// The layout of a motion-model file as a table: schemas/motion-model.md in the form that the writer, the
/// reader and the validation share.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace vrda {

inline constexpr const char* format_name = "vrda motion model";
inline constexpr const char* format_version = "1.4";
/// CF 1.9 is the first to allow 64-bit integers (row_start).
inline constexpr const char* conventions = "CF-1.9";

enum class ValueKind { float64, float32, int64, int32, int8, text };
const char* name_of(ValueKind kind);

/// Which codes an int8 dataset holds; written as CF flag_values and flag_meanings.
enum class FlagSet {
  none,
  status,
  solver_status,  ///< without `overlapping`: of the free spine, and of motion models of versions 1.1 to 1.3
  search_status,  ///< without `unbounded` too: of a trace's searches, and of motion models of version 1.0
  plausibility,
  answer,
  yes_no,
  compartment,
  move_kind,
  node,
  wrap_shape,
  body,
  audit_state,
  zero_varus_source,
  case_status,  ///< of an index: schemas/campaign.md
};

struct FlagTable {
  std::vector<std::int8_t> values;
  std::string meanings;  ///< one word a value, in order, separated by blanks
};
FlagTable flag_table(FlagSet set);

struct DatasetSpec {
  std::string path;  ///< "/bodies/reference/vertices"
  ValueKind kind = ValueKind::float64;
  std::vector<std::string> dimensions;  ///< paths of the scales, slowest first; empty: one value
  std::string units;                    ///< empty: none
  std::string long_name;
  bool may_be_nan = false;  ///< carries a NaN `_FillValue`
  FlagSet flags = FlagSet::none;
};

/// A dimension without a coordinate variable.
struct DimensionSpec {
  std::string path;
  std::int64_t size = 0;
};

struct AttributeSpec {
  std::string object;
  std::string name;
  ValueKind kind = ValueKind::text;
  std::int64_t size = 1;
};

struct PartShape {
  std::int64_t n_vertices = 0;
  std::int64_t n_triangles = 0;
  bool has_normals = false;
};

struct BodyShape {
  std::int64_t n_components = 0;
  PartShape contact;
  bool has_visual = false;
  PartShape visual;
};

struct SmoothedShape {
  std::int32_t degree = 0;
  std::int64_t n_terms = 0;
  bool has_varus = false;      ///< a fifth surface
  bool has_recontact = false;  ///< travel into contact
};

struct AuditShape {
  std::string name;
  std::int64_t n_flexion = 0;
  std::int64_t n_varus = 0;
};

struct LigamentShape {
  std::int64_t n_fibres = 0;
  std::int64_t n_wraps = 0;
};

/// Everything that a layout depends on.
struct FileShape {
  /// Of format_version. 0 knows no push, contact paths, equilibrium, ligaments or solved varus; 1 neither
  /// zero-varus motion, audits nor more than the polynomials of tx, ty, tz and theta of a smoothed set; 2 no
  /// scaling; 3 neither `plausibility` nor the status `overlapping`.
  std::int32_t minor_version = 4;
  std::int64_t n_flexion = 0;
  std::int64_t n_varus = 0;
  bool has_compartments = false;
  std::int64_t n_contacts = 0;
  std::optional<std::int64_t> n_forces;    ///< of method "equilibrium" only
  std::optional<LigamentShape> ligaments;  ///< where the job has fibres
  BodyShape reference;
  BodyShape moving;
  std::vector<SmoothedShape> smoothed;  ///< by increasing degree
  bool has_zero_varus = false;
  std::vector<AuditShape> audits;  ///< by name
  std::int64_t n_inputs = 0;
  std::optional<std::int64_t> n_landmarks;  ///< pairs, where the job scales
};

/// In the order in which the file is written: parents before children, scales before their users.
struct FileLayout {
  std::vector<std::string> groups;
  std::vector<DimensionSpec> dimensions;
  std::vector<DatasetSpec> datasets;
  std::vector<AttributeSpec> attributes;
};

FileLayout layout_of(const FileShape& shape);

/// The size of dimension `path`; the axes count as dimensions too.
std::int64_t dimension_size(const FileLayout& layout, const FileShape& shape, const std::string& path);

/// The most that the values of a file may take in memory: a hundred times a large model.
inline constexpr std::uint64_t largest_value_bytes = std::uint64_t{512} << 20;

/// What the values take, a text counted as its length of 4 bytes; 2^64 - 1 where that is too large a number.
std::uint64_t value_bytes(const FileLayout& layout, const FileShape& shape);

}  // namespace vrda
