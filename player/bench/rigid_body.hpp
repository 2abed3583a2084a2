/// Bodies of labelled markers, and how they are built from tracker frames (thesis 8.5).
#pragma once

#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "core/error.hpp"
#include "model/mesh.hpp"

namespace vrda::bench {

/// Position of each marker of a body, by label; nullopt if not visible. mm, tracker's frame.
using MarkerRow = std::vector<std::optional<Eigen::Vector3d>>;
using MarkerSpan = std::span<const std::optional<Eigen::Vector3d>>;

/// Largest number of markers of a body.
inline constexpr Eigen::Index max_markers = 64;

/// Positions further from the tracker are treated as not visible.
inline constexpr double farthest_mm = 1e6;

struct RigidBody {
  Points markers_mm;  ///< [n, 3] body frame, by label
};

/// Principal axes of a set of markers.
struct MarkerCloud {
  int n = 0;
  Eigen::Vector3d centre_mm = Eigen::Vector3d::Zero();
  Eigen::Matrix3d axes = Eigen::Matrix3d::Identity();  ///< columns: principal axes
  /// Singular values of the centred positions, descending: root of the sum of squares along each axis. The
  /// second is 0 for collinear markers.
  Eigen::Vector3d spread_mm = Eigen::Vector3d::Zero();
};

/// Of the visible markers of `body`.
MarkerCloud cloud_of(const RigidBody& body, MarkerSpan seen);

/// Markers with a smaller second singular value count as collinear. With 0.1 mm of noise, typical of an
/// optical tracker, 5 mm leave the rotation about their line uncertain by 0.1 / 5 rad: a degree.
inline constexpr double least_spread_mm = 5.0;

struct BodyOptions {
  double least_spread_mm = vrda::bench::least_spread_mm;
  double tolerance_mm = 1e-9;  ///< convergence: largest motion of a marker in an iteration
  int most_iterations = 2000;
  /// Coordinates in the required frame, for three or more markers. Empty: origin at the mean of the
  /// markers, X from the first marker to the second, Y towards the first marker at least half as far from
  /// that line as the furthest.
  MarkerRow given_mm;
};

enum class BuildStatus { converged, iteration_limit };

struct BuiltMarker {
  double residual_rms_mm = 0.0;  ///< root mean square over `n_frames`
  int n_frames = 0;              ///< used frames in which it was visible
};

struct BuiltBody {
  RigidBody body;
  std::vector<BuiltMarker> markers;
  double residual_rms_mm = 0.0;  ///< over all markers and frames
  double given_rms_mm = 0.0;     ///< RMS distance from the given coordinates; 0 if none
  int n_frames = 0;              ///< used
  int n_refused = 0;             ///< frames with fewer than three markers, or collinear ones
  BuildStatus status = BuildStatus::iteration_limit;
};

/// Least-squares shape over all visible markers, each frame fitted by a rigid transform (generalised
/// Procrustes without scale, with missing markers). All frames have the same labels. Throws FitError
/// naming `file` for fewer than three markers, collinear ones, or one never visible with three others.
/// Source: Gower (1975) Psychometrika 40:33-51; missing points as in ten Berge, Kiers, Commandeur (1993) Br
/// J Math Stat Psychol 46:1-13.
BuiltBody build_body(const std::vector<MarkerRow>& frames, const std::string& file,
                     const BodyOptions& options = {});

/// A rejected fit, with the marks to repeat.
class FitError : public InputError {
 public:
  explicit FitError(Facts facts, std::vector<std::size_t> marks = {})
      : InputError(std::move(facts)), marks_(std::move(marks))
  {
  }
  /// Indices of the marks to repeat; empty if unknown.
  const std::vector<std::size_t>& marks() const { return marks_; }

 private:
  std::vector<std::size_t> marks_;
};

}  // namespace vrda::bench
