"""The board's program: bytes and readings in, drive and frames out. It does not access hardware.

What may be out is decided by the host's own functions (musclewire_rules); who is in charge, and how old his last
command is, is decided here, as in firmware/src/control.c and application.c.
"""

import binascii
import math
import struct
from array import array

import musclewire_numbers as n
import musclewire_rules as rules

NAN = float("nan")
COMMAND_GRACE_S = 0.06  # a host that exchanges every 0.05 s is not silent
READING_GRACE_S = 0.02  # the table's times still count from the last reading
MAX_SCALE = 0.06  # a wire's resistance changes by less in its life
STORM_FRAMES, STORM_S = 16, 0.2  # so many broken frames within this time: a line that garbles
HEADER_BYTES, CHECK_BYTES = 4, 4
# Single precision where a float is one, so that tables take half the memory.
FLOATS = "d" if 1.0 + 1e-12 != 1.0 else "f"


def floats(numbers):
    """Return numbers as an array whose slices are views."""
    return memoryview(array(FLOATS, numbers))


class Loop:
    """The protection, the estimator and the controller of one wire, run once a tick."""

    def __init__(self):
        self.row = list(n.PROTECTION)
        self.row[n.LASTING_S] = list(n.PROTECTION[n.LASTING_S])
        self.rows, self.rules = [self.row], [n.RULES]
        self.numbers, self.method = floats(n.ESTIMATOR), floats(n.CONTROLLER)
        self.given, self.answer = floats([0.0] * 4), floats([NAN] * n.ESTIMATOR_ANSWERS)
        self.asked, self.answered = floats([0.0] * 11), floats([0.0] * n.CONTROLLER_ANSWERS)
        self._signal(n.CLOSE, n.NONE)
        self._forget()

    def _forget(self):
        self.target, self.scale, self.zero, self.command_v = NAN, 1.0, 0.0, 0.0
        self.closed_loop, self.expires = False, True
        self.command_age_s = self.reading_age_s = 0.0
        self._start_again()

    def _start_again(self):
        """Forget what estimator and controller remember: it is from before."""
        self.state, self.control = floats(n.ESTIMATOR_STATE), None

    def _signal(self, signal, event):
        rules.signalled(self.rows, self.rules, 0, signal, event, 0.0)

    @property
    def protection_state(self):
        return int(self.row[n.STATE])

    @property
    def event(self):
        return int(self.row[n.EVENT])

    @property
    def armed(self):
        return n.RULES[n.OUTPUT_DRIVES][self.protection_state] != n.NO_DRIVE

    @property
    def output_v(self):
        """The only drive voltage that may be out now [V]."""
        return rules.allowed_drive_v(self.rows, self.rules, 0)

    def arm(self):
        self._signal(n.ARM, n.NONE)
        self._forget()
        self.command_v = n.SENSE_V

    def off(self):
        self._signal(n.CLOSE, n.STOPPED)

    def trip(self, event):
        # What is off already stays off with its first cause.
        if self.armed:
            self._signal(n.FAULT, event)

    def renew(self):
        """A valid command has come."""
        self.command_age_s = 0.0
        resumes = n.RULES[n.EFFECTS][self.protection_state][n.PRESENT] == n.RESUME
        if self.event == n.COMMAND_MISSING and self.row[n.OFTEN_MISSING_S] < n.RULES[n.SENSE_AFTER_S]:
            self._signal(n.PRESENT, n.NONE)
            if resumes:
                self._start_again()

    def drive(self, drive_v):
        self.renew()
        self._start_again()
        rules.commanded(self.rows, self.rules, 0, drive_v)
        self.closed_loop, self.command_v = False, drive_v
        return self.armed

    def aim(self, target):
        # Below the range a target only lets the wire cool; above it the loop would heat without end.
        if not (target >= n.LOWEST and (target <= n.HIGHEST or target + self.zero <= n.HIGHEST)):
            self.trip(n.COMMAND_REFUSED)
            return False
        self.renew()
        if not self.closed_loop:
            self._start_again()
        self.closed_loop, self.target = True, target
        return True

    def correct(self, scale, zero):
        if not (abs(scale - 1.0) <= MAX_SCALE and abs(zero) <= n.SPAN):
            return False
        self.scale, self.zero, self.state = scale, zero, floats(n.ESTIMATOR_STATE)
        return True

    def reading(self, wire_v, shunt_v, passed_s):
        """Take a tick with its reading: mean voltages of the drive that was out."""
        if not self.armed:
            air_k, row = n.RULES[n.AMBIENT_K], self.row
            above_k = row[n.TEMPERATURE_K] - air_k
            row[n.TEMPERATURE_K] = air_k + rules.warmed_k(above_k, 0.0, passed_s, n.RULES[n.CAPACITY], n.RULES[n.LOSS])
            return
        # Ticks without a reading were already counted when they passed.
        uncounted_s = max(passed_s - self.reading_age_s, 0.0)
        self.reading_age_s = 0.0
        out_v = self.output_v
        rules.judged_sample(self.rows, self.rules, 0, out_v, wire_v, shunt_v, out_v, passed_s)
        self._age(uncounted_s)
        if self.armed:
            self._follow(wire_v, shunt_v, passed_s)

    def missing(self, passed_s):
        """Take a tick whose reading did not come."""
        if self.armed:
            self.reading_age_s += passed_s
            if self.reading_age_s > READING_GRACE_S:
                rules.happen(self.row, n.RULES, n.SAMPLE_LATE, self.reading_age_s)
            self._age(passed_s)

    def _age(self, passed_s):
        """Apply the table's rule to the host's silence: hold, then sense, then trip."""
        self.command_age_s += passed_s
        if not self.expires or self.command_age_s <= COMMAND_GRACE_S:
            return
        # A missing reading has its own clock, which no command may reset; both end in the same state.
        if self.command_age_s > n.EXPIRY_S or self.event in (n.NONE, n.COMMAND_MISSING):
            rules.happen(self.row, n.RULES, n.COMMAND_MISSING, self.command_age_s)

    def _follow(self, wire_v, shunt_v, passed_s):
        if not self.closed_loop:
            rules.commanded(self.rows, self.rules, 0, self.command_v)
        elif n.RULES[n.EFFECTS][self.protection_state][n.COMMAND] == n.FOLLOW:
            rules.commanded(self.rows, self.rules, 0, self._controlled(wire_v, shunt_v, passed_s))
        else:
            self._start_again()

    def estimate(self, wire_v, shunt_v, passed_s, state):
        """Return what the estimator makes of a sample; the resistance is scaled and the power stays."""
        root, given = math.sqrt(self.scale), self.given
        # Time begins again at each tick: in single precision hours leave no digits for hundredths of a second.
        if n.ESTIMATOR_TIME >= 0:
            state[n.ESTIMATOR_TIME] = 0.0
        given[0], given[1], given[2], given[3] = passed_s, self.output_v, wire_v * root, shunt_v / root
        rules.estimator_tick(self.numbers, state, given, self.answer)
        return self.answer

    def _controlled(self, wire_v, shunt_v, passed_s):
        answer, asked = self.estimate(wire_v, shunt_v, passed_s, self.state), self.asked
        if self.control is None:
            if answer[3] == n.NO_CURRENT:
                return self.output_v
            self.control = floats(n.CONTROL_STATE)
            for place in n.DRIVE_PLACES:
                self.control[place] = self.output_v
        asked[0], asked[5] = min(self.target + self.zero, n.HIGHEST), passed_s
        asked[1], asked[2], asked[3], asked[4] = answer[0], answer[1], answer[2], answer[3]
        for place in range(5):
            asked[6 + place] = answer[6 + place] if n.KNOWS_WIRE else NAN
        rules.controller_tick(self.method, self.control, asked, self.answered)
        return -1.0 if self.answered[1] else self.answered[0]


