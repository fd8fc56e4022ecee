"""Is the force the measured law? Calibration of a file, the paper's table and figures, presses at random places."""
