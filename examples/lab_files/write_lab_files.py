"""Write two recordings of a simulated wire as laboratories keep them, into the folder it is started in.

    python examples/lab_files/write_lab_files.py

`bench.tdms` is as LabVIEW writes it: waveforms with their clock, two groups of different rates, millivolts and
millimetres. `logger.csv` is as a logger with a German Windows writes it: lines above the headers, semicolons, decimal
commas, headers of its own, a column that nobody needs. Each is two cycles of the simulated wire.
"""

from pathlib import Path

import numpy as np
from nptdms import ChannelObject, TdmsWriter

import musclewire as mw


def slow_loop(seed):
    """A slow loop of the paper's wire, with noise of its own."""
    with mw.open_rig("simulated", seed=seed) as rig:
        return mw.characterize(rig)


def write_tdms(path, loop):
    """Write voltages and laser in one group, and the slow thermometer of the room in another."""
    period_s = float(np.median(np.diff(loop["time_s"])))
    started = np.datetime64("2026-03-08T10:30:28")

    def channel(group, name, values, unit, increment_s):
        clock = {"wf_start_time": started, "wf_start_offset": 0.0, "wf_increment": increment_s}
        return ChannelObject(group, name, values, {**clock, "unit_string": unit})

    with TdmsWriter(path) as writer:
        writer.write_segment(
            [
                channel("Measured", "Wire voltage", loop["wire_voltage_v"], "V", period_s),
                channel("Measured", "Shunt voltage", 1e3 * loop["shunt_voltage_v"], "mV", period_s),
                channel("Measured", "Displacement", 1e3 * loop["displacement_m"], "mm", period_s),
                channel("Room", "Air", np.full(len(loop) // 20, 22.0), "degC", 20.0 * period_s),
            ]
        )


def write_csv(path, loop):
    """Write rows with decimal commas below lines of titles."""
    lines = [
        "Messung 12 am Drahtpruefstand",
        "Bediener;M. Muster",
        "",
        "Zeit [ms];U_Draht [mV];U_R [mV];Laser1 [mm];Bemerkung",
    ]
    columns = (loop["time_s"], loop["wire_voltage_v"], loop["shunt_voltage_v"], loop["displacement_m"])
    for row in zip(*columns, strict=True):
        lines.append(";".join(f"{1e3 * value:.4f}" for value in row).replace(".", ",") + ";ok")
    path.write_text("\n".join(lines) + "\n", encoding="cp1252")


write_tdms(Path("bench.tdms"), slow_loop(seed=11))
write_csv(Path("logger.csv"), slow_loop(seed=12))
print("bench.tdms and logger.csv written")
