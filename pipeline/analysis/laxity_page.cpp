// The HTML page of laxity tests: tables and SVG plots, drawn without scripts.
#include <algorithm>
#include <cmath>

#include "analysis/laxity.hpp"
#include "analysis/result_files.hpp"
#include "core/text.hpp"
#include "core/units.hpp"

namespace vrda::analysis {
namespace {

constexpr const char* colours[] = {"#1f5fa8", "#c2500a", "#2a7f62", "#7a5fa8", "#b5892b", "#8a2f4f"};

const char* colour_at(std::size_t k)
{
  return colours[k % std::size(colours)];
}

struct Point {
  double x, y;
};
struct Line {
  std::string label;  ///< for the legend; empty: not in the legend
  std::size_t colour = 0;
  bool is_dashed = false;
  std::vector<Point> points;
};
struct Bar {
  Point at;
  double half = nan;  ///< half length of the error bar
};
struct Plot {
  std::string x, y;  ///< titles
  std::vector<Line> lines;
  std::vector<Bar> bars;
};

// 1, 2 or 5 times a power of ten, for at most six ticks.
double tick_of(double span)
{
  double tick = 1e-6;
  for (int k = 0; span / tick > 6.0; ++k) tick *= k % 3 == 1 ? 2.5 : 2.0;
  return tick;
}

struct Range {
  double low = 0.0, high = 0.0;
  void include(double value)
  {
    if (!std::isfinite(value)) return;
    low = std::min(low, value);
    high = std::max(high, value);
  }
};

std::string plot_svg(const Plot& plot)
{
  constexpr double width = 330.0, height = 220.0, left = 52.0, bottom = 40.0, top = 8.0;
  Range x, y;
  for (const Line& line : plot.lines) {
    for (const Point& p : line.points) {
      x.include(p.x);
      y.include(p.y);
    }
  }
  for (const Bar& bar : plot.bars) {
    x.include(bar.at.x);
    y.include(bar.at.y + (std::isnan(bar.half) ? 0.0 : bar.half));
    y.include(bar.at.y - (std::isnan(bar.half) ? 0.0 : bar.half));
  }
  if (x.high == x.low) x.high = x.low + 1.0;
  if (y.high == y.low) y.high = y.low + 1.0;
  const auto px = [&](double value) { return left + (value - x.low) / (x.high - x.low) * width; };
  const auto py = [&](double value) { return top + (y.high - value) / (y.high - y.low) * height; };
  const auto at = [](double value) { return decimals(value); };
  std::string svg = svg_start(left + width + 10, top + height + bottom, plot.y + " over " + plot.x);
  const double x_tick = tick_of(x.high - x.low), y_tick = tick_of(y.high - y.low);
  for (double v = std::ceil(x.low / x_tick) * x_tick; v <= x.high * (1 + 1e-12); v += x_tick) {
    svg += "<path class=\"grid\" d=\"M" + at(px(v)) + ' ' + at(top) + 'V' + at(top + height) + "\"/>\n";
    svg += svg_text(px(v), top + height + 14, "middle", decimals(v + 0.0, "%.6g"));
  }
  for (double v = std::ceil(y.low / y_tick) * y_tick; v <= y.high * (1 + 1e-12); v += y_tick) {
    svg += "<path class=\"grid\" d=\"M" + at(left) + ' ' + at(py(v)) + 'H' + at(left + width) + "\"/>\n";
    svg += svg_text(left - 5, py(v) + 4, "end", decimals(v + 0.0, "%.4g"));
  }
  for (const Line& line : plot.lines) {
    std::string path;
    for (const Point& p : line.points) {
      if (!std::isfinite(p.y)) continue;
      path += (path.empty() ? 'M' : 'L') + at(px(p.x)) + ' ' + at(py(p.y));
    }
    svg += "<path d=\"" + path + "\" fill=\"none\" stroke=\"" + colour_at(line.colour) +
           "\" stroke-width=\"2\"" + (line.is_dashed ? " stroke-dasharray=\"6 4\"" : "") + "/>\n";
  }
  for (const Bar& bar : plot.bars) {
    if (!std::isnan(bar.half))
      svg += "<path class=\"bar\" d=\"M" + at(px(bar.at.x)) + ' ' + at(py(bar.at.y - bar.half)) + 'V' +
             at(py(bar.at.y + bar.half)) + "\"/>\n";
    svg +=
        "<circle class=\"bar\" cx=\"" + at(px(bar.at.x)) + "\" cy=\"" + at(py(bar.at.y)) + "\" r=\"3.5\"/>\n";
  }
  svg += svg_text(left + width / 2, top + height + 32, "middle", plot.x) +
         svg_upward_text(12, top + height / 2, plot.y) + "</svg>\n<p class=\"legend\">";
  for (const Line& line : plot.lines) {
    if (!line.label.empty())
      svg += std::string("<span style=\"color:") + colour_at(line.colour) + "\">" +
             (line.is_dashed ? "&#9476; " : "&#9472; ") + line.label + "</span> ";
  }
  return svg + (plot.bars.empty() ? "" : "<span>&#9679; published</span>") + "</p>\n";
}

const char* unit_of(const TestKind& kind)
{
  return kind.is_force() ? "mm" : "degrees";
}

// In newtons and newton metres.
double shown_load(const TestKind& kind, double load)
{
  return kind.is_force() ? load : 1e-3 * load;
}

std::string load_text(const TestKind& kind, double load)
{
  return decimals(shown_load(kind, load), "%.4g") + (kind.is_force() ? " N" : " N m");
}

class Page {
 public:
  explicit Page(const LaxityDocument& document) : document_(document), result_(document.result) {}

