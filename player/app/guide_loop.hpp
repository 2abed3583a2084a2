/// A person (or a script) at the guided procedure.
#pragma once

#include <memory>
#include <optional>
#include <string>

#include "app/bench_screen.hpp"
#include "app/calibrate_options.hpp"
#include "app/guide_bench.hpp"
#include "app/guide_panel.hpp"
#include "app/key_script.hpp"
#include "app/show.hpp"
#include "app/stop_signals.hpp"

namespace vrda {

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

class GuideLoop {
 public:
  /// Opens a window unless the options want none. Throws InputError where there is no display, or the
  /// options' script or model cannot be read.
  GuideLoop(const CalibrateOptions& options, const BenchFile& bench, GuideSession& session,
            KeptCalibration& kept, const ShowStreams& streams);

  /// Until all is done or the operator leaves: by key, window, signal, or the end of a script without window.
  void run(GuideBench& before, StopSignals& stop);

 private:
  void round(GuideBench& before);
  void take_keys();
  void keep();
  void tell_words();
  void show(GuideBench& before);

  const CalibrateOptions& options_;
  const BenchFile& bench_;
  GuideSession& session_;
  KeptCalibration& kept_;
  ShowStreams streams_;
  GuidePanel panel_;
  GuideContent content_;
  Scene nothing_;
  std::optional<PlacedModel> model_;
  bool is_model_loaded_ = false;
  std::unique_ptr<BenchScreen> screen_;  ///< nothing: nobody looks
  ScreenWatch watch_;
  KeyScript script_;
  std::uint64_t n_rounds_ = 0, told_revision_ = 0;
  std::string pictured_;  ///< the task of the last picture
  int n_pictures_ = 0;
  bool is_over_ = false;
};

}  // namespace vrda
