"""Write the corpus's TDMS files with nptdms, as LabVIEW and FlexLogger write them."""

from __future__ import annotations

import struct
from pathlib import Path

import numpy as np
from nptdms import ChannelObject, GroupObject, RootObject, TdmsWriter
from tests.extras.lab_files.corpus.lab_signals import (
    DISPLACEMENT_MM,
    FORCE_N,
    PERIOD_S,
    ROWS,
    SHUNT_VOLTAGE_V,
    START,
    TIME_S,
    WIRE_VOLTAGE_V,
)


def waveform(unit: str, period_s: float = PERIOD_S) -> dict[str, object]:
    """Return the properties that LabVIEW gives a channel that was written as a waveform."""
    return {
        "wf_start_time": START,
        "wf_start_offset": 0.0,
        "wf_increment": period_s,
        "wf_samples": ROWS,
        "wf_xname": "Time",
        "wf_xunit_string": "s",
        "unit_string": unit,
    }


def channels(group: str = "Measured") -> list[ChannelObject]:
    """Return the run as waveform channels of a group."""
    return [
        ChannelObject(group, "Wire voltage", WIRE_VOLTAGE_V, waveform("V")),
        ChannelObject(group, "Shunt voltage", SHUNT_VOLTAGE_V * 1e3, waveform("mV")),
        ChannelObject(group, "LVDT", DISPLACEMENT_MM, waveform("mm")),
    ]


def write(path: Path, *objects: object) -> None:
    """Write objects as one segment."""
    with TdmsWriter(path) as writer:
        writer.write_segment(list(objects))


def good(folder: Path) -> None:
    """Write files that are read."""
    write(folder / "tdms_waveforms.tdms", RootObject({"operator": "lab"}), GroupObject("Measured"), *channels())
    write(
        folder / "tdms_time_channel.tdms",
        ChannelObject("Log", "Time", TIME_S * 1e3, {"unit_string": "ms"}),
        ChannelObject("Log", "U wire", WIRE_VOLTAGE_V, {"unit_string": "V"}),
        ChannelObject("Log", "Kraft", FORCE_N, {"NI_UnitDescription": "N"}),
    )
    write(
        folder / "tdms_timestamps.tdms",
        ChannelObject("Log", "Timestamp", START + (TIME_S * 1e6).astype("timedelta64[us]")),
        ChannelObject("Log", "Wire voltage", WIRE_VOLTAGE_V, {"unit_string": "V"}),
    )
    write(
        folder / "tdms_properties.tdms",
        RootObject({"Shunt resistance [ohm]": "0.47", "Leg length [mm]": "84", "Author": "lab", "NI_secret": 3}),
        *channels(),
    )
    fast = ChannelObject("Fast", "Force", np.repeat(FORCE_N, 5), waveform("N", PERIOD_S / 5))
    write(folder / "tdms_two_rates.tdms", *channels(), fast)
    mixed = ChannelObject("Measured", "Force", np.repeat(FORCE_N, 5), waveform("N", PERIOD_S / 5))
    write(folder / "tdms_two_rates_in_one_group.tdms", *channels(), mixed)
    segments(folder / "tdms_many_segments.tdms")
    scaled(folder / "tdms_scaled_integers.tdms")
    text = ChannelObject("Measured", "Remark", ["a"] * ROWS)
    write(folder / "tdms_with_text_channel.tdms", *channels(), text)
    whole = (folder / "tdms_many_segments.tdms").read_bytes()
    (folder / "tdms_cut_off_in_a_run.tdms").write_bytes(whole[: len(whole) - 100])


def segments(path: Path) -> None:
    """Write a run as LabVIEW does while it measures: ten rows a segment."""
    with TdmsWriter(path) as writer:
        for start in range(0, ROWS, 10):
            rows = slice(start, start + 10)
            writer.write_segment(
                [
                    ChannelObject("Measured", "Wire voltage", WIRE_VOLTAGE_V[rows], waveform("V")),
                    ChannelObject("Measured", "LVDT", DISPLACEMENT_MM[rows], waveform("mm")),
                ]
            )


def scaled(path: Path) -> None:
    """Write raw counts of a converter with the linear scale of DAQmx, which a reader must apply."""
    counts = np.round(WIRE_VOLTAGE_V / 5.0 * 32767).astype(np.int16)
    scale = {
        "NI_Scaling_Status": "unscaled",
        "NI_Number_Of_Scales": np.uint32(1),
        "NI_Scale[0]_Scale_Type": "Linear",
        "NI_Scale[0]_Linear_Slope": 5.0 / 32767,
        "NI_Scale[0]_Linear_Y_Intercept": 0.0,
        "NI_Scale[0]_Linear_Input_Source": np.uint32(0xFFFFFFFF),
    }
    write(path, ChannelObject("Measured", "Wire voltage", counts, {**waveform("V"), **scale}))


def damaged(folder: Path, good_folder: Path) -> None:
    """Write files that are refused."""
    whole = (good_folder / "tdms_waveforms.tdms").read_bytes()
    (folder / "tdms_20_bytes.tdms").write_bytes(whole[:20])
    (folder / "tdms_metadata_cut.tdms").write_bytes(whole[:300])
    (folder / "tdms_not_one.tdms").write_bytes(b"PK\x03\x04" + whole)
    (folder / "tdms_absurd_name_length.tdms").write_bytes(whole[:32] + struct.pack("<I", 0xFFFFFFF0) + whole[36:])
    (folder / "tdms_absurd_object_count.tdms").write_bytes(whole[:28] + struct.pack("<I", 0xFFFFFFF0) + whole[32:])
    (folder / "tdms_index_alone.tdms").write_bytes(b"TDSh" + whole[4:])
    # The number of values follows type (double: 10) and dimension (1) of each channel.
    place = whole.index(struct.pack("<IIQ", 10, 1, ROWS))
    absurd = whole[: place + 8] + struct.pack("<Q", 2**60) + whole[place + 16 :]
    (folder / "tdms_absurd_value_count.tdms").write_bytes(absurd)
    scales = {"NI_Scaling_Status": "unscaled", "NI_Number_Of_Scales": np.uint32(0xFFFFFFFF)}
    write(
        folder / "tdms_absurd_scales.tdms",
        ChannelObject("Measured", "Wire voltage", np.arange(4, dtype=np.int16), {**waveform("V"), **scales}),
    )
