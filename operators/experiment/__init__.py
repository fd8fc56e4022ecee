"""The sensory comparison of the paper's chapter 5."""
