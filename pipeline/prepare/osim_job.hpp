/// A job from an OpenSim model: one of its joints with the meshes, ligaments, wraps and muscles of both
/// bodies (schemas/osim.md).
#pragma once

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "model/frames.hpp"

namespace vrda::prepare {

struct OsimJobOptions {
  std::string file;                  ///< the model
  std::string joint;                 ///< name of the joint
  std::vector<std::string> folders;  ///< of mesh files, searched after the model's own
  std::optional<Side> side;          ///< default: by the names and axes of the joint
  std::vector<std::string> drawn;  ///< meshes that are only drawn; empty: menisci and fibula, "none": no mesh
  std::vector<std::string> followers;  ///< bodies that follow the joint; empty: patella and fabella
  std::optional<double> muscle_share;  ///< of the largest isometric force: muscles become lines of tension
};

struct OsimJob {
  std::string name;                                        ///< of the job file, without extension
  std::string text;                                        ///< TOML
  std::vector<std::pair<std::string, std::string>> files;  ///< names and contents of the files that it needs
  std::vector<std::string> taken, left_out;  ///< what of the model is in the job, and what is not
};

/// Throws InputError naming file and component for another version than 4, damaged XML, an unknown joint or
/// type of joint, a frame or mesh that is missing, and a body without meshes.
OsimJob osim_job(const OsimJobOptions& options);

}  // namespace vrda::prepare
