#include "store/journal.hpp"

#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <charconv>
#include <cmath>
#include <filesystem>
#include <optional>
#include <system_error>
#include <tuple>
#include <utility>

#include "core/text.hpp"

namespace vrda::store {
namespace {

/// A record of a hundred contacts takes 7 kB; a length above 16 MiB means a damaged frame.
constexpr FrameFormat step_format{"VRDAJRNL", 2, std::uint32_t{1} << 24, "record"};

}  // namespace

JournalContent parse_journal(const std::string& path, std::string_view bytes)
{
  JournalContent content;
  FrameFileSummary facts = parse_frames(path, bytes, step_format, [&](std::string_view frame) -> std::string {
    std::optional<StepRecord> record = record_of(frame);
    if (!record) return "a record that is not a motion step";
    content.records.push_back(std::move(*record));
    return {};
  });
  content.key = std::move(facts.key);
  content.valid_bytes = facts.valid_bytes;
  content.dropped_bytes = facts.dropped_bytes;
  content.dropped_reason = std::move(facts.dropped_reason);
  return content;
}

JournalContent read_journal(const std::string& path)
{
  return parse_journal(path, read_frame_file(path));
}

FrameTail journal_tail(const std::string& path)
{
  return FrameTail(path, step_format);
}

void require_key(const std::string& found, const std::string& path, const std::string& wanted)
{
  if (found == wanted) return;
  throw InputError({path, "key", "the journal of another job (" + found + ")",
                    wanted + ", or " + start_over_remedy + ", or another output"});
}

JournalWriter JournalWriter::create(const std::string& path, const std::string& key)
{
  return JournalWriter(FrameWriter::create(path, key, step_format));
}

std::optional<OpenJournal> JournalWriter::try_open(const std::string& path, const std::string& key)
{
  if (access(path.c_str(), F_OK) != 0) {
    std::optional<FrameWriter> created = FrameWriter::try_create(path, key, step_format);
    if (!created) return std::nullopt;
    return OpenJournal{JournalWriter(std::move(*created)), {key, {}, 0, 0, {}}};
  }
  std::optional<FrameWriter> locked = FrameWriter::try_lock(path, step_format);
  const std::optional<std::string> bytes = read_frame_file_if_present(path);
  if (!bytes) return std::nullopt;  // its writer has just finished the model and removed it
  // The lock excludes other writers; a journal of another job is an error even while it is being written.
  JournalContent content = parse_journal(path, *bytes);
  require_key(content.key, path, key);
  if (!locked) return std::nullopt;
  locked->cut(content.valid_bytes);
  return OpenJournal{JournalWriter(std::move(*locked)), std::move(content)};
}

OpenJournal JournalWriter::open(const std::string& path, const std::string& key)
{
  std::optional<OpenJournal> opened = try_open(path, key);
  if (opened) return std::move(*opened);
  refuse_locked(path);
}

void JournalWriter::append(const StepRecord& record)
{
  file_.append(bytes_of(record));
}

namespace {

// Upper bound of valid coordinates (mm, rad), as in motion models.
constexpr double largest_pose_number = 1e9;

// Contacts and contact forces have the same layout: point, normal, one measure, triangles, compartment.
template <typename Touch>
void append_touch(std::string& bytes, const Touch& touch, double measure)
{
  append_vector(bytes, touch.point_solver_mm);
  append_vector(bytes, touch.normal_solver);
  append_double(bytes, measure);
  append_i32(bytes, touch.triangle_reference);
  append_i32(bytes, touch.triangle_moving);
  append_i8(bytes, touch.compartment);
}

template <typename Touch>
Touch take_touch(ByteReader& cursor, double Touch::*measure)
{
  Touch touch;
  touch.point_solver_mm = cursor.take_vector();
  touch.normal_solver = cursor.take_vector();
  touch.*measure = cursor.take_double();
  touch.triangle_reference = cursor.take_i32();
  touch.triangle_moving = cursor.take_i32();
  touch.compartment = cursor.take_i8();
  return touch;
}

}  // namespace

void append_key(std::string& bytes, const StepKey& key)
{
  bytes.push_back(static_cast<char>(key.kind));
  append_i32(bytes, key.flexion);
  append_i32(bytes, key.varus);
}

void append_pose(std::string& bytes, const MovingPose& pose)
{
  append_vector(bytes, pose.translation_mm);
  append_double(bytes, pose.theta_rad);
}

void append_contact(std::string& bytes, const ContactRecord& contact)
{
  append_touch(bytes, contact, contact.distance_mm);
}

StepKey take_key(ByteReader& cursor)
{
  StepKey key;
  const std::uint64_t kind = cursor.take(1);
  if (kind > static_cast<std::uint64_t>(last_step_kind)) cursor.mark_invalid();
  key.kind = static_cast<StepKind>(kind);
  key.flexion = cursor.take_i32();
  key.varus = cursor.take_i32();
  return key;
}

MovingPose take_pose(ByteReader& cursor)
{
  MovingPose pose;
  pose.translation_mm = cursor.take_vector();
  pose.theta_rad = cursor.take_double();
  // NaN is allowed: no pose was found.
  if ((pose.translation_mm.array().abs() > largest_pose_number).any() ||
      std::abs(pose.theta_rad) > largest_pose_number)
    cursor.mark_invalid();
  return pose;
}

StepStatus take_status(ByteReader& cursor)
{
  const auto status = static_cast<StepStatus>(cursor.take_i8());
  const bool is_known = std::find(std::begin(all_step_statuses), std::end(all_step_statuses), status) !=
                        std::end(all_step_statuses);
  if (!is_known) cursor.mark_invalid();
  return status;
}

ContactRecord take_contact(ByteReader& cursor)
{
  return take_touch(cursor, &ContactRecord::distance_mm);
}

namespace {

void append_balance(std::string& bytes, const Balance& balance)
{
  for (const double value : {balance.energy_nmm, balance.residual_n, balance.complementarity_mm,
                             balance.worst_gap_mm, balance.flexion_moment_nmm, balance.varus_moment_nmm}) {
    append_double(bytes, value);
  }
  append_u32(bytes, static_cast<std::uint32_t>(balance.forces.size()));
  for (const ContactForce& force : balance.forces) append_touch(bytes, force, force.along_delta_n);
}

Balance take_balance(ByteReader& cursor)
{
  Balance balance;
  for (double* value : {&balance.energy_nmm, &balance.residual_n, &balance.complementarity_mm,
                        &balance.worst_gap_mm, &balance.flexion_moment_nmm, &balance.varus_moment_nmm}) {
    *value = cursor.take_double();
  }
  const std::uint64_t n_forces = cursor.take(4);
  // Checked before allocation; a force has as many bytes as a contact.
  if (n_forces > cursor.n_bytes_left() / contact_bytes) cursor.mark_invalid();
  for (std::uint64_t i = 0; cursor.is_valid() && i < n_forces; ++i)
    balance.forces.push_back(take_touch(cursor, &ContactForce::along_delta_n));
  return balance;
}

void append_coordinates(std::string& bytes, const StepRecord& record)
{
  bytes.push_back(record.coordinates ? 1 : 0);
  if (!record.coordinates) return;
  append_double(bytes, record.flexion_rad);
  for (const double force : record.coordinates->holding) append_double(bytes, force);
  for (const std::int8_t determined : record.coordinates->determined) append_i8(bytes, determined);
}

void take_coordinates(ByteReader& cursor, StepRecord& record)
{
  if (!cursor.take_bool()) return;
  record.coordinates.emplace();
  record.flexion_rad = cursor.take_double();
  if (!(std::abs(record.flexion_rad) <= largest_pose_number)) cursor.mark_invalid();
  for (double& force : record.coordinates->holding) force = cursor.take_double();
  for (std::int8_t& determined : record.coordinates->determined) {
    determined = cursor.take_i8();
    if (determined < -1 || determined > 1) cursor.mark_invalid();
  }
}

}  // namespace

std::string bytes_of(const StepRecord& record)
{
  std::string bytes;
  append_key(bytes, record.key);
  append_pose(bytes, record.pose);
  append_i8(bytes, static_cast<std::int8_t>(record.status));
  append_i32(bytes, record.iterations);
  append_i32(bytes, record.queries);
  append_double(bytes, record.residual_mm);
  append_double(bytes, record.gap_medial_mm);
  append_double(bytes, record.gap_lateral_mm);
  for (const bool flag : {record.contact_medial, record.contact_lateral, record.theta_determined}) {
    bytes.push_back(flag ? 1 : 0);
  }
  append_double(bytes, record.varus_rad);
  append_balance(bytes, record.balance);
  append_coordinates(bytes, record);
  append_u32(bytes, static_cast<std::uint32_t>(record.contacts.size()));
  for (const ContactRecord& contact : record.contacts) append_contact(bytes, contact);
  return bytes;
}

std::optional<StepRecord> record_of(std::string_view bytes)
{
  ByteReader cursor(bytes);
  StepRecord record;
  record.key = take_key(cursor);
  record.pose = take_pose(cursor);
  record.status = take_status(cursor);
  record.iterations = cursor.take_i32();
  record.queries = cursor.take_i32();
  record.residual_mm = cursor.take_double();
  record.gap_medial_mm = cursor.take_double();
  record.gap_lateral_mm = cursor.take_double();
  record.contact_medial = cursor.take_bool();
  record.contact_lateral = cursor.take_bool();
  record.theta_determined = cursor.take_bool();
  record.varus_rad = cursor.take_double();
  if (record.status == StepStatus::stable &&
      !(record.pose.translation_mm.allFinite() && std::isfinite(record.pose.theta_rad) &&
        std::abs(record.varus_rad) <= largest_pose_number))
    cursor.mark_invalid();
  record.balance = take_balance(cursor);
  take_coordinates(cursor, record);
  const std::uint64_t n_contacts = cursor.take(4);
  if (!cursor.is_valid() || cursor.n_bytes_left() != n_contacts * contact_bytes) return std::nullopt;
  for (std::uint64_t i = 0; i < n_contacts; ++i) record.contacts.push_back(take_contact(cursor));
  return record;
}

namespace {

namespace fs = std::filesystem;

constexpr std::string_view start_ending = ".start.h5";
constexpr std::string_view spine_ending = ".spine.journal";
constexpr std::string_view journal_ending = ".journal";
constexpr std::string_view shard_mark = ".shard-";
constexpr std::string_view between = "-of-";

std::optional<std::int32_t> count_in(std::string_view text)
{
  std::int32_t value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  const bool is_whole = error == std::errc() && end == text.data() + text.size();
  return is_whole && value > 0 && text.front() != '0' ? std::optional(value) : std::nullopt;
}

struct JournalName {
  std::string output;
  Shard shard;
};

std::optional<JournalName> shard_journal_name(std::string_view journal)
{
  if (!journal.ends_with(journal_ending)) return std::nullopt;
  const std::string_view stem = journal.substr(0, journal.size() - journal_ending.size());
  const std::size_t mark = stem.rfind(shard_mark);
  if (mark == std::string_view::npos) return std::nullopt;
  const auto shard = parse_shard(stem.substr(mark + shard_mark.size()), between);
  if (!shard) return std::nullopt;
  return JournalName{std::string(stem.substr(0, mark)), *shard};
}

struct Listing {
  std::vector<std::string> paths;
  std::error_code error;
};

Listing shard_journals_listed(const std::string& output)
{
  const fs::path folder = fs::path(output).has_parent_path() ? fs::path(output).parent_path() : ".";
  std::vector<std::tuple<std::int32_t, std::int32_t, std::string>> found;
  Listing listing;
  for (fs::directory_iterator it(folder, listing.error), end; !listing.error && it != end;
       it.increment(listing.error)) {
    const std::string path = (fs::path(output).parent_path() / it->path().filename()).string();
    const auto name = shard_journal_name(path);
    if (name && name->output == output) found.emplace_back(name->shard.count, name->shard.number, path);
  }
  std::sort(found.begin(), found.end());
  for (const auto& [count, number, path] : found) listing.paths.push_back(path);
  return listing;
}

}  // namespace

std::string journal_of(const std::string& output)
{
  return output + std::string(journal_ending);
}

std::string trace_journal_of(const std::string& output)
{
  return output + ".trace" + std::string(journal_ending);
}

std::string start_file_of(const std::string& output)
{
  return output + std::string(start_ending);
}

std::string output_of_start_file(const std::string& start_file)
{
  const bool is_one = start_file.size() > start_ending.size() && start_file.ends_with(start_ending);
  return is_one ? start_file.substr(0, start_file.size() - start_ending.size()) : std::string();
}

std::optional<Shard> parse_shard(std::string_view text, std::string_view separator)
{
  const std::size_t at = text.find(separator);
  if (at == std::string_view::npos) return std::nullopt;
  const auto number = count_in(text.substr(0, at));
  const auto count = count_in(text.substr(at + separator.size()));
  if (!number || !count || *number > *count) return std::nullopt;
  return Shard{*number, *count};
}

std::string spine_journal_of(const std::string& output)
{
  return output + std::string(spine_ending);
}

std::string shard_journal_of(const std::string& output, const Shard& shard)
{
  return output + std::string(shard_mark) + std::to_string(shard.number) + std::string(between) +
         std::to_string(shard.count) + std::string(journal_ending);
}

std::optional<Shard> shard_of_journal(const std::string& journal)
{
  const auto name = shard_journal_name(journal);
  return name ? std::optional(name->shard) : std::nullopt;
}

std::string output_of_journal(const std::string& journal)
{
  if (journal.ends_with(spine_ending)) return journal.substr(0, journal.size() - spine_ending.size());
  const auto name = shard_journal_name(journal);
  return name ? name->output : std::string();
}

std::vector<std::string> list_shard_journals(const std::string& output)
{
  const Listing listing = shard_journals_listed(output);
  if (!listing.error) return listing.paths;
  const fs::path folder = fs::path(output).has_parent_path() ? fs::path(output).parent_path() : ".";
  throw InputError({folder.string(), "", listing.error.message(), "a folder that can be read"});
}

std::vector<std::string> list_shard_journals_if_readable(const std::string& output)
{
  return shard_journals_listed(output).paths;
}

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
