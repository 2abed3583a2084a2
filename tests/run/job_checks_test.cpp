// Parts of a job that are other parts, large meshes, outputs that are links; lines that sum up a model.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <filesystem>

#include "job/job.hpp"
#include "job/mesh_text.hpp"
#include "run/run_command.hpp"
#include "run/run_output.hpp"
#include "support/meshes.hpp"
#include "support/refusal.hpp"
#include "support/scratch.hpp"

namespace vrda::job_checks_test {

// A block of femur above a block of tibia with a sheet of cartilage 5 mm below the femur.
class WrongParts : public testing::Test {
 protected:
  void SetUp() override
  {
    scratch_.write("reference.stl", test::binary_stl(test::box({0, 0, 0}, {50, 40, 70})));
    scratch_.write("moving.stl", test::binary_stl(test::box({0, -60, 0}, {50, 30, 70})));
    scratch_.write("cover.stl", test::binary_stl(test::box({0, -43, 0}, {40, 4, 60})));
    Mesh copy = test::box({0, -60, 0}, {50, 30, 70});
    copy.triangles = copy.triangles.colwise().reverse().eval();
    scratch_.write("copy.stl", test::binary_stl(copy));
  }

  run::CheckedCase checked(const std::string& body, const std::string& file, const std::string& more = "")
  {
    const std::string part = "[[" + body + ".component]]\nname = \"cover\"\nfile = \"" + file +
                             "\"\nmaterial = \"cartilage\"\n" + more;
    const std::string job = scratch_.write("job.toml", test::small_job("", part)).string();
    return run::load_checked_case(job::read_job(job), "");
  }

  test::Scratch scratch_;
};

TEST_F(WrongParts, AThickenedBoneAndItsOwnCartilageArePermitted)
{
  EXPECT_NO_THROW(checked("moving", "copy.stl", "offset_mm = 1\n"));  // a thickened bone
  EXPECT_NO_THROW(checked("moving", "cover.stl"));
}

/// Large meshes take long to read: a line on standard error says so first.
TEST_F(WrongParts, LargeMeshesAreAnnounced)
{
  const job::Job job = job::read_job(scratch_.write("job.toml", test::small_job("", "")).string());
  const std::uintmax_t n_bytes = job::mesh_bytes(job, "");
  EXPECT_EQ(n_bytes, std::filesystem::file_size(scratch_.path() / "reference.stl") +
                         std::filesystem::file_size(scratch_.path() / "moving.stl"));
  const auto announced = [&](std::uintmax_t large_bytes) {
    testing::internal::CaptureStderr();
    run::load_checked_case(job, "", large_bytes);
    return testing::internal::GetCapturedStderr();
  };
  EXPECT_EQ(announced(n_bytes + 1), "");
  EXPECT_EQ(announced(n_bytes), "reading and checking meshes of 0 MB\n");
}

/// Refused before the run writes its journal beside the link.
TEST(ParentFolder, ALinkIntoNoFolderIsRefused)
{
  const test::Scratch scratch;
  const std::filesystem::path link = scratch.path() / "knee.h5";
  std::filesystem::create_symlink("nowhere/knee.h5", link);
  EXPECT_THAT(test::input_error([&] { run::make_parent_folder(link.string()); }),
              test::refuses({"knee.h5", "", "nowhere", "folder that exists"}));
  std::filesystem::create_directory(scratch.path() / "nowhere");
  EXPECT_NO_THROW(run::make_parent_folder(link.string()));
}

// Stable poses at every 5 degrees from -20 to 40, at one varus.
store::MotionModel model_with_border(const std::vector<double>& at_border_deg)
{
  store::MotionModel model;
  for (int i = -4; i <= 8; ++i) model.flexion_deg.push_back(5.0 * i);
  const auto n = static_cast<Eigen::Index>(model.flexion_deg.size());
  model.status = store::GridB::Constant(n, 1, status_stable);
  model.plausibility = store::GridB::Zero(n, 1);
  for (Eigen::Index i = 0; i < n; ++i) {
    if (std::ranges::count(at_border_deg, model.flexion_deg[static_cast<std::size_t>(i)]) > 0)
      model.plausibility(i, 0) = static_cast<std::int8_t>(Plausibility::border_contact);
  }
  return model;
}

TEST(UnsolvedFraction, CountsContactsFarPastTheFirstAtABorder)
{
  struct Row {
    std::vector<double> at_border_deg;
    int n_past;
  };
  for (const Row& row : {Row{{}, 0}, Row{{20, 25, 30}, 0}, Row{{20, 35}, 1}, Row{{20, 25, 30, 35, 40}, 2},
                         Row{{-20, 40}, 0}, Row{{-5, -20, 40}, 1}, Row{{0, 10, 15, -10, -15}, 2}}) {
    SCOPED_TRACE(testing::PrintToString(row.at_border_deg));
    const store::MotionModel model = model_with_border(row.at_border_deg);
    EXPECT_EQ((run::is_past_border(model) == 1).count(), row.n_past);
    EXPECT_NEAR(run::unsolved_fraction(model), row.n_past / 13.0, 1e-12);
  }
  store::MotionModel model = model_with_border({20, 35});
  model.status(0, 0) = static_cast<std::int8_t>(StepStatus::no_contact);
  EXPECT_NEAR(run::unsolved_fraction(model), 2.0 / 13.0, 1e-12);
}

}  // namespace vrda::job_checks_test
