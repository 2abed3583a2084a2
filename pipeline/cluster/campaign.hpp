/// A study: many motion models to make, the product of axes of named levels (schemas/campaign.md).
#pragma once

#include <string>
#include <vector>

#include "cluster/case_spec.hpp"
#include "core/error.hpp"

namespace vrda {

struct CampaignCase {
  CaseSpec spec;
  std::vector<std::string> levels;  ///< [axes] names
  /// Of the first of spec.overrides, those that levels give: where, "campaign.size.1.set".
  std::vector<std::string> set_at = {};
};

struct Campaign {
  std::string file;  ///< as it was given
  std::string title;
  std::vector<std::string> axes;    ///< in the order written: "subject", "method", ...
  std::vector<CampaignCase> cases;  ///< the last axis fastest
};

/// The cases of a job with a [campaign] table or of a campaign file; of a plain job the one case named after
/// the file, with no axis. `data_directory` holds for subjects without one of their own, `overrides` come
/// last in every case. Opens no mesh. Throws InputError naming file, key, found and wanted.
Campaign campaign_of(const std::string& job_or_campaign, const std::string& data_directory,
                     const std::vector<std::string>& overrides);

/// What is wrong with a case, told as a fault of the campaign's file where a level's settings are wrong.
/// Names the case where there are several.
InputError fault_of_case(const Campaign& campaign, const CampaignCase& one, const InputError& error);

}  // namespace vrda
