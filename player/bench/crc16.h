/* CRC-16/CCITT-FALSE: polynomial 0x1021, initial value 0xFFFF, not reflected. */
#ifndef VRDA_FIRMWARE_CRC16_H
#define VRDA_FIRMWARE_CRC16_H

#include <stddef.h>
#include <stdint.h>

uint16_t crc16(const uint8_t* bytes, size_t n);

#endif
