"""The rules of a board as MicroPython computes them: rows of exercise in, outcomes out, all numbers to the bit."""

import array
import math
import struct

import musclewire_numbers as n
import musclewire_rules as rules


def floats(numbers):
    return memoryview(array.array("d", numbers))


class Tick:
    """As the host's reference of an exported library: a sample, then estimate and controller."""

    def __init__(self):
        self.numbers, self.method = floats(n.ESTIMATOR), floats(n.CONTROLLER)
        self.given, self.answer = floats([0.0] * 4), floats([0.0] * n.ESTIMATOR_ANSWERS)
        self.asked, self.answered = floats([0.0] * 11), floats([0.0] * n.CONTROLLER_ANSWERS)
        self.start()

    def start(self):
        row = list(n.PROTECTION)
        row[n.LASTING_S] = list(n.PROTECTION[n.LASTING_S])
        self.rows, self.rules = [row], [n.RULES]
        row[n.TEMPERATURE_K] = n.RULES[n.AMBIENT_K]
        rules.signalled(self.rows, self.rules, 0, n.ARM, n.NONE, 0.0)
        self.state, self.control, self.time_s = floats(n.ESTIMATOR_STATE), None, 0.0

    def drive_v(self):
        return rules.allowed_drive_v(self.rows, self.rules, 0)

    def take(self, wire_v, shunt_v, target, tick_s):
        out_v = self.drive_v()
        rules.judged_sample(self.rows, self.rules, 0, out_v, wire_v, shunt_v, out_v, tick_s)
        self.time_s += tick_s
        given, answer = self.given, self.answer
        given[0], given[1], given[2], given[3] = self.time_s, self.drive_v(), wire_v, shunt_v
        rules.estimator_tick(self.numbers, self.state, given, answer)
        rules.commanded(self.rows, self.rules, 0, self.controlled(target, tick_s) if math.isfinite(target) else -1.0)

    def controlled(self, target, tick_s):
        asked, answer = self.asked, self.answer
        if self.control is None:
            if answer[3] == n.NO_CURRENT:
                return self.drive_v()
            self.control = floats(n.CONTROL_STATE)
            for place in n.DRIVE_PLACES:
                self.control[place] = self.drive_v()
        asked[0], asked[5] = target, tick_s
        for place in range(4):
            asked[1 + place] = answer[place]
        for place in range(5):
            asked[6 + place] = answer[6 + place] if n.KNOWS_WIRE else math.nan
        rules.controller_tick(self.method, self.control, asked, self.answered)
        return self.answered[0]

    def outcome(self):
        row = self.rows[0]
        return struct.pack("<dddBB", self.drive_v(), row[n.TEMPERATURE_K], self.answer[0], row[n.STATE], row[n.EVENT])


tick, given = Tick(), "<Bdddd"
with open("/exercise.bin", "rb") as file:
    content = file.read()
size = struct.calcsize(given)
for at in range(0, len(content), size):
    start, wire_v, shunt_v, target, tick_s = struct.unpack(given, content[at : at + size])
    if start:
        tick.start()
    tick.take(wire_v, shunt_v, target, tick_s)
    print(tick.outcome().hex())
