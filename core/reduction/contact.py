"""What a plan says of contact: it is the proxy's surface that touches, the mesh is what is shown."""

from __future__ import annotations

from dataclasses import replace

from .planner import Plan

BENT = 0.07  # of the spacing: how far a mesh stands out where a sharp edge bends its proxy (dev.py core meeting)
SEEN = 1e-5  # [m] that can be seen


def in_contact(chosen: Plan) -> Plan:
    """Return a plan whose reason says how far a mesh that a proxy moves may overlap what it meets."""
    proxy = chosen.proxy
    if proxy is None:
        return chosen
    # what it meets keeps a distance too, but for a finer body a smaller one
    overlap = proxy.stands_out + BENT * proxy.spacing - proxy.offset
    message = f"In contact the mesh shown may overlap by up to {1e3 * overlap:.2g} mm."
    if overlap < SEEN:
        message = "In contact it is the proxy that touches; the mesh shown stays clear."
    return replace(chosen, reason=f"{chosen.reason} {message}")
