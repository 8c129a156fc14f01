"""The nouns everyone shares: a raw sample, a recording, and how recordings are read and written."""

from __future__ import annotations

from musclewire.signals.columns import COLUMNS
from musclewire.signals.exchange import RawSample
from musclewire.signals.hdf5 import RecordingWriter
from musclewire.signals.reading import has_headers, read_recording, understand
from musclewire.signals.recording import Recording

__all__ = ["RawSample", "Recording", "RecordingWriter", "has_headers", "read_recording", "understand", "COLUMNS"]
