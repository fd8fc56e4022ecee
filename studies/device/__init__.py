"""Does an emulated device render the law, and lift a cube? The emulator itself is in studies/bench."""
