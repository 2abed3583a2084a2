#include "store/motion_model_file.hpp"

#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include <bit>
#include <filesystem>
#include <limits>

#include "core/error.hpp"
#include "store/sample_model.hpp"
#include "support/input_error.hpp"
#include "support/scratch.hpp"

namespace vrda {
namespace {

using test::input_error;

template <typename Scalar>
void expect_equal(const Grid<Scalar>& a, const Grid<Scalar>& b, const char* what)
{
  ASSERT_EQ(a.rows(), b.rows()) << what;
  ASSERT_EQ(a.cols(), b.cols()) << what;
  for (Eigen::Index k = 0; k < a.size(); ++k) {
    const bool both_nan = a.data()[k] != a.data()[k] && b.data()[k] != b.data()[k];
    EXPECT_TRUE(both_nan || a.data()[k] == b.data()[k]) << what << " at " << k;
  }
}

void expect_equal(const Part& a, const Part& b)
{
  EXPECT_EQ(a.mesh.vertices_mm, b.mesh.vertices_mm);
  EXPECT_EQ(a.mesh.triangles, b.mesh.triangles);
  EXPECT_EQ(a.mesh.normals, b.mesh.normals);
  EXPECT_EQ(a.component, b.component);
}

void expect_equal(const Body& a, const Body& b)
{
  EXPECT_EQ(a.name, b.name);
  ASSERT_EQ(a.components.size(), b.components.size());
  for (std::size_t i = 0; i < a.components.size(); ++i) {
    EXPECT_EQ(a.components[i].name, b.components[i].name);
    EXPECT_EQ(a.components[i].material, b.components[i].material);
  }
  expect_equal(a.contact, b.contact);
  expect_equal(a.visual, b.visual);
}

void expect_equal(const SmoothedSet& a, const SmoothedSet& b)
{
  EXPECT_EQ(a.degree, b.degree);
  EXPECT_TRUE((a.exponents == b.exponents).all());
  ASSERT_EQ(a.surfaces.size(), b.surfaces.size());
  for (std::size_t s = 0; s < a.surfaces.size(); ++s) {
    EXPECT_EQ(a.surfaces[s].name, b.surfaces[s].name);
    EXPECT_EQ(a.surfaces[s].coefficients, b.surfaces[s].coefficients);
    expect_equal(a.surfaces[s].values, b.surfaces[s].values, "smoothed values");
    EXPECT_EQ(a.surfaces[s].n_cells, b.surfaces[s].n_cells);
    EXPECT_EQ(a.surfaces[s].rms, b.surfaces[s].rms);
    EXPECT_EQ(a.surfaces[s].largest_residual, b.surfaces[s].largest_residual);
    EXPECT_EQ(a.surfaces[s].leave_one_out_rms, b.surfaces[s].leave_one_out_rms);
    EXPECT_EQ(a.surfaces[s].condition_number, b.surfaces[s].condition_number);
  }
}

void expect_equal_cells(const MotionModel& a, const MotionModel& b)
{
  expect_equal(a.tx_mm, b.tx_mm, "tx");
  expect_equal(a.ty_mm, b.ty_mm, "ty");
  expect_equal(a.tz_mm, b.tz_mm, "tz");
  expect_equal(a.theta_deg, b.theta_deg, "theta");
  ASSERT_EQ(a.X_reference_moving.size(), b.X_reference_moving.size());
  const Eigen::Index n = static_cast<Eigen::Index>(a.X_reference_moving.size());
  expect_equal<double>(Eigen::Map<const GridD>(a.X_reference_moving.data(), n, 1),
                       Eigen::Map<const GridD>(b.X_reference_moving.data(), n, 1), "X_reference_moving");
  expect_equal(a.status, b.status, "status");
  expect_equal(a.iterations, b.iterations, "iterations");
  expect_equal(a.queries, b.queries, "queries");
  expect_equal(a.residual_mm, b.residual_mm, "residual");
  expect_equal(a.gap_medial_mm, b.gap_medial_mm, "gap_medial_mm");
  expect_equal(a.gap_lateral_mm, b.gap_lateral_mm, "gap_lateral_mm");
  expect_equal(a.contact_medial, b.contact_medial, "contact_medial");
  expect_equal(a.contact_lateral, b.contact_lateral, "contact_lateral");
  expect_equal(a.theta_determined, b.theta_determined, "theta_determined");
  expect_equal(a.is_spine, b.is_spine, "is_spine");
  expect_equal(a.clinical.flexion_deg, b.clinical.flexion_deg, "flexion_angle");
  expect_equal(a.clinical.varus_deg, b.clinical.varus_deg, "varus_angle");
  expect_equal(a.clinical.internal_rotation_deg, b.clinical.internal_rotation_deg, "internal_rotation");
  expect_equal(a.clinical.anterior_mm, b.clinical.anterior_mm, "anterior");
  expect_equal(a.clinical.proximal_mm, b.clinical.proximal_mm, "proximal");
  expect_equal(a.clinical.lateral_mm, b.clinical.lateral_mm, "lateral");
}

void expect_equal(const MotionModel& a, const MotionModel& b)
{
  EXPECT_EQ(a.title, b.title);
  EXPECT_EQ(a.joint, b.joint);
  EXPECT_EQ(a.side, b.side);
  EXPECT_EQ(a.method, b.method);
  EXPECT_EQ(a.rotation_centre_mm, b.rotation_centre_mm);
  EXPECT_EQ(a.delta, b.delta);
  EXPECT_EQ(a.contact_resolution_mm, b.contact_resolution_mm);
  EXPECT_EQ(a.has_compartments, b.has_compartments);
  EXPECT_EQ(a.flexion_deg, b.flexion_deg);
  EXPECT_EQ(a.varus_deg, b.varus_deg);
  expect_equal_cells(a, b);
  EXPECT_EQ(a.contacts.row_start, b.contacts.row_start);
  EXPECT_EQ(a.contacts.point_world_mm, b.contacts.point_world_mm);
  EXPECT_EQ(a.contacts.normal_world, b.contacts.normal_world);
  EXPECT_EQ(a.contacts.distance_mm, b.contacts.distance_mm);
  EXPECT_EQ(a.contacts.triangle_reference, b.contacts.triangle_reference);
  EXPECT_EQ(a.contacts.triangle_moving, b.contacts.triangle_moving);
  EXPECT_EQ(a.contacts.compartment, b.contacts.compartment);
  expect_equal(a.reference, b.reference);
  expect_equal(a.moving, b.moving);
  ASSERT_EQ(a.smoothed.size(), b.smoothed.size());
  for (std::size_t i = 0; i < a.smoothed.size(); ++i) expect_equal(a.smoothed[i], b.smoothed[i]);
  EXPECT_EQ(a.job.text, b.job.text);
  EXPECT_EQ(a.job.resolved, b.job.resolved);
  ASSERT_EQ(a.job.inputs.size(), b.job.inputs.size());
  for (std::size_t i = 0; i < a.job.inputs.size(); ++i) {
    EXPECT_EQ(a.job.inputs[i].name, b.job.inputs[i].name);
    EXPECT_EQ(a.job.inputs[i].sha256, b.job.inputs[i].sha256);
  }
}

TEST(MotionModelFile, GivesBackWhatWasWritten)
{
  const test::Scratch scratch;
  const std::string path = scratch.path() / "knee.h5";
  const test::SampleOptions variants[] = {{},
                                          {91, 21, true, true, true},
                                          {4, 3, false, false, false},
                                          {3, 1, true, true, false},
                                          {1, 1, false, true, false}};
  for (const test::SampleOptions& options : variants) {
    SCOPED_TRACE(options.n_flexion * 100 + options.n_varus);
    MotionModel model = test::sample_model(options);
    if (options.n_flexion == 1) model.smoothed.clear();  // the sample's set has a term of flexion
    write_motion_model(path, model);
    for (const Finding& finding : validate_motion_model(path)) {
      ADD_FAILURE() << finding.where << ": " << finding.found << ", wanted " << finding.wanted;
    }
    expect_equal(read_motion_model(path), model);
  }
}

TEST(MotionModelFile, StartFileIsAValidModelWithEveryCellPending)
{
  const test::Scratch scratch;
  const std::string path = scratch.path() / "knee.start.h5";
  const MotionModel start = with_pending_cells(test::sample_model());
  write_motion_model(path, start);
  EXPECT_TRUE(validate_motion_model(path).empty());
  const MotionModel read = read_motion_model(path);
  expect_equal(read, start);
  EXPECT_TRUE((read.status == static_cast<std::int8_t>(StepStatus::pending)).all());
  EXPECT_EQ(read.contacts.row_start, std::vector<std::int64_t>(13, 0));
}

TEST(MotionModelFile, EqualModelsGiveEqualBytes)
{
  const test::Scratch scratch;
  const std::string a = scratch.path() / "a.h5", b = scratch.path() / "folder" / "longer-name.h5";
  std::filesystem::create_directory(scratch.path() / "folder");
  MotionModel model = test::sample_model({91, 21, true, true, true});
  write_motion_model(a, model);
  sleep(1);  // a stored time would differ
  // A NaN is a NaN, whatever its bits.
  model.tx_mm(1, 2) = std::bit_cast<double>(0xfff8000000000001u);
  write_motion_model(b, model);
  EXPECT_EQ(test::read_bytes(a), test::read_bytes(b));
}

TEST(MotionModelFile, WritingReadBackBytesGivesTheSameFile)
{
  const test::Scratch scratch;
  const std::string a = scratch.path() / "a.h5", b = scratch.path() / "b.h5";
  write_motion_model(a, test::sample_model());
  write_motion_model(b, read_motion_model(a));
  EXPECT_EQ(test::read_bytes(a), test::read_bytes(b));
}

TEST(MotionModelFile, ReplacesAFileAndLeavesNothingElse)
{
  const test::Scratch scratch;
  const std::string path = scratch.write("knee.h5", "an older result");
  write_motion_model(path, test::sample_model());
  EXPECT_TRUE(validate_motion_model(path).empty());
  EXPECT_EQ(std::distance(std::filesystem::directory_iterator(scratch.path()), {}), 1);
}

TEST(MotionModelFile, AnUnwritableOutputIsNamedAndTheOldFileKept)
{
  const test::Scratch scratch;
  const std::string nowhere = scratch.path() / "no" / "such" / "knee.h5";
  const InputError::Facts facts = input_error([&] { write_motion_model(nowhere, test::sample_model()); });
  EXPECT_EQ(facts.file, nowhere);
  EXPECT_NE(facts.found.find("No such file or directory"), std::string::npos);
  EXPECT_NE(facts.wanted.find("written"), std::string::npos);

  const std::string folder = scratch.path() / "knee.h5";
  std::filesystem::create_directory(folder);
  scratch.write("knee.h5/inside", "kept");
  EXPECT_EQ(input_error([&] { write_motion_model(folder, test::sample_model()); }).file, folder);
  EXPECT_TRUE(std::filesystem::exists(scratch.path() / "knee.h5" / "inside"));
  EXPECT_EQ(std::distance(std::filesystem::directory_iterator(scratch.path()), {}), 1);
}

TEST(MotionModelFile, AModelWhoseShapesDisagreeIsOurMistake)
{
  const test::Scratch scratch;
  const std::string path = scratch.path() / "knee.h5";
  MotionModel model = test::sample_model();
  model.tx_mm.conservativeResize(2, 2);
  EXPECT_THROW(write_motion_model(path, model), InternalError);
  model = test::sample_model();
  model.smoothed[0].surfaces.pop_back();
  EXPECT_THROW(write_motion_model(path, model), InternalError);
  model = test::sample_model();
  model.smoothed.push_back(model.smoothed[0]);
  EXPECT_THROW(write_motion_model(path, model), InternalError);
  EXPECT_FALSE(std::filesystem::exists(path));
}

TEST(MotionModelFile, WhatIsNoMotionModelIsRefused)
{
  const test::Scratch scratch;
  const std::string missing = scratch.path() / "missing.h5";
  EXPECT_EQ(input_error([&] { read_motion_model(missing); }).file, missing);
  EXPECT_NE(input_error([&] { read_motion_model(missing); }).found.find("No such file"), std::string::npos);
  EXPECT_EQ(input_error([&] { read_motion_model(scratch.path()); }).found, "no regular file");
  for (const std::string& bytes :
       {std::string(), std::string("title = \"a job\"\n"), std::string(4096, '\0')}) {
    const std::string file = scratch.write("job.toml", bytes);
    const InputError::Facts facts = input_error([&] { read_motion_model(file); });
    EXPECT_EQ(facts.file, file);
    EXPECT_NE(facts.found.find("no HDF5 file"), std::string::npos);
    EXPECT_NE(facts.wanted.find("motion model"), std::string::npos);
    EXPECT_THROW(validate_motion_model(file), InputError);
  }
}

}  // namespace
}  // namespace vrda
