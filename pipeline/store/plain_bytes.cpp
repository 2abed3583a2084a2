#include "store/plain_bytes.hpp"

#include <limits>
#include <optional>

#include "store/binding.hpp"
#include "store/dataset_reader.hpp"
#include "store/model_shape.hpp"
#include "store/plain_stream.hpp"
#include "store/trace_binding.hpp"
#include "store/trace_values.hpp"
#include "store/values.hpp"

namespace vrda {
namespace {

/// Saves moving all that stands already.
constexpr std::size_t room_for_texts = std::size_t{1} << 20;
/// Bytes, for PlainReader::require.
constexpr std::uint64_t nothing_has_so_many = std::numeric_limits<std::uint64_t>::max();
/// Sets and audits that a file can hold: the reader takes 10000 objects.
constexpr std::uint32_t most_groups = 1000;

// Each pass_...(stream, value) goes one way with a PlainWriter and a const value, and the other with a
// PlainReader: what is written and what is read cannot come apart.

template <typename Stream, typename Flag>
void pass_flag(Stream& stream, Flag& flag)
{
  std::int8_t code = flag ? 1 : 0;
  stream.pass(code);
  if constexpr (!std::is_const_v<Flag>) flag = code != 0;
}

/// A size that an index of 32 bits can have.
template <typename Stream, typename Size>
void pass_size(Stream& stream, Size& size)
{
  stream.pass(size);
  if constexpr (!std::is_const_v<Size>) {
    if (size < 0 || size > std::numeric_limits<std::int32_t>::max()) stream.require(nothing_has_so_many);
  }
}

template <typename Stream, typename Optional, typename Pass>
void pass_optional(Stream& stream, Optional& value, const Pass& pass)
{
  std::int8_t code = value.has_value() ? 1 : 0;
  stream.pass(code);
  if constexpr (!std::is_const_v<Optional>) {
    if (code != 0) value.emplace();
  }
  if (value) pass(*value);
}

template <typename Stream, typename List, typename Pass>
void pass_list(Stream& stream, List& list, const Pass& pass)
{
  auto n = static_cast<std::uint32_t>(list.size());
  stream.pass(n);
  if constexpr (!std::is_const_v<List>) {
    if (n > most_groups) stream.require(nothing_has_so_many);
    list.resize(n);
  }
  for (auto& item : list) pass(item);
}

template <typename Stream, typename Shape>
void pass_part(Stream& stream, Shape& shape)
{
  pass_size(stream, shape.n_vertices);
  pass_size(stream, shape.n_triangles);
  pass_flag(stream, shape.has_normals);
}

template <typename Stream, typename Shape>
void pass_body(Stream& stream, Shape& shape)
{
  pass_size(stream, shape.n_components);
  pass_part(stream, shape.contact);
  pass_flag(stream, shape.has_visual);
  pass_part(stream, shape.visual);
}

template <typename Stream, typename Shape>
void pass_shape(Stream& stream, Shape& shape)
{
  pass_size(stream, shape.n_flexion);
  pass_size(stream, shape.n_varus);
  pass_flag(stream, shape.has_compartments);
  pass_size(stream, shape.n_contacts);
  pass_optional(stream, shape.n_forces, [&](auto& n) { pass_size(stream, n); });
  pass_optional(stream, shape.ligaments, [&](auto& ligaments) {
    pass_size(stream, ligaments.n_fibres);
    pass_size(stream, ligaments.n_wraps);
  });
  pass_body(stream, shape.reference);
  pass_body(stream, shape.moving);
  pass_list(stream, shape.smoothed, [&](auto& set) {
    stream.pass(set.degree);
    pass_size(stream, set.n_terms);
    pass_flag(stream, set.has_varus);
    pass_flag(stream, set.has_recontact);
  });
  pass_flag(stream, shape.has_zero_varus);
  pass_list(stream, shape.audits, [&](auto& audit) {
    stream.pass(audit.name);
    pass_size(stream, audit.n_flexion);
    pass_size(stream, audit.n_varus);
  });
  pass_size(stream, shape.n_inputs);
  pass_optional(stream, shape.n_landmarks, [&](auto& n) { pass_size(stream, n); });
}

/// The members that `shape` has, for the visit of the datasets.
void open_members(MotionModel& model, const FileShape& shape)
{
  model.has_compartments = shape.has_compartments;
  if (shape.has_compartments) model.contact_paths.emplace();
  if (shape.n_forces) model.equilibrium.emplace();
  if (shape.ligaments) model.ligaments.emplace();
  for (const SmoothedShape& smoothed : shape.smoothed) {
    SmoothedSet& set = model.smoothed.emplace_back();
    set.degree = smoothed.degree;
    for (const std::string& name : smoothed_names(smoothed)) set.surfaces.emplace_back().name = name;
    if (smoothed.has_recontact) set.recontact_mm.emplace();
  }
  if (shape.has_zero_varus) model.zero_varus.emplace();
  for (const AuditShape& audit : shape.audits) model.audits.emplace_back().name = audit.name;
  if (shape.n_landmarks) model.job.scaling.emplace();
}

/// What stands in the attributes of the file.
template <typename Stream, typename Model>
void pass_attributes(Stream& stream, Model& model)
{
  for (auto* text :
       {&model.title, &model.joint, &model.side, &model.method, &model.reference.name, &model.moving.name})
    stream.pass(*text);
  stream.pass(model.rotation_centre_mm);
  stream.pass(model.delta);
  stream.pass(model.contact_resolution_mm);
  stream.pass(model.push.point_mm);
  if (model.equilibrium) stream.pass(model.equilibrium->band_moment_nmm);
  if (model.ligaments) stream.pass(model.ligaments->transition_strain);
  for (auto& set : model.smoothed) {
    pass_flag(stream, set.is_robust);
    for (auto& surface : set.surfaces) {
      stream.pass(surface.n_cells);
      for (auto* number :
           {&surface.rms, &surface.largest_residual, &surface.leave_one_out_rms, &surface.condition_number})
        stream.pass(*number);
    }
  }
  if (model.zero_varus) stream.pass(model.zero_varus->set);
  for (auto& audit : model.audits) stream.pass(audit.refine);
  if (!model.job.scaling) return;
  stream.pass(model.job.scaling->factor);
  pass_flag(stream, model.job.scaling->keeps_steps);
  stream.pass(model.job.scaling->standard_error);
  stream.pass(model.job.scaling->residual_rms_mm);
}

template <typename Stream, typename ATrace>
void pass_attributes_of_trace(Stream& stream, ATrace& trace)
{
  for (auto* text : {&trace.title, &trace.side, &trace.job_key}) stream.pass(*text);
  for (auto* number :
       {&trace.approach_step_mm, &trace.translation_resolution_mm, &trace.rotation_resolution_deg})
    stream.pass(*number);
}

template <typename Stream, typename Shape>
void pass_trace_shape(Stream& stream, Shape& shape)
{
  for (auto* size : {&shape.n_searches, &shape.n_moves, &shape.n_contacts, &shape.n_inputs})
    pass_size(stream, *size);
}

}  // namespace

std::string plain_bytes(const MotionModel& model)
{
  PlainWriter stream;
  const FileShape shape = shape_of(model);
  stream.reserve(value_bytes(layout_of(shape), shape) + room_for_texts);
  pass_shape(stream, shape);
  pass_attributes(stream, model);
  visit_datasets(model, shape, stream);
  return stream.take();
}

MotionModel motion_model_of(std::string_view bytes, const std::string& file)
{
  PlainReader stream(bytes, file);
  FileShape shape;
  pass_shape(stream, shape);
  MotionModel model;
  open_members(model, shape);
  pass_attributes(stream, model);
  const FileLayout layout = layout_of(shape);
  stream.require(value_bytes(layout, shape));
  visit_datasets(model, shape, DatasetReader(stream, layout, shape));
  if (!model.has_compartments) set_no_compartments(model);
  require_none(check_values(model), file);
  return model;
}

std::string plain_bytes(const Trace& trace)
{
  PlainWriter stream;
  const TraceShape shape = shape_of(trace);
  stream.reserve(value_bytes(trace_layout_of(shape), {}) + room_for_texts);
  pass_trace_shape(stream, shape);
  pass_attributes_of_trace(stream, trace);
  visit_trace(trace, stream);
  return stream.take();
}

Trace trace_of(std::string_view bytes, const std::string& file)
{
  PlainReader stream(bytes, file);
  TraceShape shape;
  pass_trace_shape(stream, shape);
  Trace trace;
  pass_attributes_of_trace(stream, trace);
  const FileLayout layout = trace_layout_of(shape);
  stream.require(value_bytes(layout, {}));
  visit_trace(trace, DatasetReader(stream, layout, FileShape()));
  require_none(check_values(trace), file);
  return trace;
}

}  // namespace vrda
