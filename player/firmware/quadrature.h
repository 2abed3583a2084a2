/* Two square signals 90 degrees apart, four states a period: 00, 01, 11, 10 one way and back the other. */
#ifndef VRDA_FIRMWARE_QUADRATURE_H
#define VRDA_FIRMWARE_QUADRATURE_H

#include <stdbool.h>
#include <stdint.h>

/* Written by the interrupt of either signal, read and reset by the port's hal with interrupts off. */
typedef struct {
  uint8_t state;    /* signal A in bit 1, signal B in bit 0 */
  uint16_t counter; /* two's complement; +1 where A leads B */
  uint16_t n_lost;  /* steps over two states at once; stays at its largest value */
} quadrature;

void quadrature_start(quadrature* q, bool a, bool b);

/* At every edge of either signal: both as they are now. */
void quadrature_edge(quadrature* q, bool a, bool b);

uint16_t quadrature_read_and_reset_counter(quadrature* q);
uint16_t quadrature_read_and_reset_lost(quadrature* q);

#endif
