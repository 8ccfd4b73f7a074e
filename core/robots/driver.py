"""The import line for drivers of one's own: all that a driver needs, under names that stay."""

from core.errors import BadInput, Refused, Unavailable
from core.gate.twist import ZERO, Twist
from core.geometry import Pose, Transform, arc
from core.optics import CameraModel
from core.robots.conformance import check_robot
from core.robots.device import Base, Device, Equipment, Findings
from core.robots.readings import Readings
from core.sensors import Camera, Image, Laser, Scan, Sound
from core.sensors.microphones import MicrophoneArray

__all__ = [
    "ZERO",
    "BadInput",
    "Base",
    "Camera",
    "CameraModel",
    "Device",
    "Equipment",
    "Findings",
    "Image",
    "Laser",
    "MicrophoneArray",
    "Pose",
    "Readings",
    "Refused",
    "Scan",
    "Sound",
    "Transform",
    "Twist",
    "Unavailable",
    "arc",
    "check_robot",
]
