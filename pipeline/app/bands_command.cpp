// `vrda bands`: the bands of an uncertain job, as CSV or JSON.

#include <cmath>
#include <cstdio>
#include <nlohmann/json.hpp>

#include "app/commands.hpp"
#include "core/document.hpp"
#include "core/text.hpp"
#include "model/coordinates.hpp"
#include "solve/case_solver.hpp"

namespace vrda::app {
namespace {

using Json = nlohmann::ordered_json;
using solve::BandQuantity;

struct BandsOptions {
  std::string file;
  std::string table = "bands";  ///< bands, fibres, shares or samples
  bool as_json = false;
};

constexpr std::array<const char*, 5> probability_names{"min", "p05", "p50", "p95", "max"};

const char* suffix_of(const BandQuantity& quantity)
{
  const std::string unit = quantity.unit;
  return unit == "degree" ? "_deg" : unit == "mm" ? "_mm" : "_n";
}

// Nothing for a missing number.
std::string cell(double value)
{
  return std::isfinite(value) ? short_decimal(value, 6) : "";
}

Json json_number(double value)
{
  return std::isfinite(value) ? Json(std::round(1e6 * value) / 1e6) : Json();
}

class BandTables {
 public:
  explicit BandTables(const store::MotionModel& model)
      : model_(model),
        motion_(*model.uncertainty),
        key_(model.frames ? model.frames->key : model.flexion_deg),
        key_name_(model.frames ? model.frames->key_name : "flexion_deg"),
        quantities_(solve::quantities_of(motion_))
  {
  }

  void print(const std::string& table) const
  {
    if (table == "bands") print_bands();
    if (table == "fibres") print_fibres();
    if (table == "shares") print_shares();
    if (table == "samples") print_samples();
  }

  Json json() const
  {
    Json quantities = Json::array();
    for (const BandQuantity& quantity : quantities_) {
      Json one = {{"name", quantity.name}, {"unit", quantity.unit}};
      for (std::size_t p = 0; p < probability_names.size(); ++p) {
        Json values = Json::array();
        for (std::size_t i = 0; i < key_.size(); ++i) values.push_back(json_number(quantity.band_at(p, i)));
        one[probability_names[p]] = std::move(values);
      }
      Json shares = Json::array();
      for (const solve::SpreadShare& share : solve::spread_shares(quantity)) {
        shares.push_back({{"draw", motion_.draw[share.draw]},
                          {"first_order", json_number(share.index)},
                          {"low", json_number(share.low)},
                          {"high", json_number(share.high)},
                          {"rank_correlation", json_number(share.rank_correlation)}});
      }
      one["shares"] = std::move(shares);
      quantities.push_back(std::move(one));
    }
    return {{"samples", motion_.n_samples()}, {"sequence", motion_.sequence},
            {"seed", motion_.seed},           {key_name_, key_},
            {"solved", motion_.n_solved},     {"quantities", quantities}};
  }

 private:
  void print_bands() const
  {
    std::printf("%s,solved", key_name_.c_str());
    for (const BandQuantity& quantity : quantities_) {
      for (const char* p : probability_names)
        std::printf(",%s_%s%s", quantity.name.c_str(), p, suffix_of(quantity));
    }
    for (std::size_t i = 0; i < key_.size(); ++i) {
      std::printf("\n%s,%d", cell(key_[i]).c_str(), motion_.n_solved[i]);
      for (const BandQuantity& quantity : quantities_) {
        for (std::size_t p = 0; p < probability_names.size(); ++p)
          std::printf(",%s", cell(quantity.band_at(p, i)).c_str());
      }
    }
    std::printf("\n");
  }

  void print_fibres() const
  {
    std::printf("fibre,%s,tension_min_n,tension_p05_n,tension_p50_n,tension_p95_n,tension_max_n\n",
                key_name_.c_str());
    const std::vector<std::string> names =
        model_.ligaments ? model_.ligaments->name : std::vector<std::string>{};
    for (std::size_t k = 0; k < names.size(); ++k) {
      for (std::size_t i = 0; i < key_.size(); ++i) {
        std::printf("%s,%s", quoted_csv(names[k]).c_str(), cell(key_[i]).c_str());
        for (std::size_t p = 0; p < probability_names.size(); ++p)
          std::printf(",%s", cell(motion_.tension_band_n[(p * key_.size() + i) * names.size() + k]).c_str());
        std::printf("\n");
      }
    }
  }

