// [coordinates] and [frames]: roles and values by row.
#include "job/coordinates.hpp"

#include <gmock/gmock.h>

#include <cmath>
#include <tuple>

#include "core/units.hpp"
#include "job/command_jobs.hpp"
#include "job/mesh_text.hpp"
#include "support/scratch.hpp"

namespace vrda::coordinates_test {

using testing::ElementsAre;

constexpr const char* motion =
    "# measured\n"
    "time_s,flexion_deg,internal_deg,ant_mm\n"
    "0.0,10,1,0.5\n"
    "0.1,5,2,0.7\n"
    "0.2,20,-1,\n";

job::Job job_of(const std::string& settings, const std::vector<std::string>& overrides = {})
{
  return job::parse_job("job.toml", test::small_job() + settings, overrides);
}

job::LoadedCoordinates loaded(const std::string& settings, const std::string& table = motion)
{
  const test::Scratch scratch;
  scratch.write("motion.csv", table);
  const job::Job job = job_of(settings);
  EXPECT_TRUE(job.coordinates.has_value());
  return job::load_coordinates(job, *job.coordinates, scratch.path().string());
}

constexpr const char* frames = "[frames]\nfile = \"motion.csv\"\n[coordinates]\n";

TEST(Coordinates, grid)
{
  const job::Job grid = job_of("[grid]\nflexion = { from = 0, to = 90, step = 5 }\nvarus = \"free\"\n");
  const job::Job same =
      job_of("[coordinates]\nflexion = { from = 0, to = 90, step = 5 }\nvarus = \"free\"\n");
  EXPECT_FALSE(same.coordinates);
  EXPECT_EQ(same.grid.flexion_deg, grid.grid.flexion_deg);
  EXPECT_TRUE(same.is_varus_free);
  const job::Job both = job_of(
      "[coordinates]\nflexion = { from = 0, to = 9, step = 3 }\nvarus = { from = -2, to = 2, step = 1 }\n");
  EXPECT_FALSE(both.coordinates);
  EXPECT_THAT(both.grid.varus_deg, ElementsAre(-2, -1, 0, 1, 2));
}

TEST(Coordinates, frames)
{
  const job::LoadedCoordinates c =
      loaded(std::string(frames) +
             "flexion = { column = \"flexion_deg\" }\ninternal = { column = \"internal_deg\" }\n"
             "proximal = -3.5\n");
  EXPECT_EQ(c.rows.key_name, "time_s");
  EXPECT_THAT(c.rows.key, ElementsAre(0.0, 0.1, 0.2));
  EXPECT_THAT(c.grid.flexion_deg, ElementsAre(10.0, 5.0, 20.0));
  EXPECT_THAT(c.grid.varus_deg, ElementsAre(0.0));
  ASSERT_EQ(c.rows.rows.size(), 3U);
  EXPECT_EQ(c.rows.rows[1](0), rad_from_deg(5.0));
  EXPECT_EQ(c.rows.rows[2](2), rad_from_deg(-1.0));
  EXPECT_EQ(c.rows.rows[0](4), -3.5);
  for (const Eigen::Index free : {1, 3, 5}) EXPECT_TRUE(std::isnan(c.rows.rows[0](free)));
  EXPECT_EQ(c.rows.role[0], CoordinateRole::given);
  EXPECT_EQ(c.rows.role[1], CoordinateRole::free);
  ASSERT_EQ(c.inputs.size(), 1U);
  EXPECT_EQ(c.inputs[0].name, "motion.csv");
}

TEST(Coordinates, over_driving)
{
  const std::string push = "[push]\nforce_n = { driving = [-2, 2], value = [100, 300] }\n";
  const job::LoadedCoordinates c =
      loaded(push +
             "[coordinates]\nflexion = \"free\"\nanterior = { from = -2, to = 2, step = 2 }\n"
             "internal = { driving = [-2, 0, 1], value = [4, 8, 10] }\n");
  ASSERT_EQ(c.rows.rows.size(), 3U);
  for (const auto& [row, internal_deg, force_n] :
       {std::tuple(0, 4.0, 100.0), {1, 8.0, 200.0}, {2, 10.0, 300.0}}) {
    const auto i = static_cast<std::size_t>(row);
    EXPECT_EQ(c.rows.rows[i](2), rad_from_deg(internal_deg)) << row;
    EXPECT_NEAR(job::push_at(c.push, Eigen::Vector3d::UnitY(), 0.0, i).force_n.y(), force_n, 1e-12) << row;
  }
  // Over a driving flexion it is the table over flexion.
  const job::Job over = job_of(push),
                 flexion = job_of("[push]\nforce_n = { flexion_deg = [-2, 2], value = [100, 300] }\n");
  EXPECT_EQ(over.push.force_n.flexion_rad, flexion.push.force_n.flexion_rad);
  EXPECT_FALSE(over.push.force_n.is_over_driving);
}

TEST(Coordinates, LoadsMayComeFromColumnsOfTheFrames)
{
  const std::string push =
      "[push]\nforce_n = { columns = [\"push_n\"] }\n[[push.load]]\nname = \"implant\"\nframe = \"moving\"\n"
      "force_n = { columns = [\"fx\", \"push_n\", \"fz\"] }\n";
  const std::string roles = std::string(frames) + "flexion = { column = \"flexion_deg\" }\n";
  const std::string table = "frame,flexion_deg,push_n,fx,fz\n1,0,20,1,2\n2,5,30,3,4\n";
  const job::LoadedCoordinates c = loaded(push + roles, table);
  EXPECT_EQ(c.push.force_n.value(1, 0), 30.0);
  EXPECT_EQ(c.push.loads.at(0).force_n.value(1, 2), 4.0);
  EXPECT_EQ(c.push.loads.at(0).force_n.value(0, 1), 20.0);
}

TEST(Coordinates, linear_table)
{
  const job::LoadedCoordinates c = loaded(
      "[coordinates]\nflexion = { from = 0, to = 30, step = 15 }\n"
      "internal = { file = \"motion.csv\", column = \"internal_deg\" }\n"
      "anterior = { flexion_deg = [0, 30], value = [2, 5] }\n",
      "flexion_deg,internal_deg\n0,0\n10,4\n40,7\n");
  EXPECT_FALSE(c.rows.is_sequence());
  ASSERT_EQ(c.path_flexion_deg.size(), 31U);  // steps of at most 1 degree
  EXPECT_NEAR(c.rows.rows[5](2), rad_from_deg(2.0), 1e-15);
  EXPECT_NEAR(c.rows.rows[25](2), rad_from_deg(5.5), 1e-15);
  EXPECT_NEAR(c.rows.rows[10](3), 3.0, 1e-14);
  EXPECT_EQ(c.rows.rows[15](0), rad_from_deg(15.0));
}

TEST(Coordinates, sequence)
{
  const job::LoadedCoordinates c =
      loaded("[coordinates]\nflexion = 30\ninternal = { from = -10, to = 10, step = 5 }\n");
  EXPECT_EQ(c.rows.key_name, "internal_deg");
  EXPECT_THAT(c.rows.key, ElementsAre(-10, -5, 0, 5, 10));
  EXPECT_THAT(c.grid.flexion_deg, testing::Each(testing::DoubleNear(30.0, 1e-13)));
  EXPECT_EQ(c.rows.rows[3](2), rad_from_deg(5.0));
}

TEST(Coordinates, one_frame)
{
  const job::LoadedCoordinates c = loaded("[coordinates]\nvarus = \"free\"\n");
  EXPECT_EQ(c.rows.key_name, "frame");
  ASSERT_EQ(c.rows.rows.size(), 1U);
  EXPECT_TRUE(c.rows.rows[0].array().isNaN().all());
}

TEST(Coordinates, two_driven)
{
  const job::LoadedCoordinates c = loaded(
      "[coordinates]\nflexion = { from = 0, to = 4, step = 2 }\nvarus = { from = -1, to = 1, step = 1 }\n"
      "internal = 5\n");
  EXPECT_THAT(c.grid.varus_deg, ElementsAre(-1, 0, 1));
  EXPECT_TRUE(std::isnan(c.rows.rows[0](1)));  // the grid's column
  EXPECT_EQ(c.rows.role[1], CoordinateRole::driven);
}

}  // namespace vrda::coordinates_test
