#include "store/record_bytes.hpp"

#include <algorithm>
#include <cmath>

namespace vrda::store {

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

}  // namespace vrda::store
