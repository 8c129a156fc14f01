"""Rig files with kind = "python:module:Class": what is imported, when, and what never is."""

from __future__ import annotations

import sys
import threading
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor, wait
from pathlib import Path

import numpy as np
import pytest

import musclewire as mw
from musclewire.errors import CallerError
from musclewire.rigs import (
    DEVICES,
    DeviceConfiguration,
    open_rig,
    read_rig_file,
    rig_configuration,
    simulated_configuration,
)
from musclewire.rigs._outside import OutsideConfiguration, imported
from musclewire.signals import Recording

NAMES = ("my_plant", "my_failing_plant", "my_other_plant")
PLANT = """
import pathlib

from musclewire.rigs._device import SWITCHED_OFF, DeviceFacts
from musclewire.rigs._kinds import DeviceConfiguration
from musclewire.rigs._mounted_wire import MountedWire
from musclewire.signals._exchange import RawSample, drive_voltage_of

pathlib.Path(__file__).with_suffix(".imported").touch()


class ResistorConfiguration(MountedWire, DeviceConfiguration):
    resistance: float


class Plain:
    def __init__(self, configuration):
        self.of, self.drive_voltage_v, self.samples, self.is_off = configuration, 0.0, 0, False
        self.facts = DeviceFacts(
            sample_period_s=configuration.sample_period,
            paced=False,
            leg_length_m=configuration.leg_length_m,
            drive_amplitude_v=configuration.drive_amplitude,
            limits=configuration.protection_limits(wire_range_v=10.0, shunt_range_v=10.0, readings_noisy=False),
            wire_temperature_k=295.15,
        )

    def metadata(self):
        return {"rig": "resistor", **self.of.facts()}

    def exchange(self, command):
        self.drive_voltage_v = drive_voltage_of(command)
        if self.is_off:
            self.drive_voltage_v = 0.0
            return SWITCHED_OFF
        self.samples += 1
        current_a = self.drive_voltage_v / (self.of.resistance + self.of.shunt)
        time_s = self.samples * self.of.sample_period
        return RawSample(time_s, self.drive_voltage_v, current_a * self.of.resistance, current_a * self.of.shunt)

    def sense(self):
        self.drive_voltage_v = self.of.sense_voltage
        return True

    def off(self):
        self.is_off, self.drive_voltage_v = True, 0.0
        return True


class Resistor(Plain):
    configuration = ResistorConfiguration


class NoSwitch:
    def metadata(self): ...
    def exchange(self, command): ...
    def sense(self): ...


class Hot(Resistor):
    def __init__(self, configuration):
        super().__init__(configuration)
        self.drive_voltage_v = 1.0


class Unmade(Resistor):
    def __init__(self): ...


number = 3
"""
KEYS = """
resistance = 17.0
wire = "paper-100um"
wire_length = "14 cm"
shunt = "1 ohm"
sense_voltage = "0.3 V"
drive_amplitude = "3.0 V"
maximum_voltage = "3.6 V"
"""


@pytest.fixture(autouse=True)
def _forgets_what_it_imported() -> Iterator[None]:
    yield
    for name in NAMES:
        sys.modules.pop(name, None)
    for kind in [kind for kind in imported if kind.split(":")[1] in NAMES]:
        del imported[kind]


def rig_file(folder: Path, kind: str, keys: str = KEYS, plant: str = PLANT) -> Path:
    (folder / "my_plant.py").write_text(plant, encoding="utf-8")
    file = folder / "plant.toml"
    file.write_text(f'kind = "{kind}"\n{keys}', encoding="utf-8")
    return file


def was_imported(folder: Path) -> bool:
    return "my_plant" in sys.modules or (folder / "my_plant.imported").exists()


def test_a_rig_file_opens_the_class_of_a_module_next_to_it(tmp_path: Path) -> None:
    with open_rig(rig_file(tmp_path, "python:my_plant:Resistor")) as rig:
        sample = rig.exchange(1.8)
    assert sample.wire_voltage_v / sample.shunt_voltage_v == pytest.approx(17.0)
    assert rig.metadata()["rig"] == "resistor"


