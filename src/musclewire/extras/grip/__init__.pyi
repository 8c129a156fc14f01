"""The list of names that other rooms may use."""

from ._contact_detection import THRESHOLD as THRESHOLD
from ._contact_detection import ContactDetector as ContactDetector
from ._grip import TARGET_N as TARGET_N
from ._grip import grip as grip
from ._gripper_training import GripperKnowledge as GripperKnowledge
from ._gripper_training import close_fingers as close_fingers
from ._gripper_training import load_knowledge as load_knowledge
from ._gripper_training import object_of as object_of
from ._gripper_training import train_gripper as train_gripper
from ._gripper_training import with_object as with_object
