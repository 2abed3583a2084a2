/// Whether a fit is that of a knee.
#pragma once

#include <string>
#include <vector>

#include "registration/knee_fit.hpp"

namespace vrda::registration {

/// Why a knee is refused: which measure is out of range, with its limit; empty: accepted.
std::vector<std::string> rejection_reasons(const KneeFit& fit, const KneeSurfaces& subject);

/// The mistake that explains a refusal: a wrong side or unit in `known`, exchanged bones, or an open sheet
/// wound inward; empty: none found. Repeats the whole fit for each, unless only the length of a bone is
/// refused.
std::string probable_cause(const KneeFit& fit, const KneeSurfaces& subject, const TemplateKnee& reference,
                           const KneeFitOptions& known = {});

/// Accepted, but doubtful: little bone, cartilage only, an uncertain side.
std::vector<std::string> fit_warnings(const KneeFit& fit, const KneeSurfaces& subject, bool is_side_given);

/// Why a mesh is not the fibula of a tibia: the height of its head, or its distance; empty: accepted. Both
/// are in the tibia's anatomical frame, mm.
std::string fibula_rejection(const Mesh& fibula, const Mesh& tibia);

/// Whether the head of the fibula, its highest 20 mm, is lateral of the rotation centre. `fibula` is in the
/// tibia's anatomical frame.
bool is_fibula_lateral(const Mesh& fibula, Side side);

}  // namespace vrda::registration
