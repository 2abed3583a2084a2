/// Byte format of framed_file.hpp, shared by its writer and its readers.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

namespace vrda::inline core {

struct FrameFormat {
  std::string_view magic;  ///< 8 bytes
  std::uint32_t version = 1;
  std::uint32_t longest_content = 0;  ///< bytes; a larger length means a damaged frame
  const char* frame_name = "record";  ///< in messages: "a torn record"
};

std::string header_bytes(const std::string& key, const FrameFormat& format);

/// Upper bound for all formats.
inline constexpr std::size_t longest_header_bytes = 8 + 8 + 4096 + 4;

/// Remedy for a file that cannot be resumed; only `vrda run` has the option --fresh.
inline constexpr const char* start_over_remedy =
    "the file removed to start over (vrda run --fresh, or by hand and then vrda resume)";

/// The header at the beginning of a file.
struct FrameHeader {
  std::string key;          ///< of the job that wrote it
  std::size_t n_bytes = 0;  ///< 0: invalid header; then field, found and wanted describe the error
  std::string field;
  std::string found;
  std::string wanted;
};
FrameHeader parse_header(std::string_view bytes, const FrameFormat& format);

inline constexpr std::size_t frame_head_bytes = 8;  ///< length and checksum, before the content

std::string frame_of(std::string_view content);

struct ParsedFrame {
  std::string_view content;
  std::size_t n_bytes = 0;         ///< frame and content
  std::string invalid_reason;      ///< why the frame is invalid; empty if it is valid
  std::size_t n_bytes_needed = 0;  ///< if `rest` is too short: number of bytes needed, else 0
};

/// The frame at the beginning of `rest`.
ParsedFrame parse_frame(std::string_view rest, const FrameFormat& format);

}  // namespace vrda::inline core
