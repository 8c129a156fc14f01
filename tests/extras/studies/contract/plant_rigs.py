"""An example of a plant from outside in the contract suite: a module next to its rig file, another family of wire."""

from __future__ import annotations

from tests.contract.rig_subject import RigSubject, without_a_test
from tests.places import EXAMPLES

from musclewire.rigs import open_rig

LIANG_ROGERS = EXAMPLES / "plants" / "liang_rogers.toml"

# The maker's 126 ohm/m over 14 cm, and up to 15 % more.
SUBJECTS = (RigSubject("another family", without_a_test(lambda: open_rig(LIANG_ROGERS)), (17.6, 20.3)),)
