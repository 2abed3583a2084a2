// What a table of a motion states, and its poses under every convention, against rotations composed by Eigen.
#include <gtest/gtest.h>
#include <Eigen/Geometry>
#include <cstdio>

#include "core/units.hpp"
#include "model/coordinates.hpp"
#include "store/motion_model.hpp"
#include "support/refusal.hpp"
#include "support/scratch.hpp"
#include "tables/convention_search.hpp"
#include "tables/imported_model.hpp"
#include "tables/motion_table.hpp"

namespace vrda::tables::motion_table_test {

MotionTable table_of(const std::string& text, const std::string& file = "m.csv",
                     const TableColumns& columns = {})
{
  return motion_table_from_text(file, text, columns);
}

TEST(MotionTable, NamesStateUnitsAndConvention)
{
  const MotionTable clinical =
      table_of("flexion_rad,varus_rad,internal_rad,ant_cm,prox_cm,lat_cm\n1,2,3,4,5,6\n");
  EXPECT_EQ(clinical.stated.angles, AngleUnit::radians);
  EXPECT_EQ(clinical.stated.length_mm, 10.0);
  EXPECT_EQ(clinical.stated.order, AngleOrder::zxy);
  EXPECT_EQ(clinical.stated.lengths, LengthPoint::origin);
  EXPECT_TRUE(clinical.are_angles_clinical && clinical.are_lengths_clinical);
  EXPECT_EQ(clinical.coordinates.at(0).angle, (std::array<double, 3>{2, 3, -1}));
  EXPECT_EQ(clinical.coordinates.at(0).length, (std::array<double, 3>{4, 5, 6}));

  const MotionTable bare = table_of("rx,ry,rz,x,y,z\n1,2,3,4,5,6\n");
  EXPECT_FALSE(bare.stated.angles || bare.stated.length_mm || bare.stated.order || bare.stated.direction ||
               bare.stated.lengths || bare.stated.side || bare.stated.axes);
  EXPECT_FALSE(bare.are_angles_clinical || bare.are_lengths_clinical);
  EXPECT_EQ(bare.coordinates.at(0).angle, (std::array<double, 3>{1, 2, 3}));
  EXPECT_EQ(bare.key_name, "frame");
  EXPECT_EQ(bare.key, std::vector<double>{1});
}

TEST(MotionTable, AnExportIsReadByItsPoseNotByItsWorldTranslation)
{
  const MotionTable table = table_of(
      "gait_percent,flexion_deg,varus_deg,internal_deg,anterior_mm,proximal_mm,lateral_mm,attitude_flexion_"
      "deg,"
      "attitude_varus_deg,tx_mm,ty_mm,tz_mm,theta_deg,centre_x_mm,centre_y_mm,centre_z_mm\n0.5,1,2,3,4,5,6,7,"
      "8,9,"
      "10,11,12,13,14,15\n");
  ASSERT_TRUE(table.point_mm);
  EXPECT_EQ(*table.point_mm, Eigen::Vector3d(13, 14, 15));
  EXPECT_EQ(table.stated.lengths, LengthPoint::grood_suntay);
  EXPECT_EQ(table.coordinates.at(0).length, (std::array<double, 3>{4, 5, 6}));
  EXPECT_EQ(table.key_name, "gait_percent");
  // The key of an export is its first column whatever its name.
  const MotionTable own = table_of(
      "cycle,flexion_deg,varus_deg,internal_deg,ant_mm,prox_mm,lat_mm,attitude_flexion_deg\n0.5,1,2,3,4,5,6,"
      "7\n");
  EXPECT_EQ(own.key_name, "cycle");
  EXPECT_EQ(own.key, std::vector<double>{0.5});
}

TEST(MotionTable, OpenSimHeadersStateTheUnits)
{
  const std::string names = "time\tknee_flex_l\tknee_add_l\tknee_rot_l\tknee_tx_l\tknee_ty_l\tknee_tz_l\n";
  const std::string row = "0.25\t30\t2\t3\t0.01\t0.02\t0.03\n";
  const MotionTable degrees =
      table_of("a walk\nversion=1\nnRows=1\ninDegrees=yes\n\nendheader\n" + names + row, "m.mot");
  EXPECT_EQ(degrees.stated.angles, AngleUnit::degrees);
  EXPECT_EQ(degrees.stated.length_mm, 1000.0);
  EXPECT_TRUE(degrees.are_angles_clinical);
  EXPECT_FALSE(degrees.are_lengths_clinical);  // knee_tz_l is along Z, medial
  EXPECT_EQ(degrees.key_name, "time_s");
  EXPECT_EQ(degrees.stated.lengths, LengthPoint::origin);  // of a file that names no point
  EXPECT_FALSE(degrees.point_mm);
  const MotionTable centred = table_of(
      "inDegrees=yes\ntranslations=rotation-centre\nrotation_centre_mm=1 -2.5 3\nendheader\n" + names + row,
      "m.mot");
  EXPECT_EQ(centred.stated.lengths, LengthPoint::centre);
  ASSERT_TRUE(centred.point_mm);
  EXPECT_EQ(*centred.point_mm, Eigen::Vector3d(1, -2.5, 3));
  const MotionTable radians = table_of("inDegrees=no\nkey=gait_percent\nendheader\n" + names + row, "m.sto");
  EXPECT_EQ(radians.stated.angles, AngleUnit::radians);
  EXPECT_EQ(radians.key_name, "gait_percent");
  const std::string state = "/jointset/knee_r/knee_";
  const MotionTable states =
      table_of("inDegrees=no\nendheader\ntime\t" + state + "flex_r/value\t" + state + "flex_r/speed\t" +
                   state + "add_r/value\t" + state + "rot_r/value\t" + state + "tx_r/value\t" + state +
                   "ty_r/value\t" + state + "tz_r/value\n0 1 9 2 3 4 5 6\n",
               "m.sto");
  EXPECT_EQ(states.coordinates.at(0).angle, (std::array<double, 3>{2, 3, -1}));
}

constexpr const char* opensim_rows =
    "endheader\ntime\tknee_flex_r\tknee_add_r\tknee_rot_r\tknee_tx_r\tknee_ty_r\tknee_tz_"
    "r\n0\t30\t2\t3\t1\t2\t3\n";

TEST(MotionTable, AHeaderIsReadHoweverItIsSpelled)
{
  using enum AngleUnit;
  struct Row {
    const char* header;
    AngleUnit angles;
    std::size_t n_warnings;
  };
  for (const Row& row : {Row{"inDegrees = no", radians, 0},
                         Row{"inDegrees =no", radians, 0},
                         Row{"in degrees=no", radians, 0},
                         Row{"IN_DEGREES\t=\tNo\t", radians, 0},
                         Row{"in-degrees: off", radians, 0},
                         Row{"inDegrees no", radians, 0},
                         Row{"inDegrees=0,,,", radians, 0},
                         Row{"inDegrees= yes", degrees, 0},
                         Row{"inDegrees=true;", degrees, 0},
                         Row{"inDegrees='1'", degrees, 0},
                         Row{"\"inDegrees=yes\"", degrees, 0},
                         Row{"inDegrees=y\ninDegrees=Yes", degrees, 0},
                         Row{"inDegrees,no", radians, 0},
                         Row{"inDegrees; no", radians, 0},
                         Row{"// inDegrees=no", radians, 1},
                         Row{"; inDegrees=no\n%inDegrees=yes\ninDegrees=y", degrees, 0},
                         Row{"Units: rad\ninDegrees=yes", degrees, 0},
                         Row{"# inDegrees=no", radians, 1},
                         Row{"# inDegrees=no\ninDegrees=yes", degrees, 0},
                         Row{"# Key: blue is left\nUnits are S.I. units: m, "
                             "s\nnRows=1\nnColumns=7\nversion=1\nDataType=double\n"
                             "OpenSimVersion=4.3\nname=a walk\nIf the header has 'inDegrees', angles are in "
                             "degrees.\ninDegrees=no",
                             radians, 0}}) {
    SCOPED_TRACE(row.header);
    const MotionTable table = table_of(row.header + std::string("\n") + opensim_rows, "m.mot");
    EXPECT_EQ(table.stated.angles, row.angles);
    EXPECT_EQ(table.warnings.size(), row.n_warnings);
  }
  // Names with a unit are nearer to the numbers.
  const MotionTable both = table_of(
      "inDegrees=no\nendheader\nflexion_deg varus_deg internal_deg tx ty tz\n1 2 3 4 5 6\n", "m.mot");
  EXPECT_EQ(both.stated.angles, degrees);
  EXPECT_EQ(both.warnings.size(), 1u);
  const MotionTable table =
      table_of("Translations = Rotation Center\nrotation-center (mm) = (1, -2.5, 3)\nKEY = cycle\n" +
                   std::string(opensim_rows),
               "m.mot");
  EXPECT_EQ(table.stated.lengths, LengthPoint::centre);
  EXPECT_EQ(table.point_mm, Eigen::Vector3d(1, -2.5, 3));
  EXPECT_EQ(table.key_name, "cycle");
}

TEST(MotionTable, AHeaderKeyWithASlipIsNotLostInSilence)
{
  for (const char* slip : {"inDegress=no", "indegree=no", "degrees: no", "translation=mesh-origin",
                           "rotation_centre=1 2 3", "keys=cycle", "key: cycle",
                           // No slips, but about the unit of angles.
                           "Units: rad", "units = Degrees", "angle_unit=\"radians\"", "inRadians=yes",
                           "inDeg=no", "nRows=1 inDegrees=no", "inDegrees->no"}) {
    SCOPED_TRACE(slip);
    const MotionTable table = table_of(slip + std::string("\n") + opensim_rows, "m.mot");
    ASSERT_EQ(table.warnings.size(), 1u);
    EXPECT_EQ(table.warnings[0].find("m.mot: line 1: \""), 0u) << table.warnings[0];
    EXPECT_FALSE(table.stated.angles);
  }
}

TEST(MotionTable, ACommentOfACsvStatesTheUnitWithAWarning)
{
  const std::string rows = "flexion,varus,internal,tx,ty,tz\n1,2,3,4,5,6\n";
  const MotionTable table = table_of("# inDegrees = no\n# convention: ISB\n" + rows);
  EXPECT_EQ(table.stated.angles, AngleUnit::radians);
  EXPECT_EQ(table.warnings.size(), 1u);
  EXPECT_TRUE(table_of("# convention: ISB (deg)\n" + rows).warnings.empty());
  EXPECT_EQ(table_of("# angles: rad\n" + rows).warnings.size(), 1u);
}

TEST(MotionTable, AColumnMayHaveTheOppositeSign)
{
  const std::string rows = "endheader\ntime a knee_add_r knee_rot_r knee_tx_r knee_ty_r z\n0 30 2 3 4 5 6\n";
  struct Row {
    const char *header, *flexion, *tz;
    double rz, length;  // a rotation about Z is -flexion
  };
  for (const Row& row : {Row{"", "a", "z", -30, 6}, Row{"", "-a", "-z", 30, -6}, Row{"", "+a", "z", -30, 6},
                         // The user's sign replaces that of the header.
                         Row{"negated=a z\n", "a", "z", 30, -6}, Row{"negated=a z\n", "-a", "+z", 30, 6},
                         Row{"Negated = a, z;\n", "a", "z", 30, -6}}) {
    SCOPED_TRACE(row.header + std::string(row.flexion));
    TableColumns columns;
    columns.of_coordinate = {
        {"flexion", row.flexion}, {"tx", "knee_tx_r"}, {"ty", "knee_ty_r"}, {"tz", row.tz}};
    const MotionTable table = table_of(row.header + rows, "m.mot", columns);
    EXPECT_EQ(table.coordinates.at(0).angle, (std::array<double, 3>{2, 3, row.rz}));
    EXPECT_EQ(table.coordinates.at(0).length, (std::array<double, 3>{4, 5, row.length}));
  }
  // Of two tables the one without the column has its usual names.
  TableColumns columns;
  columns.of_coordinate = {{"flexion", "-absent"}};
  columns.may_be_absent = true;
  EXPECT_EQ(table_of(opensim_rows, "m.mot", columns).absent_columns, std::vector<std::string>{"absent"});
}

TEST(MotionTable, ColumnsAreNamedByTheUser)
{
  TableColumns columns;
  columns.of_coordinate = {{"flexion", "a"}, {"varus", "b"}, {"internal", "c"},
                           {"tx", "d"},      {"ty", "e"},    {"tz", "f"}};
  columns.key = "Cycle %";
  const MotionTable table = table_of("Cycle %,a,b,c,d,e,f\n1,10,20,30,40,50,60\n", "m.csv", columns);
  EXPECT_EQ(table.key_name, "cycle__");
  EXPECT_TRUE(core::is_key_name(table.key_name));
  EXPECT_EQ(table.coordinates.at(0).angle, (std::array<double, 3>{20, 30, -10}));
  EXPECT_EQ(table.coordinates.at(0).length, (std::array<double, 3>{40, 50, 60}));
}

TEST(MotionTable, AutoscoperRowsMayHaveCommasOrBlanks)
{
  const MotionTable commas = table_of("1,0,0,5,0,1,0,6,0,0,1,7,0,0,0,1\n", "m.tra");
  const MotionTable blanks = table_of("1 0 0 5 0 1 0 6 0 0 1 7\n", "m.tra");
  EXPECT_EQ(commas.matrices, blanks.matrices);
  EXPECT_EQ(commas.matrices.at(0)[7], 6.0);
}

// Products of three rotations of numbers with 17 digits, and 100 mm of lever.
constexpr double rounding = 1e-12;

MotionTable pose_table_of(const std::string& text, const std::string& file = "m.csv",
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
    expect_near(only_pose(pose_table_of("rx,ry,rz,tx,ty,tz\n0.3,-0.7,1.1,1.2,-3.4,0.5\n"), c), wanted);
    c.direction = Direction::reference_in_moving;
    expect_near(only_pose(pose_table_of("rx,ry,rz,tx,ty,tz\n0.3,-0.7,1.1,1.2,-3.4,0.5\n"), c),
                wanted.inverse());
    c = {};
    c.order = order;
    char row[200];
    std::snprintf(row, sizeof row, "xrot,yrot,zrot,x,y,z\n%.17g,%.17g,%.17g,12,-34,5\n", deg_from_rad(0.3),
                  deg_from_rad(-0.7), deg_from_rad(1.1));
    expect_near(only_pose(pose_table_of(row), c), wanted);
  }
}

