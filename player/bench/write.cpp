// OpenIGTLink messages to bytes: for the simulated tracker, for programs that show the joint, for tests.
#include <igtl_header.h>
#include <igtl_polydata.h>
#include <igtl_position.h>
#include <igtl_qtdata.h>
#include <igtl_tdata.h>
#include <igtl_transform.h>

#include <algorithm>
#include <bit>
#include <cstring>
#include <limits>
#include <utility>

#include "core/error.hpp"
#include "bench/message.hpp"
#include "bench/scene_message.hpp"

namespace vrda::bench {
namespace {

using Bytes = std::vector<std::uint8_t>;

template <std::size_t n>
void put_text(char (&field)[n], const std::string& text)
{
  // Padded with zeros and truncated, as the protocol requires.
  std::fill(std::begin(field), std::end(field), '\0');
  std::copy_n(text.begin(), std::min(n, text.size()), field);
}

/// Big-endian, the lowest `n` bytes.
void append_number(Bytes& bytes, std::uint64_t value, int n)
{
  for (int k = n - 1; k >= 0; --k) bytes.push_back(static_cast<std::uint8_t>(value >> (8 * k)));
}

template <class Part>
void append_part(Bytes& bytes, const Part& part)
{
  const std::size_t at = bytes.size();
  bytes.resize(at + sizeof part);
  std::memcpy(bytes.data() + at, &part, sizeof part);
}

/// Three columns of the rotation, then the position.
void put_transform(igtl_float32* numbers, const IgtlTool& tool)
{
  for (int k = 0; k < 12; ++k) numbers[k] = static_cast<float>(tool.X_tracker_tool.matrix()(k % 3, k / 3));
  if (tool.visibility == ToolVisibility::invalid_pose) numbers[0] = std::numeric_limits<float>::quiet_NaN();
}

/// Position, and quaternion as x, y, z, w.
void put_pose(igtl_float32* position, igtl_float32* quaternion, const IgtlTool& tool)
{
  const Eigen::Quaterniond q(Eigen::Matrix3d(tool.X_tracker_tool.linear()));
  for (int k = 0; k < 3; ++k) position[k] = static_cast<float>(tool.X_tracker_tool.translation()(k));
  for (int k = 0; k < 4; ++k) quaternion[k] = static_cast<float>(q.coeffs()(k));
  if (tool.visibility == ToolVisibility::invalid_pose)
    quaternion[0] = std::numeric_limits<float>::quiet_NaN();
}

void append_transform(Bytes& bytes, const IgtlTool& tool)
{
  igtl_float32 numbers[12];
  put_transform(numbers, tool);
  igtl_transform_convert_byte_order(numbers);
  append_part(bytes, numbers);
}

void append_position(Bytes& bytes, const IgtlTool& tool)
{
  igtl_float32 position[3], quaternion[4];
  put_pose(position, quaternion, tool);
  igtl_position place;
  std::memcpy(place.position, position, sizeof position);
  std::memcpy(place.quaternion, quaternion, sizeof quaternion);
  igtl_position_convert_byte_order(&place);
  append_part(bytes, place);
}

void append_tdata(Bytes& bytes, const IgtlTool& tool)
{
  igtl_float32 numbers[12];
  put_transform(numbers, tool);
  igtl_tdata_element element{};
  put_text(element.name, tool.name);
  element.type = IGTL_TDATA_TYPE_6D;
  std::memcpy(element.transform, numbers, sizeof numbers);
  igtl_tdata_convert_byte_order(&element, 1);
  append_part(bytes, element);
}

void append_qtdata(Bytes& bytes, const IgtlTool& tool)
{
  igtl_float32 position[3], quaternion[4];
  put_pose(position, quaternion, tool);
  igtl_qtdata_element element{};
  put_text(element.name, tool.name);
  element.type = IGTL_QTDATA_TYPE_6D;
  std::memcpy(element.position, position, sizeof position);
  std::memcpy(element.quaternion, quaternion, sizeof quaternion);
  igtl_qtdata_convert_byte_order(&element, 1);
  append_part(bytes, element);
}

void append_status(Bytes& bytes, const IgtlMessage& message)
{
  append_number(bytes, static_cast<std::uint64_t>(message.code), 2);
  append_number(bytes, 0, 8);
  char name[20];
  put_text(name, message.code == igtl_status_ok ? "OK" : "Error");
  append_part(bytes, name);
  bytes.insert(bytes.end(), message.text.begin(), message.text.end());
  bytes.push_back(0);
}

void append_start(Bytes& bytes, const IgtlMessage& message)
{
  append_number(bytes, static_cast<std::uint32_t>(message.interval_ms), 4);
  char coordinates[IGTL_STT_TDATA_LEN_COORDNAME];
  put_text(coordinates, message.text);
  append_part(bytes, coordinates);
}

Bytes content_of(const IgtlMessage& message)
{
  Bytes bytes;
  const bool is_one = message.kind == IgtlKind::transform || message.kind == IgtlKind::position;
  check(!is_one || message.tools.size() == 1, "a TRANSFORM or POSITION has exactly one tool");
  check(!is_one || message.header_version == 2 || message.tools[0].visibility != ToolVisibility::missing,
        "a TRANSFORM or POSITION of a missing tool needs header version 2");
  for (const IgtlTool& tool : message.tools) {
    if (message.kind == IgtlKind::transform) append_transform(bytes, tool);
    if (message.kind == IgtlKind::position) append_position(bytes, tool);
    if (tool.visibility == ToolVisibility::missing) continue;
    if (message.kind == IgtlKind::tdata) append_tdata(bytes, tool);
    if (message.kind == IgtlKind::qtdata) append_qtdata(bytes, tool);
  }
  if (message.kind == IgtlKind::status) append_status(bytes, message);
  if (message.kind == IgtlKind::start_tdata) append_start(bytes, message);
  if (message.kind == IgtlKind::tdata_started)
    append_number(bytes, static_cast<std::uint64_t>(message.code), 1);
  return bytes;
}

/// Header version 2 puts the extended header before the content and the meta data after it. Without tools
/// there is no status to state.
Bytes wrapped(const IgtlMessage& message, const Bytes& content)
{
  const bool has_tools = is_list(message) || !message.tools.empty();
  const bool is_missing = message.tools.size() == 1 && message.tools[0].visibility == ToolVisibility::missing;
  const std::string key = "TransformStatus", value = is_missing ? "MISSING" : "OK";
  constexpr std::uint64_t extended_bytes = 12, us_ascii = 3;
  Bytes entries, values;
  append_number(entries, has_tools ? 1 : 0, 2);
  if (has_tools) {
    append_number(entries, key.size(), 2);
    append_number(entries, us_ascii, 2);
    append_number(entries, value.size(), 4);
    values.insert(values.end(), key.begin(), key.end());
    values.insert(values.end(), value.begin(), value.end());
  }
  Bytes bytes;
  append_number(bytes, extended_bytes, 2);
  append_number(bytes, entries.size(), 2);
  append_number(bytes, values.size(), 4);
  append_number(bytes, 0, 4);  // no message identifier
  for (const Bytes* part : {&content, &std::as_const(entries), &std::as_const(values)})
    bytes.insert(bytes.end(), part->begin(), part->end());
  return bytes;
}

/// Seconds, and fraction in units of 2^-32 s.
std::uint64_t timestamp_of(std::int64_t device_ns)
{
  check(device_ns >= 0, "time stamps count from the device's epoch");
  const auto ns = static_cast<std::uint64_t>(device_ns);
  const std::uint64_t seconds = ns / 1'000'000'000U, rest = ns % 1'000'000'000U;
  check(seconds <= 0xFFFFFFFFU, "a time stamp has 32 bits of seconds");
  return seconds << 32 | ((rest << 32) + 500'000'000U) / 1'000'000'000U;
}

}  // namespace

namespace {

Bytes message_bytes(int version, const char* type, const std::string& device, std::int64_t device_ns,
                    const Bytes& body)
{
  igtl_header header{};
  header.version = static_cast<igtl_uint16>(version);
  put_text(header.name, type);
  put_text(header.device_name, device);
  header.timestamp = timestamp_of(device_ns);
  header.body_size = body.size();
  header.crc = igtl_crc(body);
  igtl_header_convert_byte_order(&header);
  Bytes bytes;
  append_part(bytes, header);
  bytes.insert(bytes.end(), body.begin(), body.end());
  return bytes;
}

}  // namespace

std::vector<std::uint8_t> bytes_of(const IgtlMessage& message)
{
  check(message.header_version == 1 || message.header_version == 2, "header versions are 1 and 2");
  const Bytes content = content_of(message);
  return message_bytes(message.header_version, type_of(message.kind), message.device, message.device_ns,
                       message.header_version == 2 ? wrapped(message, content) : content);
}

std::vector<std::uint8_t> string_bytes(const std::string& device, std::int64_t device_ns,
                                       const std::string& text)
{
  constexpr std::uint64_t us_ascii = 3;
  constexpr std::size_t longest = 0xFFFF;
  check(text.size() <= longest, "a STRING has at most 65535 bytes");
  Bytes body;
  append_number(body, us_ascii, 2);
  append_number(body, text.size(), 2);
  body.insert(body.end(), text.begin(), text.end());
  return message_bytes(1, "STRING", device, device_ns, body);
}

std::vector<std::uint8_t> polydata_bytes(const std::string& device, std::int64_t device_ns, const Mesh& mesh)
{
  constexpr std::uint32_t triangle_bytes = 4 * sizeof(igtl_uint32);
  const auto n_points = static_cast<std::uint32_t>(mesh.vertices_mm.rows());
  const auto n_triangles = static_cast<std::uint32_t>(mesh.triangles.rows());
  Bytes body;
  body.reserve(sizeof(igtl_polydata_header) + 12 * n_points + triangle_bytes * n_triangles);
  // Counts and bytes of points; vertices, lines, polygons, strips; attributes.
  for (const std::uint32_t number :
       {n_points, 0U, 0U, 0U, 0U, n_triangles, triangle_bytes * n_triangles, 0U, 0U, 0U})
    append_number(body, number, sizeof number);
  static_assert(sizeof(igtl_polydata_header) == 10 * sizeof(igtl_uint32));
  for (std::uint32_t k = 0; k < n_points; ++k) {
    for (int axis = 0; axis < 3; ++axis)
      append_number(body, std::bit_cast<std::uint32_t>(static_cast<float>(mesh.vertices_mm(k, axis))), 4);
  }
  for (std::uint32_t t = 0; t < n_triangles; ++t) {
    append_number(body, 3, 4);
    for (int corner = 0; corner < 3; ++corner)
      append_number(body, static_cast<std::uint32_t>(mesh.triangles(t, corner)), 4);
  }
  return message_bytes(1, "POLYDATA", device, device_ns, body);
}

}  // namespace vrda::bench
