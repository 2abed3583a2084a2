// What a table of a motion states.
#include "tables/motion_table.hpp"

#include <gtest/gtest.h>

#include "store/motion_model.hpp"

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

}  // namespace vrda::tables::motion_table_test
