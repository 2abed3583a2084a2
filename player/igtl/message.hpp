/// The messages of OpenIGTLink that a tracker speaks, and their bytes.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "core/mesh.hpp"

namespace vrda {

enum class IgtlKind : std::uint8_t {
  transform,
  position,
  tdata,   ///< places of several tools
  qtdata,  ///< the same with quaternions
  status,
  start_tdata,   ///< STT_TDATA: asks for TDATA
  stop_tdata,    ///< STP_TDATA
  tdata_started  ///< RTS_TDATA: the answer to either
};

enum class IgtlSight : std::uint8_t {
  seen,
  missing,      ///< the meta data say so (TransformStatus, as PLUS sends it); lists leave such tools out
  not_a_place,  ///< a matrix that is no rotation, a quaternion not of unit length, a number that is none
};

struct IgtlTool {
  std::string name;  ///< at most 20 bytes go over the line
  IgtlSight sight = IgtlSight::seen;
  Pose X_tracker_tool = Pose::Identity();  ///< mm, kept as float32 on the line
};

constexpr int igtl_status_ok = 1;

struct IgtlMessage {
  IgtlKind kind = IgtlKind::transform;
  int header_version = 1;        ///< 2: with an extended header and meta data (OpenIGTLink 3)
  std::string device;            ///< at most 20 bytes go over the line
  std::int64_t device_ns = 0;    ///< since the device's epoch, below 2^32 s; 0: none
  std::vector<IgtlTool> tools;   ///< of transform and position: one, named as the device
  int code = igtl_status_ok;     ///< of status; of tdata_started: 0 for success
  std::string text;              ///< of status; of start_tdata: the name of the coordinate system, 32 bytes
  std::int32_t interval_ms = 0;  ///< of start_tdata: between two messages, 0 for as often as can be
};

/// Whether it holds the places of several tools.
inline bool is_list(const IgtlMessage& message)
{
  return message.kind == IgtlKind::tdata || message.kind == IgtlKind::qtdata;
}

/// Header, body and checksum. A tool that is missing is left out of lists; in a transform or position it
/// takes header version 2. A tool that is not a place is written with a number that is none.
std::vector<std::uint8_t> bytes_of(const IgtlMessage& message);

/// Largest entry of R^T R - I, and of |q|^2 - 1, that passes as rounding: matrices written with three
/// decimals (each entry off by 5e-4, a column's length and products by 2 sqrt(3) of that) do, a scale of 0.1
/// % does not.
constexpr double most_rotation_error = 1.8e-3;

/// The rotation nearest to the matrix, nothing where it is farther from one than that, mirrored or not
/// finite.
std::optional<Eigen::Matrix3d> nearest_rotation(const Eigen::Matrix3d& matrix);

/// The quaternion (w, x, y, z) made of unit length, nothing likewise.
std::optional<Eigen::Quaterniond> unit_quaternion(const Eigen::Vector4d& wxyz);

/// Heads and bodies of single messages: what stream.hpp is made of.
constexpr std::size_t igtl_head_bytes = 58;

struct IgtlHead {
  int version = 0;
  std::string type;  ///< as it stands in the message
  std::string device;
  std::int64_t device_ns = 0;
  std::uint64_t body_bytes = 0, crc = 0;
};

/// Of igtl_head_bytes bytes; control characters of the names become '?'.
IgtlHead head_of(std::span<const std::uint8_t> bytes);

/// ECMA-182, going on from the checksum of what came before.
std::uint64_t igtl_crc(std::span<const std::uint8_t> bytes, std::uint64_t before = 0);

bool is_known_type(const std::string& type);

/// Nothing where the body's size or its meta data do not fit the type.
std::optional<IgtlMessage> message_of(const IgtlHead& head, std::span<const std::uint8_t> body);

/// The type's name on the line.
const char* type_of(IgtlKind kind);

}  // namespace vrda
