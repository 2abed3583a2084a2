// `offset_mm` of a component: bytes, contact, threads, `vrda fit`.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <nlohmann/json.hpp>

#include "app/scenes.hpp"
#include "store/motion_model.hpp"

namespace vrda::offset_test {

using nlohmann::json;

const std::string key = "reference.component.0.offset_mm";

class Offset : public testing::Test {
 protected:
  std::string path(const std::string& name) const { return (scratch_.path() / name).string(); }

  // The two balls on a dented plate, with the equilibrium as well: both touch at the free varus.
  std::string solved(const std::string& name, const std::vector<std::string>& more)
  {
    std::vector<std::string> words{"run", job_, "-o", path(name), "--progress", "none"};
    words.insert(words.end(), more.begin(), more.end());
    const test::Ended run = test::run_vrda(words);
    EXPECT_EQ(run.exit_code, 0) << run.err;
    return path(name);
  }

  static json printed(const std::vector<std::string>& words, int exit_code = 0)
  {
    const test::Ended ended = test::run_vrda(words);
    EXPECT_EQ(ended.exit_code, exit_code) << ended.err;
    return json::parse(ended.out);
  }

  test::Scratch scratch_;
  std::string job_ = test::small_knee_job(scratch_, "right").string();
};

TEST_F(Offset, OfZeroIsTheJobWithoutTheKey)
{
  const std::string bare = solved("bare.h5", {}), zero = solved("zero.h5", {"--set", key + "=0"});
  EXPECT_EQ(test::read_bytes(bare), test::read_bytes(zero));
}

// The audit measures with Bullet and the directional gap, from the file alone.
TEST_F(Offset, LeavesNeitherOverlapNorGap)
{
  for (const std::string method : {"stability-search", "equilibrium"}) {
    SCOPED_TRACE(method);
    const std::string file =
        solved(method + ".h5", {"--set", key + "=0.8", "--set", "solver.method=\"" + method + "\""});
    EXPECT_EQ(test::run_vrda({"audit", file, "--set", "raw"}).exit_code, 0);
    const store::MotionModel model = store::read_motion_model(file);
    EXPECT_THAT(model.reference.contact.mesh.offset_mm, testing::Each(0.8));
    EXPECT_TRUE(model.moving.contact.mesh.offset_mm.empty());
    ASSERT_EQ(model.audits.size(), 1u);
    EXPECT_EQ(model.audits.front().penetration_mm.maxCoeff(), 0.0);
    EXPECT_LE(model.audits.front().gap_mm.maxCoeff(), model.contact_resolution_mm);
    EXPECT_GT(model.contacts.distance_mm.size(), 0u);
  }
}

TEST_F(Offset, ScalesAsALength)
{
  const store::MotionModel twice =
      store::read_motion_model(solved("twice.h5", {"--set", key + "=0.8", "--set", "scaling.factor=2"}));
  EXPECT_THAT(twice.reference.contact.mesh.offset_mm, testing::Each(1.6));
}

TEST_F(Offset, IsFoundFromASyntheticMotion)
{
  const std::string motion =
      solved("motion.h5", {"--set", key + "=1.3", "--set", "solver.method=\"equilibrium\""});
  const json found = printed({"fit", job_, "--set", key + "=\"fit\"", "--motion", motion, "--rows",
                              "first-half", "-o", path("fitted.toml"), "--json"});
  EXPECT_EQ(found.at("status"), "converged");
  EXPECT_NEAR(found.at("offset_mm"), 1.3, 1e-3);  // gaps of up to the contact resolution of 1e-5 mm remain
  EXPECT_LT(found.at("other_gap_rms_mm"), 1e-3);
  EXPECT_GT(found.at("bare_gap_rms_mm"), 1.0);
  // The file written is a job with the number.
  EXPECT_THAT(test::read_bytes(path("fitted.toml")), testing::HasSubstr("offset_mm = 1.3"));
}

// A motion whose objects never face each other does not depend on the offset.
TEST_F(Offset, IsUndeterminedByAMotionWithoutContact)
{
  std::ofstream(path("aside.csv")) << "frame,flexion_deg,varus_deg,internal_deg,tx_mm,ty_mm,tz_mm\n"
                                      "1,0,0,0,400,-20,0\n2,5,0,0,400,-20,0\n3,8,0,0,400,-20,0\n";
  const json found =
      printed({"fit", job_, "--set", key + "=\"fit\"", "--motion", path("aside.csv"), "--json"}, 3);
  EXPECT_EQ(found.at("status"), "undetermined");
  EXPECT_TRUE(found.at("standard_error_mm").is_null());
}

}  // namespace vrda::offset_test
