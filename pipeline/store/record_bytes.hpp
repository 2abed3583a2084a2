/// Byte layout of one journal record: little-endian, mm and rad, frame S. Bytes that are not a valid record
/// give an empty value; the journal's checksum is checked elsewhere.
#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "model/step_record.hpp"
#include "core/little_endian.hpp"

namespace vrda::store {

std::string bytes_of(const StepRecord& record);

/// The inverse of bytes_of; empty if the bytes are not a valid record.
std::optional<StepRecord> record_of(std::string_view bytes);

// Parts, shared with the journal of traces.

inline constexpr std::size_t contact_bytes = 7 * 8 + 2 * 4 + 1;

void append_key(std::string& bytes, const StepKey& key);
void append_pose(std::string& bytes, const MovingPose& pose);
void append_contact(std::string& bytes, const ContactRecord& contact);

/// An invalid key, pose, status or contact makes the reader invalid.
StepKey take_key(ByteReader& cursor);
MovingPose take_pose(ByteReader& cursor);
StepStatus take_status(ByteReader& cursor);
ContactRecord take_contact(ByteReader& cursor);

}  // namespace vrda::store
