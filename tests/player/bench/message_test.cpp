#include <gtest/gtest.h>
#include <igtlPositionMessage.h>
#include <igtlQuaternionTrackingDataMessage.h>
#include <igtlStatusMessage.h>
#include <igtlTrackingDataMessage.h>
#include <igtlTransformMessage.h>

#include <limits>

#include "bench/igtl_message.hpp"
#include "core/text.hpp"

namespace vrda::message_test {

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

// Dyadic cosine and sine would not be a rotation; 3-4-5 is one to rounding.
Eigen::Matrix3d rotation()
{
  Eigen::Matrix3d R;
  R << 0.6, -0.8, 0.0, 0.8, 0.6, 0.0, 0.0, 0.0, 1.0;
  return R;
}

constexpr double rounding = 4.0 * std::numeric_limits<double>::epsilon();

TEST(NearestRotation, OfARotationTimesASymmetricMatrixIsTheRotation)
{
  // The polar decomposition is unique: R S with S symmetric and positive gives R back.
  Eigen::Matrix3d S;
  S << 1.0005, 1e-4, -2e-4, 1e-4, 0.9998, 3e-4, -2e-4, 3e-4, 1.0002;
  const std::optional<Eigen::Matrix3d> R = bench::corrected_rotation(rotation() * S);
  ASSERT_TRUE(R);
  EXPECT_LT((*R - rotation()).cwiseAbs().maxCoeff(), rounding);
}

TEST(NearestRotation, RefusesMatricesThatAreNotRotations)
{
  EXPECT_TRUE(bench::corrected_rotation(rotation()));
  EXPECT_FALSE(bench::corrected_rotation(-rotation()));
  EXPECT_FALSE(bench::corrected_rotation(Eigen::Matrix3d::Zero()));
  Eigen::Matrix3d mirrored = rotation();
  mirrored.col(2) *= -1.0;
  EXPECT_FALSE(bench::corrected_rotation(mirrored));
  // R^T R - I of a scale 1 + e is 2e: three decimals pass, a scale of a thousandth does not.
  EXPECT_TRUE(bench::corrected_rotation((1.0 + 0.49 * bench::max_rotation_error) * rotation()));
  EXPECT_FALSE(bench::corrected_rotation((1.0 + 0.51 * bench::max_rotation_error) * rotation()));
  EXPECT_FALSE(bench::corrected_rotation(1.001 * rotation()));
  for (int k = 0; k < 9; ++k) {
    Eigen::Matrix3d matrix = rotation();
    matrix(k) = std::numeric_limits<double>::quiet_NaN();
    EXPECT_FALSE(bench::corrected_rotation(matrix));
    matrix(k) = std::numeric_limits<double>::infinity();
    EXPECT_FALSE(bench::corrected_rotation(matrix));
    matrix(k) = 1e200;
    EXPECT_FALSE(bench::corrected_rotation(matrix));
  }
}

}  // namespace vrda::message_test
