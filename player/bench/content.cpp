// Bytes of an OpenIGTLink message to poses and commands; checks lengths and checksum.
#include <igtl_header.h>
#include <igtl_position.h>
#include <igtl_qtdata.h>
#include <igtl_tdata.h>
#include <igtl_transform.h>
#include <igtl_util.h>

#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <utility>

#include "core/error.hpp"
#include "bench/message.hpp"

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

}  // namespace vrda::bench
