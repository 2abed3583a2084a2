#include "analysis/rom_journal.hpp"

#include <cmath>
#include <filesystem>

#include "core/error.hpp"
#include "core/text.hpp"
#include "core/little_endian.hpp"
#include "job/input_file.hpp"
#include "solve/case_solver.hpp"

namespace vrda::analysis {
namespace {

constexpr core::FrameFormat line_format{"VRDAROMJ", 2, std::uint32_t{1} << 28, "line"};
// Must be changed when the same job may give other cells.
constexpr const char* rom_solver = "highest seat 1";

void append_cell(std::string& bytes, const SolvedCell& solved)
{
  const RomCell& cell = solved.cell;
  core::append_i8(bytes, static_cast<std::int8_t>(cell.status));
  core::append_vector(bytes, cell.translation_mm);
  core::append_double(bytes, cell.opening_mm);
  core::append_double(bytes, cell.largest_strain);
  core::append_i32(bytes, cell.fibre);
  core::append_i32(bytes, cell.component_reference);
  core::append_i32(bytes, cell.component_moving);
  core::append_double(bytes, solved.across_mm.x());
  core::append_double(bytes, solved.across_mm.y());
}

SolvedCell take_cell(core::ByteReader& reader)
{
  SolvedCell solved;
  const std::int8_t status = reader.take_i8();
  if (status < 0 || status >= static_cast<std::int8_t>(std::size(all_rom_statuses))) reader.mark_invalid();
  solved.cell.status = static_cast<RomStatus>(status);
  solved.cell.translation_mm = reader.take_vector();
  solved.cell.opening_mm = reader.take_double();
  solved.cell.largest_strain = reader.take_double();
  solved.cell.fibre = reader.take_i32();
  solved.cell.component_reference = reader.take_i32();
  solved.cell.component_moving = reader.take_i32();
  solved.across_mm.x() = reader.take_double();
  solved.across_mm.y() = reader.take_double();
  return solved;
}

/// The valid part of a journal.
core::FrameFileSummary parse_lines(const std::string& path, const std::string& key, RomLines& lines)
{
  const auto take = [&](std::string_view frame) -> std::string {
    std::optional<RomLine> line = line_of(frame);
    if (!line) return "a frame that is not a line of cells";
    const std::pair at{line->axis, line->at};
    lines.insert_or_assign(at, std::move(*line));
    return {};
  };
  const core::FrameFileSummary summary =
      core::parse_frames(path, core::read_frame_file(path), line_format, take);
  if (summary.key != key)
    throw InputError({path, "key", "the journal of another job, other rotations or other limits",
                      "--fresh, or another --output"});
  return summary;
}

}  // namespace

std::string rom_key(const job::Case& job_case, const RomPlan& plan)
{
  std::string text = std::string(rom_solver) + '\n' + solve::fingerprint_of(job_case);
  for (const std::vector<double>& axis : plan.axes.rad) {
    text += '\n';
    for (const double rad : axis) text += shortest_decimal(rad) + ' ';
  }
  for (const double limit : {plan.limits.translation_mm, plan.limits.opening_mm, plan.limits.strain})
    text += '\n' + (std::isfinite(limit) ? shortest_decimal(limit) : "free");
  return job::sha256_of(text + '\n' + std::to_string(static_cast<int>(plan.delta_body)));
}

void read_lines(const std::string& path, const std::string& key, RomLines& lines)
{
  parse_lines(path, key, lines);
}

core::FrameWriter open_lines(const std::string& path, const std::string& key, bool is_fresh,
                                RomLines& lines)
{
  std::error_code error;
  if (is_fresh || !std::filesystem::exists(path, error))
    return core::FrameWriter::create(path, key, line_format);
  std::optional<core::FrameWriter> writer = core::FrameWriter::try_lock(path, line_format);
  const core::FrameFileSummary summary = parse_lines(path, key, lines);
  if (!writer) core::refuse_locked(path);
  writer->cut(summary.valid_bytes);
  return std::move(*writer);
}

std::string line_bytes(const RomLine& line)
{
  std::string bytes;
  core::append_i8(bytes, line.axis);
  for (const std::int32_t row : line.at) core::append_i32(bytes, row);
  core::append_i32(bytes, static_cast<std::int32_t>(line.cells.size()));
  for (const SolvedCell& cell : line.cells) append_cell(bytes, cell);
  return bytes;
}

std::optional<RomLine> line_of(std::string_view bytes)
{
  core::ByteReader reader(bytes);
  RomLine line;
  line.axis = reader.take_i8();
  for (std::int32_t& row : line.at) row = reader.take_i32();
  const std::int32_t n = reader.take_i32();
  for (std::int32_t k = 0; k < n && reader.is_valid(); ++k) line.cells.push_back(take_cell(reader));
  const bool is_whole = reader.is_valid() && reader.n_bytes_left() == 0 && line.axis >= 0 && line.axis < 3;
  if (!is_whole) return std::nullopt;
  return line;
}

}  // namespace vrda::analysis
