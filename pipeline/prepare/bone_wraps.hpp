/// Wraps that keep transferred fibres out of the subject's bones.
#pragma once

#include <string>
#include <vector>

#include "prepare/template_joint.hpp"

namespace vrda::prepare {

/// A bundle that crosses bone, or would without its wraps.
struct BundleCrossing {
  std::string bundle;
  int n_fibres = 0;
  int n_wrapped = 0;  ///< fibres over a wrap fitted here
  /// Deepest point of a fibre inside a bone over the solved flexions.
  double straight_mm = 0.0;  ///< before the wraps
  double left_mm = 0.0;      ///< with them
  std::string bone;          ///< name of the object that `straight_mm` crosses
  double flexion_rad = 0.0;  ///< of `straight_mm`
};

/// Fits a wrap over bone to each fibre of `subject` that is deeper than 0.5 mm inside one at a pose of
/// `slack`, and sets the slack lengths again by `lengths`, which is that of `subject`, with the wrapped
/// lengths. Other slack lengths give other poses: up to three times. A wrap of the template is replaced only
/// where it leaves more than the fitted one. The bundles that cross or crossed bone, in order; `slack` is
/// that of the last wraps.
std::vector<BundleCrossing> wrap_over_bones(job::Case& subject, SlackLengths& lengths, SlackResult& slack);

}  // namespace vrda::prepare
