"""The doctor on the NI rig at its seam and on the firmware in its emulator: the same checks as on the simulated rig."""

from __future__ import annotations

import shutil
from pathlib import Path

import pytest
from emulation.daq_bench import card_of
from emulation.daq_server import DaqServer
from tests.extras.board.contract.nidaq_rigs import COLD_K, NIDAQ_RIGS, DeviceAtSeam, wiring_of
from tests.extras.board.contract.serial_rigs import SERIAL_RIGS

from musclewire.experiment import Examination, examine
from musclewire.extras.board import NiDaqConfiguration
from musclewire.rigs import GuardedRig, read_rig_file, shipped_rig_files

RIGS = {**NIDAQ_RIGS, **SERIAL_RIGS}
# The paper's wire, cold, behind its shunt of 1 ohm at 0.3 V.
TRUE_WIRE_V, TRUE_SHUNT_V = 0.3 * 17.28 / 18.28, 0.3 / 18.28


@pytest.mark.parametrize(
    "name", [*NIDAQ_RIGS, *(pytest.param(name, marks=pytest.mark.emulated) for name in SERIAL_RIGS)]
)
def test_a_sound_rig_passes_and_gets_no_more_than_its_sense_voltage(name: str) -> None:
    with RIGS[name]() as rig:
        found = examine(rig, hold_s=2.0)
        assert found.highest_v == rig.sense_voltage_v
    assert found.trouble is None
    assert not found.findings.failed
    # Time passes by reading, or in lockstep with commands: no clock of the host stands beside it.
    assert len(found.findings.checks) >= 24


def examined(wiring: NiDaqConfiguration, errors: dict[str, tuple[float, float]], *, meters: bool) -> Examination:
    """The examination of a card whose terminals have errors that its rig file does not know."""
    server = DaqServer(card_of(wiring_of("ni-pci-6229"), paced=False, errors=errors))
    device = DeviceAtSeam(wiring.model_copy(update={"lockstep": True}), server)
    with GuardedRig(device, wire_temperature_k=COLD_K) as rig:
        if meters:
            return examine(rig, meter_wire_v=TRUE_WIRE_V, meter_shunt_v=TRUE_SHUNT_V)
        return examine(rig)


@pytest.mark.emulated
def test_what_a_card_reads_wrong_is_found_and_written_into_its_rig_file(tmp_path: Path) -> None:
    path = tmp_path / "mine.toml"
    shutil.copy(shipped_rig_files()["ni-pci-6229"], path)
    errors = {"ai0": (0.98, 6e-3), "ai1": (1.03, -1.2e-3)}
    before = read_rig_file(path)
    assert isinstance(before, NiDaqConfiguration)
    found = examined(before, errors, meters=True)
    assert {"wire_offset_v", "shunt_offset_v"} <= found.findings.failed

    found.write_calibration(path)
    after = read_rig_file(path)
    assert isinstance(after, NiDaqConfiguration)
    assert after.inputs.wire_voltage.gain == pytest.approx(1 / 0.98, rel=2e-3)
    assert after.inputs.shunt_voltage.gain == pytest.approx(1 / 1.03, rel=1e-2)
    mended = examined(after, errors, meters=False)
    assert not mended.findings.failed
    ohm = next(check.value for check in mended.findings.checks if check.name == "wire_resistance_ohm")
    assert ohm == pytest.approx(17.28, rel=0.01)
