/// System call filter (seccomp) of the current process.
#pragma once

#include <string>

namespace vrda::store {

/// Whether address or thread sanitizers are enabled, which exceed memory limits and open files for reports.
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
inline constexpr bool is_sanitized = true;
#elif defined(__has_feature)
#if __has_feature(address_sanitizer) || __has_feature(thread_sanitizer)
inline constexpr bool is_sanitized = true;
#else
inline constexpr bool is_sanitized = false;
#endif
#else
inline constexpr bool is_sanitized = false;
#endif

/// Restricts this process to computing, allocating memory, reading and writing open files, and exiting. The
/// kernel refuses every other system call with EPERM: no file, socket, program or thread can be opened or
/// started. Returns an empty string, or the reason why the kernel rejected the filter. Does nothing under
/// address and thread sanitizers, whose reports need to open files.
std::string confine_this_process();

}  // namespace vrda::store
