/// The joint in the window: the file of the command line, then those dropped on it.
#pragma once

#include <memory>
#include <string>

#include "show/session.hpp"

namespace vrda {

class ShownModel {
 public:
  /// Shows `model`, which came from `file`. The renderer must outlive this. Throws InputError where the
  /// options want what the model has not.
  ShownModel(const std::string& file, MotionModel model, const SessionOptions& options, Renderer& renderer);

  Session& session() const { return *session_; }
  const std::string& file() const { return file_; }
  const std::string& title() const { return title_; }

  /// Shows the motion model in `file`, with the same options as far as it has their set. What stands in the
  /// way is one message on the picture, and the joint stays. True: there is another joint.
  bool open(const std::string& file);

 private:
  void show(MotionModel model, const SessionOptions& options);

  SessionOptions options_;
  Renderer& renderer_;
  std::string file_, title_;
  std::unique_ptr<Session> session_;
};

}  // namespace vrda
