"""The report of a calibration, for the tests in a browser."""

from __future__ import annotations

from tests.browser.report_subject import ReportSubject

SLOW_SINE = ("characterize", "simulated", "--seed", "5", "--cycles", "1", "--period", "12s", "-o", "loop.h5", "--json")
FOUND = ("calibrate", "loop.h5", "-o", "mine.toml", "--effort", "quick", "--report", "report.html", "--json")
SUBJECTS = (ReportSubject("calibrate", (SLOW_SINE, FOUND), 2),)
