#include "bench/body_sheet.hpp"

#include <cmath>
#include <cstdio>
#include <opencv2/aruco/charuco.hpp>

#include "core/text.hpp"

namespace vrda::bench {

std::array<MarkerCorners, markers_a_body> marker_corners_mm(const BodySheet& sheet)
{
  const double scale = sheet.marker_mm / 40.0, gap = scale * sheet_margin_mm, far = gap + sheet.marker_mm;
  const double half_rad = 0.5 * sheet.fold_rad;
  const Eigen::Vector3d right(std::sin(half_rad), 0.0, -std::cos(half_rad));
  const Eigen::Vector3d left(-right.x(), 0.0, right.z());
  std::array<MarkerCorners, markers_a_body> markers;
  for (std::size_t k = 0; k < markers_a_body; ++k) {
    const bool is_right = k % 2 == 1, is_lower = k >= 2;
    const double top = is_lower ? -0.5 * gap : 0.5 * gap + sheet.marker_mm, bottom = top - sheet.marker_mm;
    // Along the face from the edge; on the left face the outer side comes first.
    const Eigen::Vector3d& along = is_right ? right : left;
    const double first = is_right ? gap : far, second = is_right ? far : gap;
    const Eigen::Vector3d y = Eigen::Vector3d::UnitY();
    markers[k] = {first * along + top * y, second * along + top * y, second * along + bottom * y,
                  first * along + bottom * y};
  }
  return markers;
}

std::array<std::array<bool, 6>, 6> marker_cells(std::size_t id)
{
  const cv::Ptr<cv::aruco::Dictionary> dictionary =
      cv::aruco::getPredefinedDictionary(cv::aruco::DICT_4X4_50);
  cv::Mat picture;
  cv::aruco::drawMarker(dictionary, static_cast<int>(id), 6, picture, 1);
  std::array<std::array<bool, 6>, 6> cells;
  for (int row = 0; row < 6; ++row) {
    for (int column = 0; column < 6; ++column)
      cells[static_cast<std::size_t>(row)][static_cast<std::size_t>(column)] =
          picture.at<std::uint8_t>(row, column) == 0;
  }
  return cells;
}

namespace {

constexpr double points_per_mm = 72.0 / 25.4, page_width_mm = 210.0, page_height_mm = 297.0;

/// The drawing operators of a page, in mm from the lower left corner.
class Page {
 public:
  Page() { add("%.4f 0 0 %.4f 0 0 cm\n", points_per_mm, points_per_mm); }

  void line(double x0, double y0, double x1, double y1, bool is_dashed = false)
  {
    text_ += is_dashed ? "[2 1] 0 d 0.2 w\n" : "[] 0 d 0.2 w\n";
    add("%.4f %.4f m %.4f %.4f l S\n", x0, y0, x1, y1);
  }

  void rectangle(double x, double y, double width, double height)
  {
    line(x, y, x + width, y);
    line(x, y + height, x + width, y + height);
    line(x, y, x, y + height);
    line(x + width, y, x + width, y + height);
  }

  void words(double x, double y, double height_mm, const std::string& text)
  {
    add("BT /F %.4f Tf %.4f %.4f Td (", height_mm, x, y);
    for (const char c : text) {
      if (c == '(' || c == ')' || c == '\\') text_ += '\\';
      text_ += c;
    }
    text_ += ") Tj ET\n";
  }

  /// An image of one bit a cell, black where `is_black(row, column)`; the lower left corner at x, y.
  template <typename IsBlack>
  void cells(double x, double y, double width, double height, int rows, int columns, IsBlack is_black)
  {
    add("q %.4f 0.0000 0.0000 %.4f %.4f %.4f cm BI /W %d /H %d /BPC 1 /CS /G /F /AHx ID ", width, height, x,
        y, columns, rows);
    for (int row = 0; row < rows; ++row) {
      for (int column = 0; column < columns; column += 4) {
        int digit = 0;
        for (int bit = 0; bit < 4; ++bit) {
          const bool is_white = column + bit >= columns || !is_black(row, column + bit);
          digit = digit << 1 | (is_white ? 1 : 0);
        }
        text_ += "0123456789ABCDEF"[digit];
      }
      // Rows start at whole bytes.
      if ((columns + 3) / 4 % 2 == 1) text_ += 'F';
    }
    text_ += "> EI Q\n";
  }

  const std::string& text() const { return text_; }

 private:
  template <typename... Numbers>
  void add(const char* format, Numbers... numbers)
  {
    char line[256];
    std::snprintf(line, sizeof line, format, numbers...);
    text_ += line;
  }

