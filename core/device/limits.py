"""The limits of this package: what keeps a hand safe, and the deadlines of device, servo and Blender.

A device reports its own limits (spec.py); the numbers of the protocol are in wire.py. A number that follows from others
is written as an expression of them. Nothing here may be weakened.
"""

from __future__ import annotations

# force and speed, whatever a device reports about itself
HARD_CEILING = 20.0  # [N] largest force: twice the peak of the Haptic Master
SLEW = 1000.0  # [N/s] fastest rise of force: 1 N per millisecond, so that the peak of a device takes ten ticks
TOP_SPEED = 1.5  # [m/s] no hand exploring an object is faster; a runaway motor is
RMS_TIME = 10.0  # [s] window of the root mean square force, which stands for the heating of the motors

# arming
QUIET_FORCE = 0.2  # [N] arming waits until the force is below this, so that the device does not kick
RAMP_TIME = 0.5  # [s] from zero to full force: longer than a hand takes to let go
RAMP_DAMPING = 3.0  # [N s/m] damping during the ramp: of the order of a device's own friction

# how long each side may be silent
TICK = 0.001  # [s] nominal tick (a device may have another, spec.py); also between two looks at line and lifeline
# [s] without a STATE the force ends after this; also clock tolerance, longest time step, and time constant of the speed
# filter, because one converter bit per tick alone reads as 0.1 m/s
STATE_GAP = 5 * TICK
LOST_TIME = 0.100  # [s] without a STATE a device is lost; a surface of this age begins to fade, and at twice it is gone
ZERO_TIME = LOST_TIME / 4  # [s] without commands a device's own force must be zero by then
LEASE = 3 * LOST_TIME  # [s] the dead-man key counts as held this long after it was last seen down: a fade and a renewal
ANSWER_TIME = 1.0  # [s] deadline for the answer of a device or servo, and for a process to end
REFUSAL_TIME = ANSWER_TIME + 2 * LOST_TIME  # [s] wait for a device to arm; it refuses after ANSWER_TIME without quiet
SLOWEST_FRAME = 0.050  # [s] a change of the surface is spread over one frame of Blender, but over no more than this
QUIET_TIME = SLOWEST_FRAME  # [s] of quiet before arming; after this long without force a touch is over

# readings and messages that are not trusted
FASTEST = 4 * TOP_SPEED  # [m/s] a fingertip that seems to move faster is a sensor error
FAILED_TICKS = round(STATE_GAP / TICK)  # impossible readings in a row after which the sensor has failed
FARTHEST = 10.0  # [m] a position farther away is an error
STIFFEST = 1e6  # [N/m] a stiffer law is an error
LEVEL = 1e-3  # largest deviation from 1 of a normal's squared length: rounding stays below, other vectors do not

# the line
LOSS_FRAMES = round(ANSWER_TIME / TICK)  # number of STATEs in the lost share; it needs a tenth of them to mean anything
LOSS_WARNS = 0.05  # lost share that warns: the force becomes rough
LOSS_DISARMS = 0.30  # lost share that disarms: a force would be held for several ticks in a row
DELAY_TIME = ANSWER_TIME / 4  # [s] time constant of the mean delay: a few hundred answers, some of which are late

# what can be rendered without giving energy
PASSIVE_SHARE = 0.8  # share of the passive stiffness in use: the rest covers errors in estimates of friction and delay
SIDEWAYS = 2 / 3  # tangential over normal stiffness: 2 (1 - nu) / (2 - nu) of a soft contact, nu = 1/2. Mindlin 1949
MOST_DAMPING = 4 * RAMP_DAMPING  # [N s/m] of the passivity controller: a tenth of tip mass over tick; more would shake
ALLOWED = 5e-4  # [J] that a touch may give back beyond what it took: a 12-bit step at either end of a way, at 1.25 N
YIELD_ENERGY = ALLOWED / 2  # [J] each time this much more is given back, the force falls to 1/e

# processes
BLENDER_GONE = 10 * ANSWER_TIME  # [s] without an order: Blender has ended, if no pipe can be watched (Windows)
PRIORITY = 10  # in the first-in-first-out class: above every ordinary process, below the system's own
