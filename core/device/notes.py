"""The servo's messages to the artist about device and line: why there is no force, and what to do."""

from . import wire

NOT_ARMED = "The device did not arm: lift all fingertips, check that its motors are on, and arm it again."
FAULTS = {
    wire.FAULT_WATCHDOG: "The device received no commands in time and stopped its motors. Arm it again.",
    wire.FAULT_SENSOR: (
        "An angle sensor of the device gives impossible readings. Check its cables, then arm the device again."
    ),
    wire.FAULT_SPEED: "A fingertip of the device was faster than any hand. Arm the device again.",
    wire.FAULT_ARM_REFUSED: NOT_ARMED,
    wire.FAULT_LINK: "The device lost too many frames. Check the cable or the network, then arm it again.",
}
NO_ANSWER = "Nothing answered within 1 s. Check the port, power, and baud rate ({baud}) or secret of the device."
NO_STATES = "The device answers but streams no positions. Switch it off and on, then connect again."
SILENT = "The device is silent: the connection is lost. When it is back, arm it again."
WAS_SILENT = "The device was silent for more than 100 ms. Arm it again."
STOOD_STILL = "Device or computer stood still for more than 100 ms, or the device's clock is wrong. Arm it again."
TOO_FAST = "A fingertip was faster than 1.5 m/s. Arm the device again."
BAD_FORCE = "The simulation gave forces that are not numbers. Reset it and arm the device again."
LOSSY = "{share:.0%} of the frames are lost on the line. Check the cable or the network, then arm the device again."
YIELDS = (
    "The force on a fingertip is reduced, because it would give your hand more energy than it took. Press deeper, or "
    "lift the fingertip for a moment."
)
