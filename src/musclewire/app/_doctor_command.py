"""The command that looks a rig over before anything is heated: doctor."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from musclewire.app._options import HOLD, METER_SHUNT, METER_WIRE, REAL_TIME, SEED, WRITE, RigName, in_si
from musclewire.app._output import Result, progress_bar, table
from musclewire.app._stopping import opened_rig, stops_between_samples

if TYPE_CHECKING:
    from musclewire.app._answers import DoctorAnswer
    from musclewire.experiment import ChannelCalibration, Examination, RigCheck
    from musclewire.signals import RawSample


@dataclass(frozen=True)
class MeterOptions:
    """How long the sense voltage is held, and what a meter reads meanwhile."""

    hold: Annotated[str, HOLD] = "5 s"
    meter_wire: Annotated[str | None, METER_WIRE] = None
    meter_shunt: Annotated[str | None, METER_SHUNT] = None


def doctor(
    rig: RigName,
    measurement: MeterOptions,
    write: Annotated[bool, WRITE] = False,
    seed: Annotated[int | None, SEED] = None,
    real_time: Annotated[bool, REAL_TIME] = False,
) -> Result:
    """Check wiring, noise, polarity, sense voltage and sample clock; nothing is heated."""
    from musclewire.experiment import require_calibrated_kind

    if write:
        require_calibrated_kind(rig)
    found = examined(rig, measurement, seed, real_time)
    written = found.write_calibration(Path(rig)) if write else None
    lines = [text(found)]
    if written is not None:
        lines.append(f"offsets and gains are in {written}; run the doctor again")
    return Result(document(rig, found, written), "\n".join(lines), holds=found.ok, error=found.trouble)


def examined(rig: str, measurement: MeterOptions, seed: int | None, real_time: bool) -> Examination:
    """Return what the examination of a rig found."""
    from musclewire.experiment import examination_s, examine

    hold_s = in_si("--hold", measurement.hold)
    wire_v = in_si("--meter-wire", measurement.meter_wire)
    shunt_v = in_si("--meter-shunt", measurement.meter_shunt)
    task = "Below and at the sense voltage"
    with (
        stops_between_samples(),
        opened_rig(rig, seed=seed, real_time=real_time) as opened,
        progress_bar(task, examination_s(hold_s)) as on_sample,
    ):
        return examine(
            opened,
            hold_s=hold_s,
            meter_wire_v=wire_v,
            meter_shunt_v=shunt_v,
            on_sample=since_start(on_sample),
        )


def since_start(on_row: Any) -> Callable[[RawSample], None]:
    """Return what moves a progress bar by samples of a rig whose clock began before."""
    started_s: list[float] = []

    def on_sample(sample: RawSample) -> None:
        started_s[:] = started_s or [sample.time_s]
        on_row({"time_s": sample.time_s - started_s[0]})

    return on_sample


def document(rig: str, found: Examination, written: Path | None) -> DoctorAnswer:
    """Return the answer of an examination."""
    from musclewire.app._answers import DoctorAnswer

    return DoctorAnswer.read_from(
        found,
        found.findings,
        rig=rig,
        highest_drive_voltage_v=found.highest_v,
        trouble=None if found.trouble is None else str(found.trouble),
        written=None if written is None else str(written),
    )


def text(found: Examination) -> str:
    """Return an examination as lines: verdict, name, value, what it means or what to do."""
    rows = [("ok" if one.ok else "NO", one.name, valued(one), explained(one)) for one in found.findings.worst_first]
    rows += [("-", one.name, "not run", one.reason) for one in found.findings.unchecked]
    lines = [table(["", "", "", ""], rows, left=(0, 1, 3))]
    lines += ["", *(calibrated(one) for one in found.calibration)] if found.calibration else []
    return "\n".join([*lines, "", f"{found.findings.summary}; the drive was at most {found.highest_v:.3g} V"])


def calibrated(one: ChannelCalibration) -> str:
    """Return what a channel reads wrong as a line."""
    gain = "gain unknown without a meter" if one.gain is None else f"true = {one.gain:.5f} times what is left"
    return f"{one.channel} channel: {1e3 * one.offset_v:.4f} mV too much at 0 V; {gain}"


def explained(check: RigCheck) -> str:
    """Return what a check means; a value that is a sentence comes first."""
    long = isinstance(check.value, str) and not valued(check)
    return f"{check.value}; {check.advice}" if long else check.advice


def valued(check: RigCheck) -> str:
    """Return a value with its unit, in steps of a thousand where that reads better."""
    if isinstance(check.value, str):
        # A sentence as value goes to the advice, which has room for it.
        return "" if len(check.value) > 18 else check.value
    if check.value is None:
        return ""
    small = check.unit in {"V", "A", "s"} and 0.0 < abs(check.value) < 0.1
    number = f"{1e3 * check.value:.4g} m" if small else f"{check.value:.4g} "
    return (number + ("" if check.unit == "1" else check.unit)).strip()
