#include "analysis/result_files.hpp"

#include <cmath>
#include <cstdio>

#include "core/text.hpp"

namespace vrda::analysis {

std::string decimals(double value, const char* format)
{
  if (!std::isfinite(value)) return "&ndash;";
  char text[32];
  std::snprintf(text, sizeof text, format, value);
  // "-0.00" and "-0 %" are zero.
  const std::string shown = text;
  const bool is_zero = shown.starts_with("-0") && shown.find_first_of("123456789") == std::string::npos;
  return is_zero ? shown.substr(1) : shown;
}

std::string html_page(const PageFrame& frame, const std::string& body)
{
  const std::string title = escape_markup(frame.title);
  return "<!doctype html>\n<html lang=\"en\"><head><meta charset=\"utf-8\">"
         "<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n<title>" +
         title + R"(</title>
<style>
:root{color-scheme:light dark;--ink:#1d2126;--paper:#fff;--rule:#d5d8dc}
@media(prefers-color-scheme:dark){:root{--ink:#e6e8eb;--paper:#16191d;--rule:#3a3f46}}
body{font:15px/1.5 system-ui,'DejaVu Sans',sans-serif;color:var(--ink);background:var(--paper);max-width:)" +
         frame.width_px + ";margin:2rem auto;padding:0 1rem}\n" + frame.style +
         "</style>\n</head><body>\n<h1>" + title + "</h1>\n" + body + "<footer><p>By " +
         escape_markup(frame.by) + ".</p></footer>\n</body></html>\n";
}

std::string svg_start(double width, double height, const std::string& label)
{
  return "<svg viewBox=\"0 0 " + decimals(width) + ' ' + decimals(height) + "\" role=\"img\" aria-label=\"" +
         label + "\">\n";
}

std::string svg_text(double x, double y, const char* anchor, const std::string& text)
{
  return "<text x=\"" + decimals(x) + "\" y=\"" + decimals(y) + "\" text-anchor=\"" + anchor + "\">" + text +
         "</text>\n";
}

std::string svg_upward_text(double x, double y, const std::string& text)
{
  return "<text transform=\"translate(" + decimals(x, "%.0f") + ' ' + decimals(y) +
         ") rotate(-90)\" text-anchor=\"middle\">" + text + "</text>\n";
}

}  // namespace vrda::analysis
