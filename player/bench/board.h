/* Firmware of the encoder board (schemas/serial-protocol.md): C99, without the C library. A port fills in `hal`. */
#ifndef VRDA_FIRMWARE_BOARD_H
#define VRDA_FIRMWARE_BOARD_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

/* Hardware abstraction: the only board-specific part, filled in by a port. */

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

/* Quadrature decoder: two square signals 90 degrees apart, four states a period (00, 01, 11, 10). */

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

/* CRC-16/CCITT-FALSE: polynomial 0x1021, initial value 0xFFFF, not reflected. */

uint16_t crc16(const uint8_t* bytes, size_t n);

/* State of the board and its answers (schemas/serial-protocol.md). */

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

#ifdef __cplusplus
}
#endif

#endif
