// Serialization of motion models and traces between processes.
#include "store/read_separately.hpp"

#include <gtest/gtest.h>


#include "core/text.hpp"
#include "store/sample_model.hpp"
#include "support/traces.hpp"

namespace vrda::plain_bytes_test {

std::vector<store::MotionModel> samples()
{
  test::SampleOptions bare, mechanics, one_cell;
  bare.has_compartments = bare.has_visual = false;
  mechanics.is_equilibrium = true;
  mechanics.n_fibres = 3;
  mechanics.n_wraps = 2;
  one_cell.n_flexion = one_cell.n_varus = 1;
  one_cell.has_failed_cell = false;
  store::MotionModel single = test::sample_model(one_cell);
  single.smoothed.clear();  // one cell has no terms for a degree
  return {test::with_derived(test::sample_model()), test::sample_model(bare),
          test::with_derived(test::sample_model(mechanics)), single, test::frames_model()};
}

TEST(PlainBytes, AModelComesBackToTheLastBit)
{
  for (const store::MotionModel& model : samples()) {
    const std::string bytes = store::serialize(model);
    const store::MotionModel again = store::deserialize_motion_model(bytes, "knee.h5");
    test::expect_equal(model, again);
    EXPECT_EQ(store::serialize(again), bytes);
  }
}

TEST(PlainBytes, ATraceComesBackToTheLastBit)
{
  const store::Trace trace = test::trace_beside(test::sample_model());
  const std::string bytes = store::serialize(trace);
  const store::Trace again = store::trace_of(bytes, "knee.trace.h5");
  EXPECT_EQ(store::serialize(again), bytes);
  test::expect_equal(again, trace);
}

TEST(PlainBytes, CutAnywhereTheyAreRefused)
{
  const std::string bytes = store::serialize(samples()[2]);
  for (std::size_t size = 0; size < bytes.size(); size += 13) {
    try {
      store::deserialize_motion_model(std::string_view(bytes).substr(0, size), "knee.h5");
      ADD_FAILURE() << "no InputError of " << size << " bytes";
    } catch (const InputError& error) {
      EXPECT_EQ(error.facts().file, "knee.h5");
    }
  }
}

}  // namespace vrda::plain_bytes_test
