/// Files of a range of motion (schemas/range-of-motion.md): the document, tables and maps.
#pragma once

#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "analysis/range_of_motion.hpp"
#include "core/framed_file.hpp"

namespace vrda::analysis {

struct RomDocument {
  std::string program;                                     ///< that wrote it
  std::string title, joint, side, job;                     ///< of the job; its kind, its resolved text
  std::vector<job::LoadedInput> inputs;                    ///< names and hashes
  std::vector<std::string> reference_names, moving_names;  ///< of the components
  std::vector<std::string> fibre_names;
  RangeOfMotion range;
};

RomDocument rom_document(const job::Case& job_case, const RangeOfMotion& range, const std::string& program);

/// Text of rom.json. Angles in degrees, lengths in mm; every number reads back exactly.
std::string rom_json(const RomDocument& document);

/// Parses the text of a rom.json. Throws InputError naming `file` and the key.
RomDocument parse_rom(const std::string& file, const std::string& text);

/// One row per attitude.
std::string rom_csv(const RomDocument& document);

/// The ends of the range along each driven rotation, for every combination of the other two: the run of
/// cells in range through the neutral value, and what is beyond. Empty where the neutral value is not in
/// range.
struct RangeEnd {
  double deg = 0.0;
  bool is_of_axis = false;  ///< the end of the driven values: nothing was tried beyond
  RomStatus beyond = RomStatus::in_range;
  std::int32_t component_reference = -1, component_moving = -1, fibre = -1;  ///< of the cell beyond
};
/// "contact: acetabulum on head", "fibre: ACLam", "end of the driven values".
std::string cause_of(const RomDocument& document, const RangeEnd& end);
struct RangeAlong {
  std::size_t axis = 0;
  std::array<std::size_t, 3> at{};  ///< row of each rotation; of `axis` the neutral one
  bool is_empty = true;
  RangeEnd low, high;
};
std::vector<RangeAlong> boundaries_of(const RangeOfMotion& range);

/// boundaries_of() as a table.
std::string boundary_csv(const RomDocument& document);

/// Maps of the attitudes as data of a picture or page: one map per slice, a cell per attitude.
struct RomMaps {
  /// Degrees: from (x, y) to (x, y).
  using Line = std::array<double, 4>;
  static constexpr const char* outline_colour = "#101418";

  std::string title;
  std::array<std::string, 3> titles;            ///< of abscissa, ordinate and slices: driven rotations first
  std::vector<double> x_deg, y_deg, slice_deg;  ///< values of the three
  /// One more than values: half way between neighbours.
  std::vector<double> x_edges_deg, y_edges_deg;
  std::vector<std::pair<std::string, std::string>> legend;   ///< colour "#rrggbb" and meaning
  std::vector<std::vector<std::vector<std::size_t>>> cells;  ///< [slice, x, y] row of the legend
  std::vector<std::vector<Line>> outlines;                   ///< [slice]
};
/// The status of each cell, and the boundary of the range that is connected with the neutral attitude.
RomMaps status_maps(const RomDocument& document);
/// Which cells are in range of both, of one, of neither.
RomMaps comparison_maps(const RomDocument& a, const RomDocument& b);

/// The maps as an 8-bit RGB PNG, byte-identical for equal maps.
std::string maps_picture(const RomMaps& maps);

/// Cells and volumes of two ranges over the same rotations.
struct RomComparison {
  RomVolume a, b, both, only_a, only_b;
};
/// Throws InputError naming `file_b` if the rotations differ.
RomComparison compare_ranges(const RangeOfMotion& a, const RangeOfMotion& b, const std::string& file_b);

/// Of two ranges over the same rotations: one row per attitude with the status of each.
std::string comparison_csv(const RomDocument& a, const RomDocument& b);

// The append-only journals of a range of motion, from which a killed run resumes and shards are joined:
// frames of core/framed_file.hpp, one per line.

/// By axis and rows of the other axes.
using RomLines = std::map<std::pair<std::int8_t, std::array<std::int32_t, 3>>, RomLine>;

/// SHA-256 of what determines the cells: the job, its inputs, the solver, rotations and limits.
std::string rom_key(const job::Case& job_case, const RomPlan& plan);

/// Adds the lines of a journal. Throws InputError if it cannot be read or has another key.
void read_lines(const std::string& path, const std::string& key, RomLines& lines);

/// Resumes the journal at `path`, adding its lines, or starts one; with `is_fresh` always starts one. Throws
/// InputError if it has another key or is being written.
core::FrameWriter open_lines(const std::string& path, const std::string& key, bool is_fresh, RomLines& lines);

}  // namespace vrda::analysis
