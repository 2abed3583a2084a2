/// A person (or a script) at the guided procedure.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "bench/screen_watch.hpp"
#include "calibrate/calibrate.hpp"
#include "calibrate/guide_bench.hpp"
#include "calibrate/guide_panel.hpp"
#include "loop/loop.hpp"
#include "view/keys.hpp"

namespace vrda {

struct ScriptLine {
  KeyPress press;
  int n_presses = 0;    ///< 0: it waits
  double wait_s = 0.0;  ///< of the loop, before the next line
};

/// "press Right 12", "press Shift+Left 3", "press Enter", "wait 0.5"; behind # nothing counts. Keys are
/// letters, digits, Enter, Backspace, Escape, Space, Left, Right, Up, Down, with Shift+ or Control+ or both.
/// Throws InputError naming `path` and the line.
std::vector<ScriptLine> parsed_key_script(const std::string& text, const std::string& path);

/// Gives the keys as time goes on.
class KeyScript {
 public:
  explicit KeyScript(std::vector<ScriptLine> lines) : lines_(std::move(lines)) {}

  /// What is pressed at `now_s` of the loop: of one line at a time, so that each is answered before the next.
  /// Valid until the next call.
  const std::vector<KeyPress>& keys(double now_s);
  bool is_over() const { return next_ == lines_.size(); }

 private:
  std::vector<ScriptLine> lines_;
  std::vector<KeyPress> keys_;
  std::size_t next_ = 0;
  double begun_s_ = -1.0;  ///< of the wait under way; below 0: none
};

/// The calibration's file, written whole whenever the session has something new. An empty path keeps nothing.
class KeptCalibration {
 public:
  KeptCalibration(const BenchFile& bench, std::string path) : bench_(bench), path_(std::move(path)) {}
  /// Throws InputError where it cannot be written; the next call tries again.
  void write(const GuideSession& session);

 private:
  const BenchFile& bench_;
  std::string path_;
  std::uint64_t revision_ = 0;  ///< of what it was begun with
};

class GuideMode final : public Mode {
 public:
  /// Opens a window unless the options want none. Throws InputError where there is no display, or the
  /// options' script or model cannot be read.
  GuideMode(const CalibrateOptions& options, const BenchFile& bench, GuideSession& session,
            KeptCalibration& kept, const Streams& streams);

  Sink& sink() { return sink_; }
  /// What stands before the operator: wanted before the first round.
  void stand_before(GuideBench& bench) { before_ = &bench; }

  /// All is done or the operator leaves: by key, or the end of a script without window.
  bool is_over() const override { return is_over_; }
  RoundTime round_time() const override;
  void take(const InputEvent& event) override;
  void advance(double elapsed_s) override;
  void draw() override;

 private:
  void press(const KeyPress& press);
  void tell_words();
  void make_content();
  bool place_model();

  const CalibrateOptions& options_;
  const BenchFile& bench_;
  GuideSession& session_;
  KeptCalibration& kept_;
  Streams streams_;
  GuidePanel panel_;
  GuideContent content_;
  Scene nothing_;
  std::optional<PlacedModel> model_;
  bool is_model_loaded_ = false;
  Sink sink_;
  GuideBench* before_ = nullptr;
  ScreenWatch watch_;
  KeyScript script_;
  std::uint64_t n_rounds_ = 0, told_revision_ = 0;
  std::string pictured_;  ///< the task of the last picture
  std::size_t n_pictures_ = 0;
  bool is_over_ = false;
};

}  // namespace vrda
