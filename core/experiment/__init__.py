"""The sensory comparison of the paper's chapter 5: people say how like the real object the virtual one feels.

plan: what is shown, read from a file, in a seeded order under blind labels. staircase: levels that follow the answers.
log: each answer appended to a CSV file, so that a stopped experiment continues. run: the trial that is next.
"""
