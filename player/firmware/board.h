/* What the board knows and how it answers (schemas/serial-protocol.md). */
#ifndef VRDA_FIRMWARE_BOARD_H
#define VRDA_FIRMWARE_BOARD_H

#include <stdbool.h>
#include <stdint.h>

#include "firmware/hal.h"

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
  int32_t position; /* counts since power-up or the last zero; wraps like two's complement */
  bool is_zeroed;   /* since power-up */
  bool has_lost;    /* counts, since the last zero */
} board;

void board_start(board* b, const hal* hardware);

/* Takes the counter over into the position. */
void board_poll(board* b);

/* The frame that answers a request byte, into `frame`; returns its length, 0 for a byte that is no request.
 */
uint8_t board_answer(board* b, uint8_t request, uint8_t frame[board_longest_frame]);

/* One round: polls, and answers what was asked. Call it for ever. */
void board_loop(board* b);

#endif
