/* Hardware abstraction: the only board-specific part, filled in by a port. */
#ifndef VRDA_FIRMWARE_HAL_H
#define VRDA_FIRMWARE_HAL_H

#include <stdint.h>

typedef struct {
  void* self; /* passed to every function */
  /* Next received byte, or -1 when none is available. */
  int (*receive)(void* self);
  /* Sends; may block until there is room. */
  void (*send)(void* self, const uint8_t* bytes, uint8_t n);
  /* 0 to 1023. */
  uint16_t (*potentiometer)(void* self);
  /* The 16-bit counter's value, two's complement; resets it atomically. */
  uint16_t (*read_and_reset_counter)(void* self);
  /* Steps without a direction since the last call. */
  uint16_t (*read_and_reset_lost)(void* self);
} hal;

#endif