  /// Both directions of one coordinate, if they are tested.
  std::string section(LaxityTest first) const
  {
    if (curve_of(result_, 0, 0, first) == nullptr) return {};
    const LaxityTest second = opposite(first);
    const TestKind& kind = kind_of(first);
    const double load = whole_load(result_.loads, first);
    return std::string("<h2>") + kind.both + ", " + load_text(kind, load) + "</h2>\n" + table(first, second) +
           "<div class=\"plots\"><figure>" + plot_svg(over_flexion(first, second)) +
           "<figcaption>Laxity over flexion; " + kind.name + " above zero, " + kind_of(second).name +
           " below</figcaption></figure><figure>" + plot_svg(over_load(first, second)) +
           "<figcaption>Displacement over load with all fibres</figcaption></figure></div>\n" +
           shares(first, second);
  }

  std::string published() const
  {
    if (document_.compared.empty()) return {};
    std::string html =
        "<h2>Published values</h2><table><thead><tr><th>test</th><th>flexion</th><th>published</th><th>found"
        "</th><th>difference</th><th>in standard deviations</th><th>source</th></tr></thead><tbody>\n";
    for (const Compared& one : document_.compared) {
      const PublishedValue& row = one.published;
      html += "<tr><th scope=\"row\">" + row.test + "</th><td>" + decimals(row.flexion_deg, "%.4g") +
              "&deg;</td><td>" + decimals(row.value) +
              (std::isnan(row.sd) ? std::string() : " &plusmn; " + decimals(row.sd)) + "</td><td>" +
              decimals(one.found) + "</td><td>" + decimals(one.difference(), "%+.2f") + "</td><td>" +
              decimals(one.difference() / row.sd, "%+.1f") + "</td><td>" + escape_markup(row.source) +
              escape_markup(one.missing) + "</td></tr>\n";
    }
    return html + "</tbody></table>\n";
  }

 private:
  static LaxityTest opposite(LaxityTest first)
  {
    return static_cast<LaxityTest>(static_cast<std::size_t>(first) + 1);
  }

  std::string state_name(std::size_t state) const
  {
    return escape_markup(state == 0 ? result_.states[state] : "without " + result_.states[state]);
  }

  double value(std::size_t state, std::size_t flexion, LaxityTest test) const
  {
    return in_file_unit(kind_of(test), curve_of(result_, state, flexion, test)->laxity());
  }

  // Of the fibres of a cut, in the intact joint.
  double cut_share(std::size_t state, std::size_t flexion, LaxityTest test) const
  {
    const std::vector<std::string>& cut = result_.loads.cuts[state - 1].bundles;
    double sum = 0.0;
    for (const BundleResistance& of : curve_of(result_, 0, flexion, test)->bundles)
      sum += std::find(cut.begin(), cut.end(), of.bundle) != cut.end() ? of.share : 0.0;
    return sum;
  }

  std::string table(LaxityTest first, LaxityTest second) const
  {
    const TestKind& kind = kind_of(first);
    std::string html =
        std::string("<table><caption>Laxity, ") + unit_of(kind) +
        "; of a cut: how much farther than the intact joint, and the share of the load that its "
        "fibres carry there</caption><thead><tr><th>flexion</th><th>state</th><th>" +
        kind.name + "</th><th>farther</th><th>share</th><th>" + kind_of(second).name +
        "</th><th>farther</th><th>share</th><th>both</th></tr></thead><tbody>\n";
    for (std::size_t f = 0; f < result_.loads.flexion_deg.size(); ++f) {
      for (std::size_t s = 0; s < result_.states.size(); ++s) {
        html += "<tr><th scope=\"row\">" + decimals(result_.loads.flexion_deg[f], "%.4g") + "&deg;</th><td>" +
                state_name(s) + "</td>";
        for (const LaxityTest test : {first, second}) {
          html += "<td>" + decimals(value(s, f, test)) + "</td>";
          const double farther = in_file_unit(
              kind, curve_of(result_, s, f, test)->position() - curve_of(result_, 0, f, test)->position());
          html += s == 0 ? std::string("<td></td><td></td>")
                         : "<td>" + decimals(farther, "%+.2f") + "</td><td>" +
                               decimals(100.0 * cut_share(s, f, test), "%.0f %%") + "</td>";
        }
        html += "<td>" + decimals(value(s, f, first) + value(s, f, second)) + "</td></tr>\n";
      }
    }
    return html + "</tbody></table>\n";
  }

