/* What a port fills in: the only place that knows the board. */
#ifndef VRDA_FIRMWARE_HAL_H
#define VRDA_FIRMWARE_HAL_H

#include <stdint.h>

typedef struct {
  void* self; /* handed to every function */
  /* Next received byte, or -1 when none waits. */
  int (*receive)(void* self);
  /* Sends; may wait for room. */
  void (*send)(void* self, const uint8_t* bytes, uint8_t n);
  /* 0 to 1023. */
  uint16_t (*potentiometer)(void* self);
  /* The 16-bit counter's value, two's complement; sets it to zero in the same moment. */
  uint16_t (*read_and_reset_counter)(void* self);
  /* Steps that could not be counted since the last call. */
  uint16_t (*read_and_reset_lost)(void* self);
} hal;

#endif
