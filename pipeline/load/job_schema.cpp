#include "load/job_schema.hpp"

#include "core/error.hpp"
#include "core/text.hpp"
#include "documents/schema.hpp"

namespace vrda::load {

const documents::DocumentSchema& campaign_schema();  // schemas/campaign.schema.json
const documents::DocumentSchema& job_schema();       // schemas/job.schema.json

namespace {

constexpr const char* campaign_key = "campaign";

// The [campaign] table only, the subject of its schema.
documents::Document campaign_part(const documents::Document& document)
{
  const documents::DocumentValue* table = document.root.find(campaign_key);
  check(table != nullptr, "the document has no [campaign]");
  return {document.file, {documents::DocumentValue::Table{{campaign_key, *table}}}, document.overridden};
}

documents::DocumentValue without_campaign(const documents::DocumentValue& root)
{
  documents::DocumentValue::Table kept;
  for (const documents::DocumentEntry& entry : *root.table()) {
    if (entry.key != campaign_key) kept.push_back(entry);
  }
  return {kept, root.line};
}

// Checks the names of the job keys that the levels of an axis set.
void check_settings(const documents::Document& document, const documents::DocumentEntry& axis)
{
  const documents::DocumentValue::List* levels = axis.value.list();
  for (std::size_t i = 0; levels != nullptr && i < levels->size(); ++i) {
    const documents::DocumentValue* settings = (*levels)[i].find("set");
    const std::string at = "campaign." + axis.key + "." + std::to_string(i) + ".set.";
    if (settings != nullptr) job_schema().check_known_keys({document.file, *settings, {}, at});
  }
}

}  // namespace

documents::DocumentValue checked_job(const documents::Document& document)
{
  if (is_campaign_only(document.root)) {
    throw InputError({document.file, "reference", "a campaign without a joint",
                      "a job with [reference] and [moving]; run a campaign with vrda plan and vrda submit"});
  }
  const documents::DocumentValue job = job_schema().checked(document);
  if (document.root.find(campaign_key) != nullptr) campaign_schema().checked(campaign_part(document));
  return without_campaign(job);
}

bool is_campaign_only(const documents::DocumentValue& root)
{
  return root.find(campaign_key) != nullptr && root.find("reference") == nullptr &&
         root.find("moving") == nullptr;
}

void check_campaign(const documents::Document& document)
{
  for (const documents::DocumentEntry& entry : *document.root.table()) {
    if (entry.key == campaign_key || !is_campaign_only(document.root)) continue;
    document.refuse(entry.key, "a key next to [campaign] in a file without a joint",
                    "only [campaign], or a complete job with [reference] and [moving]");
  }
  campaign_schema().checked(campaign_part(document));
  for (const documents::DocumentEntry& axis : *document.root.find(campaign_key)->table())
    check_settings(document, axis);
}

}  // namespace vrda::load
