/// Bench files for tests.
#pragma once

#include "bench/bench_file.hpp"

namespace vrda::test {

/// Lines before the first table, without prediction.
inline std::string bench_head(const std::string& leg = "two-bodies", const std::string& head = "stage")
{
  return "title = \"Desk\"\nleg = \"" + leg + "\"\nhead = \"" + head + "\"\n";
}

inline const std::string display_table = "[display]\nwidth = 1280\nheight = 1024\nlayout = \"quarters\"\n";
inline const std::string tracker_table = "[tracker]\nport = 18944\n";
inline const std::string two_bodies = "[body.femur]\ntool = \"femur\"\n[body.tibia]\ntool = \"tibia\"\n";
inline const std::string board_table = "[board]\nport = \"/tmp/board\"\npotentiometer = \"selected\"\n";

/// Two bodies with tools, head on the stage, and a board.
inline std::string bench_text()
{
  return bench_head() + display_table + tracker_table + two_bodies + board_table;
}

inline bench::BenchFile bench_of(const std::string& text)
{
  return bench::parse_bench_file(text, "bench.toml");
}

}  // namespace vrda::test
