#include "bench/quadrature.h"

static uint8_t state_of(bool a, bool b)
{
  return (uint8_t)((a ? 2u : 0u) | (b ? 1u : 0u));
}

void quadrature_start(quadrature* q, bool a, bool b)
{
  q->state = state_of(a, b);
  q->counter = 0;
  q->n_lost = 0;
}

void quadrature_edge(quadrature* q, bool a, bool b)
{
  /* Row: previous state; column: new state. 2 marks a step over two states. */
  static const int8_t counts[4][4] = {{0, -1, 1, 2}, {1, 0, 2, -1}, {-1, 2, 0, 1}, {2, 1, -1, 0}};
  const uint8_t now = state_of(a, b);
  const int8_t count = counts[q->state][now];
  q->state = now;
  if (count != 2) {
    q->counter = (uint16_t)(q->counter + (uint16_t)count);
  } else if (q->n_lost < UINT16_MAX) {
    ++q->n_lost;
  }
}

uint16_t quadrature_read_and_reset_counter(quadrature* q)
{
  const uint16_t counter = q->counter;
  q->counter = 0;
  return counter;
}

uint16_t quadrature_read_and_reset_lost(quadrature* q)
{
  const uint16_t n_lost = q->n_lost;
  q->n_lost = 0;
  return n_lost;
}
