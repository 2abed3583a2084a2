#include "bench/igtl_message.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>

namespace vrda::stream_test {

using Bytes = std::vector<std::uint8_t>;

bench::IgtlMessage transform(std::int64_t ns)
{
  bench::IgtlMessage message;
  message.device = "Femur";
  message.device_ns = ns;
  message.tools.push_back({"Femur"});
  return message;
}

/// A header for any body, with a right checksum; `type` may be unknown to the library.
Bytes message_of_type(const std::string& type, const Bytes& body, int version = 1)
{
  Bytes bytes = bench::bytes_of(transform(1));
  bytes.resize(bench::igtl_header_bytes);
  bytes[1] = static_cast<std::uint8_t>(version);
  std::fill(bytes.begin() + 2, bytes.begin() + 14, std::uint8_t{0});
  std::copy(type.begin(), type.end(), bytes.begin() + 2);
  const std::uint64_t numbers[] = {body.size(), bench::igtl_crc(body)};
  for (int k = 0; k < 16; ++k)
    bytes[static_cast<std::size_t>(42 + k)] = static_cast<std::uint8_t>(numbers[k / 8] >> (56 - 8 * (k % 8)));
  bytes.insert(bytes.end(), body.begin(), body.end());
  return bytes;
}

Bytes& operator+=(Bytes& to, const Bytes& more)
{
  to.insert(to.end(), more.begin(), more.end());
  return to;
}

/// The time stamps of the messages received when the bytes are passed in pieces of `n`.
std::vector<std::int64_t> stamps(bench::IgtlStream& stream, const Bytes& bytes, std::size_t n)
{
  std::vector<std::int64_t> found;
  for (std::size_t at = 0; at < bytes.size(); at += n) {
    stream.add(std::span(bytes).subspan(at, std::min(n, bytes.size() - at)));
    while (const std::optional<bench::IgtlMessage> message = stream.next())
      found.push_back(message->device_ns);
  }
  return found;
}

TEST(IgtlStream, GivesTheSameMessagesHoweverTheBytesAreCut)
{
  Bytes bytes = bench::bytes_of(transform(1));
  bytes += message_of_type("IMAGE", Bytes(5000, 7));
  bytes += bench::bytes_of(transform(2));
  bytes += message_of_type("GET_STATUS", {});
  bytes += bench::bytes_of(transform(3));
  for (std::size_t n :
       {std::size_t{1}, std::size_t{2}, std::size_t{57}, std::size_t{58}, std::size_t{106}, bytes.size()}) {
    SCOPED_TRACE(n);
    bench::IgtlStream stream;
    EXPECT_EQ(stamps(stream, bytes, n), (std::vector<std::int64_t>{1, 2, 3}));
    EXPECT_EQ(stream.n_skipped(), 2U);
    EXPECT_EQ(stream.n_malformed(), 0U);
    EXPECT_FALSE(stream.is_broken());
  }
}

TEST(IgtlStream, AnyChangedBitOfABodyBreaksIt)
{
  const Bytes whole = bench::bytes_of(transform(5));
  for (std::size_t bit = 8 * 50; bit < 8 * whole.size(); ++bit) {  // from the checksum on
    Bytes bytes = whole;
    bytes[bit / 8] ^= static_cast<std::uint8_t>(1U << (bit % 8));
    bench::IgtlStream stream;
    stream.add(bytes);
    EXPECT_FALSE(stream.next());
    EXPECT_EQ(stream.error_message(), "found TRANSFORM with a wrong checksum, wanted CRC64 of its body");
    stream.add(whole);
    EXPECT_FALSE(stream.next()) << "what follows cannot be trusted";
  }
}

TEST(IgtlStream, AChecksumOfZeroIsAcceptedAndCounted)
{
  const auto unchecked = [](Bytes bytes) {
    std::fill(bytes.begin() + 50, bytes.begin() + 58, std::uint8_t{0});
    return bytes;
  };
  Bytes bytes = unchecked(bench::bytes_of(transform(1)));
  bytes += unchecked(message_of_type("IMAGE", Bytes(5000, 7)));
  bytes += message_of_type("GET_STATUS", {});
  bytes += bench::bytes_of(transform(2));
  bench::IgtlStream stream;
  EXPECT_EQ(stamps(stream, bytes, 100), (std::vector<std::int64_t>{1, 2}));
  EXPECT_EQ(stream.n_unchecked(), 2U);
  EXPECT_FALSE(stream.is_broken());
  Bytes wrong = message_of_type("IMAGE", Bytes(5000, 7));
  wrong.back() ^= 1;
  EXPECT_TRUE(stamps(stream, wrong, 100).empty());
  EXPECT_EQ(stream.error_message(), "found IMAGE with a wrong checksum, wanted CRC64 of its body");
}

TEST(IgtlStream, HeadersThatCannotBeOneBreakIt)
{
  struct Row {
    const char* what;
    std::size_t at;
    std::uint8_t byte;
    const char* error_message;
  };
  for (const Row& row :
       {Row{"version", 1, 3, "found header version 3, wanted 1 or 2 of OpenIGTLink"},
        Row{"no type", 2, 0, "found type '', wanted the name of an OpenIGTLink message"},
        Row{"control character", 3, 7, "found type 'T?ANSFORM', wanted the name of an OpenIGTLink message"},
        Row{"huge body", 44, 1, "found TRANSFORM of 1099511627824 bytes, wanted at most 65536"}}) {
    SCOPED_TRACE(row.what);
    Bytes bytes = bench::bytes_of(transform(5));
    bytes[row.at] = row.byte;
    bench::IgtlStream stream;
    stream.add(bytes);
    EXPECT_FALSE(stream.next());
    EXPECT_EQ(stream.error_message(), row.error_message);
  }
  Bytes image = message_of_type("IMAGE", {});
  image[44] = 1;
  bench::IgtlStream stream;
  stream.add(image);
  EXPECT_FALSE(stream.next());
  EXPECT_EQ(stream.error_message(), "found IMAGE of 1099511627776 bytes, wanted at most 4294967296");
}

TEST(IgtlStream, ABodyOfAWrongSizeCostsThatMessageOnly)
{
  struct Row {
    const char* type;
    std::size_t size;
  };
  for (const Row& row : {Row{"TRANSFORM", 47}, Row{"TRANSFORM", 0}, Row{"POSITION", 13}, Row{"POSITION", 29},
                         Row{"TDATA", 71}, Row{"QTDATA", 49}, Row{"STATUS", 29}, Row{"STT_TDATA", 35},
                         Row{"STP_TDATA", 1}, Row{"RTS_TDATA", 2}}) {
    SCOPED_TRACE(row.type);
    Bytes bytes = message_of_type(row.type, Bytes(row.size, 1));
    bytes += bench::bytes_of(transform(9));
    bench::IgtlStream stream;
    EXPECT_EQ(stamps(stream, bytes, bytes.size()), (std::vector<std::int64_t>{9}));
    EXPECT_EQ(stream.n_malformed(), 1U);
    EXPECT_FALSE(stream.is_broken());
  }
}

TEST(IgtlStream, PositionsMayLeaveOutTheQuaternionOrItsLastNumber)
{
  // Built manually: the library's class writes out of bounds for these.
  bench::IgtlMessage message = transform(1);
  message.kind = bench::IgtlKind::position;
  const Eigen::Quaterniond turn(0.8, 0.0, 0.6, 0.0);
  message.tools[0].X_tracker_tool.linear() = turn.toRotationMatrix();
  message.tools[0].X_tracker_tool.translation() = Eigen::Vector3d(1.0, 2.0, 3.0);
  const Bytes whole = bench::bytes_of(message);
  for (const std::size_t size : {std::size_t{12}, std::size_t{24}}) {
    SCOPED_TRACE(size);
    bench::IgtlStream stream;
    const auto body = whole.begin() + static_cast<std::ptrdiff_t>(bench::igtl_header_bytes);
    stream.add(message_of_type("POSITION", {body, body + static_cast<std::ptrdiff_t>(size)}));
    const bench::IgtlTool tool = stream.next().value().tools.at(0);
    EXPECT_EQ(tool.visibility, bench::ToolVisibility::seen);
    EXPECT_EQ(Eigen::Vector3d(tool.X_tracker_tool.translation()), Eigen::Vector3d(1.0, 2.0, 3.0));
    const Eigen::Quaterniond wanted = size == 12 ? Eigen::Quaterniond::Identity() : turn;
    constexpr double storage = 4.0 / (1 << 24);  // float32, in products of up to four
    EXPECT_LT((tool.X_tracker_tool.linear() - wanted.toRotationMatrix()).cwiseAbs().maxCoeff(), storage);
  }
}

/// Header version 2 built manually from the protocol's specification.
Bytes extended(std::uint16_t extended_bytes, std::uint16_t entries_bytes, std::uint32_t values_bytes,
               const Bytes& rest)
{
  Bytes body;
  const auto put = [&body](std::uint64_t value, int n) {
    for (int k = n - 1; k >= 0; --k) body.push_back(static_cast<std::uint8_t>(value >> (8 * k)));
  };
  put(extended_bytes, 2);
  put(entries_bytes, 2);
  put(values_bytes, 4);
  put(77, 4);
  body += rest;
  return body;
}

Bytes identity_body()
{
  const Bytes bytes = bench::bytes_of(transform(1));
  return {bytes.begin() + bench::igtl_header_bytes, bytes.end()};
}

/// Content and one pair of meta data.
Bytes with_pair(const std::string& key, const std::string& value)
{
  Bytes rest = identity_body();
  const auto n_key = static_cast<std::uint8_t>(key.size()), n_value = static_cast<std::uint8_t>(value.size());
  rest += {0, 1, 0, n_key, 0, 3, 0, 0, 0, n_value};
  rest.insert(rest.end(), key.begin(), key.end());
  rest.insert(rest.end(), value.begin(), value.end());
  return extended(12, 10, static_cast<std::uint32_t>(key.size() + value.size()), rest);
}

TEST(IgtlStream, MetaDataSayWhetherAToolWasSeen)
{
  struct Row {
    const char *key, *value;
    bench::ToolVisibility sight;
  };
  for (const Row& row : {Row{"TransformStatus", "OK", bench::ToolVisibility::seen},
                         Row{"TransformStatus", "SWITCH1_IS_ON", bench::ToolVisibility::seen},
                         Row{"TransformStatus", "OUT_OF_VIEW", bench::ToolVisibility::missing},
                         Row{"TransformStatus", "MISSING", bench::ToolVisibility::missing},
                         Row{"TransformValid", "true", bench::ToolVisibility::seen},
                         Row{"TransformValid", "false", bench::ToolVisibility::missing},
                         Row{"Anything", "MISSING", bench::ToolVisibility::seen}}) {
    SCOPED_TRACE(std::string(row.key) + " " + row.value);
    bench::IgtlStream stream;
    stream.add(message_of_type("TRANSFORM", with_pair(row.key, row.value), 2));
    EXPECT_EQ(stream.next().value().tools.at(0).visibility, row.sight);
  }
}

TEST(IgtlStream, AnExtendedHeaderMayBeLongerAndWithoutMetaData)
{
  Bytes rest{1, 2, 3, 4};  // four bytes of the next header
  rest += identity_body();
  bench::IgtlStream stream;
  stream.add(message_of_type("TRANSFORM", extended(16, 0, 0, rest), 2));
  EXPECT_EQ(stream.next().value().tools.at(0).visibility, bench::ToolVisibility::seen);
}

TEST(IgtlStream, ExtendedHeadersThatDoNotFitCostThatMessageOnly)
{
  const Bytes good = with_pair("TransformStatus", "OK");
  struct Row {
    const char* what;
    std::size_t at;
    std::uint8_t byte;
  };
  for (const Row& row :
       {Row{"extended header below 12", 1, 11}, Row{"extended header beyond the body", 0, 255},
        Row{"entries beyond the body", 2, 255}, Row{"meta data beyond the body", 4, 255},
        Row{"more pairs than entries", 12 + 48 + 1, 2}, Row{"a key beyond the meta data", 12 + 48 + 2, 1},
        Row{"a value beyond the meta data", 12 + 48 + 6, 255}, Row{"entries of a byte", 3, 1}}) {
    SCOPED_TRACE(row.what);
    Bytes body = good;
    body[row.at] = row.byte;
    Bytes bytes = message_of_type("TRANSFORM", body, 2);
    bytes += bench::bytes_of(transform(9));
    bench::IgtlStream stream;
    EXPECT_EQ(stamps(stream, bytes, bytes.size()), (std::vector<std::int64_t>{9}));
    EXPECT_EQ(stream.n_malformed(), 1U);
  }
}

}  // namespace vrda::stream_test
