#include <gtest/gtest.h>
#include <igtlPositionMessage.h>
#include <igtlQuaternionTrackingDataMessage.h>
#include <igtlStatusMessage.h>
#include <igtlTrackingDataMessage.h>
#include <igtlTransformMessage.h>

#include <algorithm>
#include <limits>
#include <random>

#include "bench/igtl_message.hpp"
#include "core/text.hpp"

namespace vrda::igtl_test {

using Bytes = std::vector<std::uint8_t>;

constexpr std::uint32_t seconds = 1'700'000'000, fraction = 0x40000000;  // a quarter of a second
constexpr std::int64_t stamp_ns = 1'700'000'000'250'000'000;

Pose turned_pose()
{
  Pose X = Pose::Identity();
  X.linear() = Eigen::Quaterniond(0.5, 0.1, -0.7, 0.5).normalized().toRotationMatrix();
  X.translation() = Eigen::Vector3d(12.5, -340.125, 2001.75);  // exact in float32
  return X;
}

bench::IgtlMessage message_with(bench::IgtlKind kind, const std::vector<std::string>& names)
{
  bench::IgtlMessage message;
  message.kind = kind;
  message.device = names.size() == 1 ? names[0] : "Tracker";
  message.device_ns = stamp_ns;
  for (const std::string& name : names) {
    bench::IgtlTool tool{name};
    tool.X_tracker_tool = turned_pose();
    tool.X_tracker_tool.translation().x() += static_cast<double>(message.tools.size());
    message.tools.push_back(tool);
  }
  return message;
}

template <class Message>
Bytes packed(Message& message, const char* device)
{
  message->SetDeviceName(device);
  message->SetTimeStamp(seconds, fraction);
  message->Pack();
  const auto* at = static_cast<const std::uint8_t*>(message->GetPackPointer());
  return {at, at + message->GetPackSize()};
}

template <class Element>
void set_matrix(Element& element, const Pose& X)
{
  ::igtl::Matrix4x4 matrix;
  for (int r = 0; r < 4; ++r) {
    for (int c = 0; c < 4; ++c) matrix[r][c] = static_cast<float>(X.matrix()(r, c));
  }
  element->SetMatrix(matrix);
}

template <class Element>
void set_place(Element& element, const Pose& X)
{
  const Eigen::Vector3f p = X.translation().cast<float>();
  const Eigen::Vector4f q = Eigen::Quaterniond(Eigen::Matrix3d(X.linear())).coeffs().cast<float>();
  element->SetPosition(p.x(), p.y(), p.z());
  element->SetQuaternion(q(0), q(1), q(2), q(3));
}

TEST(IgtlMessage, PosesAreWrittenAsTheLibraryWritesThem)
{
  const ::igtl::TransformMessage::Pointer transform = ::igtl::TransformMessage::New();
  set_matrix(transform, turned_pose());
  EXPECT_EQ(bench::bytes_of(message_with(bench::IgtlKind::transform, {"Femur"})), packed(transform, "Femur"));
  const ::igtl::PositionMessage::Pointer position = ::igtl::PositionMessage::New();
  set_place(position, turned_pose());
  EXPECT_EQ(bench::bytes_of(message_with(bench::IgtlKind::position, {"Femur"})), packed(position, "Femur"));
}

/// The library leaves the reserved byte of each element, after its name and type, uninitialised.
Bytes with_reserved_bytes_zero(Bytes bytes, std::size_t element_bytes)
{
  for (std::size_t at = bench::igtl_header_bytes; at < bytes.size(); at += element_bytes) bytes[at + 21] = 0;
  const std::uint64_t crc = bench::igtl_crc(std::span(bytes).subspan(bench::igtl_header_bytes));
  for (std::size_t k = 0; k < 8; ++k) bytes[50 + k] = static_cast<std::uint8_t>(crc >> (56 - 8 * k));
  return bytes;
}

TEST(IgtlMessage, ListsOfToolsAreWrittenAsTheLibraryWritesThem)
{
  const bench::IgtlMessage tdata = message_with(bench::IgtlKind::tdata, {"Femur", "Tibia"});
  const bench::IgtlMessage qtdata = message_with(bench::IgtlKind::qtdata, {"Femur", "Tibia"});
  const ::igtl::TrackingDataMessage::Pointer oracle = ::igtl::TrackingDataMessage::New();
  const ::igtl::QuaternionTrackingDataMessage::Pointer q_oracle =
      ::igtl::QuaternionTrackingDataMessage::New();
  for (const bench::IgtlTool& tool : tdata.tools) {
    ::igtl::TrackingDataElement::Pointer element = ::igtl::TrackingDataElement::New();
    ::igtl::QuaternionTrackingDataElement::Pointer q_element = ::igtl::QuaternionTrackingDataElement::New();
    element->SetName(tool.name.c_str());
    q_element->SetName(tool.name.c_str());
    element->SetType(::igtl::TrackingDataElement::TYPE_6D);
    q_element->SetType(::igtl::QuaternionTrackingDataElement::TYPE_6D);
    set_matrix(element, tool.X_tracker_tool);
    set_place(q_element, tool.X_tracker_tool);
    oracle->AddTrackingDataElement(element);
    q_oracle->AddQuaternionTrackingDataElement(q_element);
  }
  EXPECT_EQ(bench::bytes_of(tdata), with_reserved_bytes_zero(packed(oracle, "Tracker"), 70));
  EXPECT_EQ(bench::bytes_of(qtdata), with_reserved_bytes_zero(packed(q_oracle, "Tracker"), 50));
}

TEST(IgtlMessage, RequestsAndStatusAreWrittenAsTheLibraryWritesThem)
{
  bench::IgtlMessage start = message_with(bench::IgtlKind::start_tdata, {"Tracker"});
  start.interval_ms = 10;
  start.text = "Patient";
  const ::igtl::StartTrackingDataMessage::Pointer start_oracle = ::igtl::StartTrackingDataMessage::New();
  start_oracle->SetResolution(10);
  start_oracle->SetCoordinateName("Patient");
  EXPECT_EQ(bench::bytes_of(start), packed(start_oracle, "Tracker"));

  const ::igtl::StopTrackingDataMessage::Pointer stop_oracle = ::igtl::StopTrackingDataMessage::New();
  EXPECT_EQ(bench::bytes_of(message_with(bench::IgtlKind::stop_tdata, {"Tracker"})),
            packed(stop_oracle, "Tracker"));

  bench::IgtlMessage started = message_with(bench::IgtlKind::tdata_started, {"Tracker"});
  started.code = 0;
  const ::igtl::RTSTrackingDataMessage::Pointer started_oracle = ::igtl::RTSTrackingDataMessage::New();
  started_oracle->SetStatus(::igtl::RTSTrackingDataMessage::STATUS_SUCCESS);
  EXPECT_EQ(bench::bytes_of(started), packed(started_oracle, "Tracker"));

  bench::IgtlMessage status = message_with(bench::IgtlKind::status, {"Tracker"});
  status.code = 13;
  status.text = "starting up";
  const ::igtl::StatusMessage::Pointer status_oracle = ::igtl::StatusMessage::New();
  status_oracle->SetCode(13);
  status_oracle->SetSubCode(0);
  status_oracle->SetErrorName("Error");
  status_oracle->SetStatusString("starting up");
  EXPECT_EQ(bench::bytes_of(status), packed(status_oracle, "Tracker"));
}

std::vector<bench::IgtlMessage> read(const Bytes& bytes)
{
  bench::IgtlStream stream;
  stream.add(bytes);
  std::vector<bench::IgtlMessage> messages;
  while (std::optional<bench::IgtlMessage> message = stream.next()) messages.push_back(*message);
  EXPECT_EQ(stream.error_message(), "");
  return messages;
}

/// float32 has 24 bits: entries of rotations within 2^-24, the translations here exactly; projection to a
/// rotation changes it by at most the same again. Quaternions enter the matrix by up to four products.
constexpr double storage = 4.0 / (1 << 24);

TEST(IgtlMessage, ReadsBackWhatWasWritten)
{
  for (const bench::IgtlKind kind : {bench::IgtlKind::transform, bench::IgtlKind::position,
                                     bench::IgtlKind::tdata, bench::IgtlKind::qtdata}) {
    for (const int version : {1, 2}) {
      SCOPED_TRACE(std::to_string(static_cast<int>(kind)) + " in header version " + std::to_string(version));
      const bool is_list = kind == bench::IgtlKind::tdata || kind == bench::IgtlKind::qtdata;
      bench::IgtlMessage message =
          message_with(kind, is_list ? std::vector<std::string>{"Femur", "Tibia", "exactly-20-bytes-lng"}
                                     : std::vector<std::string>{"Femur"});
      message.header_version = version;
      const std::vector<bench::IgtlMessage> back = read(bench::bytes_of(message));
      ASSERT_EQ(back.size(), 1U);
      EXPECT_EQ(back[0].kind, kind);
      EXPECT_EQ(back[0].header_version, version);
      EXPECT_EQ(back[0].device, message.device);
      EXPECT_EQ(back[0].device_ns, stamp_ns);
      ASSERT_EQ(back[0].tools.size(), message.tools.size());
      for (std::size_t k = 0; k < message.tools.size(); ++k) {
        EXPECT_EQ(back[0].tools[k].name, message.tools[k].name);
        EXPECT_EQ(back[0].tools[k].visibility, bench::ToolVisibility::seen);
        const Pose &X = back[0].tools[k].X_tracker_tool, &wanted = message.tools[k].X_tracker_tool;
        EXPECT_EQ(Eigen::Vector3d(X.translation()), Eigen::Vector3d(wanted.translation()));
        EXPECT_LT((X.linear() - wanted.linear()).cwiseAbs().maxCoeff(), storage);
      }
    }
  }
}

TEST(IgtlMessage, TimeStampsComeBackToTheNanosecond)
{
  for (const std::int64_t ns :
       {0LL, 1LL, 2LL, 999'999'999LL, 1'000'000'000LL, 123'456'789LL, 4'294'967'295'999'999'999LL}) {
    bench::IgtlMessage message = message_with(bench::IgtlKind::transform, {"Femur"});
    message.device_ns = ns;
    EXPECT_EQ(read(bench::bytes_of(message)).at(0).device_ns, ns);
  }
}

TEST(IgtlMessage, AToolThatIsMissingIsLeftOutOfListsAndSaidByMetaData)
{
  bench::IgtlMessage list = message_with(bench::IgtlKind::tdata, {"Femur", "Tibia"});
  list.tools[0].visibility = bench::ToolVisibility::missing;
  const std::vector<bench::IgtlMessage> back = read(bench::bytes_of(list));
  ASSERT_EQ(back.at(0).tools.size(), 1U);
  EXPECT_EQ(back[0].tools[0].name, "Tibia");

  bench::IgtlMessage one = message_with(bench::IgtlKind::transform, {"Femur"});
  one.tools[0].visibility = bench::ToolVisibility::missing;
  EXPECT_THROW(bench::bytes_of(one), InternalError);
  one.header_version = 2;
  EXPECT_EQ(read(bench::bytes_of(one)).at(0).tools.at(0).visibility, bench::ToolVisibility::missing);
}

TEST(IgtlMessage, APoseWithNumbersThatAreNotFiniteIsInvalid)
{
  for (const bench::IgtlKind kind : {bench::IgtlKind::transform, bench::IgtlKind::position,
                                     bench::IgtlKind::tdata, bench::IgtlKind::qtdata}) {
    bench::IgtlMessage message = message_with(kind, {"Femur"});
    message.tools[0].visibility = bench::ToolVisibility::invalid_pose;
    EXPECT_EQ(read(bench::bytes_of(message)).at(0).tools.at(0).visibility,
              bench::ToolVisibility::invalid_pose);
    message.tools[0].visibility = bench::ToolVisibility::seen;
    constexpr double one_km_mm = 1e6;
    for (const double y_mm : {std::numeric_limits<double>::infinity(), one_km_mm, -one_km_mm}) {
      message.tools[0].X_tracker_tool.translation().y() = y_mm;
      EXPECT_EQ(read(bench::bytes_of(message)).at(0).tools.at(0).visibility,
                bench::ToolVisibility::invalid_pose);
    }
  }
}

/// Matrices with three decimals pass and are made rotations; a scale of a thousandth and a mirror do not.
TEST(IgtlMessage, OnlyRotationsAreSeen)
{
  const Pose wanted = turned_pose();
  bench::IgtlMessage message = message_with(bench::IgtlKind::transform, {"Femur"});
  const auto read_with = [&](double scale, double last_column) {
    message.tools[0].X_tracker_tool.linear() = scale * wanted.linear();
    message.tools[0].X_tracker_tool.linear().col(2) *= last_column;
    return read(bench::bytes_of(message)).at(0).tools.at(0);
  };
  // R^T R - I of a scale 1 + e is 2e.
  const bench::IgtlTool passed = read_with(1.0 + 0.49 * bench::max_rotation_error, 1.0);
  EXPECT_EQ(passed.visibility, bench::ToolVisibility::seen);
  EXPECT_LT((passed.X_tracker_tool.linear() - wanted.linear()).cwiseAbs().maxCoeff(), storage);
  for (const double scale : {1.0 + 0.51 * bench::max_rotation_error, 1.001, 0.0, -1.0, 1e200})
    EXPECT_EQ(read_with(scale, 1.0).visibility, bench::ToolVisibility::invalid_pose) << scale;
  EXPECT_EQ(read_with(1.0, -1.0).visibility, bench::ToolVisibility::invalid_pose);
}

TEST(IgtlMessage, ReadsStatusAndRequests)
{
  bench::IgtlMessage said = message_with(bench::IgtlKind::status, {"Tracker"});
  said.code = 18;
  said.text = "lamp\nbroken";
  EXPECT_EQ(read(bench::bytes_of(said)).at(0).text, "lamp?broken");
  said.text = "";
  EXPECT_EQ(read(bench::bytes_of(said)).at(0).text, "Error") << "the name of the error";
  said.interval_ms = -3;
  said.code = 1;
  for (const bench::IgtlKind kind : {bench::IgtlKind::start_tdata, bench::IgtlKind::stop_tdata,
                                     bench::IgtlKind::tdata_started, bench::IgtlKind::status}) {
    said.kind = kind;
    const bench::IgtlMessage back = read(bench::bytes_of(said)).at(0);
    EXPECT_EQ(back.kind, kind);
    EXPECT_EQ(back.interval_ms, kind == bench::IgtlKind::start_tdata ? -3 : 0);
    EXPECT_EQ(back.code, 1);
  }
}

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

}  // namespace vrda::igtl_test
