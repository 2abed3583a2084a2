#include "store/solved_cells.hpp"

#include <cmath>
#include <span>

#include "model/clinical.hpp"
#include "model/side.hpp"
#include "core/units.hpp"
#include "store/compressed_rows.hpp"

namespace vrda::store {
namespace {

// The axis value where varus was prescribed: conversion to radians and back may change the last bit.
double solved_varus_deg(const MotionModel& model, const StepRecord& r)
{
  const double axis_deg = model.varus_deg[static_cast<std::size_t>(r.key.varus)];
  return r.varus_rad == rad_from_deg(axis_deg) ? axis_deg : deg_from_rad(r.varus_rad);
}

Attitude attitude_of(const MotionModel& model, const StepRecord& r)
{
  return {rad_from_deg(model.flexion_deg[static_cast<std::size_t>(r.key.flexion)]), r.varus_rad};
}

void set_pose(MotionModel& model, const StepRecord& r)
{
  const SolverFrame frame = solver_frame(model, r.key.flexion);
  const Eigen::Index i = r.key.flexion, j = r.key.varus;
  const Attitude attitude = attitude_of(model, r);
  const Eigen::Vector3d t = world_translation_mm(frame, r.pose);
  model.tx_mm(i, j) = t.x();
  model.ty_mm(i, j) = t.y();
  model.tz_mm(i, j) = t.z();
  model.theta_deg(i, j) = deg_from_rad(r.pose.theta_rad);
  model.varus_solved_deg(i, j) = solved_varus_deg(model, r);

  const Pose X = X_reference_moving(frame, attitude, r.pose);
  const std::size_t first = 16 * static_cast<std::size_t>(i * model.status.cols() + j);
  for (int row = 0; row < 4; ++row) {
    for (int column = 0; column < 4; ++column) {
      model.X_reference_moving[first + static_cast<std::size_t>(4 * row + column)] = X.matrix()(row, column);
    }
  }
  const ClinicalCoordinates clinical = clinical_coordinates(X, frame.side, frame.rotation_centre_mm);
  model.clinical.flexion_deg(i, j) = deg_from_rad(clinical.flexion_rad);
  model.clinical.varus_deg(i, j) = deg_from_rad(clinical.varus_rad);
  model.clinical.internal_rotation_deg(i, j) = deg_from_rad(clinical.internal_rotation_rad);
  model.clinical.anterior_mm(i, j) = clinical.anterior_mm;
  model.clinical.proximal_mm(i, j) = clinical.proximal_mm;
  model.clinical.lateral_mm(i, j) = clinical.lateral_mm;
}

/// Replaces a number only where it differs by more than rounding, so that the others keep their bits.
void replace(double& number, double by)
{
  constexpr double rounding = 1e-6;  // degrees or mm
  if (std::abs(by - number) > rounding) number = by;
}

void set_next(ClinicalSurfaces& surfaces, const MotionModel& model, Eigen::Index cell,
              ContinuousCoordinates& along)
{
  const ClinicalCoordinates c = along.next(pose_in(model.X_reference_moving, static_cast<std::size_t>(cell)));
  replace(surfaces.flexion_deg.data()[cell], deg_from_rad(c.flexion_rad));
  replace(surfaces.varus_deg.data()[cell], deg_from_rad(c.varus_rad));
  replace(surfaces.internal_rotation_deg.data()[cell], deg_from_rad(c.internal_rotation_rad));
  replace(surfaces.anterior_mm.data()[cell], c.anterior_mm);
}

/// The stable cell of a row from which the others follow: that of the spine, else the first; -1 without any.
Eigen::Index first_of_row(const MotionModel& model, Eigen::Index i)
{
  Eigen::Index found = -1;
  for (Eigen::Index j = model.status.cols() - 1; j >= 0; --j) {
    if (model.status(i, j) != status_stable) continue;
    if (model.is_spine(i, j) == 1) return j;
    found = j;
  }
  return found;
}

}  // namespace

ClinicalCurves clinical_curves(const MotionModel& model)
{
  ClinicalCurves curves{model.clinical};
  ContinuousCoordinates over_rows(side_named(model.side), model.rotation_centre_mm);
  const Eigen::Index n = model.status.cols();
  for (Eigen::Index i = 0; i < model.status.rows(); ++i) {
    const Eigen::Index first = first_of_row(model, i);
    if (first < 0) continue;
    set_next(curves.surfaces, model, i * n + first, over_rows);
    for (const Eigen::Index step : {1, -1}) {
      ContinuousCoordinates along = over_rows;
      for (Eigen::Index j = first + step; j >= 0 && j < n; j += step)
        if (model.status(i, j) == status_stable) set_next(curves.surfaces, model, i * n + j, along);
      curves.n_locked += along.n_locked() - over_rows.n_locked();
    }
  }
  curves.n_locked += over_rows.n_locked();
  return curves;
}

SolverFrame solver_frame(const MotionModel& model, std::int32_t flexion)
{
  return {side_named(model.side), model.rotation_centre_mm, model.push.delta.row(flexion).transpose()};
}

void set_cell(MotionModel& model, const StepRecord& r)
{
  const Eigen::Index i = r.key.flexion, j = r.key.varus;
  model.status(i, j) = static_cast<std::int8_t>(r.status);
  model.iterations(i, j) = r.iterations;
  model.queries(i, j) = r.queries;
  if (r.status != StepStatus::stable) return;
  set_pose(model, r);
  model.residual_mm(i, j) = r.residual_mm;
  model.gap_medial_mm(i, j) = r.gap_medial_mm;
  model.gap_lateral_mm(i, j) = r.gap_lateral_mm;
  model.contact_medial(i, j) = r.contact_medial ? 1 : 0;
  model.contact_lateral(i, j) = r.contact_lateral ? 1 : 0;
  model.theta_determined(i, j) = r.theta_determined ? 1 : 0;
}

ContactRows contact_rows(const MotionModel& model, const std::vector<StepRecord>& cells)
{
  const auto contacts_of = [](const StepRecord& r) { return std::span<const ContactRecord>(r.contacts); };
  return compressed_rows(model, cells, contacts_of, &ContactRecord::distance_mm, &ContactRows::distance_mm);
}

}  // namespace vrda::store
