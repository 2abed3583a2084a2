/// The report as one self-contained HTML page.
#pragma once

#include <string>

#include "report/report.hpp"

namespace vrda {

/// What the page shows, as JSON (report.models whole when there is one, else what a comparison needs).
std::string report_json(const Report& report);

/// The whole page: style, plotting library, code and data within it. It asks no network for anything, and
/// forbids the browser to (Content-Security-Policy). Text of the models is never read as HTML.
std::string report_page(const Report& report);

}  // namespace vrda
