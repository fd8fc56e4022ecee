"""What C and Python both must know, written by `dev.py native` from native/constants.h."""

ABI = 27
MAX_FINGERTIPS = 3
MAX_STEPS = 1000000
MAX_BODIES = 4096
MAX_RING = 12
LANES = 8
FOLLOWED = 8
FACTORS = 33
AIR_PRESSURE = 101325.0
AIR_EXPONENT = 1.4
LIQUID_BULK_MODULUS = 2e6
OFFSET = 0.05
ROUNDING = 1e-6
TRAVEL = 0.25
