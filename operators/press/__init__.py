"""Pressing live: the poke, play, what runs, and what it presses with and against."""
