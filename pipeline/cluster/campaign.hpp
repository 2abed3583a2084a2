/// A study: many motion models to make, the product of axes of named levels (schemas/campaign.md).
#pragma once

#include <string>
#include <vector>

#include "cluster/case_spec.hpp"

namespace vrda {

struct CampaignCase {
  CaseSpec spec;
  std::vector<std::string> levels;  ///< [axes] names
};

struct Campaign {
  std::string title;
  std::vector<std::string> axes;    ///< in the order written: "subject", "method", ...
  std::vector<CampaignCase> cases;  ///< the last axis fastest
};

/// The cases of a job with a [campaign] table or of a campaign file; of a plain job the one case named after
/// the file, with no axis. `data_directory` holds for subjects without one of their own, `overrides` come
/// last in every case. Opens no mesh. Throws InputError naming file, key, found and wanted.
Campaign campaign_of(const std::string& job_or_campaign, const std::string& data_directory,
                     const std::vector<std::string>& overrides);

}  // namespace vrda
