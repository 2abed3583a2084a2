// Jobs with roles for the joint's coordinates, from the job to the motion model.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "app/scenes.hpp"
#include "core/units.hpp"
#include "store/motion_model.hpp"

namespace vrda::coordinates_run_test {

namespace fs = std::filesystem;
using testing::ElementsAre;
using testing::IsEmpty;

// Up and down again: flexion neither ascends nor is unique.
constexpr const char* motion =
    "time_s,flexion_deg,internal_deg,lat_mm\n"
    "0.0,0,0.5,0.1\n"
    "0.1,2,0.2,0.0\n"
    "0.2,4,-0.4,-0.1\n"
    "0.3,2,-0.1,0.0\n"
    "0.5,1,0.3,0.2\n";

class CoordinateRun : public testing::Test {
 protected:
  // The knee of two balls with `settings` instead of its grid.
  fs::path job(const std::string& settings, const std::string& method = "equilibrium")
  {
    const fs::path file = test::small_knee_job(scratch_, "right");
    std::string text = test::text_of(file);
    const std::size_t grid = text.find("[grid]"), after = text.find("\n[", grid);
    text = text.substr(0, grid) + settings + (after == std::string::npos ? "" : text.substr(after));
    const std::string search = "method = \"stability-search\"";
    text.replace(text.find(search), search.size(), "method = \"" + method + "\"");
    scratch_.write("motion.csv", motion);
    return scratch_.write("knee.toml", text);
  }

  store::MotionModel solved(const fs::path& file, const std::vector<std::string>& more = {},
                            int exit_code = 0)
  {
    const fs::path output = scratch_.path() / "out.h5";
    std::vector<std::string> words{"run",     file.string(), "-o",     output.string(),
                                   "--fresh", "--replace",   "--quiet"};
    words.insert(words.end(), more.begin(), more.end());
    const test::Ended ended = test::run_vrda(words);
    EXPECT_EQ(ended.exit_code, exit_code) << ended.err;
    EXPECT_THAT(store::validate_hdf5(output.string()), IsEmpty());
    return store::read_motion_model(output.string());
  }

  test::Scratch scratch_;
};

constexpr const char* frames =
    "[frames]\nfile = \"motion.csv\"\n[coordinates]\nflexion = { column = \"flexion_deg\" }\n"
    "internal = { column = \"internal_deg\" }\n";

TEST_F(CoordinateRun, GivenCoordinatesOfFramesAreKept)
{
  const store::MotionModel model = solved(job(frames));
  ASSERT_TRUE(model.frames);
  EXPECT_EQ(model.frames->key_name, "time_s");
  EXPECT_THAT(model.frames->key, ElementsAre(0.0, 0.1, 0.2, 0.3, 0.5));
  ASSERT_EQ((model.status == 0).count(), 5);
  const std::vector<double> flexion{0, 2, 4, 2, 1}, internal{0.5, 0.2, -0.4, -0.1, 0.3};
  for (Eigen::Index i = 0; i < 5; ++i) {
    // Conversion to radians and back.
    EXPECT_NEAR(model.clinical.flexion_deg(i, 0), flexion[static_cast<std::size_t>(i)], 1e-12);
    EXPECT_NEAR(model.clinical.internal_rotation_deg(i, 0), internal[static_cast<std::size_t>(i)], 1e-12);
    EXPECT_LT(std::max(model.gap_medial_mm(i, 0), model.gap_lateral_mm(i, 0)), 1e-4);  // both balls bear
  }
  ASSERT_TRUE(model.coordinates);
  EXPECT_THAT(model.coordinates->role, ElementsAre(1, 2, 1, 2, 2, 2));
  EXPECT_THAT(std::vector<std::int8_t>(model.coordinates->determined.begin(),
                                       model.coordinates->determined.begin() + 6),
              ElementsAre(-1, 1, -1, 1, 1, 1));
  EXPECT_TRUE(std::isnan(model.coordinates->holding_moment_nmm[1]));
  EXPECT_FALSE(std::isnan(model.coordinates->holding_moment_nmm[2]));
}

TEST_F(CoordinateRun, FramesOfOneFlexionAreThoseOfTheGrid)
{
  const store::MotionModel sequence =
      solved(job("[frames]\nfile = \"motion.csv\"\n[coordinates]\nflexion = { column = \"flexion_deg\" }\n"));
  const store::MotionModel grid =
      solved(job("[coordinates]\nflexion = { from = 0, to = 4, step = 1 }\nvarus = \"free\"\n"));
  ASSERT_FALSE(grid.frames);
  const std::vector<Eigen::Index> row{0, 2, 4, 2, 1};
  for (Eigen::Index i = 0; i < 5; ++i) {
    const Eigen::Index k = row[static_cast<std::size_t>(i)];
    // Both end within the tolerance of 1e-4 mm of height, on facets of some 5 mm.
    EXPECT_NEAR(sequence.ty_mm(i, 0), grid.ty_mm(k, 0), 2e-4);
    EXPECT_NEAR(sequence.varus_solved_deg(i, 0), grid.varus_solved_deg(k, 0), 1e-2);
  }
}

TEST_F(CoordinateRun, OneDrivenRotationMakesASequence)
{
  const store::MotionModel model =
      solved(job("[coordinates]\nflexion = 2\ninternal = { from = -2, to = 2, step = 1 }\n"));
  ASSERT_TRUE(model.frames);
  EXPECT_EQ(model.frames->key_name, "internal_deg");
  for (Eigen::Index i = 0; i < 5; ++i)
    EXPECT_NEAR(model.clinical.internal_rotation_deg(i, 0), static_cast<double>(i - 2), 1e-12);
}

TEST_F(CoordinateRun, AHeightThatOverlapsIsANamedStatus)
{
  const store::MotionModel free = solved(job(frames));
  const double bearing = free.clinical.proximal_mm(0, 0);
  const auto with_height = [&](double height_mm) {
    return std::string(frames) + "varus = 0\nproximal = " + std::to_string(height_mm) + "\n";
  };
  const store::MotionModel high = solved(job(with_height(bearing + 3.0)), {}, 3);
  EXPECT_EQ((high.status == static_cast<std::int8_t>(StepStatus::no_clearance)).count(), 5);
  const store::MotionModel low = solved(job(with_height(bearing - 3.0)));
  EXPECT_EQ((low.status == 0).count(), 5);
  EXPECT_NEAR(low.clinical.proximal_mm(2, 0), bearing - 3.0, 1e-6);  // six decimals in the job
}

TEST_F(CoordinateRun, TheSearchKeepsWhatIsGiven)
{
  const std::string roles = "varus = 1\nlateral = { column = \"lat_mm\" }\n";
  const store::MotionModel model = solved(job(frames + roles, "stability-search"));
  ASSERT_EQ((model.status == 0).count(), 5);
  const std::vector<double> lateral{0.1, 0.0, -0.1, 0.0, 0.2};
  for (Eigen::Index i = 0; i < 5; ++i) {
    EXPECT_NEAR(model.clinical.varus_deg(i, 0), 1.0, 1e-12);
    EXPECT_NEAR(model.clinical.lateral_mm(i, 0), lateral[static_cast<std::size_t>(i)], 2e-3);
  }
}

TEST_F(CoordinateRun, CommandsTakeFrames)
{
  solved(job(frames));
  const std::string model = scratch_.path() / "out.h5";
  for (const std::vector<std::string>& words :
       {std::vector<std::string>{"info", model}, {"audit", model}, {"validate", model}})
    EXPECT_EQ(test::run_vrda(words).exit_code, 0);
}

}  // namespace vrda::coordinates_run_test
