"""The report of a study, for the tests in a browser."""

from __future__ import annotations

from tests.browser.report_subject import ReportSubject

STUDY = """
format = "musclewire-study"
version = 1
name = "pretension"
run = { kind = "simulate", supply = "3.2 V", duration = "1 s", keep = ["stroke", "energy_j", "strain"] }
sampling = { method = "sobol", samples = 8 }
parameters.pretension.values = ["1.5 N", "1.9 N"]
parameters.convection_factor = { low = 0.85, high = 0.95 }
"""

SUBJECTS = (
    ReportSubject(
        "sweep",
        (("sweep", "study.toml", "-o", "out", "--workers", "1", "--json"),),
        3,
        {"study.toml": STUDY},
    ),
)
