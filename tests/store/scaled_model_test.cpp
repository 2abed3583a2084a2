#include "store/scaled_model.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "core/error.hpp"
#include "store/equal_models.hpp"
#include "store/h5_reader.hpp"
#include "store/model_shape.hpp"
#include "store/motion_model_file.hpp"
#include "store/sample_derived.hpp"
#include "store/sample_model.hpp"
#include "support/scratch.hpp"

namespace vrda::scaled_model_test {

MotionModel whole_model()
{
  test::SampleOptions options;
  options.is_equilibrium = true;
  options.n_fibres = 3;
  options.n_wraps = 2;
  return test::with_derived(test::sample_model(options));
}

std::vector<double> numbers_of(const H5Reader& file, const DatasetSpec& spec)
{
  std::int64_t n = 1;
  for (const std::int64_t size : file.facts(spec.path).shape) n *= size;
  std::vector<double> values(static_cast<std::size_t>(n));
  file.read(spec.path, std::span<double>(values));
  return values;
}

/// Of row k of poses, row by row, that is a shift.
bool is_shift(std::size_t k)
{
  return k % 4 == 3 && k % 16 != 15;
}

// The layout says which numbers are lengths, energies and moments, so none is forgotten. Powers of two are
// exact.
TEST(ScaledModel, WhateverHasALengthIsTwiceAsLong)
{
  const MotionModel model = whole_model(), large = scaled_model(model, 2.0);
  const test::Scratch scratch;
  const std::string small_path = (scratch.path() / "small.h5").string();
  const std::string large_path = (scratch.path() / "large.h5").string();
  write_motion_model(small_path, model);
  write_motion_model(large_path, large);
  const H5Reader small_file(read_hdf5(small_path)), large_file(read_hdf5(large_path));
  int n_lengths = 0, n_others = 0;
  for (const DatasetSpec& spec : layout_of(shape_of(model)).datasets) {
    if (spec.kind != ValueKind::float64) continue;
    SCOPED_TRACE(spec.path);
    const bool has_length = spec.units == "mm" || spec.units == "N mm";
    const bool is_pose = spec.path.find("/X_") != std::string::npos;
    ++(has_length ? n_lengths : n_others);
    const std::vector<double> before = numbers_of(small_file, spec), after = numbers_of(large_file, spec);
    for (std::size_t k = 0; k < before.size(); ++k) {
      const double factor = has_length && (!is_pose || is_shift(k)) ? 2.0 : 1.0;
      EXPECT_TRUE(after[k] == factor * before[k] || (std::isnan(before[k]) && std::isnan(after[k])))
          << k << ": " << before[k] << " became " << after[k];
    }
  }
  EXPECT_GT(n_lengths, 40);
  EXPECT_GT(n_others, 20);
  EXPECT_EQ(large.rotation_centre_mm, 2.0 * model.rotation_centre_mm);
  EXPECT_EQ(large.contact_resolution_mm, 2.0 * model.contact_resolution_mm);
  EXPECT_EQ(large.push.point_mm, 2.0 * model.push.point_mm);
  EXPECT_EQ(large.equilibrium->band_moment_nmm, 2.0 * model.equilibrium->band_moment_nmm);
  const SmoothedSurface &tx = model.smoothed.front().surfaces.front(),
                        &large_tx = large.smoothed.front().surfaces.front();
  EXPECT_EQ(large_tx.rms, 2.0 * tx.rms);
  EXPECT_EQ(large_tx.largest_residual, 2.0 * tx.largest_residual);
}

TEST(ScaledModel, BackAgainIsTheSame)
{
  const MotionModel model = whole_model();
  test::expect_equal(scaled_model(scaled_model(model, 0.5), 2.0), model);
  test::expect_equal(scaled_model(model, 1.0), model);
}

TEST(ScaledModel, NoSizeIsOurMistake)
{
  EXPECT_THROW(scaled_model(whole_model(), 0.0), InternalError);
}

}  // namespace vrda::scaled_model_test
