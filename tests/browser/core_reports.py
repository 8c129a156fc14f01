"""The reports of the demo and of a calibration, for the tests in a browser."""

from __future__ import annotations

from tests.browser.report_subject import ReportSubject

SLOW_SINE = ("characterize", "simulated", "--seed", "5", "--cycles", "1", "--period", "12s", "-o", "loop.h5", "--json")
SUBJECTS = (
    ReportSubject("demo", (("demo", "--json", "--output", "."),), 5),
    ReportSubject(
        "calibrate",
        (
            SLOW_SINE,
            ("calibrate", "loop.h5", "-o", "mine.toml", "--effort", "quick", "--report", "report.html", "--json"),
        ),
        2,
    ),
)
