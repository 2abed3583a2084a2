#include "bench/board.h"

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

void board_start(board* b, const hal* hardware)
{
  b->hardware = hardware;
  b->position = 0;
  b->is_zeroed = false;
  b->has_lost = false;
}

void board_poll(board* b)
{
  const uint16_t counter = b->hardware->read_and_reset_counter(b->hardware->self);
  /* Sign extension in unsigned arithmetic, which cannot overflow. */
  const uint32_t moved = (counter & 0x8000u) != 0u ? counter | 0xFFFF0000u : counter;
  b->position = (int32_t)((uint32_t)b->position + moved);
  if (b->hardware->read_and_reset_lost(b->hardware->self) > 0) b->has_lost = true;
}

static uint8_t put_u16(uint8_t* at, uint16_t value)
{
  at[0] = (uint8_t)(value & 0xFFu);
  at[1] = (uint8_t)(value >> 8);
  return 2;
}

static uint8_t put_i32(uint8_t* at, int32_t value)
{
  for (int i = 0; i < 4; ++i) at[i] = (uint8_t)((uint32_t)value >> (8 * i));
  return 4;
}

static uint8_t put_payload(board* b, uint8_t request, uint8_t* at)
{
  uint8_t n = 0;
  switch (request) {
    case 'P':
      return put_u16(at, b->hardware->potentiometer(b->hardware->self));
    case 'E':
      board_poll(b);
      n = put_i32(at, b->position);
      at[n] = (uint8_t)((b->is_zeroed ? board_flag_zeroed : 0) | (b->has_lost ? board_flag_lost : 0));
      return (uint8_t)(n + 1);
    case 'Z':
      board_poll(b);
      n = put_i32(at, b->position);
      b->position = 0;
      b->is_zeroed = true;
      b->has_lost = false;
      return n;
    case 'V':
      at[0] = board_protocol_version;
      at[1] = 'V', at[2] = 'R', at[3] = 'D', at[4] = 'A';
      return 5;
    default:
      return 0;
  }
}

uint8_t board_answer(board* b, uint8_t request, uint8_t frame[board_longest_frame])
{
  const uint8_t n_payload = put_payload(b, request, frame + 4);
  if (n_payload == 0) return 0;
  frame[0] = board_frame_start_0;
  frame[1] = board_frame_start_1;
  frame[2] = request;
  frame[3] = n_payload;
  const uint8_t n = (uint8_t)(4 + n_payload);
  return (uint8_t)(n + put_u16(frame + n, crc16(frame + 2, (size_t)n_payload + 2)));
}

void board_loop(board* b)
{
  uint8_t frame[board_longest_frame];
  board_poll(b);
  const hal* const h = b->hardware;
  const int request = h->receive(h->self);
  if (request < 0) return;
  const uint8_t n = board_answer(b, (uint8_t)request, frame);
  if (n > 0) h->send(h->self, frame, n);
}
