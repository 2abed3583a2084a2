/// Index of a campaign: a table with one row per case and one column per property, and its HDF5 file
/// (schemas/campaign.md).
#pragma once

#include <cstdint>
#include <string>
#include <variant>
#include <vector>

#include "store/dataset.hpp"

namespace vrda::store {

struct IndexColumn {
  std::string name;       ///< letters, digits and '_'
  std::string units;      ///< of numbers: "mm", "degree", "N", "1"; else empty
  std::string long_name;  ///< description for users
  /// [n_rows] texts, numbers (NaN: no value) or codes of `flags`.
  std::variant<std::vector<std::string>, std::vector<double>, std::vector<std::int8_t>> values;
  FlagSet flags = FlagSet::none;
};

struct IndexTable {
  std::string title;
  std::vector<IndexColumn> columns;  ///< the first one is text: the name of each row, unique
};

inline constexpr const char* index_format_name = "vrda campaign index";
inline constexpr const char* index_format_version = "1.0";

/// `table` as a netCDF-4 file whose one dimension is the first column. Equal tables give equal bytes. `path`:
/// its future name, for errors.
std::string index_bytes(const std::string& path, const IndexTable& table);

/// The table as CSV (RFC 4180): a heading, then one line per row; codes as words, NaN as an empty field.
std::string index_csv(const IndexTable& table);

}  // namespace vrda::store
