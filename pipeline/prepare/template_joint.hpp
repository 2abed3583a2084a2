/// The knee whose frames and ligaments are transferred to a subject.
#pragma once

#include "job/case.hpp"
#include "geometry/knee_fit.hpp"

namespace vrda::prepare {

/// Canonical axes of its own side, as loaded.
struct TemplateJoint {
  job::Case joint;
  geometry::TemplateKnee knee;
  Mesh fibula;  ///< empty: the template has none
};

/// The bone and cartilage of a body by the materials of its components; menisci and fibula are left out.
geometry::BoneSurfaces surfaces_of(const Body& body);

/// A knee with ligaments as a template; a left knee is mirrored. The fibula is the moving component whose
/// name contains "fibula". Throws InputError naming `joint.title` for another joint.
TemplateJoint template_of(const job::Case& joint);

/// The generated knee "knee-template".
TemplateJoint generic_template();

/// The template of the other side.
TemplateJoint mirrored(const TemplateJoint& joint);

}  // namespace vrda::prepare
