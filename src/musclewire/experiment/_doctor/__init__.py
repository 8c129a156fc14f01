"""Is this rig wired as its file states? Checks at the sense voltage and below, before anything is heated."""

from musclewire.experiment._doctor.evidence import RigCheck, SkippedCheck
from musclewire.experiment._doctor.examine import Examination, examine

__all__ = ["RigCheck", "Examination", "SkippedCheck", "examine"]
