#include "show/shown_model.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "loop/loop.hpp"
#include "store/motion_model_file.hpp"

namespace vrda {
namespace {

bool is_reached(double wanted_rad, double shown_rad)
{
  constexpr double rounding_rad = 1e-9;
  return std::abs(wanted_rad - shown_rad) < rounding_rad;
}

/// What of the attitude asked for is not shown; empty where all of it is.
std::string what_is_not_shown(const SessionOptions& asked, const Session& session)
{
  const bool is_flexion_shown =
      !asked.flexion_rad || is_reached(*asked.flexion_rad, session.state().timeline.flexion_rad);
  const bool is_varus_shown =
      !asked.varus_rad || is_reached(*asked.varus_rad, session.pose().attitude.varus_rad);
  if (is_flexion_shown && is_varus_shown) return {};
  if (!is_varus_shown && session.is_varus_free()) return "varus was free and is shown as it was found";
  const std::string which = is_varus_shown ? "flexion" : is_flexion_shown ? "varus" : "flexion and varus";
  return "the " + which + " asked for " + (is_varus_shown || is_flexion_shown ? "lies" : "lie") +
         " outside the measured range";
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
  const std::string remark = what_is_not_shown(own, *session_);
  if (!remark.empty()) session_->tell(remark);
}

bool ShownModel::open(const std::string& file)
{
  const auto refused = attempt([&] {
    MotionModel model = read_motion_model(file);
    SessionOptions own = options_;
    const std::vector<std::string> names = set_names(model);
    if (std::find(names.begin(), names.end(), own.set) == names.end()) own.set = names.front();
    show(std::move(model), own);
    file_ = file;
  });
  if (refused) session_->tell(refused->what());
  return !refused;
}

}  // namespace vrda
