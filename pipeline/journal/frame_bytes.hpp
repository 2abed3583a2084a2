/// The bytes of framed_file.hpp: what writes the file and what reads it agree here.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

namespace vrda {

struct FrameFormat {
  std::string_view magic;  ///< 8 bytes
  std::uint32_t version = 1;
  std::uint32_t longest_content = 0;  ///< bytes; a frame that claims more is damaged
  const char* frame_name = "record";  ///< in messages: "a torn record"
};

std::string header_bytes(const std::string& key, const FrameFormat& format);

/// Of any format: a key is short.
inline constexpr std::size_t longest_header_bytes = 8 + 8 + 4096 + 4;

/// What to do about a file that nothing can go on with; of vrda's commands only `run` has the option.
inline constexpr const char* way_to_start_over =
    "the file removed to start over (vrda run --fresh; or by hand, then vrda resume)";

/// The header at the beginning of a file.
struct FrameHeader {
  std::string key;          ///< of the job that wrote it
  std::size_t n_bytes = 0;  ///< 0: the header is not that of the format
  std::string field;        ///< then: where, what is there instead and what was wanted
  std::string found;
  std::string wanted;
};
FrameHeader header_in(std::string_view bytes, const FrameFormat& format);

inline constexpr std::size_t frame_head_bytes = 8;  ///< length and checksum, before the content

std::string frame_of(std::string_view content);

struct Taken {
  std::string_view content;
  std::size_t n_bytes = 0;      ///< frame and content
  std::string why_not;          ///< empty: the frame is whole
  std::size_t n_bytes_due = 0;  ///< not whole because `rest` ends too soon: what it would take
};

/// The frame at the beginning of `rest`.
Taken take_frame(std::string_view rest, const FrameFormat& format);

}  // namespace vrda
