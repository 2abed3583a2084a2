/* Quadrature decoder: two square signals 90 degrees apart, four states a period (00, 01, 11, 10). */
#ifndef VRDA_FIRMWARE_QUADRATURE_H
#define VRDA_FIRMWARE_QUADRATURE_H

#include <stdbool.h>
#include <stdint.h>

/* Written by the interrupt of either signal, read and reset by the port's hal with interrupts disabled. */
typedef struct {
  uint8_t state;    /* signal A in bit 1, signal B in bit 0 */
  uint16_t counter; /* two's complement; +1 where A leads B */
  uint16_t n_lost;  /* steps over two states at once; saturates */
} quadrature;

void quadrature_start(quadrature* q, bool a, bool b);

/* Call at every edge of either signal, with the current levels of both. */
void quadrature_edge(quadrature* q, bool a, bool b);

uint16_t quadrature_read_and_reset_counter(quadrature* q);
uint16_t quadrature_read_and_reset_lost(quadrature* q);

#endif
