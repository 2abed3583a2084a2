// Bytes of an OpenIGTLink message to poses and commands; checks lengths and checksum.
#include "bench/igtl_message.hpp"

#include <igtl_header.h>
#include <igtl_polydata.h>
#include <igtl_position.h>
#include <igtl_qtdata.h>
#include <igtl_tdata.h>
#include <igtl_transform.h>
#include <igtl_util.h>
#include <Eigen/LU>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstring>
#include <limits>
#include <utility>

#include "core/text.hpp"

namespace vrda::bench {
namespace {

using ByteView = std::span<const std::uint8_t>;

static_assert(sizeof(igtl_header) == igtl_header_bytes);

/// Text of a field of fixed size, up to its first zero.
std::string text_of(const char* at, std::size_t most)
{
  std::string text(at, strnlen(at, most));
  for (char& c : text) {
    if (static_cast<unsigned char>(c) < 0x20 || c == 0x7F) c = '?';
  }
  return text;
}

std::string text_of(ByteView bytes)
{
  return text_of(reinterpret_cast<const char*>(bytes.data()), bytes.size());
}

/// Big-endian.
std::uint64_t number_at(ByteView bytes, std::size_t at, std::size_t n)
{
  std::uint64_t value = 0;
  for (const std::uint8_t byte : bytes.subspan(at, n)) value = value << 8 | byte;
  return value;
}

/// The library's own conversion drops up to 32 ns and can map two stamps to the end of a second: rounded
/// here, so that whole nanoseconds are preserved.
std::int64_t ns_of(std::uint64_t timestamp)
{
  const std::uint64_t seconds = timestamp >> 32, fraction = timestamp & 0xFFFFFFFFU;
  return static_cast<std::int64_t>(seconds * 1'000'000'000U +
                                   ((fraction * 1'000'000'000U + 0x80000000U) >> 32));
}

/// A body without the extended header and meta data of header version 2.
struct Stripped {
  ByteView content;
  bool is_seen = true;     ///< according to the meta data
  bool is_stated = false;  ///< the meta data say so
};

/// PLUS states for every transform whether its tool was visible; a pressed switch also counts as visible.
bool is_visible_value(const std::string& key, const std::string& value)
{
  if (key == "TransformValid") return value != "0" && value != "false" && value != "False";
  if (key != "TransformStatus") return true;
  return value == "OK" || value.starts_with("SWITCH");
}

/// Adds what the meta data state about the visibility. Layout: the number of entries, entries of 8 bytes (key
/// size, encoding, value size), then keys and values concatenated. False if the sizes do not fit.
bool read_meta_data(ByteView entries, ByteView values, Stripped& message)
{
  if (entries.empty()) return true;
  if (entries.size() < 2) return false;
  const std::size_t n = number_at(entries, 0, 2);
  if (entries.size() < 2 + 8 * n) return false;
  for (std::size_t k = 0, at = 0; k < n; ++k) {
    const std::size_t n_key = number_at(entries, 2 + 8 * k, 2), n_value = number_at(entries, 6 + 8 * k, 4);
    if (n_key + n_value > values.size() - at) return false;
    const std::string key = text_of(values.subspan(at, n_key));
    message.is_stated = message.is_stated || key == "TransformStatus" || key == "TransformValid";
    message.is_seen = is_visible_value(key, text_of(values.subspan(at + n_key, n_value))) && message.is_seen;
    at += n_key + n_value;
  }
  return true;
}

/// Layout: extended header, content, meta data entries, meta data.
std::optional<Stripped> stripped(int version, ByteView body)
{
  if (version == 1) return Stripped{body};
  constexpr std::size_t least_extended = 12;
  if (body.size() < least_extended) return std::nullopt;
  const std::size_t n_extended = number_at(body, 0, 2), n_entries = number_at(body, 2, 2),
                    n_values = number_at(body, 4, 4);
  if (n_extended < least_extended || n_extended + n_entries + n_values > body.size()) return std::nullopt;
  ByteView rest = body.subspan(n_extended);
  const ByteView values = rest.last(n_values);
  rest = rest.first(rest.size() - n_values);
  Stripped message{rest.first(rest.size() - n_entries)};
  if (!read_meta_data(rest.last(n_entries), values, message)) return std::nullopt;
  return message;
}

/// Far beyond the volume of any tracker.
constexpr double farthest_mm = 100'000.0;

IgtlTool placed_tool(std::string name, const std::optional<Eigen::Matrix3d>& R,
                     const Eigen::Vector3d& position_mm)
{
  IgtlTool tool{std::move(name)};
  if (!R || !position_mm.allFinite() || position_mm.cwiseAbs().maxCoeff() > farthest_mm) {
    tool.visibility = ToolVisibility::invalid_pose;
    return tool;
  }
  tool.X_tracker_tool.linear() = *R;
  tool.X_tracker_tool.translation() = position_mm;
  return tool;
}

/// The 12 numbers of a TRANSFORM: three columns of the rotation, then the position.
IgtlTool tool_of(std::string name, const igtl_float32 (&numbers)[12])
{
  const Eigen::Matrix<double, 3, 4> matrix =
      Eigen::Map<const Eigen::Matrix<float, 3, 4>>(numbers).cast<double>();
  return placed_tool(std::move(name), corrected_rotation(matrix.leftCols<3>()), matrix.col(3));
}

/// Position, and quaternion as x, y, z, w.
IgtlTool tool_of(std::string name, const Eigen::Vector3d& position_mm, const Eigen::Vector4d& xyzw)
{
  std::optional<Eigen::Matrix3d> R;
  if (const auto q = unit_quaternion({xyzw(3), xyzw(0), xyzw(1), xyzw(2)})) R = q->toRotationMatrix();
  return placed_tool(std::move(name), R, position_mm);
}

bool read_transform(ByteView content, IgtlMessage& message)
{
  if (content.size() != IGTL_TRANSFORM_SIZE) return false;
  igtl_float32 numbers[12];
  std::memcpy(numbers, content.data(), sizeof numbers);
  igtl_transform_convert_byte_order(numbers);
  message.tools.push_back(tool_of(message.device, numbers));
  return true;
}

/// Sizes: position only; three quaternion components, the fourth computed; all.
bool read_position(ByteView content, IgtlMessage& message)
{
  igtl_position place{};
  static_assert(sizeof place == IGTL_POSITION_MESSAGE_DEFAULT_SIZE);
  if (content.size() > sizeof place) return false;
  std::memcpy(&place, content.data(), content.size());
  igtl_position_convert_byte_order(&place);
  Eigen::Vector4d xyzw(static_cast<double>(place.quaternion[0]), static_cast<double>(place.quaternion[1]),
                       static_cast<double>(place.quaternion[2]), static_cast<double>(place.quaternion[3]));
  if (content.size() == IGTL_POSITION_MESSAGE_POSITON_ONLY_SIZE) {
    xyzw = {0.0, 0.0, 0.0, 1.0};
  } else if (content.size() == IGTL_POSITION_MESSAGE_WITH_QUATERNION3_SIZE) {
    xyzw(3) = std::sqrt(std::max(0.0, 1.0 - xyzw.head<3>().squaredNorm()));
  } else if (content.size() != sizeof place) {
    return false;
  }
  const Eigen::Vector3d position_mm(static_cast<double>(place.position[0]),
                                    static_cast<double>(place.position[1]),
                                    static_cast<double>(place.position[2]));
  message.tools.push_back(tool_of(message.device, position_mm, xyzw));
  return true;
}

bool read_tdata(ByteView content, IgtlMessage& message)
{
  if (content.size() % IGTL_TDATA_ELEMENT_SIZE != 0) return false;
  for (; !content.empty(); content = content.subspan(IGTL_TDATA_ELEMENT_SIZE)) {
    igtl_tdata_element element;
    static_assert(sizeof element == IGTL_TDATA_ELEMENT_SIZE);
    std::memcpy(&element, content.data(), sizeof element);
    igtl_tdata_convert_byte_order(&element, 1);
    igtl_float32 numbers[12];
    std::memcpy(numbers, element.transform, sizeof numbers);
    message.tools.push_back(tool_of(text_of(element.name, sizeof element.name), numbers));
  }
  return true;
}

bool read_qtdata(ByteView content, IgtlMessage& message)
{
  if (content.size() % IGTL_QTDATA_ELEMENT_SIZE != 0) return false;
  for (; !content.empty(); content = content.subspan(IGTL_QTDATA_ELEMENT_SIZE)) {
    igtl_qtdata_element element;
    static_assert(sizeof element == IGTL_QTDATA_ELEMENT_SIZE);
    std::memcpy(&element, content.data(), sizeof element);
    igtl_qtdata_convert_byte_order(&element, 1);
    Eigen::Vector3f position_mm;
    Eigen::Vector4f xyzw;
    std::memcpy(position_mm.data(), element.position, sizeof element.position);
    std::memcpy(xyzw.data(), element.quaternion, sizeof element.quaternion);
    message.tools.push_back(
        tool_of(text_of(element.name, sizeof element.name), position_mm.cast<double>(), xyzw.cast<double>()));
  }
  return true;
}

/// Code, sub-code (8 bytes), name of the error (20), text.
bool read_status(ByteView content, IgtlMessage& message)
{
  constexpr std::size_t fixed_bytes = 30;
  if (content.size() < fixed_bytes) return false;
  message.code = static_cast<int>(number_at(content, 0, 2));
  message.text = text_of(content.subspan(fixed_bytes));
  if (message.text.empty()) message.text = text_of(content.subspan(10, 20));
  return true;
}

bool read_start(ByteView content, IgtlMessage& message)
{
  if (content.size() != IGTL_STT_TDATA_SIZE) return false;
  message.interval_ms = static_cast<std::int32_t>(static_cast<std::uint32_t>(number_at(content, 0, 4)));
  message.text = text_of(content.subspan(4));
  return true;
}

bool read_stop(ByteView content, IgtlMessage& /*message*/)
{
  return content.empty();
}

bool read_started(ByteView content, IgtlMessage& message)
{
  if (content.size() != IGTL_RTS_TDATA_SIZE) return false;
  message.code = content[0];
  return true;
}

struct MessageType {
  const char* name;
  bool (*read)(ByteView content, IgtlMessage& message);  ///< false: of another size
};

/// In the order of IgtlKind.
constexpr std::array<MessageType, 8> types{{{"TRANSFORM", read_transform},
                                            {"POSITION", read_position},
                                            {"TDATA", read_tdata},
                                            {"QTDATA", read_qtdata},
                                            {"STATUS", read_status},
                                            {"STT_TDATA", read_start},
                                            {"STP_TDATA", read_stop},
                                            {"RTS_TDATA", read_started}}};

const MessageType* find_type(const std::string& name)
{
  const auto found = std::ranges::find_if(types, [&](const MessageType& type) { return name == type.name; });
  return found == types.end() ? nullptr : &*found;
}

}  // namespace

IgtlHeader header_of(ByteView bytes)
{
  check(bytes.size() == igtl_header_bytes, "head_of needs igtl_head_bytes bytes");
  igtl_header header;
  std::memcpy(&header, bytes.data(), sizeof header);
  igtl_header_convert_byte_order(&header);
  IgtlHeader head;
  head.version = header.version;
  head.type = text_of(header.name, sizeof header.name);
  head.device = text_of(header.device_name, sizeof header.device_name);
  head.device_ns = ns_of(header.timestamp);
  head.body_bytes = header.body_size;
  head.crc = header.crc;
  return head;
}

std::uint64_t igtl_crc(ByteView bytes, std::uint64_t before)
{
  // The library's function is not const-correct; it only reads.
  return crc64(const_cast<std::uint8_t*>(bytes.data()), bytes.size(), before);
}

bool is_known_type(const std::string& type)
{
  return find_type(type) != nullptr;
}

const char* type_of(IgtlKind kind)
{
  return types.at(static_cast<std::size_t>(kind)).name;
}

std::optional<IgtlMessage> message_of(const IgtlHeader& head, ByteView body)
{
  const MessageType* const type = find_type(head.type);
  const std::optional<Stripped> inner = stripped(head.version, body);
  if (type == nullptr || !inner) return std::nullopt;
  IgtlMessage message;
  message.kind = static_cast<IgtlKind>(type - types.data());
  message.header_version = head.version;
  message.device = head.device;
  message.device_ns = head.device_ns;
  if (!type->read(inner->content, message)) return std::nullopt;
  for (IgtlTool& tool : message.tools) {
    tool.is_stated = inner->is_stated;
    if (!inner->is_seen) tool.visibility = ToolVisibility::missing;
  }
  return message;
}

std::optional<Eigen::Matrix3d> corrected_rotation(const Eigen::Matrix3d& matrix)
{
  const Eigen::Matrix3d error = matrix.transpose() * matrix - Eigen::Matrix3d::Identity();
  // allFinite first: a maximum may ignore NaN.
  if (!error.allFinite() || error.cwiseAbs().maxCoeff() > max_rotation_error) return std::nullopt;
  if (matrix.determinant() <= 0.0) return std::nullopt;
  // Newton's iteration to the orthogonal factor squares the error each time: 1e-3, 1e-6, 1e-12, rounding.
  Eigen::Matrix3d R = matrix;
  for (int n = 0; n < 3; ++n) {
    const Eigen::Matrix3d inverse = R.inverse();
    R = 0.5 * (R + inverse.transpose()).eval();
  }
  return R;
}

std::optional<Eigen::Quaterniond> unit_quaternion(const Eigen::Vector4d& wxyz)
{
  const double length_sq = wxyz.squaredNorm();
  if (!(std::abs(length_sq - 1.0) <= max_rotation_error)) return std::nullopt;
  const Eigen::Vector4d unit = wxyz / std::sqrt(length_sq);
  return Eigen::Quaterniond(unit(0), unit(1), unit(2), unit(3));
}

void IgtlStream::set_broken(const std::string& found, const std::string& wanted)
{
  error_message_ = "found " + found + ", wanted " + wanted;
  buffer_.clear();
  begin_ = 0;
}

void IgtlStream::add(std::span<const std::uint8_t> bytes)
{
  if (is_broken()) return;
  buffer_.erase(buffer_.begin(), buffer_.begin() + static_cast<std::ptrdiff_t>(begin_));
  begin_ = 0;
  buffer_.insert(buffer_.end(), bytes.begin(), bytes.end());
}

/// False where the stream is broken.
bool IgtlStream::parse_header()
{
  IgtlHeader head = header_of(unparsed().first(igtl_header_bytes));
  if (head.version != 1 && head.version != 2) {
    set_broken("header version " + std::to_string(head.version), "1 or 2 of OpenIGTLink");
  } else if (head.type.empty() || head.type.find('?') != std::string::npos) {
    set_broken("type '" + head.type + "'", "the name of an OpenIGTLink message");
  } else if (const std::uint64_t most = is_known_type(head.type) ? max_body_bytes : max_skipped_bytes;
             head.body_bytes > most) {
    set_broken(head.type + " of " + std::to_string(head.body_bytes) + " bytes",
               "at most " + std::to_string(most));
  }
  if (is_broken()) return false;
  begin_ += igtl_header_bytes;
  skipped_ = skipped_crc_ = 0;
  head_ = std::move(head);
  return true;
}

/// Of the complete body. Some senders write 0 instead of a checksum: their messages are counted.
bool IgtlStream::accepts_checksum(std::uint64_t crc)
{
  if (crc == head_->crc) return true;
  if (head_->crc == 0) {
    ++n_unchecked_;
    return true;
  }
  set_broken(head_->type + " with a wrong checksum", "CRC64 of its body");
  return false;
}

/// Skips the available part of the body; true when it is complete and its checksum is accepted.
bool IgtlStream::skip_body()
{
  const std::uint64_t n = std::min<std::uint64_t>(head_->body_bytes - skipped_, unparsed().size());
  skipped_crc_ = igtl_crc(unparsed().first(n), skipped_crc_);
  skipped_ += n;
  begin_ += n;
  if (skipped_ < head_->body_bytes) return false;
  if (!accepts_checksum(skipped_crc_)) return false;
  ++n_skipped_;
  head_.reset();
  return true;
}

std::optional<IgtlMessage> IgtlStream::next()
{
  while (!is_broken()) {
    if (!head_ && (!has(igtl_header_bytes) || !parse_header())) return std::nullopt;
    if (!is_known_type(head_->type)) {
      if (!skip_body()) return std::nullopt;
      continue;
    }
    if (!has(head_->body_bytes)) return std::nullopt;
    const std::span<const std::uint8_t> body = unparsed().first(head_->body_bytes);
    if (!accepts_checksum(igtl_crc(body))) return std::nullopt;
    std::optional<IgtlMessage> message = message_of(*head_, body);
    begin_ += body.size();
    head_.reset();
    if (message) return message;
    ++n_malformed_;
  }
  return std::nullopt;
}

// OpenIGTLink messages to bytes: for the simulated tracker, for programs that show the joint, for tests.

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
