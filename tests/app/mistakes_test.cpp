// Typical mistakes and implausible inputs of a new job: mistakes.json has the edits, and the key, the number
// and the remedy that one line of a check must name. A run prints and keeps the warnings of a check.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <cstring>
#include <functional>
#include <map>
#include <random>
#include <sstream>

#include "app/scenes.hpp"
#include "core/text.hpp"
#include "store/motion_model.hpp"
#include "support/messages.hpp"
#include "support/refusal_table.hpp"

namespace vrda::mistakes_test {

namespace fs = std::filesystem;
using test::Scratch;

const std::vector<std::string> meshes{"femur.stl", "tibia.stl", "meniscus_medial.stl",
                                      "meniscus_lateral.stl"};

/// The files of the generated knee; their job is in mistakes.json.
void shape_knee(const Scratch& scratch, const std::string& resolution = "resolution=1")
{
  EXPECT_EQ(
      test::run_vrda({"shape", "knee", "--ligaments", "-o", scratch.path().string(), resolution}).exit_code,
      0);
}

/// Made once and copied.
void knee(const Scratch& scratch)
{
  static const auto made = [] {
    auto folder = std::make_unique<Scratch>();
    shape_knee(*folder);
    return folder;
  }();
  fs::copy(made->path(), scratch.path());
}

using Corner = std::array<float, 3>;

/// Changes the corners of a mesh, those at one place in the same way.
void change_mesh(const Scratch& scratch, const std::string& name, const std::function<void(Corner&)>& change)
{
  std::string bytes = test::read_bytes(scratch.path() / name);
  std::map<Corner, Corner> known;
  for (std::size_t at = 84; at < bytes.size(); at += 50) {
    for (std::size_t k = 1; k < 4; ++k) {
      Corner corner{};
      std::memcpy(corner.data(), bytes.data() + at + 12 * k, 12);
      const auto [found, is_new] = known.emplace(corner, corner);
      if (is_new) change(found->second);
      std::memcpy(bytes.data() + at + 12 * k, found->second.data(), 12);
    }
  }
  scratch.write(name, bytes);
}

void scale_meshes(const Scratch& scratch, float factor, const std::vector<std::string>& names = meshes)
{
  for (const std::string& name : names)
    change_mesh(scratch, name, [&](Corner& corner) {
      for (float& value : corner) value *= factor;
    });
}

void add_noise(const Scratch& scratch, double deviation_mm)
{
  std::mt19937 engine;
  change_mesh(scratch, "femur.stl", [&](Corner& corner) {
    std::normal_distribution<double> noise_mm(0.0, deviation_mm);
    for (float& value : corner) value += static_cast<float>(noise_mm(engine));
  });
}

/// Every twentieth triangle of the femur is missing.
void make_holes(const Scratch& scratch)
{
  const std::string bytes = test::read_bytes(scratch.path() / "femur.stl");
  std::string kept = bytes.substr(0, 84);
  for (std::size_t at = 84, k = 0; at < bytes.size(); at += 50, ++k)
    if (k % 20 != 0) kept += bytes.substr(at, 50);
  const auto n = static_cast<std::uint32_t>((kept.size() - 84) / 50);
  std::memcpy(kept.data() + 80, &n, 4);
  scratch.write("femur.stl", kept);
}

/// One vertex of the femur is beyond its opposite side.
void make_spike(const Scratch& scratch)
{
  bool is_made = false;
  change_mesh(scratch, "femur.stl", [&](Corner& corner) {
    if (!is_made && corner[2] > 30.0F) corner[2] = -80.0F, is_made = true;
  });
}

/// Adds triangles to the femur after its own, beside it.
void add_triangles(const Scratch& scratch, const std::vector<std::array<Corner, 3>>& triangles)
{
  std::string bytes = test::read_bytes(scratch.path() / "femur.stl");
  for (const std::array<Corner, 3>& corners : triangles) {
    std::string facet(50, '\0');
    std::memcpy(facet.data() + 12, corners.data(), 36);
    bytes += facet;
  }
  const auto n = static_cast<std::uint32_t>((bytes.size() - 84) / 50);
  std::memcpy(bytes.data() + 80, &n, 4);
  scratch.write("femur.stl", bytes);
}

/// Multiplies a column of the fibres whose name begins with `prefix`; without a column removes them.
void change_fibres(const Scratch& scratch, const std::string& prefix, const std::string& column,
                   double factor)
{
  std::istringstream lines(test::text_of(scratch.path() / "ligaments.csv"));
  std::string text;
  std::size_t changed = 0;
  bool has_heading = false;
  for (std::string line; std::getline(lines, line);) {
    std::vector<std::string> fields;
    std::istringstream row(line);
    for (std::string field; std::getline(row, field, ',');) fields.push_back(field);
    const bool is_comment = line.starts_with("#"), is_heading = !is_comment && !has_heading;
    if (is_heading) {
      has_heading = true;
      changed = static_cast<std::size_t>(std::find(fields.begin(), fields.end(), column) - fields.begin());
    }
    const bool is_chosen = !is_comment && !is_heading && line.starts_with(prefix);
    if (is_chosen && column.empty()) continue;
    if (is_chosen) {
      fields.at(changed) = shortest_decimal(factor * std::stod(fields.at(changed)));
      line.clear();
      for (const std::string& field : fields) line += (line.empty() ? "" : ",") + field;
    }
    text += line + "\n";
  }
  scratch.write("ligaments.csv", text);
}

void mirror_fibres(const Scratch& scratch, const std::string& prefix)
{
  for (const char* column : {"reference_z_mm", "moving_z_mm"}) change_fibres(scratch, prefix, column, -1.0);
}

/// The knee, changed.
auto knee_and(std::function<void(const Scratch&)> change)
{
  return [change = std::move(change)](const Scratch& scratch) {
    knee(scratch);
    change(scratch);
  };
}

auto with_fibres(const std::string& prefix, const std::string& column, double factor)
{
  return knee_and([=](const Scratch& scratch) { change_fibres(scratch, prefix, column, factor); });
}

/// A hip whose head, of radius 24 mm, has a fovea 5 mm deep, moved away from the files' origin.
void hip_with_fovea(const Scratch& scratch)
{
  EXPECT_EQ(test::run_vrda({"shape", "hip", "-o", scratch.path().string()}).exit_code, 0);
  const auto moved = [](Corner& corner) {
    for (std::size_t k = 0; k < 3; ++k) corner[k] += std::array{31.0F, -7.0F, 250.0F}[k];
  };
  change_mesh(scratch, "socket.stl", moved);
  change_mesh(scratch, "head.stl", [&](Corner& corner) {
    const float r = std::hypot(corner[0], corner[1], corner[2]);
    const float along = (-0.3F * corner[0] + 0.8F * corner[1] - 0.5F * corner[2]) / r;
    const float depth_mm = 5.0F * std::max(0.0F, along - 0.9F) / 0.1F;
    if (r < 25.0F)
      for (float& value : corner) value *= 1.0F - depth_mm / r;
    moved(corner);
  });
}

const std::string stiffness = "stiffness_n_per_strain", length = "slack_length_mm";

const test::Scenes scenes{
    {"knee", knee},
    {"knee_in_metres", knee_and([](const Scratch& s) { scale_meshes(s, 0.001F); })},
    {"knee_in_cm", knee_and([](const Scratch& s) { scale_meshes(s, 0.1F); })},
    {"femur_in_metres", knee_and([](const Scratch& s) { scale_meshes(s, 0.001F, {"femur.stl"}); })},
    {"hip_with_fovea", hip_with_fovea},
    {"far_away", knee_and([](const Scratch& s) {
       for (const std::string& name : meshes) change_mesh(s, name, [](Corner& corner) { corner[0] += 1e6F; });
     })},
    // 888 triangles; the mean edge is no longer than that of flat plates in use.
    {"coarse", [](const Scratch& s) { shape_knee(s, "resolution=0.75"); }},
    {"noisy", knee_and([](const Scratch& s) { add_noise(s, 0.3); })},
    {"fine_noisy",
     [](const Scratch& s) {
       shape_knee(s, "resolution=2.5");
       add_noise(s, 0.12);
     }},
    {"holes", knee_and(make_holes)},
    {"spike", knee_and(make_spike)},
    // The second triangle lies 0.1 mm beside the first, which it turns back to.
    {"fold", knee_and([](const Scratch& s) {
       const Corner a{-20, 31, 0}, b{-20, 31, 3}, c{-17, 31, 0}, d{-17, 31.1F, 3};
       add_triangles(s, {{a, b, c}, {b, a, d}});
     })},
    {"needle", knee_and([](const Scratch& s) {
       add_triangles(s, {{Corner{-20, 31, 0}, Corner{-20, 31, 9}, Corner{-20, 31.05F, 4}}});
     })},
    {"tail", knee_and([](const Scratch& s) {
       s.write("femur.stl", test::read_bytes(s.path() / "femur.stl") + std::string(92, '\0'));
     })},
    {"stiffness_times_30", with_fibres("", stiffness, 30.0)},
    {"stiffness_in_kilonewtons", with_fibres("", stiffness, 0.001)},
    {"soft_mcls2", with_fibres("MCLs2", stiffness, 0.03)},
    {"stiff_lcl4", with_fibres("LCL4", stiffness, 10.0)},
    {"stiff_aclpl3", with_fibres("ACLpl3", stiffness, 28.0)},
    {"without_lcl", with_fibres("LCL", "", 0.0)},
    {"without_aclam", with_fibres("ACLam", "", 0.0)},
    {"without_mcld", with_fibres("MCLd", "", 0.0)},
    {"slack", with_fibres("", length, 1.2)},
    {"slack_pcl", with_fibres("PCL", length, 1.2)},
    {"mirrored_fibres", knee_and([](const Scratch& s) { mirror_fibres(s, ""); })},
    {"mirrored_mcl", knee_and([](const Scratch& s) { mirror_fibres(s, "MCL"); })},
};

const std::vector<test::RefusalRow> rows = test::read_refusals(VRDA_SOURCE_DIR "/tests/app/mistakes.json");

class Mistakes : public testing::TestWithParam<test::RefusalRow> {};

TEST_P(Mistakes, AreAnswered)
{
  expect_row_answered(GetParam(), VRDA_PROGRAM, scenes);
}

INSTANTIATE_TEST_SUITE_P(Vrda, Mistakes, testing::ValuesIn(rows), test::name_of_row);

/// A sound job: the files of the first mistake, without its edits.
fs::path sound_job(const Scratch& scratch)
{
  knee(scratch);
  return scratch.write("my-knee.toml", rows.front().files.front().second);
}

TEST(SoundJob, HasNoWarning)
{
  const Scratch scratch;
  const test::Ended ended = test::run_vrda({"check", sound_job(scratch).string()});
  EXPECT_EQ(ended.exit_code, 0) << ended.err;
  EXPECT_THAT(ended.out, testing::Not(test::warns("")));
}

TEST(CheckPicture, IsAPngOfBothViewsAndLeavesOtherFilesAlone)
{
  const Scratch scratch;
  const fs::path job = sound_job(scratch);
  const std::string picture = (scratch.path() / "knee.png").string(), text = test::text_of(job);
  const auto draw = [&](const std::vector<std::string>& more) {
    std::vector<std::string> words{"check", job.string(), "--picture", picture};
    words.insert(words.end(), more.begin(), more.end());
    EXPECT_EQ(test::run_vrda(words).exit_code, 0);
    return test::read_bytes(picture);
  };
  const std::string first = draw({});
  EXPECT_EQ(first.substr(0, 4), "\x89PNG");
  EXPECT_EQ(first.substr(16, 8), std::string("\0\0\x06\x40\0\0\x03\xe8", 8));  // 1600 x 1000
  EXPECT_EQ(draw({}), first);
  for (const char* setting : {"frame.origin=[0, 300, 0]", "side=left", "push.delta=[1, 0, 0]"})
    EXPECT_NE(draw({"--set", setting}), first) << setting;
  test::expect_refused({"check", job.string(), "--picture", job.string()}, {"my-knee.toml", "", "PNG"});
  EXPECT_EQ(test::text_of(job), text);
}

TEST(Warnings, ARunPrintsAndKeepsTheWarningsOfACheck)
{
  const Scratch scratch;
  const fs::path file = sound_job(scratch);
  // A wrong side, a start within the bone, too few angles.
  test::edit(file, "side = \"right\"", "side = \"left\"");
  test::edit(file, "[[moving", "initial = { translation_mm = [0, 10, 0] }\n[[moving");
  test::edit(file, "to = 90, step = 10", "to = 10, step = 10");
  test::edit(file, "from = -9, to = 9", "from = 0, to = 3");
  const std::string job = file.string(), whole = (scratch.path() / "whole.h5").string(),
                    merged = (scratch.path() / "merged.h5").string();
  const test::Ended check = test::run_vrda({"check", job}), run = test::run_vrda({"run", job, "-o", whole});
  EXPECT_EQ(run.exit_code, 0) << run.err;
  const std::vector<std::string> kept = store::read_motion_model(whole).job.warnings;
  std::string as_checked;
  for (const std::string& warning : kept) as_checked += "warning: " + warning + "\n";
  EXPECT_THAT(kept, testing::IsSupersetOf({testing::HasSubstr("side: the job has \"left\""),
                                           testing::HasSubstr("the objects overlap in the initial pose"),
                                           testing::HasSubstr("degree 3 needs 4 angles")}));
  EXPECT_THAT(check.out, testing::EndsWith(as_checked));
  EXPECT_THAT(run.err, testing::StartsWith(as_checked));
  EXPECT_THAT(run.err.substr(as_checked.size()), testing::Not(testing::HasSubstr("smooth.degrees")));
  EXPECT_THAT(test::run_vrda({"info", whole}).out, testing::HasSubstr(as_checked));
  // In parts it is the same model, bit for bit.
  for (const char* part : {"1/2", "2/2"})
    EXPECT_EQ(test::run_vrda({"run", job, "-o", merged, "--shard", part}).exit_code, 0);
  EXPECT_EQ(test::run_vrda({"merge", "-o", merged, "--job", job}).exit_code, 0);
  EXPECT_EQ(test::read_bytes(merged), test::read_bytes(whole));
  EXPECT_EQ(test::run_vrda({"validate", whole}).exit_code, 0);
}

}  // namespace vrda::mistakes_test
