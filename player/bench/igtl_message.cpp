// OpenIGTLink messages to plain data and back; lengths and checksums are checked. The sizes and the checksum
// are the library's. Its message classes are not used: they read beyond messages that do not fit their type.
#include "bench/igtl_message.hpp"

#include <igtl_header.h>
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
#include <utility>

#include "core/text.hpp"
#include "core/units.hpp"

namespace vrda::bench {
namespace {

using ByteView = std::span<const std::uint8_t>;

static_assert(sizeof(igtl_header) == igtl_header_bytes);

/// Bytes of the fields of names: types, tools and devices, errors.
constexpr std::size_t type_bytes = IGTL_HEADER_TYPE_SIZE, name_bytes = IGTL_HEADER_NAME_SIZE;
/// Name, kind and a reserved byte, before the pose of an element of a list.
constexpr std::size_t element_head_bytes = name_bytes + 2;

/// Text of a field of fixed size, up to its first zero.
std::string text_of(ByteView bytes)
{
  std::string text(bytes.begin(), std::ranges::find(bytes, 0));
  for (char& c : text) {
    if (static_cast<unsigned char>(c) < 0x20 || c == 0x7F) c = '?';
  }
  return text;
}

/// Big-endian.
std::uint64_t number_at(ByteView bytes, std::size_t at, std::size_t n)
{
  std::uint64_t value = 0;
  for (const std::uint8_t byte : bytes.subspan(at, n)) value = value << 8 | byte;
  return value;
}

/// `n` float32 numbers from the beginning.
template <int n>
Eigen::Matrix<double, n, 1> floats_of(ByteView bytes)
{
  Eigen::Matrix<double, n, 1> numbers;
  for (std::size_t k = 0; k < n; ++k)
    numbers(static_cast<Eigen::Index>(k)) =
        static_cast<double>(std::bit_cast<float>(static_cast<std::uint32_t>(number_at(bytes, 4 * k, 4))));
  return numbers;
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

/// The nearest rotation; nullopt if mirrored, not finite, or off by more than max_rotation_error.
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

/// The normalised quaternion (w, x, y, z); nullopt under the same conditions.
std::optional<Eigen::Quaterniond> unit_quaternion(const Eigen::Vector4d& wxyz)
{
  const double length_sq = wxyz.squaredNorm();
  if (!(std::abs(length_sq - 1.0) <= max_rotation_error)) return std::nullopt;
  const Eigen::Vector4d unit = wxyz / std::sqrt(length_sq);
  return Eigen::Quaterniond(unit(0), unit(1), unit(2), unit(3));
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
IgtlTool tool_of_matrix(std::string name, ByteView bytes)
{
  const Eigen::Matrix<double, 3, 4> matrix = floats_of<12>(bytes).reshaped(3, 4);
  return placed_tool(std::move(name), corrected_rotation(matrix.leftCols<3>()), matrix.col(3));
}

/// Position, and quaternion as x, y, z, w; without it, or without its last number, which is then computed.
IgtlTool tool_of_position(std::string name, ByteView bytes)
{
  Eigen::Vector4d xyzw(0.0, 0.0, 0.0, 1.0);
  if (bytes.size() >= IGTL_POSITION_MESSAGE_WITH_QUATERNION3_SIZE) {
    xyzw.head<3>() = floats_of<3>(bytes.subspan(12));
    xyzw(3) = std::sqrt(std::max(0.0, 1.0 - xyzw.head<3>().squaredNorm()));
  }
  if (bytes.size() == IGTL_POSITION_MESSAGE_DEFAULT_SIZE) xyzw = floats_of<4>(bytes.subspan(12));
  std::optional<Eigen::Matrix3d> R;
  if (const auto q = unit_quaternion({xyzw(3), xyzw(0), xyzw(1), xyzw(2)})) R = q->toRotationMatrix();
  return placed_tool(std::move(name), R, floats_of<3>(bytes));
}

bool read_transform(ByteView content, IgtlMessage& message)
{
  if (content.size() != IGTL_TRANSFORM_SIZE) return false;
  message.tools.push_back(tool_of_matrix(message.device, content));
  return true;
}

bool read_position(ByteView content, IgtlMessage& message)
{
  if (content.size() != IGTL_POSITION_MESSAGE_POSITON_ONLY_SIZE &&
      content.size() != IGTL_POSITION_MESSAGE_WITH_QUATERNION3_SIZE &&
      content.size() != IGTL_POSITION_MESSAGE_DEFAULT_SIZE)
    return false;
  message.tools.push_back(tool_of_position(message.device, content));
  return true;
}

/// A list of tools, each with its name and pose.
template <std::size_t element_bytes, IgtlTool (*tool_of)(std::string, ByteView)>
bool read_list(ByteView content, IgtlMessage& message)
{
  if (content.size() % element_bytes != 0) return false;
  for (; !content.empty(); content = content.subspan(element_bytes)) {
    const ByteView element = content.first(element_bytes);
    message.tools.push_back(tool_of(text_of(element.first(name_bytes)), element.subspan(element_head_bytes)));
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
  if (message.text.empty()) message.text = text_of(content.subspan(10, name_bytes));
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
                                            {"TDATA", read_list<IGTL_TDATA_ELEMENT_SIZE, tool_of_matrix>},
                                            {"QTDATA", read_list<IGTL_QTDATA_ELEMENT_SIZE, tool_of_position>},
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
  check(bytes.size() == igtl_header_bytes, "header_of needs igtl_header_bytes bytes");
  const std::size_t device_at = 2 + type_bytes, numbers_at = device_at + name_bytes;
  return {static_cast<int>(number_at(bytes, 0, 2)),      text_of(bytes.subspan(2, type_bytes)),
          text_of(bytes.subspan(device_at, name_bytes)), ns_of(number_at(bytes, numbers_at, 8)),
          number_at(bytes, numbers_at + 8, 8),           number_at(bytes, numbers_at + 16, 8)};
}

std::uint64_t igtl_crc(ByteView bytes, std::uint64_t before)
{
  // The library's function is not const-correct; it only reads.
  return crc64(const_cast<std::uint8_t*>(bytes.data()), bytes.size(), before);
}

/// nullopt if the body's size or its meta data do not fit the type.
static std::optional<IgtlMessage> message_of(const IgtlHeader& head, ByteView body)
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
  } else if (const std::uint64_t most = find_type(head.type) != nullptr ? max_body_bytes : max_skipped_bytes;
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
    if (find_type(head_->type) == nullptr) {
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

// Messages to bytes: for the simulated tracker, for programs that show the joint, for tests.

namespace {

using Bytes = std::vector<std::uint8_t>;

void append(Bytes& bytes, const auto& more)
{
  bytes.insert(bytes.end(), more.begin(), more.end());
}

/// Padded with zeros or truncated to `n` bytes, as the protocol requires.
void append_text(Bytes& bytes, std::string text, std::size_t n)
{
  text.resize(n, '\0');
  append(bytes, text);
}

/// Big-endian, the lowest `n` bytes.
void append_number(Bytes& bytes, std::uint64_t value, int n)
{
  for (int k = n - 1; k >= 0; --k) bytes.push_back(static_cast<std::uint8_t>(value >> (8 * k)));
}

void append_float(Bytes& bytes, double value)
{
  append_number(bytes, std::bit_cast<std::uint32_t>(static_cast<float>(value)), 4);
}

/// Three columns of the rotation, then the position.
void append_matrix(Bytes& bytes, const IgtlTool& tool)
{
  Eigen::Matrix<double, 3, 4> matrix = tool.X_tracker_tool.matrix().topRows<3>();
  if (tool.visibility == ToolVisibility::invalid_pose) matrix(0) = nan;
  for (const double number : matrix.reshaped()) append_float(bytes, number);
}

/// Position, and quaternion as x, y, z, w.
void append_position(Bytes& bytes, const IgtlTool& tool)
{
  Eigen::Vector4d xyzw = Eigen::Quaterniond(Eigen::Matrix3d(tool.X_tracker_tool.linear())).coeffs();
  if (tool.visibility == ToolVisibility::invalid_pose) xyzw(0) = nan;
  for (int k = 0; k < 3; ++k) append_float(bytes, tool.X_tracker_tool.translation()(k));
  for (const double number : xyzw) append_float(bytes, number);
}

void append_tools(Bytes& bytes, const IgtlMessage& message)
{
  const bool has_matrix = message.kind == IgtlKind::transform || message.kind == IgtlKind::tdata;
  static_assert(IGTL_TDATA_TYPE_6D == IGTL_QTDATA_TYPE_6D);
  for (const IgtlTool& tool : message.tools) {
    if (is_list(message)) {
      if (tool.visibility == ToolVisibility::missing) continue;
      append_text(bytes, tool.name, name_bytes);
      append_number(bytes, IGTL_TDATA_TYPE_6D << 8, 2);
    }
    (has_matrix ? append_matrix : append_position)(bytes, tool);
  }
}

void append_status(Bytes& bytes, const IgtlMessage& message)
{
  append_number(bytes, static_cast<std::uint64_t>(message.code), 2);
  append_number(bytes, 0, 8);
  append_text(bytes, message.code == igtl_status_ok ? "OK" : "Error", name_bytes);
  append_text(bytes, message.text, message.text.size() + 1);
}

Bytes content_of(const IgtlMessage& message)
{
  Bytes bytes;
  switch (message.kind) {
    case IgtlKind::transform:
    case IgtlKind::position:
      check(message.tools.size() == 1, "a TRANSFORM or POSITION has exactly one tool");
      check(message.header_version == 2 || message.tools[0].visibility != ToolVisibility::missing,
            "a TRANSFORM or POSITION of a missing tool needs header version 2");
      append_tools(bytes, message);
      break;
    case IgtlKind::tdata:
    case IgtlKind::qtdata:
      append_tools(bytes, message);
      break;
    case IgtlKind::status:
      append_status(bytes, message);
      break;
    case IgtlKind::start_tdata:
      append_number(bytes, static_cast<std::uint32_t>(message.interval_ms), 4);
      append_text(bytes, message.text, IGTL_STT_TDATA_LEN_COORDNAME);
      break;
    case IgtlKind::stop_tdata:
      break;
    case IgtlKind::tdata_started:
      append_number(bytes, static_cast<std::uint64_t>(message.code), 1);
      break;
  }
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
    append(values, key + value);
  }
  Bytes bytes;
  append_number(bytes, extended_bytes, 2);
  append_number(bytes, entries.size(), 2);
  append_number(bytes, values.size(), 4);
  append_number(bytes, 0, 4);  // no message identifier
  append(bytes, content);
  append(bytes, entries);
  append(bytes, values);
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
  Bytes bytes;
  append_number(bytes, static_cast<std::uint64_t>(version), 2);
  append_text(bytes, type, type_bytes);
  append_text(bytes, device, name_bytes);
  append_number(bytes, timestamp_of(device_ns), 8);
  append_number(bytes, body.size(), 8);
  append_number(bytes, igtl_crc(body), 8);
  append(bytes, body);
  return bytes;
}

}  // namespace

std::vector<std::uint8_t> bytes_of(const IgtlMessage& message)
{
  check(message.header_version == 1 || message.header_version == 2, "header versions are 1 and 2");
  const Bytes content = content_of(message);
  return message_bytes(message.header_version, types.at(static_cast<std::size_t>(message.kind)).name,
                       message.device, message.device_ns,
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
  append(body, text);
  return message_bytes(1, "STRING", device, device_ns, body);
}

std::vector<std::uint8_t> polydata_bytes(const std::string& device, std::int64_t device_ns, const Mesh& mesh)
{
  constexpr std::uint32_t number_bytes = 4, triangle_bytes = 4 * number_bytes;
  const auto n_points = static_cast<std::uint32_t>(mesh.vertices_mm.rows());
  const auto n_triangles = static_cast<std::uint32_t>(mesh.triangles.rows());
  Bytes body;
  // Counts and bytes of points; vertices, lines, polygons, strips; attributes.
  for (const std::uint32_t number :
       {n_points, 0U, 0U, 0U, 0U, n_triangles, triangle_bytes * n_triangles, 0U, 0U, 0U})
    append_number(body, number, number_bytes);
  for (const double coordinate : mesh.vertices_mm.reshaped<Eigen::RowMajor>()) append_float(body, coordinate);
  for (const auto& triangle : mesh.triangles.rowwise()) {
    append_number(body, 3, number_bytes);
    for (const auto corner : triangle) append_number(body, static_cast<std::uint32_t>(corner), number_bytes);
  }
  return message_bytes(1, "POLYDATA", device, device_ns, body);
}

}  // namespace vrda::bench
