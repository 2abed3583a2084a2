#include "player/bench/bench_texts.hpp"

namespace vrda::test {

std::string bench_head(const std::string& leg, const std::string& head)
{
  return "title = \"Desk\"\nleg = \"" + leg + "\"\nhead = \"" + head + "\"\n";
}

std::string bench_text()
{
  return bench_head() + display_table + tracker_table + two_bodies + board_table;
}

bench::BenchFile bench_of(const std::string& text)
{
  return bench::parse_bench_file(text, "bench.toml");
}

}  // namespace vrda::test
