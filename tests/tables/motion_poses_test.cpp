// Poses of tables under every convention, against rotations composed by Eigen.
#include "tables/imported_model.hpp"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cstdio>

#include "core/units.hpp"
#include "model/coordinates.hpp"
#include "support/refusal.hpp"
#include "support/scratch.hpp"
#include "tables/convention_search.hpp"

namespace vrda::tables::motion_poses_test {

// Products of three rotations of numbers with 17 digits, and 100 mm of lever.
constexpr double rounding = 1e-12;

MotionTable table_of(const std::string& text, const std::string& file = "m.csv",
                     const TableColumns& columns = {})
{
  return motion_table_from_text(file, text, columns);
}

Eigen::Matrix3d turn(char axis, double angle_rad)
{
  return Eigen::AngleAxisd(angle_rad, Eigen::Vector3d::Unit(axis - 'x')).toRotationMatrix();
}

Pose posed(const Eigen::Matrix3d& R, const Eigen::Vector3d& t_mm)
{
  Pose X = Pose::Identity();
  X.linear() = R;
  X.translation() = t_mm;
  return X;
}

void expect_near(const Pose& a, const Pose& b, double tolerance = rounding)
{
  EXPECT_LE((a.matrix() - b.matrix()).cwiseAbs().maxCoeff(), tolerance) << a.matrix() << "\n\n" << b.matrix();
}

Pose only_pose(const MotionTable& table, const Convention& convention, const JointFrame& joint = {})
{
  return poses_of(table, convention, joint).at(0);
}

TEST(MotionPoses, EveryOrderUnitAndDirection)
{
  const double angle[3] = {0.3, -0.7, 1.1};
  for (const AngleOrder order : all_orders) {
    const char* name = name_of(order);
    SCOPED_TRACE(name);
    Eigen::Matrix3d R = Eigen::Matrix3d::Identity();
    for (int k = 0; k < 3; ++k) R = Eigen::Matrix3d(R * turn(name[k], angle[name[k] - 'x']));
    const Pose wanted = posed(R, {12.0, -34.0, 5.0});
    Convention c;
    c.order = order;
    c.angles = AngleUnit::radians;
    c.length_mm = 10.0;
    expect_near(only_pose(table_of("rx,ry,rz,tx,ty,tz\n0.3,-0.7,1.1,1.2,-3.4,0.5\n"), c), wanted);
    c.direction = Direction::reference_in_moving;
    expect_near(only_pose(table_of("rx,ry,rz,tx,ty,tz\n0.3,-0.7,1.1,1.2,-3.4,0.5\n"), c), wanted.inverse());
    c = {};
    c.order = order;
    char row[200];
    std::snprintf(row, sizeof row, "xrot,yrot,zrot,x,y,z\n%.17g,%.17g,%.17g,12,-34,5\n", deg_from_rad(0.3),
                  deg_from_rad(-0.7), deg_from_rad(1.1));
    expect_near(only_pose(table_of(row), c), wanted);
  }
}

TEST(MotionPoses, TheOtherSideIsTheMirrorImage)
{
  const Eigen::Vector3d m(1.0, 1.0, -1.0);
  const MotionTable table = table_of("rx,ry,rz,tx,ty,tz\n10,20,30,1,2,3\n");
  for (const Side joint_side : {Side::right, Side::left}) {
    JointFrame joint;
    joint.side = joint_side;
    Convention c;
    c.side = joint_side;
    const Pose same = only_pose(table, c, joint);
    c.side = joint_side == Side::right ? Side::left : Side::right;
    const Pose other = only_pose(table, c, joint);
    expect_near(other,
                posed(m.asDiagonal() * same.linear() * m.asDiagonal(), m.cwiseProduct(same.translation())));
  }
}

TEST(MotionPoses, ClinicalNumbersAreThoseOfThePoseOnBothSides)
{
  for (const Side side : {Side::right, Side::left}) {
    JointFrame joint;
    joint.side = side;
    joint.rotation_centre_mm = {3.0, -20.0, 7.0};
    for (const char* lengths : {"anterior_mm,proximal_mm,lateral_mm", "ant_mm,prox_mm,lat_mm"}) {
      SCOPED_TRACE(lengths);
      const MotionTable table = table_of(std::string("flexion_deg,varus_deg,internal_deg,") + lengths +
                                         "\n60,-4,12,3.5,-1.25,0.75\n");
      const Pose X = only_pose(table, completed({}, table.stated, side), joint);
      const ClinicalCoordinates c = clinical_coordinates(X, side, joint.rotation_centre_mm);
      EXPECT_NEAR(deg_from_rad(c.flexion_rad), 60.0, rounding * 100);
      EXPECT_NEAR(deg_from_rad(c.varus_rad), -4.0, rounding * 100);
      EXPECT_NEAR(deg_from_rad(c.internal_rotation_rad), 12.0, rounding * 100);
      const bool is_grood_suntay = table.stated.lengths == LengthPoint::grood_suntay;
      EXPECT_EQ(is_grood_suntay, lengths[3] == 'e');
      const Eigen::Vector3d found =
          is_grood_suntay ? Eigen::Vector3d(c.anterior_mm, c.proximal_mm, c.lateral_mm) : X.translation();
      const double to_lateral = !is_grood_suntay && side == Side::left ? -1.0 : 1.0;
      EXPECT_LE((found - Eigen::Vector3d(3.5, -1.25, to_lateral * 0.75)).norm(), 100 * rounding);
    }
  }
}

TEST(MotionPoses, LengthsOfTheCentreAreItsDisplacement)
{
  JointFrame joint;
  joint.rotation_centre_mm = {30.0, -200.0, 7.0};
  Convention c;
  c.lengths = LengthPoint::centre;
  for (const Direction direction : {Direction::moving_in_reference, Direction::reference_in_moving}) {
    c.direction = direction;
    Pose X = only_pose(table_of("rx,ry,rz,tx,ty,tz\n10,20,30,1,2,3\n"), c, joint);
    if (direction == Direction::reference_in_moving) X = X.inverse();
    const Eigen::Vector3d moved_mm = X * joint.rotation_centre_mm - joint.rotation_centre_mm;
    EXPECT_LE((moved_mm - Eigen::Vector3d(1, 2, 3)).norm(), 1e3 * rounding);
  }
}

TEST(MotionPoses, AxesOfTheFilesGoThroughTheFramesOfTheJob)
{
  JointFrame joint;
  joint.X_canonical_reference = posed(turn('y', 0.5), {10, 20, 30});
  joint.X_canonical_moving = posed(turn('x', -1.2), {-7, 3, 400});
  const Pose native = posed(turn('x', 0.2) * turn('y', 0.3) * turn('z', 0.4), {1, 2, 3});
  Convention c;
  c.axes = TableAxes::files;
  c.order = AngleOrder::xyz;
  c.angles = AngleUnit::radians;
  const MotionTable table = table_of("rx,ry,rz,tx,ty,tz\n0.2,0.3,0.4,1,2,3\n");
  expect_near(only_pose(table, c, joint),
              joint.X_canonical_reference * native * joint.X_canonical_moving.inverse(), 1e3 * rounding);
  c.direction = Direction::reference_in_moving;
  expect_near(only_pose(table, c, joint),
              joint.X_canonical_reference * native.inverse() * joint.X_canonical_moving.inverse(),
              1e3 * rounding);
}

constexpr const char* matrix_names = "frame,T11,T12,T13,T14,T21,T22,T23,T24,T31,T32,T33,T34\n";

TEST(MotionPoses, MatricesAreRowByRowAndBecomeRotations)
{
  // A quarter turn about Z, its entries filtered apart by 2e-3.
  const MotionTable table = table_of(std::string(matrix_names) + "7,0,-1.002,0,5,1,0,0,6,0,0,0.999,7\n");
  EXPECT_EQ(table.key, std::vector<double>{7});
  EXPECT_EQ(table.key_name, "frame");
  Convention c;
  c.length_mm = 1000.0;
  const Pose X = only_pose(table, c);
  expect_near(X, posed(turn('z', pi / 2), {5000, 6000, 7000}));
  const test::Scratch scratch;
  const std::string file = scratch.write("m.csv", std::string(matrix_names) + "7,0,-1,0,5,1,0,0,6,0,0,1,7\n");
  const MotionSequence motion = read_motion(file);
  EXPECT_EQ(motion.key, std::vector<double>{7});
  expect_near(motion.X_reference_moving.at(0), posed(turn('z', pi / 2), {5, 6, 7}));
}

TEST(MotionPoses, TwoBodiesInACommonFrameGiveTheirRelativePose)
{
  const Pose reference = posed(turn('x', 1.0), {100, 200, 300}), relative = posed(turn('z', -0.5), {1, 2, 3});
  const Pose moving = reference * relative;
  const auto row = [](const Pose& X, int n, const char* separator) {
    std::string text;
    for (int k = 0; k < n; ++k) {
      char number[40];
      std::snprintf(number, sizeof number, "%s%.17g", k == 0 ? "" : separator, X.matrix()(k / 4, k % 4));
      text += number;
    }
    return text;
  };
  const test::Scratch scratch;
  const std::string reference_row = row(reference, 16, ",") + "\n", moving_row = row(moving, 16, ",") + "\n";
  const std::string a = scratch.write("a.tra", reference_row + reference_row);
  const std::string b = scratch.write("b.tra", moving_row + moving_row);
  MotionConvention convention;
  convention.columns.reference_file = a;
  const MotionSequence motion = read_motion(b, convention);
  EXPECT_EQ(motion.key, (std::vector<double>{1, 2}));
  expect_near(motion.X_reference_moving.at(1), relative, 1e3 * rounding);
  scratch.write("a.tra", reference_row);
  EXPECT_THAT(test::input_error([&] { read_motion(b, convention); }),
              test::refuses({a, "", "1 frames", "2 frames"}));

  std::string names = "time";
  for (const char* prefix : {"femur_", "tibia_"})
    for (int k = 0; k < 12; ++k)
      names += std::string("\t") + prefix + "T" + std::to_string(k / 4 + 1) + std::to_string(k % 4 + 1);
  const std::string numbers = "0.5\t" + row(reference, 12, "\t") + "\t" + row(moving, 12, "\t");
  TableColumns columns;
  columns.reference_prefix = "femur_";
  columns.moving_prefix = "tibia_";
  const MotionTable both =
      table_of("nRows=99\nendheader\n" + names + "\n" + numbers + "\n", "m.sto", columns);
  EXPECT_EQ(both.key_name, "time_s");
  expect_near(only_pose(both, {}), relative, 1e3 * rounding);
}

// Flexion, varus and internal rotation of a walk, from `first` to `last`, in the unit of the file.
std::string walk(const std::array<double, 3>& first, const std::array<double, 3>& last)
{
  std::string text = "flexion,varus,internal,tx,ty,tz\n";
  for (int k = 0; k <= 4; ++k) {
    for (std::size_t c = 0; c < 3; ++c) text += std::to_string(first[c] + k * (last[c] - first[c]) / 4) + ",";
    text += "0,0,0\n";
  }
  return text;
}

TEST(UnitWarnings, AnImplausibleUnitIsRefusedOrNamed)
{
  using enum AngleUnit;
  struct Row {
    std::array<double, 3> first, last;  // flexion, varus, internal
    AngleUnit unit;
    std::optional<bool> has_large_flexion;
    int expected;  // warnings; -1: refused
  };
  for (const Row& row :
       {Row{{0, 0.01, 0}, {1.57, 0.06, 0.3}, degrees, true, -1},       // all in radians
        Row{{0, 0.01, 0}, {1.57, 0.06, 0.3}, degrees, false, -1},      //
        Row{{0, 0.01, 0}, {2.44, 0.06, 0.3}, degrees, true, 1},        // or a motion of two degrees
        Row{{0, 1, 0}, {1.57, 3, 15}, degrees, true, -1},              // flexion in radians
        Row{{0, 1, 0}, {1.57, 3, 15}, degrees, {}, -1},                // the joint is not known
        Row{{0, 1, 0}, {2.44, 3, 15}, degrees, true, 1},               //
        Row{{0, 1, 0}, {1.57, 3, 15}, degrees, false, 0},              // a subtalar joint
        Row{{-2.2, -13, -8}, {0.5, -1.7, -3.3}, degrees, {}, 0},       // 04, against another table
        Row{{-2.2, -13, -8}, {0.5, -1.7, -3.3}, degrees, false, 0},    // subtalar 04
        Row{{0, 0.01, 0}, {90, 0.06, 15}, degrees, true, 1},           // varus in radians
        Row{{0, 1, 0}, {90, 3, 0.26}, degrees, true, 1},               // internal rotation in radians
        Row{{5.3, 0.55, -0.2}, {16.2, -1.1, -4.3}, degrees, true, 0},  // a replaced knee
        Row{{0, 0, 0}, {120, 0, 0}, degrees, true, 0},                 // a hinge
        Row{{0, -0.5, 0}, {90, 3.2, 3}, degrees, true, 0},             // small, but measured so
        Row{{0.5, 0.02, 0.1}, {0.5, 0.02, 0.1}, degrees, true, 1},     // a posture, perhaps in radians
        Row{{0, 0, 0}, {0, 0, 0}, degrees, true, 0},                   // meshes in their pose
        Row{{0, 1, 0}, {90, 3, 15}, radians, true, -1},                // all in degrees
        Row{{0, 0.01, 0}, {1.57, 0.06, 15}, radians, true, -1},        // internal rotation in degrees
        Row{{0, 0.01, 0}, {5, 0.06, 0.2}, radians, true, 1},           // five degrees?
        Row{{0, 0.01, 0}, {2.4, 0.06, 0.3}, radians, true, 0}}) {
    SCOPED_TRACE(testing::PrintToString(row.last) + name_of(row.unit));
    const MotionTable table = table_of(walk(row.first, row.last));
    JointFrame joint;
    joint.has_large_flexion = row.has_large_flexion;
    const auto warnings = [&](UnitSource source) {
      return static_cast<int>(unit_warnings(table, row.unit, source, joint).size());
    };
    int found = -1;
    try {
      found = warnings(UnitSource::file);
    } catch (const InputError& error) {
      EXPECT_THAT(error.facts(), test::refuses({"m.csv",
                                                row.unit == radians ? "column internal" : "column flexion",
                                                "57.2958",
                                                {"--angles rad", "--angles deg"}}));
    }
    EXPECT_EQ(found, row.expected);
    // Whoever states the unit is believed, with a warning.
    EXPECT_EQ(warnings(UnitSource::option) > 0, row.expected != 0);
    EXPECT_EQ(warnings(UnitSource::found) > 0, row.expected != 0);
  }
}

TEST(UnitWarnings, AnAssumedUnitIsSaid)
{
  const MotionTable table = table_of(walk({0, 1, 0}, {90, 3, 15}));
  EXPECT_EQ(unit_warnings(table, AngleUnit::degrees, UnitSource::assumed, {}).size(), 1u);
  MotionTable stated = table;
  stated.stated.angles = AngleUnit::radians;  // but the user says otherwise
  EXPECT_EQ(unit_warnings(stated, AngleUnit::degrees, UnitSource::option, {}).size(), 1u);
}

}  // namespace vrda::tables::motion_poses_test
