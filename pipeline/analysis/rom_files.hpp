/// Files of a range of motion (schemas/range-of-motion.md): the document, tables and a page.
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

/// A self-contained HTML page: limits, volume, a map of each slice, boundaries.
std::string rom_page(const RomDocument& document);

/// The maps of the page as an 8-bit RGB PNG, byte-identical for equal documents.
std::string rom_picture(const RomDocument& document);

/// Cells and volumes of two ranges over the same rotations.
struct RomComparison {
  RomVolume a, b, both, only_a, only_b;
};
/// Throws InputError naming `file_b` if the rotations differ.
RomComparison compare_ranges(const RangeOfMotion& a, const RangeOfMotion& b, const std::string& file_b);

/// Of two ranges over the same rotations: one row per attitude with the status of each; the maps of both as a
/// page and as a picture.
std::string comparison_csv(const RomDocument& a, const RomDocument& b);
std::string comparison_page(const RomDocument& a, const RomDocument& b);
std::string comparison_picture(const RomDocument& a, const RomDocument& b);

// The append-only journals of a range of motion, from which a killed run resumes and shards are joined:
// frames of journal/framed_file.hpp, one per line.

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
