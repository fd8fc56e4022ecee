"""A session: one body with its fingertips, its clock, its shape at rest and sway, and what it shows; and the loop that
steps sessions.
"""

from .clock import step_all as step_all
from .fingertip import Finger as Finger
from .frame import Frame as Frame
from .session import Session as Session
