/// A campaign: motion models for the product of axes of named levels (schemas/campaign.md).
#pragma once

#include <string>
#include <vector>

#include "run/case_spec.hpp"
#include "core/error.hpp"

namespace vrda::run {

struct CampaignCase {
  CaseSpec spec;
  std::vector<std::string> levels;  ///< [axes] names
  /// For the first spec.overrides, which come from levels: key of the level, "campaign.size.1.set".
  std::vector<std::string> override_keys = {};
};

struct Campaign {
  std::string file;  ///< path as given
  std::string title;
  std::vector<std::string> axes;    ///< in the order written: "subject", "method", ...
  std::vector<CampaignCase> cases;  ///< the last axis fastest
};

/// The cases of a campaign file or of a job with a [campaign] table; for a plain job one case named after the
/// file, without axes. `data_directory` is the default for subjects, `overrides` are appended to every case.
/// Opens no mesh. Throws InputError naming file, key, found and wanted.
Campaign campaign_of(const std::string& job_or_campaign, const std::string& data_directory,
                     const std::vector<std::string>& overrides);

/// Maps an error of a case to the campaign's file and key if a level caused it, and names the case.
InputError error_of_case(const Campaign& campaign, const CampaignCase& one, const InputError& error);

}  // namespace vrda::run
