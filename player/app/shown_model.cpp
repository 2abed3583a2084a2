#include "app/shown_model.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/error.hpp"
#include "store/read_apart.hpp"

namespace vrda {
namespace {

bool is_reached(const Session& session, double flexion_rad)
{
  constexpr double rounding_rad = 1e-9;
  return std::abs(session.state().timeline.flexion_rad - flexion_rad) < rounding_rad;
}

}  // namespace

ShownModel::ShownModel(const std::string& file, MotionModel model, const SessionOptions& options,
                       Renderer& renderer)
    : options_(options), renderer_(renderer), file_(file)
{
  show(std::move(model), options);
}

void ShownModel::show(MotionModel model, const SessionOptions& options)
{
  SessionOptions own = options;
  own.title = model.title;
  own.width = renderer_.width();
  own.height = renderer_.height();
  auto made = std::make_unique<Session>(std::move(model), own);
  made->load_into(renderer_);
  session_ = std::move(made);
  title_ = own.title;
  if (own.flexion_rad && !is_reached(*session_, *own.flexion_rad))
    session_->tell("the flexion asked for lies outside the measured range");
}

bool ShownModel::open(const std::string& file)
{
  try {
    MotionModel model = read_motion_model_apart(file);
    SessionOptions own = options_;
    const std::vector<std::string> names = set_names(model);
    if (std::find(names.begin(), names.end(), own.set) == names.end()) own.set = names.front();
    show(std::move(model), own);
    file_ = file;
    return true;
  } catch (const InputError& error) {
    session_->tell(error.what());
    return false;
  }
}

}  // namespace vrda
