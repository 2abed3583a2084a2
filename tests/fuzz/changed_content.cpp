#include "fuzz/changed_content.hpp"

#include <algorithm>
#include <cstring>
#include <string_view>

#include "fuzz/odd_values.hpp"
#include "store/read_separately.hpp"

/// HDF5's internal function, exported by its library.
extern "C" std::uint32_t H5_checksum_metadata(const void* data, std::size_t size, std::uint32_t seed);

namespace vrda::test {
namespace {

constexpr std::size_t change_bytes = 8;

std::uint32_t u32_at(const std::string& bytes, std::size_t at)
{
  std::uint32_t value = 0;
  std::memcpy(&value, bytes.data() + at, sizeof value);
  return value;
}

/// One change of a recipe.
struct Change {
  std::uint8_t kind = 0;
  std::uint32_t place = 0;
  std::uint8_t a = 0, b = 0, c = 0;
};

Change change_at(const std::uint8_t* data)
{
  Change change{data[0], 0, data[5], data[6], data[7]};
  std::memcpy(&change.place, data + 1, sizeof change.place);
  return change;
}

void put(std::string& bytes, std::size_t at, const void* value, std::size_t size)
{
  if (at < bytes.size()) std::memcpy(bytes.data() + at, value, std::min(size, bytes.size() - at));
}

/// An offset in the metadata, in a dataset's values, or anywhere.
std::size_t place_of(const Change& change, const BaseContent& base, const std::string& bytes)
{
  if (bytes.empty()) return 0;
  const std::size_t offset = change.place >> 8;
  if (change.b % 3 == 0 && !base.checksummed.empty()) {
    const ChecksummedBlock& block = base.checksummed[(change.place & 0xffU) % base.checksummed.size()];
    return block.first + offset % block.size;
  }
  if (change.b % 3 == 1 && !base.values.empty())
    return base.values[(change.place & 0xffU) % base.values.size()] + offset % 256;
  return change.place % bytes.size();
}

void apply(std::string& bytes, const Change& change, const BaseContent& base, const BaseContent& other)
{
  const std::size_t at = place_of(change, base, bytes);
  if (at >= bytes.size()) return;
  switch (change.kind % 8) {
    case 0:
      bytes[at] = static_cast<char>(bytes[at] ^ (1 << change.a % 8));
      return;
    case 1:
      bytes[at] = static_cast<char>(change.a);
      return;
    case 2:
      put(bytes, at, &odd_integers[change.a % odd_integers.size()], std::size_t{1} << change.c % 4);
      return;
    case 3:
      put(bytes, at - at % 4, &odd_reals[change.a % odd_reals.size()], sizeof(double));
      return;
    case 4: {  // copy one part over another
      const std::size_t from = (change.place * std::size_t{2654435761}) % bytes.size();
      const std::string part = bytes.substr(from, 1 + change.a);
      put(bytes, at, part.data(), part.size());
      return;
    }
    case 5: {
      const std::string zeros(1 + change.a, change.c % 2 == 0 ? '\0' : '\xff');
      put(bytes, at, zeros.data(), zeros.size());
      return;
    }
    case 6:  // a splice; sometimes a truncation
      if (change.c % 8 == 0) {
        bytes.resize(at);
      } else {
        const std::string part =
            other.bytes.substr(std::min(at, other.bytes.size()), change.a * std::size_t{16});
        put(bytes, at, part.data(), part.size());
      }
      return;
    default:  // a slightly changed length or address
      bytes[at] = static_cast<char>(bytes[at] + (change.a % 2 == 0 ? 1 : -1) * (1 + change.a / 64));
  }
}

void mend_sums(std::string& bytes, const std::vector<ChecksummedBlock>& summed)
{
  for (const ChecksummedBlock& block : summed) {
    if (block.first + block.size + 4 > bytes.size()) continue;
    const std::uint32_t sum = H5_checksum_metadata(bytes.data() + block.first, block.size, 0);
    std::memcpy(bytes.data() + block.first + block.size, &sum, sizeof sum);
  }
}

}  // namespace

BaseContent base_of_hdf5(const std::string& bytes, const std::vector<std::size_t>& values)
{
  constexpr std::size_t longest = 2048;
  constexpr std::size_t superblock_bytes = 44;
  BaseContent base{bytes, {{0, superblock_bytes}}, values};
  for (const std::string_view signature : {"OHDR", "OCHK", "FRHP", "BTHD", "BTIN", "BTLF", "FSHD", "SMTB"}) {
    for (std::size_t at = bytes.find(signature); at != std::string::npos;
         at = bytes.find(signature, at + 1)) {
      // Their lengths are in other blocks; the end is found by the checksum.
      for (std::size_t size = 8; size < longest && at + size + 4 <= bytes.size(); ++size) {
        if (H5_checksum_metadata(bytes.data() + at, size, 0) != u32_at(bytes, at + size)) continue;
        base.checksummed.push_back({at, size});
        break;
      }
    }
  }
  return base;
}

std::string changed(const std::vector<BaseContent>& bases, const std::uint8_t* recipe, std::size_t size)
{
  if (size < 2) return bases.front().bytes;
  const BaseContent& base = bases[recipe[0] % bases.size()];
  const BaseContent& other = bases[(recipe[0] / 16U) % bases.size()];
  std::string bytes = base.bytes;
  for (std::size_t at = 2; at + change_bytes <= size; at += change_bytes)
    apply(bytes, change_at(recipe + at), base, other);
  if (base.checksummed.empty()) return bytes;  // no file
  if (recipe[1] % 8 != 1) mend_sums(bytes, base.checksummed);
  return recipe[1] % 16 == 2 ? bytes : bytes + store::seal_of(bytes);
}

}  // namespace vrda::test
