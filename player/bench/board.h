/* State of the board and its answers (schemas/serial-protocol.md). */
#ifndef VRDA_FIRMWARE_BOARD_H
#define VRDA_FIRMWARE_BOARD_H

#include <stdbool.h>
#include <stdint.h>

#include "bench/hal.h"

enum {
  board_protocol_version = 1,
  board_frame_start_0 = 0xA5,
  board_frame_start_1 = 0x5A,
  board_most_payload = 16,
  board_longest_frame = 2 + 2 + board_most_payload + 2 /* start, request and length, payload, CRC */
};

/* Flags of the answer to 'E'. */
enum { board_flag_zeroed = 1, board_flag_lost = 2 };

typedef struct {
  const hal* hardware;
  int32_t position; /* counts since power-up or the last zero; wraps in two's complement */
  bool is_zeroed;   /* since power-up */
  bool has_lost;    /* counts were lost since the last zero */
} board;

void board_start(board* b, const hal* hardware);

/* Adds the counter to the position and resets the counter. */
void board_poll(board* b);

/* Writes the answer to a request byte into `frame`; returns its length, 0 for an unknown request. */
uint8_t board_answer(board* b, uint8_t request, uint8_t frame[board_longest_frame]);

/* One iteration: polls the encoder and answers at most one request, so that a busy line delays neither the next poll
 * nor a watchdog. Call it in an endless loop. */
void board_loop(board* b);

#endif
