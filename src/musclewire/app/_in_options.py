"""What a message advises in Python, in the options of the command line.

The rooms below know no options: their messages name arguments, ``overwrite=True``. Who reads them on the command line
needs ``--overwrite``. Each pair is written here once, and a test holds each to a message that says it.
"""

from __future__ import annotations

import re

IN_OPTIONS = {
    "fit_resistance(recording, wire)": "--wire",
    "overwrite=True": "--overwrite",
    "in_python=True": "--in-python",
    "double=True": "--double",
    "say so (load_n)": "say so (--load)",
    "wire_file=... names it": "--wire-file names it",
    "choose estimator='gated'": "choose --estimator gated",
    "choose one with group='NAME'": "choose one with --group NAME",
    "leave group out": "leave --group out",
    "sources_only=True": "--sources-only",
    "relative_resistance=True": "--relative-resistance",
    "drop_missing=True": "--drop-missing",
    "save_mapping writes one": "--save-mapping writes one",
    "leave out real_time": "leave out --real-time",
    "leave out clock_speed": "leave out --clock-speed",
    "add real_time=True": "add --real-time",
    "leave out cpu": "leave out --cpu",
    "choose one of these for cpu": "choose one of these for --cpu",
    "or state the delay (delay_s)": "or state the delay (--delay)",
    "that follow each other (on)": "that follow each other (--join)",
    "give leg_length_m in its metadata": "give --leg-length, or leg_length_m in the file",
    "or leg_length_m in its metadata and": "or --leg-length and",
    "give shunt_resistance_ohm in its metadata, 0 for none": "give --shunt, '0 ohm' for none",
    "needs it, give a positive number": "needs it, give a positive number (--shunt)",
    "turn the sign when importing": "--invert",
    "take off what it reads cold": "--zero takes off what it reads cold",
    "if it is meant so, write": "if it is meant so, give --beyond-catalogue or write",
    "write it into the rig file, or a shunt": "write it into the rig file (--write), or a shunt",
    "give a supply or a current": "give --supply or --current",
    "give a longer duration": "give a longer --duration",
    "they are settings=tune(model, recording).settings": "'musclewire tune MODEL RECORDING' finds them",
}
# bench={'pretension_n': '1.9 N'} of calibrate and fit_resistance is --set pretension_n='1.9 N'.
AMPLITUDE = re.compile(r"amplitude_v=([0-9.]+)")
BENCH = re.compile(r"bench=\{'(\w+)': ([^}]+)\}")


def in_options(text: str) -> str:
    """Return a message with the options of the command line in the place of the arguments that it advises."""
    for in_python, option in IN_OPTIONS.items():
        text = text.replace(in_python, option)
    text = AMPLITUDE.sub(r'--amplitude "\1 V"', text)
    return BENCH.sub(r"--set \1=\2", text)
