"""The sensory comparison of the paper's chapter 5: people compare a virtual object with the real one, or with itself.

plan: all trials in order, from a file. run: the next trial, and what is presented in it. log: the file of answers.
"""
