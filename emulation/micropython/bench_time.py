"""Time on an emulated board, the bench's: a tick passes when its conversion comes, a pause within one takes so long."""

clock_us = 0
PERIOD_US = 1 << 30


def ticks_us():
    return clock_us % PERIOD_US


def ticks_add(ticks, delta):
    return (ticks + delta) % PERIOD_US


def ticks_diff(end, start):
    return (end - start + PERIOD_US // 2) % PERIOD_US - PERIOD_US // 2


def sleep_us(duration_us):
    global clock_us
    clock_us += duration_us
