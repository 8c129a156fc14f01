"""The wire of several segments in the contract suite."""

from __future__ import annotations

from tests.contract.rig_subject import PAPERS_WIRE_OHM, RigSubject, without_a_test

from musclewire.extras.studies import SegmentedConfiguration
from musclewire.rigs import open_rig

SUBJECTS = (RigSubject("segmented", without_a_test(lambda: open_rig(SegmentedConfiguration())), PAPERS_WIRE_OHM),)
