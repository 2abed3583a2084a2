#include "fuzz/small_models.hpp"

#include "store/sample_model.hpp"
#include "support/traces.hpp"

namespace vrda::test {

std::vector<store::MotionModel> small_models()
{
  SampleOptions smallest, small, rich, free;
  smallest.n_flexion = small.n_flexion = 3;
  smallest.n_varus = small.n_varus = 2;
  smallest.has_visual = smallest.has_failed_cell = smallest.has_compartments = false;
  small.has_failed_cell = false;
  rich.is_equilibrium = true;
  rich.n_fibres = 3;
  rich.n_wraps = 2;
  free.n_varus = 1;
  free.has_failed_cell = false;
  // The time is proportional to the number of datasets.
  store::MotionModel least = sample_model(smallest);
  least.smoothed.clear();
  return {sample_model(smallest),
          with_derived(sample_model(rich)),
          sample_model(small),
          with_derived(sample_model(free)),
          store::with_pending_cells(sample_model(smallest)),
          least,
          frames_model()};
}

store::Trace small_trace()
{
  return trace_beside(small_models().front());
}

}  // namespace vrda::test
