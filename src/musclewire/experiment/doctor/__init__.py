"""Is this rig wired as its file says? Checks by the sense voltage and less, before anything is heated."""

from musclewire.experiment.doctor.examine import Examination, examine
from musclewire.experiment.doctor.findings import RigCheck, SkippedCheck

__all__ = ["RigCheck", "Examination", "SkippedCheck", "examine"]
