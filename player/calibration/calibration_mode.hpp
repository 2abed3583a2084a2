/// Screen of the calibration session: lines of the task and text for the operator.
#pragma once

#include "calibration/calibration_pictures.hpp"
#include "show/loop.hpp"
#include "view/keys.hpp"

namespace vrda::calibration {

using view::faint, view::ink;

struct CalibrationPanelContent {
  CalibrationView view;                     ///< of the task
  std::vector<std::string> error_messages;  ///< problems of required devices
  std::string message;                      ///< error outside the procedure
  /// Of the last task from the truth, and how far it is: in px, mm or another unit of the task.
  std::string deviation;
  double deviation_value = 0.0;
  double time_left_s = 0.0;
  std::optional<Diagram> diagram;  ///< of the task; drawn if the layout has an operator's area
  bool has_help = false;
};

/// Deviations from the truth, px or mm: above the first amber, above the second red, and to be done again.
inline constexpr double fair_deviation = 2.0, large_deviation = 10.0;

class CalibrationPanel {
 public:
  explicit CalibrationPanel(const BenchFile& bench);

  const view::OverlayFont& font() const { return text_.font(); }
  /// Valid until the next call. Text is in the operator's area or, if the layout has none, at the bottom of
  /// the left eye's visible part.
  const view::Overlay& drawn(const CalibrationSession& session, const CalibrationPanelContent& content);

 private:
  void add_lines(const CalibrationPanelContent& content);
  void add_diagram(const Diagram& diagram, const view::Viewport& area, float top_px);

  view::OverlayText text_;
  view::Overlay overlay_;
  bench::DisplaySettings display_;
  view::OverlayReflector reflector_;
};

/// Draws a line into an overlay, anti-aliased if smooth, else in whole pixels.
void add_drawn_line(view::Overlay& overlay, const view::OverlayText& text, const DrawnLine& line);

/// "left edge 132 px".
std::string dial_text(const Dial& dial, double value);

// Runs a calibration session with an operator or a script.

struct ScriptLine {
  view::KeyPress press;
  int n_presses = 0;    ///< 0: a wait
  double wait_s = 0.0;  ///< loop time before the next line
};

/// Parses lines "press Right 12", "press Shift+Left 3", "press Enter", "wait 0.5"; # starts a comment. Keys:
/// letters, digits, Enter, Backspace, Escape, Space, Left, Right, Up, Down, with Shift+ or Control+ or both.
/// Throws InputError with `path` and the line.
std::vector<ScriptLine> parse_key_script(const std::string& text, const std::string& path);

/// Plays a key script.
class KeyScript {
 public:
  explicit KeyScript(std::vector<ScriptLine> lines) : lines_(std::move(lines)) {}

  /// Keys pressed at loop time `now_s`: at most one line per call, so that each is processed before the next.
  /// Valid until the next call.
  const std::vector<view::KeyPress>& keys(double now_s);
  bool is_over() const { return next_ == lines_.size(); }

 private:
  std::vector<ScriptLine> lines_;
  std::vector<view::KeyPress> keys_;
  std::size_t next_ = 0;
  double begun_s_ = -1.0;  ///< start of the current wait; negative: none
};

/// Writes the whole calibration file after each change of the session. With an empty path nothing is written.
class CalibrationWriter {
 public:
  CalibrationWriter(const BenchFile& bench, const std::string& path);
  /// Throws InputError like CalibrationFile::write(); the next call tries again.
  void write(const CalibrationSession& session);

 private:
  std::optional<bench::CalibrationFile> file_;
  std::uint64_t revision_ = 0;  ///< last written revision
};

class CalibrationMode final : public show::Mode {
 public:
  /// Opens a window unless headless. Throws InputError without a display, or for a bad script or model.
  CalibrationMode(const CalibrateOptions& options, const BenchFile& bench, CalibrationSession& session,
                  CalibrationWriter& kept, const show::Streams& streams);

  show::Sink& sink() { return sink_; }
  /// Sets the bench; must be called before the first round.
  void set_bench(CalibrationBench& bench) { calibration_bench_ = &bench; }

  /// True when all parts are done, the operator quits, or a headless script has ended.
  bool is_over() const override { return is_over_; }
  show::RoundTime round_time() const override;
  void take(const view::InputEvent& event) override;
  void advance(double elapsed_s) override;
  void draw() override;

 private:
  void press(const view::KeyPress& press);
  void press_in_task(const view::KeyPress& press);
  void take_pointer(const view::InputEvent& event);
  void take_gamepad(double elapsed_s);
  void note_task_end();
  void print_words();
  const BodyOutline* outline() const;
  void make_content();
  bool place_model();

  const CalibrateOptions& options_;
  const BenchFile& bench_;
  CalibrationSession& session_;
  CalibrationWriter& kept_;
  show::Streams streams_;
  CalibrationPanel panel_;
  CalibrationPanelContent content_;
  view::Scene nothing_;
  std::optional<AdjustedModel> model_;
  bool is_model_loaded_ = false;
  std::vector<BodyOutline> outlines_;  ///< of reference and moving body, or empty
  std::string drawn_task_;             ///< task of content_.diagram
  show::Sink sink_;
  CalibrationBench* calibration_bench_ = nullptr;
  bench::WindowCheck watch_;
  KeyScript script_;
  std::uint64_t n_rounds_ = 0, printed_revision_ = 0;
  double wheel_ = 0.0;                    ///< notches that are not yet presses
  std::optional<view::InputEvent> drag_;  ///< press of the button that is held over the picture
  view::GamepadKeys gamepad_;
  /// The current task, by part and name, with its typical time and the message for its end.
  struct AwaitedTask {
    std::string name;
    double typical_s = 0.0;
    std::optional<Deviation> deviation;
  };
  AwaitedTask awaited_;
  Pace pace_;
  std::string pictured_;  ///< task of the last picture
  std::size_t n_pictures_ = 0;
  bool is_over_ = false;
};

}  // namespace vrda::calibration
