/// The knee whose frames and ligaments are transferred to a subject.
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "geometry/gap_query.hpp"
#include "geometry/knee_fit.hpp"
#include "job/case.hpp"

namespace vrda::solve {
struct Joint;
}

namespace vrda::prepare {

/// Canonical axes of its own side, as loaded.
struct TemplateJoint {
  job::Case joint;
  geometry::TemplateKnee knee;
  Mesh fibula;                                ///< empty: the template has none
  std::optional<job::Follower> patella = {};  ///< the first follower of the job; `joint` has none
};

/// The bone and cartilage of a body by the materials of its components; menisci and fibula are left out.
geometry::BoneSurfaces surfaces_of(const Body& body);

/// A knee with ligaments as a template; a left knee is mirrored. The fibula is the moving component whose
/// name contains "fibula". Throws InputError naming `joint.title` for another joint.
TemplateJoint template_of(const job::Case& joint);

/// The generated knee "knee-template".
TemplateJoint generic_template();

/// The generated knee "knee" of `vrda shape`, without its shafts.
TemplateJoint generated_knee();

/// The template of the other side.
TemplateJoint mirrored(const TemplateJoint& joint);

// Slack lengths of transferred fibres, from both knees at the neutral pose.

/// Of the contact that `prepare` solves with and writes: the foundation of articular cartilage. Exact contact
/// rests on single points of a scanned surface, which its noise moves.
inline constexpr double contact_stiffness_n_per_mm3 = 2.0, contact_thickness_mm = 4.0;

/// The neutral pose after settling contact: varus until both compartments' gaps along Delta are equal, along
/// Delta to touch, then both balanced under the push on compliant surfaces.
struct SettledPose {
  Attitude attitude;  ///< flexion 0
  MovingPose pose;    ///< solver frame
  bool has_contact = false;
};
SettledPose settled_pose(const job::Case& joint);

/// The triangles of a tibia on one side (z of sign `side`) of the eminence between the plateaus, which does
/// not touch the condyles.
geometry::GapTree plateau_tree(const Mesh& tibia, double side);

/// Lengths of all fibres at a pose, wrapped.
std::vector<double> fibre_lengths_mm(const job::Case& joint, const SettledPose& at);

/// Largest strain and tension over the solved flexions.
struct FibreLoads {
  std::vector<double> largest_strain;     ///< [fibres]
  std::vector<double> largest_tension_n;  ///< [fibres]
  std::vector<double> flexion_rad;        ///< [n_solved], as the next
  std::vector<Pose> X_reference_moving;
  int n_solved = 0;
  int n_flexions = 0;
};
struct SlackResult {
  SettledPose settled;
  FibreLoads loads;                        ///< of the last solution
  std::vector<double> template_strain;     ///< [fibres] largest of the template
  std::vector<std::int32_t> lengthenings;  ///< fibres lengthened after each solution
};

/// Sets the slack lengths of `subject`, whose fibres are those of `reference` in the same order. The search
/// trees and the template's strains are found once, for several calls. `is_stopped` is polled; if it is true,
/// the results mean nothing. Both joints must outlive it.
class SlackLengths {
 public:
  SlackLengths(job::Case& subject, const job::Case& reference, int n_threads,
               std::function<bool()> is_stopped = {});

  /// The template's lengths times the ratio of lengths at the settled poses. Then at most four solutions
  /// lengthen the fibres strained beyond the template's largest strain + 0.05. From the scan's pose, fibres
  /// were strained by 0.3 and more.
  SlackResult set();

  bool is_stopped() const { return is_stopped_ && is_stopped_(); }

 private:
  using Bodies = std::shared_ptr<const solve::Joint>;
  // Solves the joint with free varus at 0, 10, ... 90 degrees of flexion.
  FibreLoads solved_loads(const job::Case& joint, const Bodies& bodies) const;

  job::Case& subject_;
  const job::Case& reference_;
  int n_threads_;
  std::function<bool()> is_stopped_;
  Bodies bodies_;
  SettledPose settled_;
  std::vector<double> template_mm_, template_strain_;
};

/// Where a scan shows bones only: mean over both compartments of the gap between the bones along the tibia's
/// axis in the pose of the scan. NaN where a compartment has no bone above it.
double scanned_gap_mm(const geometry::KneeFit& fit, const geometry::KneeSurfaces& subject);

/// The part of that gap that is cartilage: both layers together are 1.5 to 5 mm thick.
double cartilage_in_gap_mm(double gap_mm);

// Whether a job's frame, side and unit agree with its bones.

/// The job's keys of the frames of both bodies.
struct FrameKeys {
  std::string reference = "frame";
  std::string moving = "frame";
};

/// Compares a knee's frame, side and unit with those of the generic template registered onto its bones. Empty
/// if they agree, or if the bones differ too much from the template (in flexion, for example), or if one is
/// missing. Each warning begins with the keys that it is about.
std::vector<std::string> frame_warnings(const job::Case& knee, const FrameKeys& keys = {});

}  // namespace vrda::prepare