  void print_shares() const
  {
    std::printf("quantity,draw,%s,rank_correlation,first_order,first_order_low,first_order_high\n",
                key_name_.c_str());
    for (const BandQuantity& quantity : quantities_) {
      for (std::size_t d = 0; d < motion_.draw.size(); ++d) {
        for (std::size_t i = 0; i < key_.size(); ++i) {
          const store::UncertainPose& of = *quantity.of;
          const std::size_t at = quantity.share_row(i, d);
          std::printf("%s,%s,%s,%s,%s,%s,%s\n", quantity.name.c_str(), quoted_csv(motion_.draw[d]).c_str(),
                      cell(key_[i]).c_str(), cell(of.rank_correlation[at]).c_str(),
                      cell(of.first_order[at]).c_str(), cell(of.first_order_low[at]).c_str(),
                      cell(of.first_order_high[at]).c_str());
        }
      }
    }
  }

  void print_samples() const
  {
    std::printf("sample,%s,status", key_name_.c_str());
    for (const char* name : {"flexion_deg", "varus_deg", "internal_deg", "anterior_mm", "proximal_mm",
                             "lateral_mm", "contact_force_n"})
      std::printf(",%s", std::string(name) == key_name_ ? "solved_flexion_deg" : name);
    for (const store::UncertainFollower& follower : motion_.followers) {
      std::printf(",%s_status", follower.name.c_str());
      for (std::size_t k = 0; k < n_joint_coordinates; ++k)
        std::printf(",%s_%s%s", follower.name.c_str(), follower_coordinate_names[k], unit_suffix(k));
    }
    for (const std::string& draw : motion_.draw) std::printf(",%s", quoted_csv(draw).c_str());
    std::printf("\n");
    for (std::size_t s = 0; s < motion_.n_samples(); ++s) {
      for (std::size_t i = 0; i < key_.size(); ++i) {
        const std::size_t at = s * key_.size() + i;
        std::printf("%zu,%s,%s", s + 1, cell(key_[i]).c_str(),
                    name_of(static_cast<StepStatus>(motion_.status[at])));
        print_coordinates(motion_, at);
        std::printf(",%s", cell(motion_.contact_force_n[3 * at]).c_str());
        for (const store::UncertainFollower& follower : motion_.followers) {
          std::printf(",%s", name_of(static_cast<StepStatus>(follower.status[at])));
          print_coordinates(follower, at);
        }
        for (std::size_t d = 0; d < motion_.draw.size(); ++d)
          std::printf(",%s", cell(motion_.value[s * motion_.draw.size() + d]).c_str());
        std::printf("\n");
      }
    }
  }

  static void print_coordinates(const store::UncertainPose& of, std::size_t at)
  {
    for (const auto* rows : {&of.rotation_deg, &of.translation_mm}) {
      for (std::size_t k = 0; k < 3; ++k) std::printf(",%s", cell((*rows)[3 * at + k]).c_str());
    }
  }

  const store::MotionModel& model_;
  const store::UncertainMotion& motion_;
  const std::vector<double>& key_;
  const std::string key_name_;
  const std::vector<BandQuantity> quantities_;
};

core::ExitCode bands_command(const BandsOptions& options)
{
  const store::MotionModel model = store::read_motion_model(options.file);
  if (!model.uncertainty)
    throw InputError(
        {options.file, "/uncertainty", "no samples", "the motion model of a job with [uncertainty]"});
  const BandTables tables(model);
  if (options.as_json) {
    std::printf("%s\n", core::json_text(tables.json(), 1).c_str());
  } else {
    tables.print(options.table);
  }
  return core::ExitCode::done;
}

}  // namespace

void declare_bands(Command& c)
{
  auto& o = c.options<BandsOptions>();
  c.model(o.file, "Motion model (HDF5) of a job with [uncertainty]");
  const Option chosen = c.option("--table", o.table,
                                 "bands: quantiles over flexion; fibres: of their tension; shares: "
                                 "contributions of the draws to the spread; samples: draws and poses")
                            .one_of({"bands", "fibres", "shares", "samples"})
                            .shows_default();
  c.json(o.as_json, "Print bands and shares as JSON").excludes(chosen);
  c.runs([&o] { return bands_command(o); });
}

}  // namespace vrda::app
