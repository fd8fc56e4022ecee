"""The sensory comparison of the paper's chapter 5: plans, simulated people, and the analysis of answers."""
