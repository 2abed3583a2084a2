/// Whether a fit is that of a knee.
#pragma once

#include <string>
#include <vector>

#include "geometry/knee_fit.hpp"

namespace vrda::geometry {

/// Why a knee is refused: which measure is out of range, with its limit; empty: accepted.
std::vector<std::string> rejection_reasons(const KneeFit& fit, const KneeSurfaces& subject);

/// The mistake that explains a refusal: a wrong side or unit in `known`, exchanged bones, or an open sheet
/// wound inward; empty: none found. Repeats the whole fit for each, unless only the length of a bone is
/// refused.
std::string probable_cause(const KneeFit& fit, const KneeSurfaces& subject, const TemplateKnee& reference,
                           const KneeFitOptions& known = {});

/// Accepted, but doubtful: little bone, cartilage only, an uncertain side.
std::vector<std::string> fit_warnings(const KneeFit& fit, const KneeSurfaces& subject, bool is_side_given);

/// What shows that a mesh is no surface, such as random triangles; empty: none. A search of the nearest point
/// visits all of its triangles, so a fit takes minutes. In any unit.
std::string tangle_in(const Mesh& mesh);

/// Whether a mesh is the part that it is said to be.
struct PartCheck {
  std::string rejection;  ///< empty: accepted
  std::string doubt;      ///< of an accepted part; empty: none
};

enum class CartilageOf { femur, tibia };

/// Cartilage lies on its own bone, not on the other nor, as a meniscus does, between both. In the scan's
/// axes, mm; either bone may be empty.
PartCheck cartilage_check(const Mesh& part, CartilageOf bone, const Mesh& own_bone, const Mesh& other_bone);

/// Whether nine tenths of the points of `part` are on `surface`, within 0.5 mm or less for small parts: the
/// same surface, a copy with other triangles, or a piece of it. Meshes in mm without unused vertices.
bool is_part_of(const Mesh& part, const Mesh& surface);

/// A meniscus lies near the tibia (bone and cartilage). In the scan's axes, mm.
PartCheck meniscus_check(const Mesh& part, const Mesh& tibia);

/// Why a mesh is not the fibula of a tibia: a copy of the tibia, the height of its head, or its distance;
/// empty: accepted. Both are in the tibia's anatomical frame, mm.
std::string fibula_rejection(const Mesh& fibula, const Mesh& tibia);

/// Whether the head of the fibula, its highest 20 mm, is lateral of the rotation centre. `fibula` is in the
/// tibia's anatomical frame.
bool is_fibula_lateral(const Mesh& fibula, Side side);

}  // namespace vrda::geometry
