#include "store/trace_journal.hpp"

#include <utility>

#include "store/record_bytes.hpp"

namespace vrda::store {
namespace {

/// A move with twenty contacts takes 1.4 kB; a search of a few thousand moves takes megabytes.
constexpr FrameFormat format{"VRDATRCJ", 1, std::uint32_t{1} << 31, "trace"};

constexpr std::size_t move_bytes = 4 + 1 + 4 * 8 + 2 * 8 + 3 + 4;  ///< without contacts

SearchMove take_move(ByteReader& cursor)
{
  SearchMove move;
  move.iteration = cursor.take_i32();
  const std::uint64_t kind = cursor.take(1);
  if (kind >= std::size(all_move_kinds)) cursor.mark_invalid();
  move.kind = static_cast<MoveKind>(kind);
  move.pose = take_pose(cursor);
  move.translation_step_mm = cursor.take_double();
  move.rotation_step_rad = cursor.take_double();
  move.collides = cursor.take_bool();
  move.is_cycle = cursor.take_bool();
  move.in_contact = cursor.take_bool();
  const std::uint64_t n_contacts = cursor.take(4);
  if (n_contacts > cursor.n_bytes_left() / contact_bytes) cursor.mark_invalid();
  for (std::uint64_t i = 0; i < n_contacts && cursor.is_valid(); ++i) {
    move.contacts.push_back(take_contact(cursor));
  }
  return move;
}

}  // namespace

std::string bytes_of(const SearchTrace& trace)
{
  std::string bytes;
  append_key(bytes, trace.key);
  append_pose(bytes, trace.seed);
  append_i8(bytes, static_cast<std::int8_t>(trace.status));
  append_u32(bytes, static_cast<std::uint32_t>(trace.moves.size()));
  for (const SearchMove& move : trace.moves) {
    append_i32(bytes, move.iteration);
    append_i8(bytes, static_cast<std::int8_t>(move.kind));
    append_pose(bytes, move.pose);
    append_double(bytes, move.translation_step_mm);
    append_double(bytes, move.rotation_step_rad);
    for (const bool flag : {move.collides, move.is_cycle, move.in_contact}) append_i8(bytes, flag ? 1 : 0);
    append_u32(bytes, static_cast<std::uint32_t>(move.contacts.size()));
    for (const ContactRecord& contact : move.contacts) append_contact(bytes, contact);
  }
  return bytes;
}

std::optional<SearchTrace> trace_of(std::string_view bytes)
{
  ByteReader cursor(bytes);
  SearchTrace trace;
  trace.key = take_key(cursor);
  if (trace.key.kind > StepKind::row) cursor.mark_invalid();  // steps of these kinds have no search
  trace.seed = take_pose(cursor);
  trace.status = take_status(cursor);
  const std::uint64_t n_moves = cursor.take(4);
  if (n_moves > cursor.n_bytes_left() / move_bytes) cursor.mark_invalid();
  for (std::uint64_t i = 0; i < n_moves && cursor.is_valid(); ++i) trace.moves.push_back(take_move(cursor));
  if (!cursor.is_valid() || cursor.n_bytes_left() != 0) return std::nullopt;
  return trace;
}

TraceJournalContent parse_trace_journal(const std::string& path, std::string_view bytes)
{
  TraceJournalContent content;
  content.summary = parse_frames(path, bytes, format, [&](std::string_view frame) -> std::string {
    std::optional<SearchTrace> trace = trace_of(frame);
    if (!trace) return "a trace that is not a search";
    const StepKey key = trace->key;
    content.searches.insert_or_assign(key, std::move(*trace));
    return {};
  });
  return content;
}

TraceJournalContent read_trace_journal(const std::string& path)
{
  return parse_trace_journal(path, read_frame_file(path));
}

FrameTail trace_journal_tail(const std::string& path)
{
  return FrameTail(path, format);
}

FrameWriter create_trace_journal(const std::string& path, const std::string& key)
{
  return FrameWriter::create(path, key, format);
}

FrameWriter resume_trace_journal(const std::string& path, const FrameFileSummary& facts)
{
  return FrameWriter::resume(path, facts.valid_bytes, format);
}

}  // namespace vrda::store
