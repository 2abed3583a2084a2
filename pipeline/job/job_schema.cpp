#include "job/job_schema.hpp"

#include "core/error.hpp"
#include "core/text.hpp"
#include "core/schema.hpp"

namespace vrda::job {

const core::DocumentSchema& campaign_schema();  // schemas/campaign.schema.json
const core::DocumentSchema& job_schema();       // schemas/job.schema.json

namespace {

constexpr const char* campaign_key = "campaign";

// The [campaign] table only, the subject of its schema.
core::Document campaign_part(const core::Document& document)
{
  const core::DocumentValue* table = document.root.find(campaign_key);
  check(table != nullptr, "the document has no [campaign]");
  return {document.file, {core::DocumentValue::Table{{campaign_key, *table}}}, document.overridden};
}

core::DocumentValue without_campaign(const core::DocumentValue& root)
{
  core::DocumentValue::Table kept;
  for (const core::DocumentEntry& entry : *root.table()) {
    if (entry.key != campaign_key) kept.push_back(entry);
  }
  return {kept, root.line};
}

// Checks the names of the job keys that the levels of an axis set.
void check_settings(const core::Document& document, const core::DocumentEntry& axis)
{
  const core::DocumentValue::List* levels = axis.value.list();
  for (std::size_t i = 0; levels != nullptr && i < levels->size(); ++i) {
    const core::DocumentValue* settings = (*levels)[i].find("set");
    const std::string at = "campaign." + axis.key + "." + std::to_string(i) + ".set.";
    if (settings != nullptr) job_schema().check_known_keys({document.file, *settings, {}, at});
  }
}

}  // namespace

core::DocumentValue checked_job(const core::Document& document)
{
  if (is_campaign_only(document.root)) {
    throw InputError({document.file, "reference", "a campaign without a joint",
                      "a job with [reference] and [moving]; run a campaign with vrda plan and vrda submit"});
  }
  const core::DocumentValue job = job_schema().checked(document);
  if (document.root.find(campaign_key) != nullptr) campaign_schema().checked(campaign_part(document));
  return without_campaign(job);
}

bool is_campaign_only(const core::DocumentValue& root)
{
  return root.find(campaign_key) != nullptr && root.find("reference") == nullptr &&
         root.find("moving") == nullptr;
}

void check_campaign(const core::Document& document)
{
  for (const core::DocumentEntry& entry : *document.root.table()) {
    if (entry.key == campaign_key || !is_campaign_only(document.root)) continue;
    document.refuse(entry.key, "a key next to [campaign] in a file without a joint",
                    "only [campaign], or a complete job with [reference] and [moving]");
  }
  campaign_schema().checked(campaign_part(document));
  for (const core::DocumentEntry& axis : *document.root.find(campaign_key)->table())
    check_settings(document, axis);
}

}  // namespace vrda::job