TEST(MotionPoses, TheOtherSideIsTheMirrorImage)
{
  const Eigen::Vector3d m(1.0, 1.0, -1.0);
  const MotionTable table = pose_table_of("rx,ry,rz,tx,ty,tz\n10,20,30,1,2,3\n");
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
      const MotionTable table = pose_table_of(std::string("flexion_deg,varus_deg,internal_deg,") + lengths +
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
    Pose X = only_pose(pose_table_of("rx,ry,rz,tx,ty,tz\n10,20,30,1,2,3\n"), c, joint);
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
  const MotionTable table = pose_table_of("rx,ry,rz,tx,ty,tz\n0.2,0.3,0.4,1,2,3\n");
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
  const MotionTable table = pose_table_of(std::string(matrix_names) + "7,0,-1.002,0,5,1,0,0,6,0,0,0.999,7\n");
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
      pose_table_of("nRows=99\nendheader\n" + names + "\n" + numbers + "\n", "m.sto", columns);
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
    const MotionTable table = pose_table_of(walk(row.first, row.last));
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
  const MotionTable table = pose_table_of(walk({0, 1, 0}, {90, 3, 15}));
  EXPECT_EQ(unit_warnings(table, AngleUnit::degrees, UnitSource::assumed, {}).size(), 1u);
  MotionTable stated = table;
  stated.stated.angles = AngleUnit::radians;  // but the user says otherwise
  EXPECT_EQ(unit_warnings(stated, AngleUnit::degrees, UnitSource::option, {}).size(), 1u);
}

}  // namespace vrda::tables::motion_table_test
