/// The parts of prepare.json (schemas/prepare.md).
#pragma once

#include <nlohmann/json.hpp>

#include "prepare/knee_landmarks.hpp"
#include "prepare/template_joint.hpp"

namespace vrda::app {

/// Unit, side, residuals, maps and scales of both bones, the pose of the scan.
nlohmann::ordered_json fit_json(const geometry::KneeFit& fit);

/// The landmarks with their distances from those of the fitted template; warns of those more than 10
/// mm off.
nlohmann::ordered_json landmarks_json(const prepare::KneeLandmarks& landmarks,
                                      const std::vector<double>& residuals_mm,
                                      std::vector<std::string>& warnings);

/// Side, scales and distances of a knee without meshes.
nlohmann::ordered_json scales_json(const prepare::LandmarkScales& scales, Side side);

/// Largest strain and tension a bundle, with a warning for those out of range.
nlohmann::ordered_json bundles_json(const model::Ligaments& ligaments, const prepare::SlackResult& slack,
                                    std::vector<std::string>& warnings);

nlohmann::ordered_json fibres_json(const prepare::TransferredLigaments& transferred,
                                   const prepare::SlackResult& slack);

}  // namespace vrda::app
