"""A session (one body, its fingertips, its clock, its shape at rest), and the loop that steps sessions."""

from .fingertip import Finger as Finger
from .frame import Frame as Frame
from .session import Session as Session
from .stepping import step_all as step_all
