"""What flows in the board's circuit when a part has failed, by ngspice: python hardware/board/spice.py

The netlist is that of the parts list, so what is simulated is what is drawn and laid out. Resistors, capacitors and
fuses have their values; transistors, amplifiers and the regulator are simple models with the numbers of their data
sheets (voltages, gains, limits), which show what limits what, not the last per cent. Needs ngspice.
"""

from __future__ import annotations

import re
import subprocess
import tempfile
import tomllib
from pathlib import Path
from typing import Any, NamedTuple

__all__ = ["FAULTS", "Case", "Steady", "circuit", "ripple_v", "steady"]

PARTS = Path(__file__).resolve().parents[2] / "src/musclewire/extras/board/parts_lists/board.toml"
UNITS = {"ohm": 1.0, "kohm": 1e3, "nF": 1e-9, "uF": 1e-6}
WIRE_OHM, OPEN_OHM, SHORT_OHM = 17.6, 1e9, 0.02  # 14 cm of 0.10 mm wire, cold
MODELS = """
.model d1n4007 d(is=7n n=1.8 rs=0.04)
.model bc337 npn(is=40f bf=300)
.model driver npn(is=10f bf=100)
.model power npn(is=1p bf=50)
.subckt tip122 b c e
qa c b x driver
qb c x e power
ra b x 8k
rb x e 120
.ends
.subckt lm317 adj out in
bref set 0 v=0.5*(v(in)-1.8+v(adj)+1.25-sqrt((v(in)-3.05-v(adj))^2+1e-4))
vflow set mid 0
rout mid out 0.02
fin in 0 vflow 1
.ends
.subckt lm358 out minus plus vm vp
bgain g 0 v=0.005+(v(vp)-1.505)*(0.5+0.5*tanh(2e5*(v(plus)-v(minus))/(v(vp)-1.505)))
rpole g h 1k
cpole h 0 15.9u
eout k 0 h 0 1
rout k out 100
.ends
.subckt ina180 out gnd plus minus vs
bgain k gnd v=min(max(20*(v(plus)-v(minus)),0.005),max(v(vs)-0.02,0.005))
rout k out 10
.ends
"""


class Case(NamedTuple):
    """What the board applies, what the adapter gives, and what is shorted, changed or left out."""

    drive_v: float | None = 0.0  # None: the pin floats, as at reset
    supply_v: float = 12.0
    wire_ohm: float = WIRE_OHM
    shorted: tuple[tuple[str, str], ...] = ()
    tap_broken: bool = False
    stop_pressed: bool = False


class Steady(NamedTuple):
    """Voltages and the wire's current at rest."""

    output_v: float
    current_a: float
    a0_v: float
    a1_v: float


T1_SHORTED, U3_SHORTED = ("LIMITED", "EMITTER"), ("+12V", "LIMITED")
FAULTS = {
    "at reset, the pin floats": Case(None),
    "drive of 3 V": Case(3.0),
    "program at full drive": Case(5.0),
    "T1 shorted, drive off": Case(0.0, shorted=(T1_SHORTED,)),
    "T1 shorted, wire shorted": Case(0.0, wire_ohm=SHORT_OHM, shorted=(T1_SHORTED,)),
    "U3 shorted, full drive": Case(5.0, shorted=(U3_SHORTED,)),
    "U3 shorted, wire shorted, full drive": Case(5.0, wire_ohm=SHORT_OHM, shorted=(U3_SHORTED,)),
    "T1 and U3 both shorted": Case(0.0, shorted=(T1_SHORTED, U3_SHORTED)),
    "tap broken, drive of 3 V": Case(3.0, tap_broken=True),
    "wire broken, full drive": Case(5.0, wire_ohm=OPEN_OHM),
    "adapter the other way round, full drive": Case(5.0, supply_v=-12.0),
    "S1 pressed, full drive": Case(5.0, stop_pressed=True),
}


def node(net: str) -> str:
    """Return a net's name as ngspice takes it."""
    return "0" if net == "GND" else net.lower().replace("+", "p")


def number(value: str) -> str:
    """Return a part's value in SI."""
    amount, unit = value.split()[:2]
    return f"{float(amount) * UNITS[unit]:g}"


