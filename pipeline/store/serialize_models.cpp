#include "store/serialize_models.hpp"

#include "store/binary_stream.hpp"
#include "store/registry.hpp"
#include "store/trace_registry.hpp"
#include "store/values.hpp"

namespace vrda::store {
namespace {

template <typename Visit>
std::string bytes_of(const Visit& visit)
{
  BinaryWriter stream;
  // Counted first, so that one allocation suffices.
  stream.count();
  visit(stream);
  stream.reserve_counted();
  visit(stream);
  return stream.take();
}

}  // namespace

std::string serialize(const MotionModel& model)
{
  return bytes_of([&](auto& visitor) { visit_motion_model(model, visitor); });
}

MotionModel deserialize_motion_model(std::string_view bytes, const std::string& file)
{
  MotionModel model;
  visit_motion_model(model, BinaryReader(bytes, file));
  if (!model.has_compartments) set_no_compartments(model);
  require_no_findings(check_values(model), file);
  return model;
}

std::string serialize(const Trace& trace)
{
  return bytes_of([&](auto& visitor) { visit_trace(trace, visitor); });
}

Trace trace_of(std::string_view bytes, const std::string& file)
{
  Trace trace;
  visit_trace(trace, BinaryReader(bytes, file));
  require_no_findings(check_values(trace), file);
  return trace;
}

}  // namespace vrda::store
