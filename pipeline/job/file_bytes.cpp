// Reads whole files with a size limit, and computes SHA-256.
#include "job/input_file.hpp"

#include <openssl/evp.h>

#include <array>
#include <filesystem>
#include <fstream>
#include <memory>

namespace vrda::job {

std::string file_bytes(const std::string& file, const InputError::Facts& facts, std::uintmax_t largest_bytes)
{
  namespace fs = std::filesystem;
  const auto refuse = [&](const std::string& found) {
    throw InputError({facts.file, facts.field, found, facts.wanted});
  };
  std::error_code error;
  const fs::file_status status = fs::status(file, error);
  if (status.type() == fs::file_type::not_found) refuse("no file \"" + file + "\"");
  if (status.type() == fs::file_type::directory) refuse("the folder \"" + file + "\"");
  if (status.type() != fs::file_type::regular) refuse("\"" + file + "\", which is not a regular file");
  const std::uintmax_t size = fs::file_size(file, error);
  if (error) refuse("\"" + file + "\", which cannot be read (" + error.message() + ")");
  if (size > largest_bytes) {
    throw InputError({facts.file, facts.field, "\"" + file + "\" of " + std::to_string(size) + " bytes",
                      "at most " + std::to_string(largest_bytes)});
  }
  std::ifstream stream(file, std::ios::binary);
  std::string bytes(static_cast<std::size_t>(size), '\0');
  stream.read(bytes.data(), static_cast<std::streamsize>(size));
  if (!stream) refuse("\"" + file + "\", which cannot be read");
  return bytes;
}

std::string sha256_of(std::string_view bytes)
{
  const std::unique_ptr<EVP_MD_CTX, decltype(&EVP_MD_CTX_free)> context(EVP_MD_CTX_new(), &EVP_MD_CTX_free);
  std::array<unsigned char, EVP_MAX_MD_SIZE> digest{};
  unsigned int length = 0;
  const bool is_done = context != nullptr && EVP_DigestInit_ex(context.get(), EVP_sha256(), nullptr) == 1 &&
                       EVP_DigestUpdate(context.get(), bytes.data(), bytes.size()) == 1 &&
                       EVP_DigestFinal_ex(context.get(), digest.data(), &length) == 1;
  check(is_done, "OpenSSL failed to compute a SHA-256");
  constexpr std::string_view hex = "0123456789abcdef";
  std::string out;
  for (unsigned int i = 0; i < length; ++i) {
    out += hex[digest[i] >> 4U];
    out += hex[digest[i] & 15U];
  }
  return out;
}

}  // namespace vrda::job
