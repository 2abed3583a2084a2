#include "journal/record_bytes.hpp"

#include <algorithm>
#include <bit>

namespace vrda {
namespace {

constexpr std::size_t contact_bytes = 7 * 8 + 2 * 4 + 1;

void append_u64(std::string& bytes, std::uint64_t value)
{
  for (int shift = 0; shift < 64; shift += 8) bytes.push_back(static_cast<char>(value >> shift & 0xff));
}

void append_i8(std::string& bytes, std::int8_t value)
{
  bytes.push_back(static_cast<char>(value));
}
void append_i32(std::string& bytes, std::int32_t value)
{
  append_u32(bytes, static_cast<std::uint32_t>(value));
}
void append_double(std::string& bytes, double value)
{
  append_u64(bytes, std::bit_cast<std::uint64_t>(value));
}

void append_vector(std::string& bytes, const Eigen::Vector3d& v)
{
  for (int i = 0; i < 3; ++i) append_double(bytes, v[i]);
}

/// Takes values off the front; past the end it gives zeros and remembers that it did.
class Cursor {
 public:
  explicit Cursor(std::string_view bytes) : bytes_(bytes) {}

  std::size_t left() const { return bytes_.size() - at_; }
  bool is_sound() const { return is_sound_; }

  std::uint64_t take(std::size_t n_bytes)
  {
    if (left() < n_bytes) {
      is_sound_ = false;
      return 0;
    }
    std::uint64_t value = 0;
    for (std::size_t i = 0; i < n_bytes; ++i) {
      value |= std::uint64_t{static_cast<unsigned char>(bytes_[at_ + i])} << (8 * i);
    }
    at_ += n_bytes;
    return value;
  }
  std::int8_t take_i8() { return static_cast<std::int8_t>(take(1)); }
  std::int32_t take_i32() { return static_cast<std::int32_t>(take(4)); }
  double take_double() { return std::bit_cast<double>(take(8)); }
  bool take_bool()
  {
    const std::uint64_t value = take(1);
    if (value > 1) is_sound_ = false;
    return value == 1;
  }
  Eigen::Vector3d take_vector()
  {
    Eigen::Vector3d v;
    for (int i = 0; i < 3; ++i) v[i] = take_double();
    return v;
  }

 private:
  std::string_view bytes_;
  std::size_t at_ = 0;
  bool is_sound_ = true;
};

ContactRecord take_contact(Cursor& cursor)
{
  ContactRecord contact;
  contact.point_solver_mm = cursor.take_vector();
  contact.normal_solver = cursor.take_vector();
  contact.distance_mm = cursor.take_double();
  contact.triangle_reference = cursor.take_i32();
  contact.triangle_moving = cursor.take_i32();
  contact.compartment = cursor.take_i8();
  return contact;
}

}  // namespace

void append_u32(std::string& bytes, std::uint32_t value)
{
  for (int shift = 0; shift < 32; shift += 8) bytes.push_back(static_cast<char>(value >> shift & 0xff));
}

std::uint32_t u32_at(std::string_view bytes, std::size_t offset)
{
  return static_cast<std::uint32_t>(Cursor(bytes.substr(offset)).take(4));
}

std::string bytes_of(const StepRecord& record)
{
  std::string bytes;
  bytes.push_back(static_cast<char>(record.key.kind));
  append_i32(bytes, record.key.flexion);
  append_i32(bytes, record.key.varus);
  append_vector(bytes, record.pose.translation_mm);
  append_double(bytes, record.pose.theta_rad);
  append_i8(bytes, static_cast<std::int8_t>(record.status));
  append_i32(bytes, record.iterations);
  append_i32(bytes, record.queries);
  append_double(bytes, record.residual_mm);
  append_double(bytes, record.gap_medial_mm);
  append_double(bytes, record.gap_lateral_mm);
  for (const bool flag : {record.contact_medial, record.contact_lateral, record.theta_determined}) {
    bytes.push_back(flag ? 1 : 0);
  }
  append_u32(bytes, static_cast<std::uint32_t>(record.contacts.size()));
  for (const ContactRecord& contact : record.contacts) {
    append_vector(bytes, contact.point_solver_mm);
    append_vector(bytes, contact.normal_solver);
    append_double(bytes, contact.distance_mm);
    append_i32(bytes, contact.triangle_reference);
    append_i32(bytes, contact.triangle_moving);
    append_i8(bytes, contact.compartment);
  }
  return bytes;
}

std::optional<StepRecord> record_of(std::string_view bytes)
{
  Cursor cursor(bytes);
  StepRecord record;
  const std::uint64_t kind = cursor.take(1);
  record.key.kind = static_cast<StepKind>(kind);
  record.key.flexion = cursor.take_i32();
  record.key.varus = cursor.take_i32();
  record.pose.translation_mm = cursor.take_vector();
  record.pose.theta_rad = cursor.take_double();
  record.status = static_cast<StepStatus>(cursor.take_i8());
  record.iterations = cursor.take_i32();
  record.queries = cursor.take_i32();
  record.residual_mm = cursor.take_double();
  record.gap_medial_mm = cursor.take_double();
  record.gap_lateral_mm = cursor.take_double();
  record.contact_medial = cursor.take_bool();
  record.contact_lateral = cursor.take_bool();
  record.theta_determined = cursor.take_bool();
  const std::uint64_t n_contacts = cursor.take(4);
  const bool is_known = kind <= static_cast<std::uint64_t>(StepKind::row) &&
                        std::find(std::begin(all_step_statuses), std::end(all_step_statuses),
                                  record.status) != std::end(all_step_statuses);
  if (!cursor.is_sound() || !is_known || cursor.left() != n_contacts * contact_bytes) return std::nullopt;
  for (std::uint64_t i = 0; i < n_contacts; ++i) record.contacts.push_back(take_contact(cursor));
  return record;
}

}  // namespace vrda
