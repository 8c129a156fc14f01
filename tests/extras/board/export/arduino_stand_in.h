/* What the exported sketch uses of an Arduino, as variables of a test on this machine: pins, clock, serial monitor. */
#ifndef ARDUINO_STAND_IN_H
#define ARDUINO_STAND_IN_H

#include <math.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string>

enum { A0 = 14, A1 = 15, OUTPUT = 1 };

static uint32_t clock_us;
static int analogue_counts[2] = {0, 0};
static int drive_counts = -1;
static std::string typed;

static inline uint32_t micros() { return clock_us; }
static inline uint32_t millis() { return clock_us / 1000; }
static inline void pinMode(uint8_t, int) {}
// A count more now and then, as a real converter gives.
static inline int analogRead(uint8_t pin) {
  static uint32_t noise = 1;
  noise = noise * 1664525u + 1013904223u;
  return analogue_counts[pin - A0] + static_cast<int>(noise >> 31);
}
static inline void analogWrite(uint8_t, int counts) { drive_counts = counts; }

static struct {
  void begin(long) {}
  int available() { return static_cast<int>(typed.size()); }
  int read() {
    int got = typed[0];
    typed.erase(0, 1);
    return got;
  }
  template <typename... Kind> void print(Kind...) {}
  template <typename... Kind> void println(Kind...) {}
} Serial;

#endif
