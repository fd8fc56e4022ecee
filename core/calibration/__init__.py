"""From an instrument's file to a material: read, prepare, fit, identify. numpy only."""
