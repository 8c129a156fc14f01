"""Fit a model to a CSV file from another program's logger: its own headers, milliseconds, millivolts, millimetres."""

import tempfile
from pathlib import Path

import musclewire as mw


def write_logger_csv(path: Path) -> None:
    """Write a loop as a logger would; take your own file instead."""
    with mw.open_rig("simulated", seed=3) as rig:
        loop = mw.characterize(rig)
    columns = [
        ("Millis [ms]", 1e3 * loop["time_s"]),
        ("CH1 [mV]", 1e3 * loop["wire_voltage_v"]),
        ("CH2 [mV]", 1e3 * loop["shunt_voltage_v"]),
        ("Probe [mm]", 1e3 * loop["displacement_m"]),
    ]
    rows = zip(*(values for _, values in columns), strict=True)
    lines = [",".join(header for header, _ in columns), *(",".join(f"{value:.4f}" for value in row) for row in rows)]
    path.write_text("\n".join(lines), encoding="utf-8")


with tempfile.TemporaryDirectory() as folder:
    path = Path(folder) / "logger.csv"
    write_logger_csv(path)
    recording = mw.read_recording(
        path,
        {"time_s": "Millis", "wire_voltage_v": "CH1", "shunt_voltage_v": "CH2", "displacement_m": "Probe"},
        {"shunt_resistance_ohm": 1.0, "leg_length_m": 0.07},
    )

model = mw.fit(recording)
print(model.summary())

strain = 0.02
print(f"{100 * strain:g} % strain requires {model.resistance_ohm(strain):.3f} ohm")
