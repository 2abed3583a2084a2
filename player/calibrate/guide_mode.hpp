/// Runs a calibration session with an operator or a script.
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
  int n_presses = 0;    ///< 0: a wait
  double wait_s = 0.0;  ///< loop time before the next line
};

/// Parses lines "press Right 12", "press Shift+Left 3", "press Enter", "wait 0.5"; # starts a comment. Keys:
/// letters, digits, Enter, Backspace, Escape, Space, Left, Right, Up, Down, with Shift+ or Control+ or both.
/// Throws InputError with `path` and the line.
std::vector<ScriptLine> parsed_key_script(const std::string& text, const std::string& path);

/// Plays a key script.
class KeyScript {
 public:
  explicit KeyScript(std::vector<ScriptLine> lines) : lines_(std::move(lines)) {}

  /// Keys pressed at loop time `now_s`: at most one line per call, so that each is processed before the next.
  /// Valid until the next call.
  const std::vector<KeyPress>& keys(double now_s);
  bool is_over() const { return next_ == lines_.size(); }

 private:
  std::vector<ScriptLine> lines_;
  std::vector<KeyPress> keys_;
  std::size_t next_ = 0;
  double begun_s_ = -1.0;  ///< start of the current wait; negative: none
};

/// Writes the whole calibration file after each change of the session. With an empty path nothing is written.
class KeptCalibration {
 public:
  KeptCalibration(const BenchFile& bench, std::string path) : bench_(bench), path_(std::move(path)) {}
  /// Throws InputError on a write error; the next call tries again.
  void write(const GuideSession& session);

 private:
  const BenchFile& bench_;
  std::string path_;
  std::uint64_t revision_ = 0;  ///< last written revision
};

class GuideMode final : public Mode {
 public:
  /// Opens a window unless headless. Throws InputError without a display, or for a bad script or model.
  GuideMode(const CalibrateOptions& options, const BenchFile& bench, GuideSession& session,
            KeptCalibration& kept, const Streams& streams);

  Sink& sink() { return sink_; }
  /// Sets the bench; must be called before the first round.
  void stand_before(GuideBench& bench) { guide_bench_ = &bench; }

  /// True when all parts are done, the operator quits, or a headless script has ended.
  bool is_over() const override { return is_over_; }
  RoundTime round_time() const override;
  void take(const InputEvent& event) override;
  void advance(double elapsed_s) override;
  void draw() override;

 private:
  void press(const KeyPress& press);
  void print_words();
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
  GuideBench* guide_bench_ = nullptr;
  ScreenWatch watch_;
  KeyScript script_;
  std::uint64_t n_rounds_ = 0, printed_revision_ = 0;
  std::string pictured_;  ///< task of the last picture
  std::size_t n_pictures_ = 0;
  bool is_over_ = false;
};

}  // namespace vrda