def test_a_thread_waits_until_another_has_run_the_module(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    begun, go_on = threading.Event(), threading.Event()
    monkeypatch.setattr(threading, "gate_of_this_test", (begun, go_on), raising=False)
    held = "import threading\nthreading.gate_of_this_test[0].set()\nassert threading.gate_of_this_test[1].wait(60.0)\n"
    file = rig_file(tmp_path, "python:my_plant:Resistor", plant=held + PLANT)
    with ThreadPoolExecutor(2) as both:
        first = both.submit(open_rig, file)
        assert begun.wait(60.0)
        second = both.submit(open_rig, file)
        wait([second], 0.2)  # long enough for one that does not wait to find a module without its class
        go_on.set()
        for opening in (first, second):
            opening.result().close()


def test_an_installed_module_serves_as_well(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "elsewhere").mkdir()
    file = rig_file(tmp_path, "python:my_plant:Resistor")
    (tmp_path / "my_plant.py").rename(tmp_path / "elsewhere" / "my_plant.py")
    monkeypatch.syspath_prepend(str(tmp_path / "elsewhere"))
    with open_rig(file) as rig:
        assert rig.exchange(1.8).shunt_voltage_v == pytest.approx(0.1)


def test_its_schema_names_the_nearest_key(tmp_path: Path) -> None:
    with pytest.raises(CallerError, match=r"resistence.*resistance"):
        open_rig(rig_file(tmp_path, "python:my_plant:Resistor", KEYS.replace("resistance", "resistence")))


def test_a_class_without_a_schema_has_the_keys_of_every_real_rig(tmp_path: Path) -> None:
    with pytest.raises(CallerError, match="resistance"):
        open_rig(rig_file(tmp_path, "python:my_plant:Plain"))


@pytest.mark.parametrize(
    ("kind", "message"),
    [
        ("python:my_plant", "python:module:Class"),
        ("python:../my_plant:Resistor", "python:module:Class"),
        ("python:my_missing_plant:Resistor", "there is no module 'my_missing_plant': put my_missing_plant.py next to"),
        ("python:my_plant:Resistr", "no class 'Resistr'.*Resistor"),
        ("python:my_plant:number", "must be a class"),
        ("python:my_plant:NoSwitch", "no method off"),
        ("python:my_plant:Hot", "must be 0 V"),
        ("python:my_plant:Unmade", "cannot be made from its rig file: TypeError"),
    ],
)
def test_what_is_no_device_is_said_in_one_line(tmp_path: Path, kind: str, message: str) -> None:
    with pytest.raises(CallerError, match=message):
        open_rig(rig_file(tmp_path, kind))


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("import my_missing_helper\n", "needs a module 'my_missing_helper'"),
        ("1 / 0\n", "cannot be imported: ZeroDivisionError"),
    ],
)
def test_a_module_that_fails_is_said_in_one_line_and_not_kept(tmp_path: Path, text: str, message: str) -> None:
    with pytest.raises(CallerError, match=message):
        open_rig(rig_file(tmp_path, "python:my_plant:Resistor", plant=text))
    assert "my_plant" not in sys.modules


def test_two_modules_of_one_name_are_not_mixed_up(tmp_path: Path) -> None:
    first, second = tmp_path / "first", tmp_path / "second"
    first.mkdir()
    second.mkdir()
    open_rig(rig_file(first, "python:my_plant:Resistor")).close()
    open_rig(first / "plant.toml").close()
    with pytest.raises(CallerError, match="another module named 'my_plant'"):
        open_rig(rig_file(second, "python:my_plant:Resistor"))


# What never imports.


def test_only_a_rig_that_is_opened_by_its_path_is_imported(tmp_path: Path) -> None:
    file = rig_file(tmp_path, "python:my_plant:Resistor")
    for look in (read_rig_file, rig_configuration, simulated_configuration):
        with pytest.raises(CallerError, match="only a rig that is opened by its path"):
            look(file)
    with pytest.raises(CallerError, match="there is no kind of rig"):
        DEVICES.find("python:my_plant:Resistor")
    with pytest.raises(CallerError, match="by the path of its rig file"):
        open_rig(DeviceConfiguration(kind="python:my_plant:Resistor"))
    with pytest.raises(CallerError, match="there is no rig"):
        open_rig("python:my_plant:Resistor")
    assert not was_imported(tmp_path)


def hostile_recording(folder: Path) -> Path:
    """Write a recording whose metadata name a plant wherever a name may stand."""
    rig_file(folder, "python:my_plant:Resistor")
    kind = "python:my_plant:Resistor"
    names = ("rig", "kind", "wire", "load", "estimator", "controller", "replayed_rig", "device", "source")
    facts = {"shunt_resistance_ohm": 1.0, "leg_length_m": 0.07, "sample_period_s": 0.05, "wire_length_m": 0.14}
    time_s = 0.05 * np.arange(1, 101)
    columns = {
        "time_s": time_s,
        "drive_voltage_v": np.full(100, 1.8),
        "wire_voltage_v": np.full(100, 1.7),
        "shunt_voltage_v": np.full(100, 0.1),
        "displacement_m": 1e-6 * time_s,
    }
    path = folder / "hostile.h5"
    Recording(columns, {**facts, **dict.fromkeys(names, kind), "ended": "done"}).save(path)
    return path


def test_no_recording_imports_a_plant(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Read, fitted, estimated, replayed."""
    path = hostile_recording(tmp_path)
    monkeypatch.chdir(tmp_path)
    monkeypatch.syspath_prepend(str(tmp_path))
    recording = mw.read_recording(path)
    with pytest.raises(mw.MusclewireError):
        mw.fit(recording)
    for name in ("hostile.h5", "plant.toml"):
        (tmp_path / "replay.toml").write_text(f'kind = "replay"\nrecording = "{name}"\n', encoding="utf-8")
        with pytest.raises(mw.MusclewireError), open_rig(tmp_path / "replay.toml") as rig:
            rig.exchange(1.8)
    assert not was_imported(tmp_path)


def test_a_wire_file_named_in_a_plants_rig_file_is_looked_for_next_to_it() -> None:
    plant = OutsideConfiguration.model_construct(kind="python:plant")
    by_file = plant.model_copy(update={"wire": "mine.toml"})
    assert dict(by_file.with_files_in(Path("rigs")))["wire"] == str(Path("rigs/mine.toml"))
    by_name = plant.model_copy(update={"wire": "paper-100um"})
    assert by_name.with_files_in(Path("rigs")) is by_name
