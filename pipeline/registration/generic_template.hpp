/// The knee that is registered where no other template is given.
#pragma once

#include "registration/knee_surfaces.hpp"

namespace vrda::registration {

/// The generated knee "knee-template", divided into bone and cartilage.
TemplateKnee generic_template();

}  // namespace vrda::registration
