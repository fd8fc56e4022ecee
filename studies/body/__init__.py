"""Has a body the shape and the sway of a solid? Finite elements, dents, modes, and what comes back after a press."""
