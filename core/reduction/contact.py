"""What a plan says of contact: it is the proxy's surface that touches, the mesh is what is shown."""

from __future__ import annotations

from dataclasses import replace

from ..mesh.surface import Mesh
from ..solver.scene import OFFSET
from .planner import Plan

BENT = 0.07  # of the spacing: how far a mesh stands out where a sharp edge bends its proxy (dev.py core meeting)
DEPTH = 0.5  # of a fingertip's radius: how deep the presses are that a plan's errors are of
POWER = 2.0  # of the depth, with which the force grows at most


def in_contact(mesh: Mesh, chosen: Plan, radius: float) -> Plan:
    """Return a plan that says how far off the force of a proxy is in contact, and how far its mesh may overlap.

    Args:
        radius: of the fingertips [m], and so of the smallest that is to be met as truly.
    """
    proxy = chosen.proxy
    if proxy is None:
        return chosen
    # what it meets keeps a distance too, but for a finer body a smaller one
    overlap = proxy.stands_out + BENT * proxy.spacing - proxy.offset
    sooner = 2 * max(proxy.offset - OFFSET * float(mesh.rest_lengths.mean()), 0.0)  # it is met
    force_error = min(chosen.force_error + POWER * sooner / (DEPTH * radius), 1.0)
    off, shown = f"{force_error:.0%}", f"{1e3 * overlap:.2g}"
    if proxy.pressed:
        message = f"In contact there the force is within {off}, and the mesh shown may overlap by up to {shown} mm."
    else:
        message = f"In contact the force is within {off}, and the mesh shown may overlap by up to {shown} mm."
    return replace(chosen, force_error=force_error, reason=f"{chosen.reason} {message}")
