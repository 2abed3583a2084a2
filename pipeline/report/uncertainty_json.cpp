// Bands of an uncertain job, and the draws that their spread comes from, for the page.
#include "report/model_json.hpp"
#include "solve/spread.hpp"

namespace vrda::report {

Json uncertainty_json(const store::MotionModel& model)
{
  constexpr std::size_t most_shares = 8;
  constexpr const char* band_keys[] = {"smallest", "low", "median", "high", "largest"};
  if (!model.uncertainty) return nullptr;
  const store::UncertainMotion& motion = *model.uncertainty;
  Json quantities = Json::array();
  for (const solve::BandQuantity& quantity : solve::quantities_of(motion)) {
    Json json = {{"name", quantity.name}, {"unit", quantity.unit}};
    for (std::size_t p = 0; p < store::band_probabilities.size(); ++p) {
      std::vector<double> values;
      for (std::size_t i = 0; i < motion.n_solved.size(); ++i)
        values.push_back(solve::band_at(motion, p, i, quantity.row));
      json[band_keys[p]] = short_numbers(values);
    }
    Json shares = Json::array();
    for (const solve::SpreadShare& share : solve::spread_shares(motion, quantity.row)) {
      if (shares.size() == most_shares) break;
      shares.push_back({{"draw", motion.draw[share.draw]},
                        {"index", short_number(share.index)},
                        {"low", short_number(share.low)},
                        {"high", short_number(share.high)},
                        {"rank_correlation", short_number(share.rank_correlation)}});
    }
    json["shares"] = std::move(shares);
    quantities.push_back(std::move(json));
  }
  return {{"samples", motion.n_samples()}, {"sequence", motion.sequence}, {"seed", motion.seed},
          {"draws", motion.draw.size()},   {"solved", motion.n_solved},   {"quantities", std::move(quantities)}};
}

}  // namespace vrda::report
