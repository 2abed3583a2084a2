/* Port to an ATmega328P at 16 MHz (Arduino Uno, Nano, Pro Mini): encoder A at D3 (PD3), B at D2 (PD2), potentiometer
 * at A0, serial line at D0 and D1 at 115,200 baud. Built by avr-gcc (CMakeLists.txt).
 *
 * At 100,000 counts a second an edge comes every 160 cycles, so its interrupt must be short: the decoder is compiled
 * into it, and no other interrupt and no atomic section delays it by an edge. A watchdog restarts a board that hangs.
 */
#include <avr/interrupt.h>
#include <avr/io.h>
#include <avr/wdt.h>
#include <util/atomic.h>

#include "bench/board.h"

enum { received_size = 16 }; /* a power of two; the computer has at most six requests outstanding */

static quadrature signals;
static volatile uint8_t received[received_size];
static volatile uint8_t n_received; /* bytes ever received and read, modulo 256 */
static uint8_t n_read;

ISR(PCINT2_vect)
{
  const uint8_t levels = PIND;
  quadrature_edge(&signals, (levels & _BV(PD3)) != 0, (levels & _BV(PD2)) != 0);
}

ISR(USART_RX_vect)
{
  received[n_received % received_size] = UDR0;
  ++n_received;
}

static int receive(void* self)
{
  (void)self;
  if (n_read == n_received) return -1;
  return received[n_read++ % received_size];
}

static void send(void* self, const uint8_t* bytes, uint8_t n)
{
  (void)self;
  for (uint8_t i = 0; i < n; ++i) {
    loop_until_bit_is_set(UCSR0A, UDRE0);
    UDR0 = bytes[i];
  }
}

/* The converter runs freely; reading its low byte first holds the high one. */
static uint16_t potentiometer(void* self)
{
  (void)self;
  return ADC;
}

static uint16_t read_and_reset_counter(void* self)
{
  (void)self;
  uint16_t counter;
  ATOMIC_BLOCK(ATOMIC_FORCEON) { counter = quadrature_read_and_reset_counter(&signals); }
  return counter;
}

static uint16_t read_and_reset_lost(void* self)
{
  (void)self;
  uint16_t n_lost;
  ATOMIC_BLOCK(ATOMIC_FORCEON) { n_lost = quadrature_read_and_reset_lost(&signals); }
  return n_lost;
}

static void start_hardware(void)
{
  PORTD |= _BV(PD2) | _BV(PD3); /* pull-ups, for encoders with open collectors */
  PCMSK2 = _BV(PCINT18) | _BV(PCINT19);
  PCICR = _BV(PCIE2);
  /* 16 MHz / 8 / 17 = 117,647 baud, 2.1 % above 115,200: what every Uno uses. */
  UCSR0A = _BV(U2X0);
  UBRR0 = 16;
  UCSR0C = _BV(UCSZ01) | _BV(UCSZ00);
  UCSR0B = _BV(RXCIE0) | _BV(RXEN0) | _BV(TXEN0);
  /* Against AVcc, input 0, 125 kHz. */
  ADMUX = _BV(REFS0);
  DIDR0 = _BV(ADC0D);
  ADCSRA = _BV(ADEN) | _BV(ADSC) | _BV(ADATE) | _BV(ADPS2) | _BV(ADPS1) | _BV(ADPS0);
  quadrature_start(&signals, (PIND & _BV(PD3)) != 0, (PIND & _BV(PD2)) != 0);
}

int main(void)
{
  static const hal hardware = {0, receive, send, potentiometer, read_and_reset_counter, read_and_reset_lost};
  static board state;
  MCUSR = 0; /* a watchdog reset leaves the watchdog running at its shortest period */
  wdt_enable(WDTO_250MS);
  start_hardware();
  board_start(&state, &hardware);
  sei();
  for (;;) {
    wdt_reset();
    board_loop(&state);
  }
}