  std::string text_;
};

/// A bar of 100 mm to check the printer's scale.
void add_scale(Page& page, double x, double y)
{
  page.line(x, y, x + 100.0, y);
  for (int k = 0; k <= 10; ++k) page.line(x + 10.0 * k, y, x + 10.0 * k, y + (k % 5 == 0 ? 4.0 : 2.0));
  page.words(x + 102.0, y, 4.0, "100 mm: print without scaling, and measure");
}

void add_body(Page& page, std::size_t number, const std::string& name, double bottom)
{
  constexpr double marker = 40.0, margin = sheet_margin_mm;
  constexpr double face = 2.0 * margin + marker, height = 2.0 * marker + 3.0 * margin;
  const double edge = 0.5 * page_width_mm;
  page.rectangle(edge - face, bottom, 2.0 * face, height);
  page.line(edge, bottom, edge, bottom + height, true);
  for (std::size_t k = 0; k < markers_a_body; ++k) {
    const auto black = marker_cells(markers_a_body * number + k);
    const double x = k % 2 == 1 ? edge + margin : edge - margin - marker;
    const double y = bottom + margin + (k >= 2 ? 0.0 : marker + margin);
    page.cells(x, y, marker, marker, 6, 6, [&](int row, int column) {
      return black[static_cast<std::size_t>(row)][static_cast<std::size_t>(column)];
    });
  }
  const std::string first = std::to_string(markers_a_body * number),
                    last = std::to_string(markers_a_body * number + 3);
  page.words(edge - face, bottom + height + 3.0, 5.0,
             name + ": markers " + first + " to " + last + ", 40 mm each; this side up (proximal)");
  page.words(edge - face, bottom - 5.0, 3.5,
             "Cut along the lines, fold along the dashes, glue around a square edge (90 degrees).");
}

void add_board(Page& page)
{
  constexpr double width = board_columns * board_square_mm, height = board_rows * board_square_mm;
  // Turned by 90 degrees: the long side along the page. A pixel of the drawing is a millimetre.
  const cv::Ptr<cv::aruco::CharucoBoard> board = cv::aruco::CharucoBoard::create(
      board_columns, board_rows, static_cast<float>(board_square_mm), static_cast<float>(board_marker_mm),
      cv::aruco::getPredefinedDictionary(cv::aruco::DICT_5X5_50));
  cv::Mat picture;
  board->draw(cv::Size(static_cast<int>(width), static_cast<int>(height)), picture, 0, 1);
  page.cells(
      0.5 * (page_width_mm - height), 22.0, height, width, picture.cols, picture.rows,
      [&](int row, int column) { return picture.at<std::uint8_t>(column, picture.cols - 1 - row) == 0; });
  page.words(10.0, 14.0, 4.0,
             "Board for the camera's calibration: squares of 38 mm. Glue it to a flat plate.");
  add_scale(page, 10.0, 6.0);
}

}  // namespace

std::string sheets_pdf(const std::vector<std::string>& bodies)
{
  check(!bodies.empty() && bodies.size() <= most_bodies, "the dictionary has markers for 12 bodies");
  std::vector<Page> pages((bodies.size() + 1) / 2);
  for (std::size_t k = 0; k < bodies.size(); ++k) {
    add_body(pages[k / 2], k, bodies[k], k % 2 == 0 ? 165.0 : 32.0);
    if (k % 2 == 0) add_scale(pages[k / 2], 10.0, 12.0);
  }
  add_board(pages.emplace_back());

  std::string pdf = "%PDF-1.4\n";
  std::vector<std::size_t> offsets;
  const auto add_object = [&](const std::string& content) {
    offsets.push_back(pdf.size());
    pdf += std::to_string(offsets.size()) + " 0 obj\n" + content + "\nendobj\n";
  };
  std::string kids;
  for (std::size_t k = 0; k < pages.size(); ++k) kids += std::to_string(4 + 2 * k) + " 0 R ";
  add_object("<< /Type /Catalog /Pages 2 0 R /ViewerPreferences << /PrintScaling /None >> >>");
  add_object("<< /Type /Pages /Kids [ " + kids + "] /Count " + std::to_string(pages.size()) + " >>");
  add_object("<< /Type /Font /Subtype /Type1 /BaseFont /Helvetica >>");
  for (std::size_t k = 0; k < pages.size(); ++k) {
    add_object(
        "<< /Type /Page /Parent 2 0 R /MediaBox [0 0 595.276 841.890] /Resources << /Font << /F 3 0 R >> >> "
        "/Contents " +
        std::to_string(5 + 2 * k) + " 0 R >>");
    add_object("<< /Length " + std::to_string(pages[k].text().size()) + " >>\nstream\n" + pages[k].text() +
               "\nendstream");
  }
  const std::size_t table = pdf.size();
  pdf += "xref\n0 " + std::to_string(offsets.size() + 1) + "\n0000000000 65535 f \n";
  for (const std::size_t offset : offsets) {
    char row[32];
    std::snprintf(row, sizeof row, "%010zu 00000 n \n", offset);
    pdf += row;
  }
  pdf += "trailer\n<< /Size " + std::to_string(offsets.size() + 1) + " /Root 1 0 R >>\nstartxref\n" +
         std::to_string(table) + "\n%%EOF\n";
  return pdf;
}

}  // namespace vrda::bench
