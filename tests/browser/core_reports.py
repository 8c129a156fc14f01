"""The reports of the demo and of a calibration, for the tests in a browser."""

from __future__ import annotations

from tests.browser.report_subject import ReportSubject

SUBJECTS = (
    ReportSubject("demo", (("demo", "--json", "--out", "."),), 5),
    ReportSubject(
        "calibrate",
        (
            ("characterize", "simulated", "--seed", "5", "--cycles", "1", "--period", "12", "-o", "loop.h5", "--json"),
            ("calibrate", "loop.h5", "-o", "mine.toml", "--effort", "quick", "--report", "report.html", "--json"),
        ),
        2,
    ),
)
