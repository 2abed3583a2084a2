/// Looks at every case of a campaign before anything is solved, and estimates what it will take.
#pragma once

#include <string>
#include <vector>

#include "cluster/campaign.hpp"
#include "cluster/cost.hpp"
#include "load/case.hpp"
#include "sweep/sweep.hpp"

namespace vrda {

struct PlannedCase {
  CampaignCase campaign_case;
  Case job_case;  ///< without bodies, survey and job text
  SweepPlan plan;
  CaseSize size;
  CaseCost cost;
  std::string same_as;        ///< an earlier case that gives the same motion; empty: none
  std::string same_steps_as;  ///< an earlier one that only scaling tells from this: one journal serves both
};

/// Reads every job, and each set of meshes once. Throws InputError for the first case that is wrong, named in
/// the message where there are several. Cost: a few ms a case, and loading each set of meshes.
std::vector<PlannedCase> planned_cases(const Campaign& campaign);

}  // namespace vrda
