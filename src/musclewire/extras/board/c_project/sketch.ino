// Copyright (c) 2026, the musclewire developers. SPDX-License-Identifier: BSD-3-Clause (LICENSE)
// @NAME@ on an Arduino: a wire that holds a @QUANTITY@ by its own resistance. Written by musclewire export c.
//
// Circuit: the board's circuit of musclewire's wiring guide (pin 9 through two low-pass filters of 160 Hz and a buffer of gain
// 1 -> wire -> shunt -> ground; A0 at the wire's top without divider, A1 after an amplifier of gain 20). The filters need
// fast PWM: an Uno or Nano gets 15.6 kHz here; on another board raise the PWM frequency yourself, 490 Hz would heat in pulses.
// Measure the three numbers of volts per count on your own board before the wire is connected. Send a target over the serial
// monitor, in SI (0.012 for 1.2 % strain). Anything else switches off until the board is reset: text that is not a number, a
// target above the model's range, for which the wire would be heated without end, or no target for longer than EXPIRY_MS.
// Only AVR boards get their watchdog here: on any other board start its own, or a loop that hangs leaves the wire hot.
#include <musclewire.h>
#if defined(__AVR__)
#include <avr/wdt.h>
#endif

const uint8_t DRIVE_PIN = 9;    // PWM
const uint8_t SUPPLY_PIN = A0;  // top of the wire, through a divider
const uint8_t SHUNT_PIN = A1;   // top of the shunt, through an amplifier or directly
const float SUPPLY_V_PER_COUNT = 0.00489f;  // volts at the top of the wire per count of the converter: 5 V / 1023
const float SHUNT_V_PER_COUNT = 0.000244f;  // volts at the shunt per count: the same over the amplifier's gain
#if defined(__AVR_ATmega328P__)
const uint16_t FULL_COUNT = 1023;           // timer 1, ten bits
#else
const uint16_t FULL_COUNT = 255;            // analogWrite
#endif
const float DRIVE_V_PER_COUNT = 5.0f / FULL_COUNT;  // volts of drive per count of PWM
const uint32_t TICK_US = 10000;            // converter tick: both channels are read, the protection looks
const uint8_t TICKS_A_CONTROL = 5;         // control tick: @QUANTITY@, error, drive
const uint32_t EXPIRY_MS = 5000;           // without a target for this long: off

mw_controller controller;
float target = MW_QUANTITY_MIN;
uint32_t next_us, heard_ms;
uint8_t ticks;
char line[16];
uint8_t characters;

// Mean of eight conversions, in counts.
static float counts(uint8_t pin) {
  uint16_t sum = 0;
  for (uint8_t reading = 0; reading < 8; reading++) sum += analogRead(pin);
  return sum / 8.0f;
}

static void put_out(float drive_voltage_v) {
  float wanted = drive_voltage_v / DRIVE_V_PER_COUNT + 0.5f;
  uint16_t count = wanted > FULL_COUNT ? FULL_COUNT : static_cast<uint16_t>(wanted);
#if defined(__AVR_ATmega328P__)
  // Fast PWM of ten bits at 16 MHz / 1024; at 0 the pin leaves the timer, which would still give a pulse of one count.
  TCCR1B = _BV(WGM12) | _BV(CS10);
  TCCR1A = (count > 0 ? _BV(COM1A1) : 0) | _BV(WGM11) | _BV(WGM10);
  OCR1A = count;
  if (count == 0) digitalWrite(DRIVE_PIN, LOW);
#else
  analogWrite(DRIVE_PIN, count);
#endif
}

static void read_line() {
  while (Serial.available() > 0) {
    char got = static_cast<char>(Serial.read());
    if (got != '\n' && characters < sizeof line - 1) {
      line[characters++] = got;
      continue;
    }
    line[characters] = 0;
    characters = 0;
    char *end;
    double asked = strtod(line, &end);
    // A text that is not a number, a number that is too large, or a line without an end is an emergency stop.
    if (got != '\n' || end == line || (*end != 0 && *end != '\r') || !(asked <= MW_QUANTITY_MAX)) {
      mw_protect_trip(&controller.protection, MW_EVENT_STOPPED);
      continue;
    }
    target = static_cast<float>(asked);
    heard_ms = millis();
  }
}

static void report(const mw_output &output) {
  Serial.print(output.estimate, 6);
  Serial.print(' ');
  Serial.print(output.resistance_ohm, 4);
  Serial.print(' ');
  Serial.print(output.drive_voltage_v, 3);
  Serial.print(' ');
  Serial.print(output.state);
  Serial.print(' ');
  Serial.println(output.event);
}

void setup() {
  pinMode(DRIVE_PIN, OUTPUT);
  put_out(0);  // before anything else
#if defined(__AVR__)
  wdt_enable(WDTO_250MS);  // a loop that hangs is reset, and a reset board has its output off
#endif
  Serial.begin(115200);
  mw_start(&controller);
  next_us = micros() + TICK_US;
  heard_ms = millis();
}

void loop() {
  read_line();
  if (static_cast<int32_t>(micros() - next_us) < 0) return;
  next_us += TICK_US;
  float shunt_v = SHUNT_V_PER_COUNT * counts(SHUNT_PIN);
  float wire_v = SUPPLY_V_PER_COUNT * counts(SUPPLY_PIN) - shunt_v;
  mw_output output = mw_sample(&controller, wire_v, shunt_v, TICK_US * 1e-6f);
  if (millis() - heard_ms > EXPIRY_MS) mw_protect_trip(&controller.protection, MW_EVENT_COMMAND_MISSING);
  if (++ticks >= TICKS_A_CONTROL) {
    ticks = 0;
    output = mw_control(&controller, target, TICKS_A_CONTROL * (TICK_US * 1e-6f));
    report(output);
  }
  put_out(mw_protect_allowed(&controller.protection));
#if defined(__AVR__)
  wdt_reset();
#endif
}
