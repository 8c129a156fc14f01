"""Is this rig wired as its file states? Checks at the sense voltage and below, before anything is heated."""

from musclewire.experiment.doctor.examine import Examination, examine
from musclewire.experiment.doctor.findings import RigCheck, SkippedCheck

__all__ = ["RigCheck", "Examination", "SkippedCheck", "examine"]