class FrameDecoder:
    """Frames of the serial line: COBS, a checksum, a version."""

    def __init__(self):
        self.part, self.skipping = bytearray(), False

    def push(self, byte):
        """Return a whole body, None before it has come, False for a broken one."""
        part = self.part
        if byte:
            if len(part) < n.MAX_FRAME:
                part.append(byte)
                return None
            self.part, self.skipping = bytearray(), True
            return False
        skipped, self.part, self.skipping = self.skipping or not part, bytearray(), False
        if skipped:
            return None
        body = self._unstuffed(part)
        if body is None or not HEADER_BYTES + CHECK_BYTES <= len(body) <= n.MAX_BODY or body[0] != n.VERSION:
            return False
        return body[:-4] if binascii.crc32(body[:-4]) == struct.unpack("<I", body[-4:])[0] else False

    @property
    def is_ctrl_c(self):
        """Whether what has come is Ctrl-C, alone or after a return, and no frame, whose second byte is the version."""
        part = self.part
        return part == b"\r\x03" or (len(part) == 2 and part[0] == 3 and part[1] != n.VERSION)

    @staticmethod
    def _unstuffed(frame):
        body, at = bytearray(), 0
        while at < len(frame):
            count = frame[at]
            if not count or at + count > len(frame):
                return None
            body.extend(frame[at + 1 : at + count])
            at += count
            if at < len(frame):
                body.append(0)
        return bytes(body)

    @staticmethod
    def framed(body):
        """Return a body with its checksum as a frame."""
        frame = bytearray()
        for part in (body + struct.pack("<I", binascii.crc32(body))).split(b"\0"):
            frame.append(len(part) + 1)
            frame.extend(part)
        frame.append(0)
        return bytes(frame)


