"""The numbers of this room: what keeps a hand safe, and the times within which device, servo and Blender must answer.

Those of one device it reports itself (spec.py), those of the protocol are in wire.py. What follows from others is
written as such. Nothing here may be weakened.
"""

from __future__ import annotations

# force and speed, whatever a device reports of itself
HARD_CEILING = 20.0  # [N] twice the peak of the Haptic Master
SLEW = 1000.0  # [N/s] 1 N a millisecond: the peak of a device takes ten ticks
TOP_SPEED = 1.5  # [m/s] no hand exploring an object is faster; a motor running away is
RMS_TIME = 10.0  # [s] window of the root mean square force: the heat of the motors

# arming
QUIET_FORCE = 0.2  # [N] arming waits for less force than this: nothing may kick
RAMP_TIME = 0.5  # [s] from nothing to the whole force: longer than a hand takes to let go
RAMP_DAMPING = 3.0  # [N s/m] while it ramps: of the order of a device's own friction

# how long anything may be silent
TICK = 0.001  # [s] of a device, by which the times here are judged; a device may have another (spec.py)
STATE_GAP = 5 * TICK  # [s] without a STATE there is no force after this; clocks agree, and steps are cut, to as much
SPEED_TIME = STATE_GAP  # [s] time constant of the speed: one converter bit a tick is already 0.1 m/s
LOST_TIME = 0.100  # [s] without a STATE the device counts as lost, and a surface of Blender begins to fade
ZERO_TIME = LOST_TIME / 4  # [s] by which a device's own force is zero without commands, at the latest
FADE_TIME = 2 * LOST_TIME  # [s] age at which the force of a surface has faded
LEASE = 3 * LOST_TIME  # [s] the dead-man key counts as held after it was last seen down: through a fade and a renewal
ANSWER_TIME = 1.0  # [s] a device, a servo or an ending process that has not answered by then does not
REFUSAL_TIME = ANSWER_TIME + 2 * LOST_TIME  # [s] a device waits for the quiet for ANSWER_TIME, then refuses to arm
SLOWEST_FRAME = 0.050  # [s] a change of the surface is spread over one frame of Blender, but over no more than this
QUIET_TIME = SLOWEST_FRAME  # [s] arming waits for as long a quiet; without force for as long a touch is over

# readings and messages that are not trusted
FASTEST = 4 * TOP_SPEED  # [m/s] a fingertip that moves faster was not sensed right
FAILED_TICKS = round(STATE_GAP / TICK)  # impossible readings in a row: the sensor has failed
BAD_NUMBERS = 3  # NaN or inf within LOST_TIME disarm: one may be a message that was cut
FARTHEST = 10.0  # [m] a place farther off is an error
STIFFEST = 1e6  # [N/m] and a law that is stiffer
LEVEL = 1e-3  # how far the square of a normal's length may be from 1: it was rounded, or it is no direction

# the line
LOSS_FRAMES = round(ANSWER_TIME / TICK)  # STATEs of which the lost share is taken; of a tenth it means something
LOSS_WARNS = 0.05  # share lost: what is felt becomes rough
LOSS_DISARMS = 0.30  # share lost: a force would be held for several ticks in a row
PING_EVERY = ANSWER_TIME / 4  # [s] between two questions for the delay, which changes with the load of the computer

# what can be rendered without giving energy
PASSIVE_SHARE = 0.8  # of the passive stiffness: the rest covers errors in the estimates of friction and delay
SIDEWAYS = 2 / 3  # sideways stiffness over normal: 2 (1 - nu) / (2 - nu) of a soft contact, nu = 1/2. Mindlin 1949
GRAIN = 4e-4  # [m] a piece of the path: five times the noise of a 12-bit converter at the tip
MOST_DAMPING = 12.0  # [N s/m] of the passivity controller: a tenth of tip mass over tick; more would shake
ALLOWED = 5e-4  # [J] that a touch may give back beyond what it took: one piece of the path at 1.25 N
YIELD_ENERGY = ALLOWED / 2  # [J] for each more that is given back, the force yields to 1/e
FELT = 0.07  # share by which a force must fall until a hand notices: the just-noticeable difference is 6 to 8 %
SPARE = 4 * ALLOWED  # [J] of what was taken are kept once the device let go: what it gave is known some pieces late
GRAIN_ENERGY = ALLOWED / 5  # [J] less is the noise of the converters
KNOWN_LATE = STATE_GAP + TICK  # [s] what a force gave has been counted by then, and the force has ended

# processes
REPORT_EVERY = 2 * TICK  # [s] the most that a report adds to the age of the positions that Blender gets
POLL_TIME = TICK  # [s] between two looks at line and lifeline
BLENDER_GONE = 10 * ANSWER_TIME  # [s] without an order, where a pipe cannot be watched (Windows)
PRIORITY = 10  # of the first-in-first-out class: above every ordinary process, below the system's own
