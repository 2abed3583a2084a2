#include "cluster/campaign.hpp"

namespace vrda {

Campaign campaign_of(const std::string& job_or_campaign, const std::string& data_directory,
                     const std::vector<std::string>& overrides)
{
  Campaign campaign;
  campaign.cases.push_back({case_of_job(job_or_campaign, data_directory, overrides), {}});
  return campaign;
}

}  // namespace vrda
