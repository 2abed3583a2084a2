/// Texts of the files of a prepared job.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "job/case.hpp"
#include "model/coordinates.hpp"
#include "model/frames.hpp"
#include "model/ligaments.hpp"

namespace vrda::prepare {

/// A mesh file NAME.stl in its bone's anatomical frame, mm.
struct JobComponent {
  std::string name;
  std::string material;
  bool has_contact = true;
  double inset_mm = 0.0;  ///< negative: thickened, for cartilage that is not known
};

/// The kneecap of the job: a [[follower]] named "patella".
struct JobKneecap {
  std::vector<JobComponent> components;
  Eigen::Vector3d centre_mm = Eigen::Vector3d::Zero();
  JointCoordinates scanned_joint = JointCoordinates::Zero(), scanned = JointCoordinates::Zero();
  std::vector<job::TendonDirection> directions;
  bool has_wraps = false;
};

struct JobDescription {
  std::string title;
  std::string joint = "knee";
  Side side = Side::right;
  std::vector<JobComponent> reference, moving;
  bool has_ligaments = true;
  bool has_wraps = false;
  bool has_prior = true;                       ///< a prior of the motion, and the band
  std::optional<ClinicalCoordinates> scanned;  ///< pose in the scan, for a comment
  std::optional<Pose> X_scan_reference;        ///< where the reference's files are in the scan, mm
  std::string scan_space, scan_unit = "mm";    ///< LPS, RAS or empty; mm, cm or m
  std::optional<JobKneecap> patella;
  // Of another joint than a knee (prepare/joint_frame.hpp).
  std::vector<std::string> axes;  ///< from what each is, for comments
  Eigen::Vector3d delta = Eigen::Vector3d::UnitY(), axis = Eigen::Vector3d::UnitX();
  double least_flexion_deg = -100.0, most_flexion_deg = 20.0;  ///< of a hip
  std::vector<model::Fibre> fibres;                            ///< of an ankle: their ends
};

/// TOML. A knee: free varus, flexion 0 to 90 by 5, 20 N. Another joint: as its job in jobs/; the subtalar
/// joint turns about `axis`.
std::string job_text(const JobDescription& job);

/// Table of schemas/ligaments.md. `comment`: one line without #.
std::string ligament_table(const model::Ligaments& ligaments, const std::string& comment);

/// Table of schemas/followers.md: fibres with this strain in the scan, or with their slack lengths; and
/// lines. `followers`: their names.
std::string follower_table(const model::Ligaments& ligaments, const std::vector<std::string>& followers,
                           std::optional<double> strain, const std::string& comment);

/// JSON of schemas/wraps.schema.json.
std::string wraps_text(const model::Ligaments& ligaments, const std::vector<std::string>& followers = {});

}  // namespace vrda::prepare
