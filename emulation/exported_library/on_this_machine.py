"""An exported library on this machine: compiled by gcc, called from Python, compared with Python's own tick."""

from __future__ import annotations

import ctypes
import math
import subprocess
from collections.abc import Iterable
from pathlib import Path
from typing import Any

import numpy as np

from musclewire.arrays import FloatArray
from musclewire.controllers import FuzzyPidSettings
from musclewire.errors import NumericsError
from musclewire.extras.board import ExerciseRow, ReferenceTick, TickOutcome

__all__ = ["FILTER_DIFFERENCE", "MAX_DIFFERENCE", "HostLibrary", "built", "host_hash", "largest_differences"]

FLAGS = ("-std=c99", "-O2", "-ffp-contract=off", "-Wall", "-Wextra", "-Werror")
# What is promised of C against Python, by whether it is double precision: relative there, else of full scale.
MAX_DIFFERENCE = {True: 1e-6, False: 2e-4}
# The filter enlarges the rounding of singles where faults contradict its model.
FILTER_DIFFERENCE = {True: 1e-6, False: 2e-2}
# A value nearer to zero than this fraction of its full scale is compared to that instead of to itself.
SMALL_FRACTION = 1e-3
# Python's shims around the structures of the library: plain numbers in, plain numbers out.
SHIMS = """
#include "musclewire.h"
static void put(double *out, const mw_controller *c, mw_output o)
{
    out[0] = o.resistance_ohm; out[1] = o.estimate; out[2] = o.valid;
#if defined(MW_INVERSE_MODEL)
    out[3] = c->answer.holding_w; out[4] = c->answer.due_j; out[5] = c->answer.limited;
#else
    out[3] = c->kp; out[4] = c->ki; out[5] = c->kd;
#endif
    out[6] = o.drive_voltage_v; out[7] = o.state; out[8] = o.event;
}
unsigned long shim_bytes(void) { return sizeof(mw_controller); }
void shim_start(mw_controller *c) { mw_start(c); }
void shim_sample(mw_controller *c, double wire, double shunt, double tick, double *out)
{
    put(out, c, mw_sample(c, (mw_real)wire, (mw_real)shunt, (mw_real)tick));
}
void shim_control(mw_controller *c, double target, double dt, double *out)
{
    put(out, c, mw_control(c, (mw_real)target, (mw_real)dt));
}
void shim_drive(mw_controller *c, double drive, double *out) { put(out, c, mw_drive(c, (mw_real)drive)); }
void shim_event(mw_controller *c, unsigned char event, double missing)
{
    mw_protect_event(&c->protection, event, (mw_real)missing);
}
void shim_missing(mw_controller *c, unsigned char event, double missing)
{
    mw_protect_missing(&c->protection, event, (mw_real)missing);
}
void shim_trip(mw_controller *c, unsigned char event) { mw_protect_trip(&c->protection, event); }
void shim_arm_again(mw_controller *c) { mw_protect_arm_again(&c->protection); }
void shim_off(mw_controller *c) { mw_protect_off(&c->protection); }
void shim_rest(mw_controller *c) { mw_protect_rest(&c->protection); }
int shim_recover(mw_controller *c, unsigned char event) { return mw_protect_recover(&c->protection, event); }
int shim_follows(const mw_controller *c) { return mw_protect_follows(&c->protection); }
void shim_reading(mw_controller *c, double drive, double wire, double shunt, double ordered,
                  double dt)
{
    mw_protect_reading(&c->protection, (mw_real)drive, (mw_real)wire, (mw_real)shunt, (mw_real)ordered, (mw_real)dt);
}
void shim_command(mw_controller *c, double drive) { mw_protect_command(&c->protection, (mw_real)drive); }
void shim_protection(const mw_controller *c, double *out)
{
    out[0] = c->protection.state; out[1] = c->protection.event;
    out[2] = mw_protect_allowed(&c->protection); out[3] = c->protection.above_ambient_k;
}
double shim_exponential(double x) { return mw_exponential((mw_real)x); }
double shim_root(double x) { return mw_root((mw_real)x); }
#if !defined(MW_INVERSE_MODEL)
void shim_infer(double error, double change, double *out)
{
    mw_ratios r = mw_infer((mw_real)error, (mw_real)change);
    out[0] = r.kp; out[1] = r.ki; out[2] = r.kd;
}
#endif
double shim_resistance(double wire, double shunt) { return mw_resistance((mw_real)wire, (mw_real)shunt); }
double shim_estimate(double resistance, unsigned char *valid)
{
    mw_estimation e = mw_estimate((mw_real)resistance);
    *valid = e.valid;
    return e.value;
}
#if defined(MW_FILTER)
/* A row of voltages and time after another: value, deviation, validity, four states and their covariance. */
void shim_follow(mw_controller *c, const double *in, unsigned long rows, double *out)
{
    const mw_follower *f = &c->follower;
    for (; rows > 0; rows--, in += 3, out += 17) {
        const mw_real wire = (mw_real)in[0], shunt = (mw_real)in[1];
        const mw_estimation e = mw_follow(&c->follower, mw_resistance(wire, shunt), wire, shunt, (mw_real)in[2]);
        const mw_real found[7] = {e.value, f->std, e.valid, f->steady_w, f->place, f->shift_w, f->loss};
        for (int i = 0; i < 17; i++)
            out[i] = i < 7 ? found[i] : f->covariance[i - 7];
    }
}
#endif
#if defined(MW_INVERSE_MODEL)
static void put_inverse_model(double *out, const mw_inverse_model *o, mw_inverse_model_answer a)
{
    const mw_real found[13] = {a.drive_voltage_v, a.holding_w, a.due_j, a.limited, o->drive_voltage_v, o->power_w,
                               o->given_part, o->holding_w, o->target, o->moved, o->balance_w, o->loss, o->value};
    for (int i = 0; i < 13; i++)
        out[i] = found[i];
}
/* A step of the inverse of the wire's model after another, from a drive: whether there is current, whether the wire is
 * cold and whether its state is known, target, value, deviation, time and state; the answer, then what it remembers. */
void shim_inverse_model(mw_controller *c, double drive, const double *in, unsigned long rows, double *out)
{
    mw_inverse_model *own = &c->inverse_model;
    mw_inverse_model_start(own, (mw_real)drive);
    for (; rows > 0; rows--, in += 12, out += 13) {
        const mw_sensed sensed = {
            (mw_real)in[4], (mw_real)in[5], in[1] != 0, in[2] != 0,
            (mw_real)in[7], (mw_real)in[8], (mw_real)in[9], (mw_real)in[10], (mw_real)in[11],
        };
        if (in[0] != 0)
            put_inverse_model(out, own, mw_inverse_model_step(own, (mw_real)in[3], &sensed, (mw_real)in[6]));
        else
            put_inverse_model(out, own, mw_inverse_model_hold(own));
    }
}
#endif
"""


