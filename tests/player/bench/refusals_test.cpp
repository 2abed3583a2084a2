// What `vrda-player` refuses in bench files, calibration files and options: the rows of refusals.json.
#include "bench/calibration_file.hpp"
#include "player/bench/bench_texts.hpp"
#include "support/refusal_table.hpp"

namespace vrda::player_refusals_test {

/// A bench file, and the nominal calibration of its bench.
void desk(const test::Scratch& scratch)
{
  const bench::BenchFile bench = test::bench_of(test::bench_text());
  scratch.write("bench.toml", test::bench_text());
  scratch.write("c.toml", bench::calibration_text(bench::nominal_calibration(bench), bench));
}

const test::Scenes scenes{{"desk", desk}};

class PlayerRefusals : public testing::TestWithParam<test::RefusalRow> {};

TEST_P(PlayerRefusals, AreNamed)
{
  expect_row_refused(GetParam(), VRDA_PLAYER_PROGRAM, scenes);
}

INSTANTIATE_TEST_SUITE_P(Player, PlayerRefusals,
                         testing::ValuesIn(test::read_refusals(VRDA_SOURCE_DIR
                                                               "/tests/player/bench/refusals.json")),
                         test::name_of_row);

}  // namespace vrda::player_refusals_test