def lines_of(part: dict[str, Any], case: Case) -> list[str]:
    """Return a part's lines of the netlist; connectors have none."""
    label, at = part["label"], {pin["pin"]: node(pin["net"]) for pin in part.get("pins", [])}
    pins = [at[pin] for pin in sorted(at)]
    kind = part.get("symbol", "")
    if kind in ("Device:R", "Device:C", "Device:C_Polarized"):
        return [f"{kind[7]}_{label} {at['1']} {at['2']} {number(part['value'])}"]
    if kind in ("Device:Fuse", "Device:Polyfuse"):
        return [f"R_{label} {at['1']} {at['2']} {3.0 if label == 'F2' else 0.2}"]
    if label == "S1":
        return [f"R_S1 {at['1']} {at['2']} {OPEN_OHM if case.stop_pressed else 0.01}"]
    return {
        "D1": [f"D_D1 {at.get('2')} {at.get('1')} d1n4007"],
        "T1": [f"X_T1 {' '.join(pins)} tip122"],
        "T2": [f"Q_T2 {' '.join(pins)} bc337"],
        "U3": [f"X_U3 {' '.join(pins)} lm317"],
        "U1": [f"X_U1 {' '.join(at.get(str(pin), '0') for pin in (1, 2, 3, 4, 8))} lm358"],
        "U2": [f"X_U2 {' '.join(pins)} ina180"],
    }.get(label, [])


def circuit(case: Case, drive: str = "") -> str:
    """Return the netlist for a case; ``drive`` is the waveform at D9 in the place of the case's steady one."""
    parts = tomllib.loads(PARTS.read_text("utf-8"))["part"]
    lines = ["the board's circuit", *(line for part in parts for line in lines_of(part, case))]
    lines += [f"V_in supply 0 {case.supply_v}", "V_usb p5v 0 5", f"V_pin pin 0 {drive or case.drive_v or 0.0}"]
    lines += [f"R_pin pin d9 {OPEN_OHM if case.drive_v is None else 25.0}", f"R_wire output shunt {case.wire_ohm}"]
    lines += [f"R_tap output tap {OPEN_OHM if case.tap_broken else 0.01}"]
    lines += [f"R_short{i} {node(a)} {node(b)} {SHORT_OHM}" for i, (a, b) in enumerate(case.shorted)]
    return "\n".join([*lines, MODELS])


def run(netlist: str, commands: str) -> str:
    """Return what ngspice prints. Raises RuntimeError if it finds no solution."""
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "circuit.cir"
        file.write_text(f"{netlist}\n.control\n{commands}\nquit 0\n.endc\n.end\n", encoding="utf-8")
        done = subprocess.run(["ngspice", "-b", str(file)], capture_output=True, text=True, check=False)
    if done.returncode or "simulation(s) aborted" in done.stdout + done.stderr:
        raise RuntimeError(f"ngspice found no solution:\n{done.stdout[-2000:]}{done.stderr[-2000:]}")
    return done.stdout


def printed(text: str, name: str) -> float:
    """Return a value that ngspice has printed under a name."""
    found = re.search(rf"^{re.escape(name)}\s*=\s*(\S+)", text, re.M)
    if found is None:
        raise RuntimeError(f"ngspice printed no {name}:\n{text[-2000:]}")
    return float(found[1])


def steady(case: Case) -> Steady:
    """Return voltages and current of a case at rest."""
    text = run(circuit(case), "op\nprint v(output) v(shunt) v(a0) v(a1)")
    output_v, shunt_v, a0_v, a1_v = (printed(text, f"v({name})") for name in ("output", "shunt", "a0", "a1"))
    return Steady(output_v, shunt_v / 1.0, a0_v, a1_v)  # the shunt is 1 ohm


def ripple_v(share: float) -> tuple[float, float]:
    """Return what the PWM leaves at the output with this part of each pulse on, from peak to peak, and the mean."""
    period_us = 1e6 / 15.625e3
    pulses = f"PULSE(0 5 0 50n 50n {share * period_us:.4f}u {period_us:.4f}u)"
    measure = "meas tran low min v(output) from=40m to=41m\nmeas tran high max v(output) from=40m to=41m"
    text = run(circuit(Case(0.0), pulses), f"tran 2u 41m 0 2u\n{measure}\nmeas tran mean avg v(output) from=40m to=41m")
    return printed(text, "high") - printed(text, "low"), printed(text, "mean")


def main() -> None:
    """Print a line for each case, and what the pulses leave."""
    print(f"{'':40s}  output  current      A0      A1")
    for name, case in FAULTS.items():
        at = steady(case)
        print(f"{name:40s} {at.output_v:5.2f} V  {at.current_a:5.3f} A {at.a0_v:5.2f} V {at.a1_v:5.2f} V")
    left_v, mean_v = ripple_v(0.6)
    print(f"pulses of 5 V, 60 % on: {mean_v:.3f} V, of which {1e3 * left_v:.2f} mV from peak to peak are left pulses")


if __name__ == "__main__":
    main()
