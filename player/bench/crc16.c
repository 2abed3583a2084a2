#include "bench/crc16.h"

uint16_t crc16(const uint8_t* bytes, size_t n)
{
  uint16_t crc = 0xFFFFu;
  for (size_t i = 0; i < n; ++i) {
    crc = (uint16_t)(crc ^ ((uint16_t)bytes[i] << 8));
    for (int bit = 0; bit < 8; ++bit) {
      crc = (uint16_t)((uint16_t)(crc << 1) ^ ((crc & 0x8000u) != 0u ? 0x1021u : 0u));
    }
  }
  return crc;
}
