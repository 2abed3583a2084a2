/// The append-only journals of a range of motion, from which a killed run resumes and shards are joined:
/// frames of journal/framed_file.hpp, one per line.
#pragma once

#include <map>
#include <optional>
#include <string>
#include <utility>

#include "core/framed_file.hpp"
#include "analysis/range_of_motion.hpp"

namespace vrda::analysis {

/// By axis and rows of the other axes.
using RomLines = std::map<std::pair<std::int8_t, std::array<std::int32_t, 3>>, RomLine>;

/// SHA-256 of what determines the cells: the job, its inputs, the solver, rotations and limits.
std::string rom_key(const job::Case& job_case, const RomPlan& plan);

/// Adds the lines of a journal. Throws InputError if it cannot be read or has another key.
void read_lines(const std::string& path, const std::string& key, RomLines& lines);

/// Resumes the journal at `path`, adding its lines, or starts one; with `is_fresh` always starts one. Throws
/// InputError if it has another key or is being written.
core::FrameWriter open_lines(const std::string& path, const std::string& key, bool is_fresh,
                                RomLines& lines);

std::string line_bytes(const RomLine& line);
std::optional<RomLine> line_of(std::string_view bytes);

}  // namespace vrda::analysis
