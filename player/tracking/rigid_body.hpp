/// A body of labelled markers, and how it is made from what the tracker saw (thesis 8.5).
#pragma once

#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "core/error.hpp"
#include "core/mesh.hpp"

namespace vrda {

/// Where each marker of a body is, by label; nothing where it is not seen. mm, tracker's frame.
using MarkerRow = std::vector<std::optional<Eigen::Vector3d>>;
using MarkerSpan = std::span<const std::optional<Eigen::Vector3d>>;

/// A body has no more markers than this.
inline constexpr Eigen::Index most_markers = 64;

/// What is further away from the tracker has not been seen by it.
inline constexpr double farthest_mm = 1e6;

struct RigidBody {
  Points markers_mm;  ///< [n, 3] body frame, by label
};

/// How a set of markers spreads about its mean.
struct MarkerCloud {
  int n = 0;
  Eigen::Vector3d centre_mm = Eigen::Vector3d::Zero();
  Eigen::Matrix3d axes = Eigen::Matrix3d::Identity();  ///< columns: its principal axes
  /// Singular values of the centred positions, falling: root of the sum of squares along each axis. The
  /// second is 0 for markers on a line.
  Eigen::Vector3d spread_mm = Eigen::Vector3d::Zero();
};

/// Of the markers of `body` that are seen.
MarkerCloud cloud_of(const RigidBody& body, MarkerSpan seen);

/// Markers whose second singular value is smaller count as collinear. With 0.1 mm of noise, which an optical
/// tracker has, 5 mm leave the turn about their line uncertain by 0.1 / 5 rad: a degree.
inline constexpr double least_spread_mm = 5.0;

struct BodyOptions {
  double least_spread_mm = vrda::least_spread_mm;
  double tolerance_mm = 1e-9;  ///< no marker moves further in the last iteration
  int most_iterations = 2000;
  /// Coordinates in the frame that the body is to have, for three or more markers. Empty: origin at the mean
  /// of the markers, X from the first marker to the second, Y towards the first marker that is at least half
  /// as far from that line as the furthest one.
  MarkerRow wanted_mm;
};

enum class BuildStatus { converged, iteration_limit };

struct BuiltMarker {
  double residual_rms_mm = 0.0;  ///< length of what a frame leaves, root mean square over `n_frames`
  int n_frames = 0;              ///< it was seen in, of those used
};

struct BuiltBody {
  RigidBody body;
  std::vector<BuiltMarker> markers;
  double residual_rms_mm = 0.0;  ///< over all markers and frames
  double wanted_rms_mm = 0.0;    ///< distance from the coordinates wanted; 0 where none were
  int n_frames = 0;              ///< used
  int n_refused = 0;             ///< frames of fewer than three markers, or of collinear ones
  BuildStatus status = BuildStatus::iteration_limit;
};

/// The shape that, moved rigidly onto each frame, leaves the least squares over all that was seen
/// (generalised Procrustes without scale, with gaps). Frames have the same labels. Throws FitRefusal naming
/// `file` for fewer than three markers, collinear ones, or a marker never seen together with three others.
/// Source: Gower (1975) Psychometrika 40:33-51; gaps as in ten Berge, Kiers, Commandeur (1993) Br J Math
/// Stat Psychol 46:1-13: what is not seen takes no part.
BuiltBody build_body(const std::vector<MarkerRow>& frames, const std::string& file,
                     const BodyOptions& options = {});

/// A fit that refuses its marks.
class FitRefusal : public InputError {
 public:
  explicit FitRefusal(Facts facts, std::vector<std::size_t> marks = {})
      : InputError(std::move(facts)), marks_(std::move(marks))
  {
  }
  /// Those to be made again, by their place among the fit's marks; empty: the fit does not know which.
  const std::vector<std::size_t>& marks() const { return marks_; }

 private:
  std::vector<std::size_t> marks_;
};

}  // namespace vrda
