/// Allowed outcomes of a reader for any bytes: a value, or an InputError with all facts.
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <ctime>
#include <iostream>
#include <string>

#include "core/text.hpp"

namespace vrda::test {

/// Ends the program, which libFuzzer counts as a crash, unless the condition holds.
inline void require(bool condition, const char* why)
{
  if (condition) return;
  std::cerr << why << std::endl;
  std::abort();
}

inline std::string text_of(const std::uint8_t* data, std::size_t size)
{
  return {reinterpret_cast<const char*>(data), size};
}

/// Calls `read`, which may take 2 s. An InputError must have `found` and one printable line of bounded
/// length. Any other exception propagates and counts as a crash.
template <class Read>
void read_or_refuse(Read read)
{
  constexpr std::size_t longest_message = 100'000;  // four facts of 5000 bytes, each byte shown by up to four
  constexpr std::clock_t longest = 2 * CLOCKS_PER_SEC;
  const std::clock_t start = std::clock();  // processor time, nearly independent of other load
  try {
    read();
  } catch (const InputError& error) {
    const std::string message = error.what();
    require(!error.facts().found.empty(), "a message without the found value");
    require(message.size() <= longest_message, "a message of many pages");
    for (const char c : message)
      require(static_cast<unsigned char>(c) >= 0x20, "a message of more than one line");
  }
  require(std::clock() - start <= longest, "an input that takes more than 2 s");
}

/// Calls `act`, which must not throw: accepted content must be accepted again.
template <class Act>
void require_no_throw(Act act)
{
  try {
    act();
  } catch (const InputError& error) {
    require(false, error.what());
  }
}

}  // namespace vrda::test