def built(folder: Path, out: Path, *, double: bool, compiler: str = "gcc", flags: Iterable[str] = FLAGS) -> Path:
    """Compile a library's sources as a shared object of this machine and return its path.

    Raises NumericsError with the compiler's first complaint.
    """
    shims = out / "shims.c"
    shims.write_text(SHIMS, encoding="utf-8")
    shared = out / f"{folder.name}_{'double' if double else 'single'}.so"
    precision = ["-DMW_DOUBLE"] if double else []
    sources = [str(source) for source in sorted((folder / "src").glob("*.c"))]
    _run(
        [
            compiler,
            *flags,
            *precision,
            "-shared",
            "-fPIC",
            f"-I{folder / 'src'}",
            *sources,
            str(shims),
            "-o",
            str(shared),
        ]
    )
    return shared


def host_hash(folder: Path, samples: int, *, double: bool) -> str:
    """Return what the library's ``same_bits`` prints on this machine."""
    program = folder / f"same_bits_{'double' if double else 'single'}"
    precision = ["-DMW_DOUBLE"] if double else []
    sources = [str(source) for source in sorted((folder / "src").glob("*.c"))]
    _run(
        [
            "gcc",
            *FLAGS,
            *precision,
            f"-I{folder / 'src'}",
            *sources,
            str(folder / "test/same_bits.c"),
            "-o",
            str(program),
        ]
    )
    return _run([str(program), str(samples)]).strip()