class Application:
    """What a host talks to; ``send`` takes whole frames or, if no room is left, none."""

    def __init__(self, send, set_drive, reset_cause):
        self.send, self.set_drive, self.reset_cause = send, set_drive, reset_cause
        self.loop, self.line = Loop(), FrameDecoder()
        self.tick_count = self.sequence = self.command_sequence = self.bad_frames = 0
        self.stream_every = self.stream_left = 0
        self.storm = [0] * STORM_FRAMES
        self.sums = [0.0, 0.0, 0]
        self.injected, self.kept = 0, (0.0, 0.0)
        self.event_at_reset = n.WATCHDOG if reset_cause == n.RESET_WATCHDOG else n.NONE
        self.reported = (self.loop.protection_state, self.loop.event)
        set_drive(0.0)
        self._identify()

    def _send(self, kind, payload):
        body = struct.pack("<BBH", n.VERSION, kind, self.sequence) + payload
        self.sequence = (self.sequence + 1) & 0xFFFF  # counts what is dropped, too: the host sees the gap
        self.send(FrameDecoder.framed(body))

    def _identify(self):
        periods = round(1e6 * n.TICK_S)
        limits = (n.SENSE_V, n.RULES[n.MAXIMUM_V], n.RULES[n.SHUNT_OHM], round(1e3 * n.EXPIRY_S), n.CHECKSUM)
        names = (self.event_at_reset, n.BOARD, n.QUANTITY, n.WIRE)
        version = (n.VERSION, n.FIRMWARE_MAJOR, n.FIRMWARE_MINOR, self.reset_cause)
        self._send(n.IDENTITY, struct.pack(n.LAYOUTS[n.IDENTITY], *version, periods, periods, *limits, *names))

    def settle(self):
        """Apply what is allowed now, and say what has changed."""
        loop = self.loop
        self.set_drive(loop.output_v)
        now = (loop.protection_state, loop.event)
        if now != self.reported:
            self.reported = now
            self._send(n.EVENT_FRAME, struct.pack(n.LAYOUTS[n.EVENT_FRAME], self.tick_count, *now, self._judged_ohm()))

    def _judged_ohm(self):
        row = self.loop.row
        return resistance(row[n.WIRE_VOLTAGE_V], row[n.SHUNT_VOLTAGE_V])

    def byte(self, byte):
        """Take a byte of the line. Raises KeyboardInterrupt for Ctrl-C at a board that is not armed."""
        body = self.line.push(byte)
        if self.line.is_ctrl_c and not self.loop.armed:
            raise KeyboardInterrupt
        if body is None:
            return
        if body is False:
            self._broken()
            self.settle()
            return
        _, kind, sequence = struct.unpack("<BBH", body[:HEADER_BYTES])
        done = self._obey(kind, sequence, body[HEADER_BYTES:])
        self.settle()  # the output is set before the command is acknowledged
        self._send(n.ACKNOWLEDGEMENT, struct.pack(n.LAYOUTS[n.ACKNOWLEDGEMENT], sequence, kind, done))
        if kind == n.HELLO and done == n.DONE:
            self._identify()

    def _broken(self):
        slot = self.bad_frames % STORM_FRAMES
        first = self.storm[(slot + 1) % STORM_FRAMES]
        self.storm[slot] = self.tick_count
        self.bad_frames += 1
        if self.bad_frames >= STORM_FRAMES and (self.tick_count - first) * n.TICK_S <= STORM_S:
            self.loop.trip(n.LINK_CORRUPTED)

    def _obey(self, kind, sequence, payload):
        loop = self.loop
        if kind not in n.LAYOUTS or kind >= n.IDENTITY or (kind == n.INJECT and not n.FAULT_INJECTION):
            return n.UNKNOWN
        if len(payload) != struct.calcsize(n.LAYOUTS[kind]):
            return n.BAD_PAYLOAD
        given = struct.unpack(n.LAYOUTS[kind], payload)
        if kind in (n.DRIVE, n.TARGET):
            if not loop.armed:
                return n.REFUSED
            if not (loop.drive(given[0]) if kind == n.DRIVE else loop.aim(given[0])):
                return n.BAD_PAYLOAD
            loop.expires, self.command_sequence = True, sequence
        elif kind == n.CORRECT:
            if not loop.correct(*given):
                return n.BAD_PAYLOAD
            self._send(n.CORRECTION, struct.pack(n.LAYOUTS[n.CORRECTION], loop.scale, loop.zero))
        elif kind == n.ARM_FRAME:
            loop.arm()
            self.command_sequence = sequence
        elif kind == n.OFF:
            loop.off()
        elif kind == n.STREAM:
            self.stream_every = self.stream_left = given[0]
            self.sums = [0.0, 0.0, 0]
        elif kind == n.KEEP:
            loop.renew()
        elif kind == n.INJECT:
            self.injected = given[0]
        return n.DONE

    def _with_injected(self, reading):
        """Return a reading with the fault that a test has asked for."""
        while self.injected == n.STUCK_LOOP:
            pass  # the watchdog ends this
        if self.injected == n.SILENT_CONVERTER:
            return None
        if self.injected == n.NAN_READING and reading is not None:
            return NAN, reading[1]
        if self.injected == n.FROZEN_CONVERTER:
            return self.kept
        self.kept = reading or self.kept
        return reading

    def tick(self, reading, ticks=1):
        """Take a tick: (wire, shunt) [V] as of the drive that was out, or None if no reading came."""
        loop, passed_s = self.loop, ticks * n.TICK_S
        if n.FAULT_INJECTION:
            reading = self._with_injected(reading)
        if reading is None:
            loop.missing(passed_s)
            self.settle()
            return
        self.tick_count += ticks
        out_v = loop.output_v  # while this was read; the board's own loop may change it now
        loop.reading(reading[0], reading[1], passed_s)
        sums = self.sums
        sums[0] += reading[0]
        sums[1] += reading[1]
        sums[2] += 1
        self.settle()
        if self.stream_every:
            self.stream_left -= ticks
            if self.stream_left <= 0:
                self.stream_left = self.stream_every
                self._sample(out_v)

    def _sample(self, out_v):
        """Send the means since the last sample, with resistance and estimate; NaN without a reading."""
        loop, (wire_v, shunt_v, count) = self.loop, self.sums
        wire_v, shunt_v = (wire_v / count, shunt_v / count) if count else (NAN, NAN)
        ohm = resistance(wire_v, shunt_v)
        if not (ohm > 0.0 and n.ESTIMATOR):  # without current, or without a model
            value = NAN
        elif loop.closed_loop and loop.control is not None:
            value = loop.answer[0]
        else:
            # Of an open loop by an estimator that has just begun: what it remembers is nobody's.
            value = loop.estimate(wire_v, shunt_v, n.TICK_S, floats(n.ESTIMATOR_STATE))[0]
        said = (self.tick_count, loop.protection_state, loop.event, self.command_sequence, out_v)
        self._send(n.SAMPLE, struct.pack(n.LAYOUTS[n.SAMPLE], *said, wire_v, shunt_v, ohm, value, loop.target))
        self.sums = [0.0, 0.0, 0]


def resistance(wire_v, shunt_v):
    """Return the resistance by Eq. 1 [ohm], 0 without current."""
    shunt_ohm = n.RULES[n.SHUNT_OHM]
    if not abs(shunt_v) >= n.MINIMUM_CURRENT_A * shunt_ohm:
        return 0.0
    found = wire_v / shunt_v * shunt_ohm
    return found if found > 0.0 else 0.0
