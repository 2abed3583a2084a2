#include "run/solved_model.hpp"

#include <algorithm>
#include <thread>

#include "core/error.hpp"
#include "run/summary.hpp"
#include "store/motion_model_file.hpp"

namespace vrda {

MotionModel read_solved_model(const std::string& file)
{
  MotionModel model = read_motion_model(file);
  const auto n_stable = (model.status == status_stable).count();
  if (n_stable == 0) throw InputError({file, "/status", status_line(model), "at least one stable attitude"});
  return model;
}

int threads_or_all(int asked)
{
  if (asked > 0) return asked;
  return std::max(1, static_cast<int>(std::thread::hardware_concurrency()));
}

}  // namespace vrda
