"""Samples and recordings, which all rooms use, and the reading and writing of recordings."""

from __future__ import annotations

from musclewire.signals.columns import COLUMNS
from musclewire.signals.exchange import RawSample
from musclewire.signals.import_mapping import ImportMapping, load_mapping, save_mapping
from musclewire.signals.joining import join_recordings
from musclewire.signals.plots import PLOTS
from musclewire.signals.reading import has_headers, import_recording, read_recording, understand
from musclewire.signals.recording import Recording
from musclewire.signals.recording_writer import RecordingWriter

__all__ = [
    "RawSample",
    "Recording",
    "RecordingWriter",
    "ImportMapping",
    "has_headers",
    "import_recording",
    "join_recordings",
    "load_mapping",
    "read_recording",
    "save_mapping",
    "understand",
    "COLUMNS",
    "PLOTS",
]