  Plot over_flexion(LaxityTest first, LaxityTest second) const
  {
    Plot plot{"flexion, degrees", unit_of(kind_of(first)), {}, {}};
    for (std::size_t s = 0; s < result_.states.size(); ++s) {
      const std::string name = state_name(s);
      for (const LaxityTest test : {first, second}) {
        Line line{test == first ? name : "", s, s > 0, {}};
        for (std::size_t f = 0; f < result_.loads.flexion_deg.size(); ++f)
          line.points.push_back(
              {result_.loads.flexion_deg[f], (test == first ? 1.0 : -1.0) * value(s, f, test)});
        plot.lines.push_back(line);
      }
    }
    for (const Compared& one : document_.compared) {
      const PublishedValue& row = one.published;
      if (row.test == kind_of(first).name) plot.bars.push_back({{row.flexion_deg, row.value}, row.sd});
      if (row.test == kind_of(second).name) plot.bars.push_back({{row.flexion_deg, -row.value}, row.sd});
    }
    return plot;
  }

  Plot over_load(LaxityTest first, LaxityTest second) const
  {
    const TestKind& kind = kind_of(first);
    Plot plot{kind.is_force() ? "force, N" : "moment, N m", unit_of(kind), {}, {}};
    for (std::size_t f = 0; f < result_.loads.flexion_deg.size(); ++f) {
      Line line{decimals(result_.loads.flexion_deg[f], "%.4g") + "&deg;", f, false, {}};
      for (const LaxityTest test : {second, first}) {
        const LaxityCurve& curve = *curve_of(result_, 0, f, test);
        const double sign = kind_of(test).sign;
        for (std::size_t k = 0; k < curve.poses.size(); ++k) {
          const std::size_t at = test == second ? curve.poses.size() - 1 - k : k;
          line.points.push_back({sign * shown_load(kind, curve.poses[at].load),
                                 sign * in_file_unit(kind, laxity_at_load(curve, curve.poses[at].load))});
        }
      }
      plot.lines.push_back(line);
    }
    return plot;
  }

  std::string shares(LaxityTest first, LaxityTest second) const
  {
    constexpr double smallest = 0.05;  // below, a bundle is not listed
    std::string html =
        "<table><caption>Share of the load that bundles and contact resist with all fibres, at least 5 %"
        "</caption><thead><tr><th>flexion</th><th>" +
        std::string(kind_of(first).name) + "</th><th>" + kind_of(second).name + "</th></tr></thead><tbody>\n";
    for (std::size_t f = 0; f < result_.loads.flexion_deg.size(); ++f) {
      html += "<tr><th scope=\"row\">" + decimals(result_.loads.flexion_deg[f], "%.4g") + "&deg;</th>";
      for (const LaxityTest test : {first, second}) {
        const LaxityCurve& curve = *curve_of(result_, 0, f, test);
        std::vector<BundleResistance> rows = curve.bundles;
        if (curve.is_complete()) rows.push_back(curve.contact);
        std::stable_sort(rows.begin(), rows.end(),
                         [](const auto& a, const auto& b) { return std::abs(a.share) > std::abs(b.share); });
        html += "<td>";
        for (const BundleResistance& row : rows) {
          if (std::abs(row.share) >= smallest)
            html += escape_markup(row.bundle) + ' ' + decimals(100.0 * row.share, "%.0f") + " % ";
        }
        html += "</td>";
      }
      html += "</tr>\n";
    }
    return html + "</tbody></table>\n";
  }

  const LaxityDocument& document_;
  const LaxityResult& result_;
};

constexpr const char* style =
    R"(.plots{display:grid;grid-template-columns:repeat(auto-fill,minmax(380px,1fr));gap:1rem;margin:1rem 0}
figure{margin:0;border:1px solid var(--rule);border-radius:6px;padding:.5rem}figcaption,.legend{font-size:13px;margin:0}
svg{width:100%;height:auto}svg text{font-size:11px;fill:var(--ink)}.grid{stroke:var(--rule)}.bar{stroke:var(--ink);fill:var(--ink)}
table{border-collapse:collapse;margin:.5rem 0}caption{text-align:left;font-weight:600}th,td{border-bottom:1px solid var(--rule);padding:.2rem .7rem;text-align:left}
td{font-variant-numeric:tabular-nums}
)";

}  // namespace

std::string laxity_page(const LaxityDocument& document)
{
  const Page page(document);
  std::string body =
      "<p>Flexion is held; the other five coordinates are free. Each load acts besides those of the job, "
      "along the joint's own coordinate, and grows in " +
      std::to_string(document.result.loads.load_steps) +
      " steps from the unloaded equilibrium. Laxity is the change of the coordinate.</p>\n";
  for (const LaxityTest first : {LaxityTest::anterior, LaxityTest::internal, LaxityTest::varus})
    body += page.section(first);
  return html_page({document.title + ": laxity", "1000px", style, document.program + ", " + document.solver},
                   body + page.published());
}

}  // namespace vrda::analysis
