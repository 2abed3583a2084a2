/// Along the spine: where the compartments bear, with which force, which fibres pull; and the axes of the
/// motion.
#pragma once

#include "report/json.hpp"
#include "store/motion_model.hpp"

namespace vrda {

/// Points of each compartment on both bodies over flexion and the bodies' outlines; null without
/// compartments. Of the zero-varus motion where it is there, else of the spine's cells.
Json contact_paths_json(const MotionModel& model);

/// Finite helical axes, instant centres, rolling and sliding between flexions; null before `vrda reduce`.
Json axes_json(const MotionModel& model);

/// Force along Delta by compartment over flexion, N; null by the stability search.
Json forces_json(const MotionModel& model);

/// By bundle over flexion: strain of the fibre strained most, tension of all together; null without fibres.
Json fibres_json(const MotionModel& model);

/// What only the equilibrium's spine knows: internal rotation under an extra moment, places of rest; else
/// null.
Json spine_json(const MotionModel& model);

}  // namespace vrda