class HostLibrary:
    """A compiled library behind plain numbers; one wire's state."""

    def __init__(self, shared: Path, *, double: bool) -> None:
        """Load it and start."""
        self.double = double
        self._c: Any = ctypes.CDLL(str(shared))
        for name in ("exponential", "root", "resistance", "estimate"):
            getattr(self._c, f"shim_{name}").restype = ctypes.c_double
        self._c.shim_bytes.restype = ctypes.c_ulong
        self._state = ctypes.create_string_buffer(self._c.shim_bytes())
        self._out = (ctypes.c_double * 9)()
        self.start()

    def start(self) -> None:
        """Cold start."""
        self._c.shim_start(self._state)

    def sample(self, wire_voltage_v: float, shunt_voltage_v: float, tick_s: float) -> TickOutcome:
        """Take one sample."""
        self._c.shim_sample(self._state, *_doubles(wire_voltage_v, shunt_voltage_v, tick_s), self._out)
        return self._outcome()

    def control(self, target: float, dt_s: float) -> TickOutcome:
        """Run one control tick."""
        self._c.shim_control(self._state, *_doubles(target, dt_s), self._out)
        return self._outcome()

    def drive(self, drive_voltage_v: float) -> TickOutcome:
        """Command a drive, open loop."""
        self._c.shim_drive(self._state, *_doubles(drive_voltage_v), self._out)
        return self._outcome()

    def reading(
        self,
        drive_voltage_v: float,
        wire_voltage_v: float,
        shunt_voltage_v: float,
        dt_s: float,
        ordered_voltage_v: float,
    ) -> None:
        """Give the protection one reading."""
        volts = drive_voltage_v, wire_voltage_v, shunt_voltage_v, ordered_voltage_v
        self._c.shim_reading(self._state, *_doubles(*volts, dt_s))

    def command(self, drive_voltage_v: float) -> None:
        """Give the protection one command."""
        self._c.shim_command(self._state, *_doubles(drive_voltage_v))

    def missing(self, event: int, missing_s: float) -> None:
        """Report to the protection which event has been missing for how long."""
        self._c.shim_missing(self._state, ctypes.c_ubyte(event), *_doubles(missing_s))

    def event(self, event: int, missing_s: float) -> None:
        """Let the protection act on an event as its table says."""
        self._c.shim_event(self._state, ctypes.c_ubyte(event), *_doubles(missing_s))

    def trip(self, event: int) -> None:
        """Trip the protection."""
        self._c.shim_trip(self._state, ctypes.c_ubyte(event))

    def arm_again(self) -> None:
        """Arm for a wire that is as warm as it was."""
        self._c.shim_arm_again(self._state)

    def off(self) -> None:
        """Switch off."""
        self._c.shim_off(self._state)

    def rest(self) -> None:
        """Pause at the sense voltage."""
        self._c.shim_rest(self._state)

    def recover(self, event: int) -> bool:
        """Report that what was missing under an event is back; return whether it was missing."""
        return bool(self._c.shim_recover(self._state, ctypes.c_ubyte(event)))

    def follows(self) -> bool:
        """Return whether a command would be followed."""
        return bool(self._c.shim_follows(self._state))

    def protection(self) -> tuple[int, int, float, float]:
        """Return state, event, drive allowed [V] and temperature above the air's [K]."""
        self._c.shim_protection(self._state, self._out)
        return int(self._out[0]), int(self._out[1]), self._out[2], self._out[3]

    def exponential(self, x: float) -> float:
        """Return the library's e^x."""
        return float(self._c.shim_exponential(*_doubles(x)))

    def root(self, x: float) -> float:
        """Return the library's square root."""
        return float(self._c.shim_root(*_doubles(x)))

    def follow(self, rows: FloatArray) -> FloatArray:
        """Return what the exported filter makes of rows of wire's and shunt's voltage [V] and time [s], (n, 17)."""
        given, found = np.ascontiguousarray(rows), np.empty((len(rows), 17))
        pointers = [array.ctypes.data_as(ctypes.POINTER(ctypes.c_double)) for array in (given, found)]
        self._c.shim_follow(self._state, pointers[0], ctypes.c_ulong(len(rows)), pointers[1])
        return found

    def inverse_model(self, drive_voltage_v: float, rows: FloatArray) -> FloatArray:
        """Return answers and states, (n, 13), of the inverse of the wire's model, from a drive [V], for rows (n, 12).

        A row has current (1), cold and wire known, target, value, deviation, time [s], and the wire's state.
        """
        given, found = np.ascontiguousarray(rows), np.empty((len(rows), 13))
        pointers = [array.ctypes.data_as(ctypes.POINTER(ctypes.c_double)) for array in (given, found)]
        count = ctypes.c_ulong(len(rows))
        self._c.shim_inverse_model(self._state, *_doubles(drive_voltage_v), pointers[0], count, pointers[1])
        return found

    def resistance(self, wire_voltage_v: float, shunt_voltage_v: float) -> float:
        """Return Eq. 1; 0 for "no current"."""
        return float(self._c.shim_resistance(*_doubles(wire_voltage_v, shunt_voltage_v)))

    def estimate(self, resistance_ohm: float) -> tuple[float, bool]:
        """Return the estimate and whether it is valid."""
        valid = ctypes.c_ubyte()
        value = self._c.shim_estimate(*_doubles(resistance_ohm), ctypes.byref(valid))
        return float(value), bool(valid.value)

    def infer(self, error_ratio: float, change_ratio: float) -> tuple[float, float, float]:
        """Return the three gain ratios."""
        self._c.shim_infer(*_doubles(error_ratio, change_ratio), self._out)
        return self._out[0], self._out[1], self._out[2]

    def tick(self, tick: ExerciseRow) -> TickOutcome:
        """Take the inputs of a tick of an exercise."""
        if tick.start:
            self.start()
        outcome = self.sample(tick.wire_voltage_v, tick.shunt_voltage_v, tick.tick_s)
        return self.control(tick.target, tick.control_s) if tick.control_s else outcome

    def _outcome(self) -> TickOutcome:
        resistance, estimate, valid, kp, ki, kd, drive, state, event = self._out
        return TickOutcome(resistance, estimate, bool(valid), kp, ki, kd, drive, int(state), int(event))


