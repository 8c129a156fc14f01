"""``musclewire doctor`` on faulty rigs: each fault has a name and an exit code, and nothing is written."""

from __future__ import annotations

from pathlib import Path

import pytest
from tests.command_line import CommandLine

import musclewire as mw
from musclewire.errors import CallerError, RigError
from musclewire.experiment import examine


def rig_with(tmp_path: Path, fault: str) -> Path:
    path = tmp_path / "rig.toml"
    path.write_text(f'kind = "simulated"\n\n[[fault]]\n{fault}\n', encoding="utf-8")
    return path


# The check that finds a fault, the exit code, and a word of the advice.
FAULTS = {
    'kind = "wire_open"': ("sense_current_a", 1, "broken"),
    'kind = "wire_short"': ("wire_resistance_ohm", 1, "bridged"),
    'kind = "clamp_slipped"': ("wire_resistance_ohm", 1, ""),
    'kind = "bad_contact"': ("wire_resistance_ohm", 1, ""),
    'kind = "channels_swapped"': ("channels_in_place", 1, "changed places"),
    'kind = "channel_frozen"\nchannel = "wire"': ("wire_channel_alive", 1, "frozen"),
    'kind = "channel_frozen"\nchannel = "shunt"': ("shunt_channel_alive", 1, "frozen"),
    'kind = "channel_saturated"\nchannel = "shunt"': ("rig_kept_going", 3, ""),
    'kind = "supply_missing"': ("output_gain", 1, "does not arrive"),
    'kind = "reading_not_finite"\nchannel = "shunt"': ("readings_are_numbers", 3, "device"),
    'kind = "output_stuck"\nvoltage = "2 V"': ("rig_kept_going", 3, "CUT THE POWER"),
    'kind = "output_stuck"\nvoltage = "0.2 V"': ("output_at_zero_v", 1, "CUT THE POWER"),
    'kind = "device_lost"\nat = "1 s"': ("rig_kept_going", 3, ""),
    'kind = "clock_jump"\nat = "1 s"': ("rig_kept_going", 3, ""),
    'kind = "wire_open"\nat = "4.5 s"': ("rig_kept_going", 3, ""),
}
COLD = {"channels_in_place", "sense_current_a", "output_at_zero_v", "output_gain"}


@pytest.mark.parametrize("fault", FAULTS)
def test_each_fault_of_a_rig_file_has_a_name_and_an_exit_code(
    musclewire: CommandLine, tmp_path: Path, fault: str
) -> None:
    name, code, word = FAULTS[fault]
    answer = musclewire("doctor", rig_with(tmp_path, fault), "--json")
    failed = {check["name"]: check["advice"] for check in answer.json["checks"] if not check["ok"]}
    assert word in failed[name], failed
    assert answer.json["highest_drive_voltage_v"] < (0.15 if name in COLD else 0.301)
    assert answer.code == code
    assert len(answer.err.strip().splitlines()) == (1 if code == 3 else 0)


def test_the_text_names_what_failed_and_how_much_was_put_out(musclewire: CommandLine, tmp_path: Path) -> None:
    answer = musclewire("doctor", rig_with(tmp_path, 'kind = "wire_open"'))
    assert answer.code == 1
    line = next(line for line in answer.out.splitlines() if "sense_current_a" in line)
    assert line.startswith("NO")
    assert "broken" in line
    assert "the drive was at most 0.135 V" in answer.out


def test_a_simulated_rig_has_no_place_for_a_calibration(musclewire: CommandLine, tmp_path: Path) -> None:
    answer = musclewire("doctor", rig_with(tmp_path, 'kind = "supply_missing"'), "--write")
    assert answer.code == 2
    assert "holds no calibration" in answer.err


def test_nothing_is_written_while_the_wiring_is_wrong(tmp_path: Path) -> None:
    file = tmp_path / "mine.toml"
    file.write_text('kind = "nidaq"\n', encoding="utf-8")
    for fault, error in (
        ('kind = "channels_swapped"', CallerError),
        ('kind = "wire_open"', CallerError),
        ('kind = "device_lost"\nat = "1 s"', RigError),
    ):
        with mw.open_rig(rig_with(tmp_path, fault)) as rig, pytest.raises(error) as refused:
            examine(rig).write_calibration(file)
        assert error is RigError or "nothing is written" in str(refused.value)
    with mw.open_rig("simulated", acquisition_noise_v=0.0018) as rig:
        found = examine(rig)
    assert "shunt_noise_v" in found.findings.failed
    with pytest.raises(CallerError, match=r"there is no \[inputs.wire_voltage\] to write a calibration into"):
        found.write_calibration(file)
