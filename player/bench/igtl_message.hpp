/// OpenIGTLink messages of a tracker as plain data, and their encoding. Positions are in mm, rotations are
/// unit quaternions or rotation matrices, times in ns of the device. A body that does not fit its type gives
/// nullopt, a pose that is not a rotation a tool with `invalid_pose`.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "model/mesh.hpp"

namespace vrda::bench {

enum class IgtlKind : std::uint8_t {
  transform,
  position,
  tdata,   ///< poses of several tools
  qtdata,  ///< the same with quaternions
  status,
  start_tdata,   ///< STT_TDATA: requests TDATA
  stop_tdata,    ///< STP_TDATA
  tdata_started  ///< RTS_TDATA: the answer to either
};

/// Visibility of a tracked tool.
enum class ToolVisibility : std::uint8_t {
  seen,
  missing,      ///< not listed, or reported as not visible by meta data (TransformStatus, as PLUS sends it)
  stale,        ///< for clients: nothing new for too long, or a time stamp that does not advance
  invalid_pose  ///< not a rotation matrix or unit quaternion, or not finite
};

struct IgtlTool {
  std::string name;  ///< at most 20 bytes are sent
  ToolVisibility visibility = ToolVisibility::seen;
  Pose X_tracker_tool = Pose::Identity();  ///< mm; sent as float32
  bool is_stated = false;  ///< received with meta data that state the visibility (header version 2)
};

constexpr int igtl_status_ok = 1;

struct IgtlMessage {
  IgtlKind kind = IgtlKind::transform;
  int header_version = 1;       ///< 2: with an extended header and meta data (OpenIGTLink 3)
  std::string device;           ///< at most 20 bytes are sent
  std::int64_t device_ns = 0;   ///< since the device's epoch, below 2^32 s; 0: none
  std::vector<IgtlTool> tools;  ///< of transform and position: one, with the device's name
  int code = igtl_status_ok;    ///< of status; of tdata_started: 0 for success
  std::string text;             ///< of status; of start_tdata: the name of the coordinate system, 32 bytes
  std::int32_t interval_ms =
      0;  ///< of start_tdata: minimum interval between messages; 0: as fast as possible
};

/// Whether it holds the poses of several tools.
inline bool is_list(const IgtlMessage& message)
{
  return message.kind == IgtlKind::tdata || message.kind == IgtlKind::qtdata;
}

/// Encodes header, body and checksum. A missing tool is omitted from lists; in a transform or position it
/// needs header version 2. A tool with an invalid pose is written with a NaN.
std::vector<std::uint8_t> bytes_of(const IgtlMessage& message);

/// Bound on the entries of R^T R - I, and on |q|^2 - 1, for rounding: matrices written with three decimals
/// pass (each entry is off by 5e-4, lengths and products of columns by 2 sqrt(3) times that); a scale of 0.1
/// % fails.
constexpr double max_rotation_error = 1.8e-3;

// Header and checksum.

constexpr std::size_t igtl_header_bytes = 58;

struct IgtlHeader {
  int version = 0;
  std::string type;  ///< as sent
  std::string device;
  std::int64_t device_ns = 0;
  std::uint64_t body_bytes = 0, crc = 0;
};

/// Decodes igtl_header_bytes bytes; control characters in names become '?'.
IgtlHeader header_of(std::span<const std::uint8_t> bytes);

/// CRC-64 ECMA-182, continued from the checksum `before`.
std::uint64_t igtl_crc(std::span<const std::uint8_t> bytes, std::uint64_t before = 0);

// Splits the bytes of a connection into OpenIGTLink messages.

/// The protocol has no start marker: after an invalid header or a wrong checksum the rest cannot be parsed. A
/// checksum of 0 means that the sender computes no checksum.
/// The stream is then broken, and the connection must be reopened.
class IgtlStream {
 public:
  /// Largest stored body: 900 tools of TDATA. Checked before allocation.
  static constexpr std::uint64_t max_body_bytes = 64 * 1024;
  /// Largest skipped body (images); a larger one means a corrupt header.
  static constexpr std::uint64_t max_skipped_bytes = 1ULL << 32;

  /// The next bytes of the connection, in order; ignored once broken.
  void add(std::span<const std::uint8_t> bytes);

  /// The next complete message of a known kind; nullopt until more bytes arrive, and always once broken.
  std::optional<IgtlMessage> next();

  bool is_broken() const { return !error_message_.empty(); }
  /// "found ..., wanted ..."; empty while intact.
  const std::string& error_message() const { return error_message_; }
  std::uint64_t n_skipped() const { return n_skipped_; }      ///< messages of other types, checksum accepted
  std::uint64_t n_malformed() const { return n_malformed_; }  ///< right checksum, but a wrong size
  /// Messages with checksum 0, which some senders never compute.
  std::uint64_t n_unchecked() const { return n_unchecked_; }

 private:
  bool has(std::uint64_t n) const { return buffer_.size() - begin_ >= n; }
  std::span<const std::uint8_t> unparsed() const { return std::span(buffer_).subspan(begin_); }
  bool parse_header();
  bool skip_body();
  bool accepts_checksum(std::uint64_t crc);
  void set_broken(const std::string& found, const std::string& wanted);

  std::vector<std::uint8_t> buffer_;
  std::size_t begin_ = 0;                        ///< start of the unprocessed bytes
  std::optional<IgtlHeader> head_;               ///< of the message whose body is incomplete
  std::uint64_t skipped_ = 0, skipped_crc_ = 0;  ///< of a body that is being skipped
  std::uint64_t n_skipped_ = 0, n_malformed_ = 0, n_unchecked_ = 0;
  std::string error_message_;
};

// OpenIGTLink messages for programs that show the joint, such as 3D Slicer: texts and meshes. Header version
// 1, which every version of the protocol reads. Poses are sent as TRANSFORM (above). Times in ns
// since the epoch, lengths in mm.

/// A STRING message with a text of ASCII characters, at most 65535. `device`: at most 20 bytes are sent.
std::vector<std::uint8_t> string_bytes(const std::string& device, std::int64_t device_ns,
                                       const std::string& text);

/// A POLYDATA message with the triangles of `mesh`; the vertices are sent as float32.
std::vector<std::uint8_t> polydata_bytes(const std::string& device, std::int64_t device_ns, const Mesh& mesh);

}  // namespace vrda::bench
