// QR codes for terminals.
#include "web/server.hpp"

#include <array>
#include <qrcodegen/qrcodegen.hpp>

namespace vrda::web {

std::string qr_code_text(const std::string& content)
{
  constexpr int border = 4;
  const qrcodegen::QrCode code =
      qrcodegen::QrCode::encodeText(content.c_str(), qrcodegen::QrCode::Ecc::MEDIUM);
  // Modules outside are light.
  const auto is_light = [&](int x, int y) { return !code.getModule(x, y); };
  std::string text;
  for (int y = -border; y < code.getSize() + border; y += 2) {
    for (int x = -border; x < code.getSize() + border; ++x) {
      constexpr std::array blocks{" ", "\u2584", "\u2580", "\u2588"};
      text += blocks[(is_light(x, y) ? 2U : 0U) + (is_light(x, y + 1) ? 1U : 0U)];
    }
    text += '\n';
  }
  return text;
}

}  // namespace vrda::web