def largest_differences(
    library: HostLibrary, reference: ReferenceTick, ticks: Iterable[ExerciseRow], *, relative: bool
) -> dict[str, float]:
    """Return the largest difference between C and Python for each number of the outcome.

    ``relative``: of Python's value (near zero, of a thousandth of full scale); otherwise of full scale. State, event
    and validity differ by 0 or more than any bar allows.
    """
    scales = full_scales(reference)
    most = dict.fromkeys(TickOutcome._fields, 0.0)
    for tick in ticks:
        ours = library.tick(tick)
        for name, c, python in zip(TickOutcome._fields, ours, tick.outcome, strict=True):
            scale = max(abs(python), SMALL_FRACTION * scales[name]) if relative else scales[name]
            difference = abs(float(c) - float(python)) / scale
            most[name] = max(most[name], difference) if not math.isnan(difference) else math.inf
    return most


def full_scales(reference: ReferenceTick) -> dict[str, float]:
    """Return the full scale of each number of the outcome."""
    model, settings = reference.model, reference.settings
    if isinstance(settings, FuzzyPidSettings):
        recorded = [gains[1] or 1.0 for gains in (settings.kp_range, settings.ki_range, settings.kd_range)]
    else:
        most_w = settings.maximum_steady_power_w
        recorded = [most_w, most_w * settings.thermal_time_constant_s, 1.0]
    return {
        "resistance_ohm": model.resistance_max_ohm,
        "estimate": max(abs(model.quantity_max), abs(model.quantity_min)),
        "valid": 1.0,
        **dict(zip(("kp", "ki", "kd"), recorded, strict=True)),
        "drive_voltage_v": reference.limits.maximum_voltage_v,
        "state": 1.0,
        "event": 1.0,
    }


def _doubles(*values: float) -> list[ctypes.c_double]:
    return [ctypes.c_double(value) for value in values]


def _run(command: list[str]) -> str:
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    if done.returncode:
        lines = (done.stderr or done.stdout).strip().splitlines() or ["nothing was printed"]
        first = next((line for line in lines if "error" in line), lines[0])
        raise NumericsError(f"{command[0]} ended with {done.returncode}: {first}")
    return done.stdout
