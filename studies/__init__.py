"""The laboratory, outside the zip, in a folder for each question. It imports core, never the other way.

    law         is the force the measured law? calibration of a file, the paper's table and figures
    body        has a body the shape and the sway of a solid? finite elements, dents, what comes back
    contact     does nothing pass through anything?
    charts      what does precision cost, and where do time-stepping methods fail? the charts of docs/accuracy.md
    device      does an emulated device render the law, and lift a cube? the emulator itself is in bench
    experiment  the sensory comparison: plans, simulated people, analysis
    reference   the core in numpy, with which tests compare the C core
    methods     nine time-stepping methods, of which the product uses one
    meshes      what is pressed

`commands.py` lists the commands of `python3 dev.py core`; `scenes.py` and `files.py` are shared by all.
"""
