#include "app/trace.hpp"

#include <cstdio>

#include "core/error.hpp"
#include "core/units.hpp"

namespace vrda {
namespace {

const char* name_of_motion(Motion motion)
{
  switch (motion) {
    case Motion::retreat:
      return "retreat";
    case Motion::approach:
      return "approach";
    case Motion::turn:
      return "turn";
    case Motion::slide:
      return "slide";
  }
  throw InternalError("a motion without a name");
}

std::string line_of(const Attitude& attitude, const SearchMove& move)
{
  char text[256];
  const Eigen::Vector3d& t = move.pose.translation_mm;
  std::snprintf(text, sizeof text, "%g,%g,%d,%s,%.6f,%.6f,%.6f,%.6f,%g,%g,%d\n",
                deg_from_rad(attitude.flexion_rad), deg_from_rad(attitude.varus_rad), move.iteration,
                name_of_motion(move.motion), t.x(), t.y(), t.z(), deg_from_rad(move.pose.theta_rad),
                move.translation_step_mm, deg_from_rad(move.rotation_step_rad), move.n_contacts);
  return text;
}

}  // namespace

Trace::Trace(const std::string& path) : path_(path), file_(path)
{
  file_ << "flexion_deg,varus_deg,iteration,motion,x_mm,y_mm,z_mm,theta_deg,translation_step_mm,rotation_"
           "step_deg,"
           "contacts\n";
  if (!file_) throw InputError({path, "", "a file that cannot be written", "room and permission to write"});
}

void Trace::close()
{
  file_.close();
  if (!file_) throw InputError({path_, "", "a file that cannot be written", "room and permission to write"});
}

StepRecord Trace::follow(const Attitude& attitude, const std::function<StepRecord(const Watch&)>& solve)
{
  std::string lines;
  StepRecord record = solve([&](const SearchMove& move) { lines += line_of(attitude, move); });
  const std::lock_guard lock(mutex_);
  // At once: an hour's run must not end in a trace that stopped in its first minute.
  if (!(file_ << lines))
    throw InputError({path_, "", "a file that cannot be written", "room and permission to write"});
  return record;
}

}  // namespace vrda
